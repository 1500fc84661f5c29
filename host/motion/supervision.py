"""What the board is asked about where a machine is of several objects, and what is shown clear before.

The board holds two meshes, each as it stands. What moves with the tool joins it there, what moves with the
workpiece joins that: the board decides all pairs of these two again, just before the tool comes there. Two
other objects are *beside* it: by fewer axes, or by others, they move against each other.

A piece of the path permits the tool to be anywhere in a cube, within its reach h of its sample (`follow`). So
the pieces are cut until each two beside the board are clear wherever these axes can be in the cube. With f
how far A moves by X, Y and Z as B sees it (`kinematics`), the cube becomes a box with half sides of |f| h,
which one pose with its margin covers like any other (`path_scene`).

While X, Y or Z move nothing turns: the board would have to be loaded anew on the way. Where A, B or C turn,
and X, Y, Z stand still, a program is cut in *stands* with a turn between them. A turn is shown clear before,
for all objects, as `path` does; of each stand the board holds the meshes as they stand then. Axes that may be
off move points by at most the sum of the radii of both objects times that (`kinematics`): the largest of all
pairs of the board is added to its clearance.

The board is asked about all pairs of the two meshes: an object that may touch one of the other side is in
neither, and beside the board with all of that side.

A stock (`contact`) is beside the board as well: it is no place where nothing may be. What of the tool must
stay clear of it, on some moves, is shown so in the pieces of these. Where it would be inside of it at the
start of one of them, the first piece of that move is near.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from itertools import groupby, product

import numpy as np

from triaxis.golden.errors import InputError
from triaxis.golden.exact import Rational
from triaxis.golden.pairs import coordinate_range
from triaxis.host.enclosure import Enclosure, State
from triaxis.host.engines import SceneEngine
from triaxis.host.motion.contact import Rule, Setup
from triaxis.host.motion.kinematics import Body, Meeting
from triaxis.host.motion.machine import CARRIED, STOCK, TOOL, WORKPIECE
from triaxis.host.motion.moves import Program
from triaxis.host.motion.path_check import PathResult, bulk_engine, insides_at, shown_clear
from triaxis.host.motion.path_scene import PathScene, Segment, Wanted
from triaxis.host.quantise import NOWHERE, Vector, vector
from triaxis.host.stl import StlMesh

# Lines that are listed.
_LISTED = 10
# Of two objects that come near each other.
Names = tuple[str, str]


@dataclass(frozen=True)
class Joined:
    """Objects that do not move against each other, as one mesh, with its origin at a place of the machine."""

    bodies: Sequence[Body]
    scale: Fraction
    origin: Vector

    @cached_property
    def mesh(self) -> StlMesh:
        """Return the facets of all, in their order.

        With u = 2^-53 and M the largest of coordinates and shifts, float64 moves a shift by at most u M, and
        the sum by at most 2 u M and a little: less than 4 u M together.
        """
        meshes = [self._placed(body) for body in self.bodies]
        if len(meshes) == 1:
            return meshes[0]
        facets = np.concatenate([mesh.facets.astype(np.float64) for mesh in meshes])
        return StlMesh(facets, max(mesh.rounding for mesh in meshes))

    def _placed(self, body: Body) -> StlMesh:
        if body.at == self.origin:
            return body.mesh
        shift = [float((c - o) / self.scale) for c, o in zip(body.at, self.origin, strict=True)]
        largest = max(float(np.abs(body.mesh.facets).max()), *map(abs, shift))
        rounding = body.mesh.rounding + Fraction(largest) / (1 << 51)
        return StlMesh(body.mesh.facets.astype(np.float64) + shift, rounding)

    @property
    def name(self) -> str:
        """Return what all of them are called."""
        others = f" and what moves with it ({len(self.bodies) - 1})" if len(self.bodies) > 1 else ""
        return f"the {self.bodies[0].name}{others}"

    @property
    def files(self) -> str:
        """Return the files that they come from."""
        return ", ".join(body.file for body in self.bodies)

    def named(self, facet: int) -> str:
        """Return the name of the object that a facet is of."""
        ends = np.cumsum([len(body.mesh.facets) for body in self.bodies])
        return f"the {self.bodies[int(np.searchsorted(ends, facet, 'right'))].name}"


@dataclass(frozen=True)
class Beside:
    """Two objects that the board is not asked about, and their scene: its moves in the frame of B."""

    rule: Rule
    scene: PathScene
    engine: SceneEngine

    @cached_property
    def _factors(self) -> Vector:
        """Return how far A moves, as B sees it, by X, Y and Z."""
        return self.rule.meeting.factors if self.rule.meeting else vector([Fraction(1)] * 3)

    @cached_property
    def _by(self) -> Vector:
        """Return where A is, as B sees it, with the tool at the program's zero."""
        meeting = self.rule.meeting
        return meeting.seen_from(self.rule.program.moves[0])[2] if meeting else NOWHERE

    @cached_property
    def _off(self) -> Rational:
        """Return how far A may be off that, in steps, as axes that turn may be."""
        meeting, moves = self.rule.meeting, self.rule.program.moves
        if meeting is None:
            return Rational(0)
        off = meeting.seen_from(moves[0])[3] + meeting.off_by([max(move.turn_slack for move in moves)] * 3)
        return Rational(off / self.scene.wanted.resolution)

    @cached_property
    def _numbers(self) -> frozenset[int]:
        return frozenset(self.rule.numbers)

    @property
    def insides(self) -> Enclosure:
        """Return whether one of them is inside the other at the start."""
        return insides_at(self.scene)

    @cached_property
    def _starts(self) -> dict[int, int]:
        """Return, of a stock, the moves before which it does not count: their places in the rule."""
        starts = self.scene.program.starts if self.rule.of_stock else []
        return {self.rule.numbers[start]: start for start in starts}

    @cached_property
    def _inside(self) -> dict[int, bool]:
        """Whether one is inside the other where one of these begins, as far as it was asked."""
        return {}

    def _begins_inside(self, number: int) -> bool:
        """Return whether one is inside the other at a start, where no facets are near.

        Raises InputError where nobody knows.
        """
        if number not in self._inside:
            start = self._starts[number]
            found = insides_at(self.scene, start)
            at = f" at the start of line {self.rule.program.moves[start].line}"
            found.refuse_undecided(self.rule.files, False, at)
            self._inside[number] = found.state != State.OUTSIDE
        return self._inside[number]

    @cached_property
    def _clear_still(self) -> bool:
        """Return whether they are clear where X, Y and Z move neither against the other."""
        return self._clear(NOWHERE, NOWHERE)

    def clear(self, low: Vector, high: Vector, moves: range) -> bool:
        """Return whether the rule is kept with the tool anywhere in a box, in millimetres, on some moves."""
        if self._numbers.isdisjoint(moves):
            return True
        if not (self._clear(low, high) if any(self._factors) else self._clear_still):
            return False
        # Most have none of these, and a group has very many moves.
        begins = moves if self._starts else ()
        return not any(self._begins_inside(one) for one in begins if self._begins_there(one, low, high))

    def _begins_there(self, number: int, low: Vector, high: Vector) -> bool:
        """Return whether it is a move of `_starts` that begins in a box."""
        if number not in self._starts:
            return False
        start = self.rule.program.moves[self._starts[number]].start
        return all(a <= c <= b for a, c, b in zip(low, start, high, strict=True))

    def _clear(self, low: Vector, high: Vector) -> bool:
        factors, by = self._factors, self._by
        start, end = (
            self.scene.place(vector(f * c + b for f, c, b in zip(factors, corner, by, strict=True)))
            for corner in (low, high)
        )
        segment = Segment(start, end, Rational(0), Rational(1), slack=self._off, between=True)
        least, most = coordinate_range(self.scene.grid.width)
        corners = zip(segment.sample, *self.scene.box_a, strict=True)
        fits = all(least <= t + a and t + b <= most for t, a, b in corners)
        return fits and shown_clear(self.scene, self.engine, segment, PathResult())


