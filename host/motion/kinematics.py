"""What of a machine carries and moves what: chains of axes, and where its objects are while they move.

All objects are given where they stand with each axis at 0, in one frame, the machine's. X, Y, Z move what
they carry along x, y, z; A, B, C turn it about a line along x, y, z. From the frame to an object linear axes
come first. So each point p of an object, at the machine's coordinates m, is at

    R(p) + S m

with S a diagonal of signs, and R its turns about lines that stand still, the one nearest the frame last. Of
two objects only what is not common to both chains matters: A, seen from B, is a turned mesh that is moved by
f m, f = S_a - S_b. Where nothing turns that is a path of A past B, as `path_scene` knows it.

While axes turn. Let each be at most h (in radians) from where it is taken to be, and no point of an object
further than r from its line, however the axes within it stand. Then no point is further than the sum of r h
from where it is taken to be: arcs are no shorter than their chords. It is slack, as what a control may leave
the path by; so is what A and B are off together. Small enough pieces of a turn are proven clear like straight
moves.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from itertools import groupby, takewhile

import numpy as np

from triaxis.golden.exact import Rational
from triaxis.host.motion.curves import Curve, above
from triaxis.host.motion.moves import Move
from triaxis.host.motion.path_check import NearPose
from triaxis.host.quantise import NOWHERE, Box, Vector, vector
from triaxis.host.scene import Turn, turned
from triaxis.host.stl import Facets, StlMesh

LINEAR, ROTARY = "XYZ", "ABC"
_HALF = Fraction(1, 2)
# More than pi / 180.
_RADIANS = Fraction(355, 113 * 180)


@dataclass(frozen=True)
class Axis:
    """An axis that moves an object: ``letter``, with its sign; ``pivot``: a point of a rotary axis' line."""

    of: str
    letter: str
    sign: int
    pivot: Vector = NOWHERE

    @property
    def number(self) -> int:
        """Return the direction that it moves along, or turns about: 0, 1 or 2."""
        return (LINEAR + ROTARY).index(self.letter) % 3

    @property
    def rotary(self) -> bool:
        """Return whether it turns."""
        return self.letter in ROTARY


def signs(chain: Sequence[Axis]) -> list[int]:
    """Return how a chain moves what is at its end along x, y and z by X, Y and Z."""
    return [sum(axis.sign for axis in chain if axis.letter == letter) for letter in LINEAR]


@dataclass(frozen=True)
class Body:
    """An object: its mesh, in the unit of STL files, where its origin is with all axes at 0, in millimetres,
    and the axes that move it, from the frame on.
    """

    name: str
    mesh: StlMesh
    file: str
    at: Vector = NOWHERE
    chain: tuple[Axis, ...] = ()

    @property
    def rotary(self) -> list[Axis]:
        """Return the axes that turn it, from the frame on."""
        return [axis for axis in self.chain if axis.rotary]

    def turned(self, angles: Vector) -> tuple[StlMesh, Vector, Fraction]:
        """Return its mesh turned about its origin, where that is then, and how far it may be off that."""
        mesh, origin, error = self.mesh, self.at, Fraction(0)
        for axis in reversed(self.rotary):
            turn = Turn(axis.number, axis.sign * angles[axis.number])
            if turn.degrees == 0:
                continue
            mesh = turned(mesh, (turn,))
            cosine, sine = map(Rational, turn.cosine_and_sine)
            first, second = (axis.number + 1) % 3, (axis.number + 2) % 3
            from_line = [Rational(o - p) for o, p in zip(origin, axis.pivot, strict=True)]
            x, y = from_line[first], from_line[second]
            from_line[first], from_line[second] = cosine * x - sine * y, sine * x + cosine * y
            if not turn.exact:
                # Cosine and sine are within 2^-53, and |cosine| + |sine| less than 3/2.
                error = error * Fraction(3, 2) + Fraction(int(abs(x) + abs(y) + 1), 1 << 53)
            origin = vector(Rational(p) + d for p, d in zip(axis.pivot, from_line, strict=True))
        return mesh, origin, error

    def standing(self, machine: Vector, angles: Vector, scale: Fraction) -> Facets:
        """Return its facets in the frame, in millimetres, in float64: for pictures, which decide nothing."""
        mesh, origin, _ = self.turned(angles)
        moved = (float(o + s * m) for o, s, m in zip(origin, signs(self.chain), machine, strict=True))
        return mesh.facets * float(scale) + np.array([*moved])

    def radii(self, scale: Fraction) -> list[Fraction]:
        """Return, in millimetres, how far at most its points are from the line of each rotary axis.

        However the axes within stand: about their pivots, points are in balls.
        """
        found: list[Fraction] = []
        # Of the pivot of the axis within, and of a ball around it that holds all of the object.
        within: tuple[Vector, Fraction] | None = None
        for axis in reversed(self.rotary):
            if within is None:
                points = self.mesh.facets.reshape(-1, 3).astype(np.float64) * float(scale)
                from_line = [float(a - p) for a, p in zip(self.at, axis.pivot, strict=True)]
                # What double precision rounds is far below that.
                rough = above(1e-12 * float(np.abs(points).max() + np.abs(from_line).max()))
                rough += 2 * self.mesh.rounding * scale
                points += from_line
                around = above(float(np.linalg.norm(points, axis=1).max())) + rough
                points[:, axis.number] = 0
                found.append(above(float(np.linalg.norm(points, axis=1).max())) + rough)
            else:
                apart = [float(p - q) for p, q in zip(within[0], axis.pivot, strict=True)]
                around = within[1] + above(float(np.linalg.norm(apart)))
                apart[axis.number] = 0.0
                found.append(within[1] + above(float(np.linalg.norm(apart))))
            within = axis.pivot, around
        return found[::-1]


