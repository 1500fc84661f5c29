"""The moves of a program, and what was assumed in reading it."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from pathlib import Path

import numpy as np

from triaxis.host.motion.curves import Curve
from triaxis.host.quantise import NOWHERE, Vector, vector
from triaxis.host.stl import Facets

# What a program may leave to the control, and what says it; comments.
_STATE = {
    assumed: re.compile(rf"[Gg]\s*0*(?:{codes})(?!\.?\d)")
    for assumed, codes in (
        ("G90", "9[01]"), ("G17", "1[789]"), ("G54", r"5[4-9]|59\.[123]"), ("no G92", r"92\.[12]"),
        ("no length compensation", r"43(?:\.1)?|49"),
    )
}  # fmt: skip
_CALL = re.compile(r"^\s*(?:N\s*\d+\s*)?O.*CALL", re.IGNORECASE | re.ASCII)
_COMMENT = re.compile(r"\([^)]*\)|;.*")
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


# Of `Program.changes`.
LATE_CHANGE = (
    "the tool that is changed to after the last move is not checked where it is then: add a move there"
)


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


def assumed_state(lines: Sequence[str], moves: Sequence[Move]) -> str:
    """Return the note of what no line up to the first move says: what the control has then; "" where nothing.

    An aborted program may leave G91, another system or plane; G92 and G43 stay after M2.
    """
    # A move of a subroutine stands before the call, and what is said before that counts.
    called = next((count for count, line in enumerate(lines, 1) if _CALL.search(line)), 0)
    said = (line for line in lines[: max(moves[0].line, called)] if not line.lstrip().startswith("/"))
    text = "\n".join(_COMMENT.sub("", line) for line in said)
    curved = any(move.curve is not None for move in moves)
    missing = [
        assumed
        for assumed, pattern in _STATE.items()
        if pattern.search(text) is None and (curved or assumed != "G17")
    ]
    if not missing:
        return ""
    return f"line {moves[0].line}: assumed, as no line up to the first move says it: {', '.join(missing)}"


def assumed_start(moves: Sequence[Move]) -> str:
    """Return the note of a program whose start nobody has said."""
    return f"line {moves[0].line}: the first move starts at X0 Y0 Z0, which is assumed: give --start"