@dataclass(frozen=True)
class Supervision:
    """The two meshes of the board for a part of a program with one tool, and the pairs beside them.

    ``off``: how far, in millimetres, axes that turn may move points of the two meshes against each other;
    ``shown``: what a page shows that does not move with the tool: a stock, too.
    """

    tool: Joined
    work: Joined
    beside: Sequence[Beside]
    off: Fraction
    shown: Joined

    @staticmethod
    def of(setup: Setup, program: Program, rules: Sequence[Rule], wanted: Wanted) -> "Supervision":
        """Put the objects of a machine together; raise InputError where the board cannot be asked so.

        ``rules``: what must stay clear of what, by the numbers of the program's moves.
        """
        tool = setup.carried(TOOL, setup.tool.mesh, setup.tool.name)
        work = setup.carried(WORKPIECE, setup.work[0], str(setup.work[1]))
        with_tool, with_work = (
            [body for body in setup.machine.objects if not _moved(setup.meeting(body, carrier))]
            for carrier in (tool, work)
        )
        sides = _apart([tool, *with_tool], [work, *with_work], setup)
        on_board = {frozenset((a.name, b.name)) for a in sides[0] for b in sides[1]}
        decided = {frozenset(f"the {name}" for name in names) for names in on_board}
        beside = [_beside(rule, wanted) for rule in rules if frozenset(rule.names) not in decided]
        angles, degrees = program.moves[0].turns[0], [max(move.turn_slack for move in program.moves)] * 3
        one, other = ([_standing(body, angles, setup.scale) for body in side] for side in sides)
        # What is there with the machine's axes at 0 is at the workpiece's origin with the program's at 0.
        zero = vector(c - b for c, b in zip(other[0].at, setup.base, strict=True))
        shown = [*other, *(_standing(one, angles, setup.scale) for one in setup.bodies if one.name == STOCK)]
        return Supervision(
            Joined(one, setup.scale, zero), Joined(other, setup.scale, other[0].at), beside,
            max(setup.meeting(a, b).off_by(degrees) for a, b in product(*sides)),
            Joined(shown, setup.scale, other[0].at),
        )  # fmt: skip

    def within(self, clearance: Fraction) -> "Supervision":
        """Return the same with another clearance, in millimetres; raise InputError where it does not fit."""
        return replace(self, beside=[replace(one, scene=one.scene.within(clearance)) for one in self.beside])

    def near_beside(self, scene: PathScene, segment: Segment, moves: range) -> Names | None:
        """Return two objects beside the board that are not shown clear where a segment's sample covers it.

        ``moves``: the numbers of those that it is of.
        """
        reach, scale = segment.reach, scene.wanted.scale
        low, high = (
            vector(c * scale for c in scene.path.position(vector(t + side * reach for t in segment.sample)))
            for side in (-1, 1)
        )
        return next((one.rule.names for one in self.beside if not one.clear(low, high, moves)), None)