@dataclass(frozen=True)
class _Seen(Curve):
    """A curve as another object sees it: ``factors`` times each point, and ``by``."""

    of: Curve
    factors: Vector
    by: Vector

    def at(self, part: Fraction) -> Vector:
        """Return a point, but for ``slack``."""
        return _scaled(self.factors, self.of.at(part), self.by)

    def extent(self) -> Box:
        """Return the lower and the upper corner of a box that holds all of it."""
        ends = zip(*(_scaled(self.factors, corner, self.by) for corner in self.of.extent()), strict=True)
        low, high = zip(*((min(c), max(c)) for c in ends), strict=True)
        return vector(low), vector(high)


def _scaled(factors: Vector, place: Vector, by: Vector) -> Vector:
    return vector(f * c + b for f, c, b in zip(factors, place, by, strict=True))


@dataclass(frozen=True)
class Piece:
    """Moves on which two meshes keep their directions, or, where they do not, are off by little.

    ``moves``: of A in the frame of B. ``program``: those that they are of, or the part of one that turns: the
    ``part`` from .. to. ``first``: the number of the first of them in the whole path. ``swept``: how far
    points are off at most, in millimetres, as axes turn on the way.
    """

    a: StlMesh
    b: StlMesh
    moves: tuple[Move, ...]
    program: tuple[Move, ...]
    first: int
    part: tuple[Fraction, Fraction] = (Fraction(0), Fraction(1))
    swept: Fraction = Fraction(0)
    meeting: "Meeting | None" = None

    def halves(self) -> "tuple[Piece, Piece]":
        """Return both halves of a part of a turn, in the order of the path."""
        assert self.meeting is not None
        (move,), (start, end) = self.program, self.part
        first, last = move.turns
        middle, half = move.angles(_HALF), (start + end) / 2
        if move.straight:
            place = move.at(_HALF)
            one = replace(move, end=place, turns=(first, middle))
            other = replace(move, start=place, turns=(middle, last))
            parts = (start, half), (half, end)
        else:
            # Axes do not keep time with each other: any place of the move goes with any angle.
            farthest = [r * abs(b - a) for r, a, b in zip(self.meeting.radii, first, last, strict=True)]
            widest = farthest.index(max(farthest))
            until, since = list(last), list(first)
            until[widest] = since[widest] = middle[widest]
            one, other = (
                replace(move, turns=(first, vector(until))),
                replace(move, turns=(vector(since), last)),
            )
            parts = self.part, self.part
        return (
            self.meeting.piece((one,), self.first, parts[0]),
            self.meeting.piece((other,), self.first, parts[1]),
        )

    def found(self, near: NearPose) -> NearPose:
        """Return a near pose as the program has it: where the tool is, the angles, the part of a move.

        By the axes that move A, seen from B; by the others where the tool is after that part of the move.
        """
        if self.meeting is None:
            return near
        move, (start, end) = self.program[near.move], self.part
        axes = zip(
            self.meeting.factors, near.position, self.meeting.seen_from(move)[2], move.at(near.part_of_move),
            strict=True,
        )  # fmt: skip
        position = vector((p - b) / f if f else c for f, p, b, c in axes)
        part = start + (end - start) * near.part_of_move
        return replace(near, position=position, angles=move.angles(near.part_of_move), part_of_move=part)


