"""The moves of a program."""

import math
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from pathlib import Path

import numpy as np

from triaxis.host.motion.curves import Curve
from triaxis.host.quantise import NOWHERE, Vector, vector
from triaxis.host.stl import Facets

# Chords that a turn of a curve is drawn with, and of how many turns: more are a ring of ink.
_DRAWN, _DRAWN_TURNS = 32, 100


@dataclass(frozen=True)
class Move:
    """A move of the tool's origin from ``start`` to ``end`` in millimetres, of the program's line ``line``.

    A rapid that is not straight may be anywhere in the box of both. ``slack``: how far the control may be off
    all this. ``turns``: A, B and C at both ends, in degrees; ``turn_slack``: how far they may be off.
    ``changes``: how often a tool was changed before it, to the same one, too.
    """

    line: int
    start: Vector
    end: Vector
    rapid: bool
    straight: bool = True
    curve: Curve | None = None
    slack: Fraction = Fraction(0)
    tool: int = 0
    turns: tuple[Vector, Vector] = (NOWHERE, NOWHERE)
    turn_slack: Fraction = Fraction(0)
    changes: int = 0

    def at(self, part: Fraction) -> Vector:
        """Return the position after a part of it, 0..1."""
        if self.curve is not None:
            return self.curve.at(part)
        return vector(a + (b - a) * part for a, b in zip(self.start, self.end, strict=True))

    def angles(self, part: Fraction) -> Vector:
        """Return A, B and C after a part of it, in degrees."""
        return vector(a + (b - a) * part for a, b in zip(*self.turns, strict=True))

    @property
    def turning(self) -> bool:
        """Return whether A, B or C move."""
        return self.turns[0] != self.turns[1]

    @property
    def corners(self) -> Facets:
        """Return points on the way, straight from one to the next to look at, (N, 3) in millimetres."""
        chords = 1 if self.curve is None else _DRAWN * min(self.curve.turns, _DRAWN_TURNS)
        parts = (Fraction(k, chords) for k in range(chords + 1))
        return np.array([[float(c) for c in self.at(part)] for part in parts])

    @property
    def length(self) -> float:
        """Return its Euclidean length in millimetres; a rapid is taken for straight."""
        if self.curve is not None:
            return self.curve.length
        return math.dist(map(float, self.start), map(float, self.end))

    @property
    def extent(self) -> tuple[Vector, Vector]:
        """Return the corners of a box that holds all of it."""
        if self.curve is not None:
            return self.curve.extent()
        ends = list(zip(self.start, self.end, strict=True))
        return vector(map(min, ends)), vector(map(max, ends))


@dataclass(frozen=True)
class Program:
    """The moves of a file, and what was assumed in reading it, a line each.

    ``changes``: whether the tool is changed after the last move, be it to the same one.
    """

    path: Path
    moves: tuple[Move, ...]
    notes: tuple[str, ...]
    changes: bool = False

    @property
    def stretches(self) -> "list[Program]":
        """Return the parts between which the tool is changed, be it to the same one."""
        with_tool = [(move.tool, move.changes) for move in self.moves]
        changes = [k for k in range(1, len(self.moves)) if with_tool[k] != with_tool[k - 1]]
        ends = zip([0, *changes], [*changes, len(self.moves)], strict=True)
        return [replace(self, moves=self.moves[start:end]) for start, end in ends]

    @cached_property
    def starts(self) -> list[int]:
        """Return the numbers of moves that do not start where the one before ends."""
        moves = self.moves
        return [k for k in range(len(moves)) if not k or moves[k].start != moves[k - 1].end]