def _apart(tool: list[Body], work: list[Body], setup: Setup) -> tuple[list[Body], list[Body]]:
    """Return what moves with the tool, and with the workpiece, without objects that may touch the other side.

    All others of theirs are beside the board then.
    """
    for a, b in product(tool, work):
        if frozenset((a.name, b.name)) in setup.machine.may_touch:
            one = b if a.name in CARRIED else a
            return _apart(
                [body for body in tool if body is not one], [body for body in work if body is not one], setup
            )
    return tool, work


def _moved(meeting: Meeting) -> bool:
    """Return whether X, Y or Z move one of two objects against the other."""
    return any(not axis.rotary for axis in (*meeting.a.chain, *meeting.b.chain))


def _standing(body: Body, angles: Vector, scale: Fraction) -> Body:
    """Return an object as it stands at angles: its mesh turned, and where its origin is then."""
    mesh, at, error = body.turned(angles)
    return replace(body, mesh=StlMesh(mesh.facets, mesh.rounding + error / scale), at=at)


def stands_and_turns(program: Program, tolerance: Fraction) -> list[Program]:
    """Return the parts of a program in which A, B, C stand still, and those in which they turn, in its order.

    ``tolerance``: how far these axes may be off, in degrees. Raises InputError where X, Y or Z move in a
    turn, and where angles alone cannot tell whether a turn is over.
    """
    if both := sorted({move.line for move in program.moves if move.turning and move.start != move.end}):
        lines = ", ".join(map(str, both[:_LISTED])) + ", .." * (len(both) > _LISTED)
        raise InputError(
            f"{program.path}: line {lines}: A, B, C turn while X, Y, Z move: the board holds meshes as they "
            "stand: move one after the other, or check with path"
        )
    parts = [
        replace(program, moves=tuple(moves)) for _, moves in groupby(program.moves, lambda one: one.turning)
    ]
    for part in parts:
        if part.moves[0].turning:
            _check_order(part, 2 * tolerance)
    return parts


def _check_order(turn: Program, apart: Fraction) -> None:
    """Raise InputError where the angles at the end of a turn are passed before."""
    *before, last = [move.turns for move in turn.moves]
    for one, other in (*before, (last[0], last[0])):
        between = zip(one, other, last[1], strict=True)
        if all(min(a, b) - apart <= end <= max(a, b) + apart for a, b, end in between):
            raise InputError(
                f"{turn.path}: line {turn.moves[-1].line}: the angles at the end of this turn are passed, or "
                "nearly, before it is over, so that nothing tells when it is: move X, Y or Z between, or "
                "check with path"
            )


def _beside(rule: Rule, wanted: Wanted) -> Beside:
    # Nothing turns on it, so that all of it is one piece.
    (piece,) = rule.pieces(wanted.step)
    scene = rule.scene(piece, wanted)
    return Beside(rule, scene, bulk_engine(scene))