@dataclass(frozen=True)
class Meeting:
    """Two objects, A and B, that move against each other, by the axes that are not common to both.

    ``base``: the machine's coordinates are those of the moves and this; ``scale``: millimetres per STL unit.
    """

    a: Body
    b: Body
    base: Vector
    scale: Fraction

    @staticmethod
    def of(a: Body, b: Body, base: Vector, scale: Fraction) -> "Meeting":
        """Return the meeting of two objects with whole chains."""
        common = sum(
            1 for _ in takewhile(lambda pair: pair[0] == pair[1], zip(a.chain, b.chain, strict=False))
        )
        return Meeting(replace(a, chain=a.chain[common:]), replace(b, chain=b.chain[common:]), base, scale)

    @property
    def moving(self) -> bool:
        """Return whether anything moves one against the other."""
        return bool(self.a.chain or self.b.chain)

    @cached_property
    def factors(self) -> Vector:
        """Return how far A moves, as B sees it, by X, Y and Z."""
        return vector(Fraction(s - t) for s, t in zip(signs(self.a.chain), signs(self.b.chain), strict=True))

    @cached_property
    def radii(self) -> Vector:
        """Return how far points are at most from the lines that A, B and C turn them about: all together."""
        found = [Fraction(0)] * 3
        for body in (self.a, self.b):
            for axis, radius in zip(body.rotary, body.radii(self.scale), strict=True):
                found[axis.number] += radius
        return vector(found)

    def pieces(self, moves: Sequence[Move], coarse: Fraction) -> Iterator[Piece]:
        """Yield a path in pieces; as axes turn points are off by ``coarse`` millimetres at most on each."""
        first = 0
        for _, group in groupby(enumerate(moves), lambda numbered: self._kept(*numbered)):
            together = tuple(move for _, move in group)
            pending = [self.piece(together, first)]
            while pending:
                piece = pending.pop()
                if piece.swept > coarse:
                    pending += reversed(piece.halves())
                else:
                    yield piece
            first += len(together)

    def piece(
        self,
        program: tuple[Move, ...],
        first: int,
        part: tuple[Fraction, Fraction] = (Fraction(0), Fraction(1)),
    ) -> Piece:
        """Return a piece of moves that have the same angles, or of a part of one that turns."""
        a, b, by, error = self.seen_from(program[0])
        swept = self.off_by([abs(b - a) / 2 for a, b in zip(*program[0].turns, strict=True)])
        moves = tuple(self._seen(move, by, error + swept) for move in program)
        return Piece(a, b, moves, program, first, part, swept, self)

    def seen_from(self, move: Move) -> tuple[StlMesh, StlMesh, Vector, Fraction]:
        """Return A and B as they stand half-way through a move, where A is where all coordinates are 0, in
        millimetres, and how far that may be off.
        """
        (a, at, error), (b, other, more) = (body.turned(move.angles(_HALF)) for body in (self.a, self.b))
        apart = vector(Rational(p - q) for p, q in zip(at, other, strict=True))
        return a, b, _scaled(self.factors, self.base, apart), error + more

    def _kept(self, number: int, move: Move) -> tuple[int, Vector]:
        """Return what is equal for moves that one piece may hold."""
        first, last = (
            vector(c if r else Fraction(0) for r, c in zip(self.radii, end, strict=True))
            for end in move.turns
        )
        return (number, first) if first != last else (-1, first)

    def off_by(self, degrees: Sequence[Fraction]) -> Fraction:
        """Return how far points are off at most, in millimetres, where A, B and C are off by so much."""
        return sum((r * _RADIANS * d for r, d in zip(self.radii, degrees, strict=True)), Fraction(0))

    def _seen(self, move: Move, by: Vector, off: Fraction) -> Move:
        """Return a move of A in the frame of B."""
        factors = self.factors
        most, slack = max(1, *map(abs, factors)), off + self.off_by([move.turn_slack] * 3)
        start, end = (_scaled(factors, place, by) for place in (move.start, move.end))
        curve = move.curve and _Seen(
            start, end, move.curve.bend * most, move.curve.slack * most, move.curve, factors, by
        )
        return replace(move, start=start, end=end, curve=curve, slack=move.slack * most + slack)
