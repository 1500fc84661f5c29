"""What the board is asked about where a machine is of several objects, and what is shown clear before.

The board holds two meshes, each as it stands. What moves with the tool joins it there, what moves with the
workpiece joins that: the board decides all pairs of these two again, just before the tool comes there. Two
other objects are *beside* it: by fewer axes, or by others, they move against each other.

A piece of the path permits the tool to be anywhere in a cube, within its reach h of its sample (`follow`). So
the pieces are cut until each two beside the board are clear wherever these axes can be in the cube. With f
how far A moves by X, Y and Z as B sees it (`kinematics`), the cube becomes a box with half sides of |f| h,
which one pose with its margin covers like any other (`path_scene`).

Nothing turns: the board would have to be loaded anew on the way.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property

import numpy as np

from triaxis.golden.errors import InputError
from triaxis.golden.exact import Rational
from triaxis.golden.pairs import coordinate_range
from triaxis.host.enclosure import Enclosure
from triaxis.host.engines import BULK, SceneEngine, scene_engine
from triaxis.host.motion.contact import Rule, Setup
from triaxis.host.motion.kinematics import Body, Meeting
from triaxis.host.motion.machine import TOOL, WORKPIECE
from triaxis.host.motion.moves import Program
from triaxis.host.motion.path_check import PathResult, insides_at, shown_clear
from triaxis.host.motion.path_scene import PathScene, Segment, Wanted, prepare_path
from triaxis.host.quantise import Vector, vector
from triaxis.host.stl import StlMesh

# Of two objects that come near each other.
Names = tuple[str, str]


@dataclass(frozen=True)
class Joined:
    """Objects that do not move against each other, as one mesh, in the frame of the first of them."""

    bodies: Sequence[Body]
    scale: Fraction

    @cached_property
    def mesh(self) -> StlMesh:
        """Return the facets of all, in their order.

        With u = 2^-53 and M the largest of coordinates and shifts, float64 moves a shift by at most u M, and
        the sum by at most 2 u M and a little: less than 4 u M together.
        """
        first, *others = self.bodies
        facets, rounding = [first.mesh.facets], first.mesh.rounding
        for body in others:
            shift = [float((c - o) / self.scale) for c, o in zip(body.at, first.at, strict=True)]
            facets.append(body.mesh.facets.astype(np.float64) + shift)
            largest = max(float(np.abs(body.mesh.facets).max()), *map(abs, shift))
            rounding = max(rounding, body.mesh.rounding + Fraction(largest) / (1 << 51))
        return StlMesh(np.concatenate(facets) if others else first.mesh.facets, rounding)

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
    """Two objects that the board is not asked about, and their scene: the whole program in the frame of B."""

    rule: Rule
    meeting: Meeting
    scene: PathScene
    engine: SceneEngine

    @cached_property
    def _by(self) -> Vector:
        """Return where A is, as B sees it, with the tool at the program's zero."""
        return self.meeting.seen_from(self.rule.program.moves[0])[2]

    @property
    def insides(self) -> Enclosure:
        """Return whether one of them is inside the other at the start."""
        return insides_at(self.scene)

    def clear(self, low: Vector, high: Vector) -> bool:
        """Return whether they are clear with the tool anywhere in a box, in millimetres."""
        factors, by = self.meeting.factors, self._by
        start, end = (
            self.scene.place(vector(f * c + b for f, c, b in zip(factors, corner, by, strict=True)))
            for corner in (low, high)
        )
        segment = Segment(start, end, Rational(0), Rational(1), between=True)
        least, most = coordinate_range(self.scene.grid.width)
        corners = zip(segment.sample, *self.scene.box_a, strict=True)
        fits = all(least <= t + a and t + b <= most for t, a, b in corners)
        return fits and shown_clear(self.scene, self.engine, segment, PathResult())


@dataclass(frozen=True)
class Supervision:
    """The two meshes of the board for a part of a program with one tool, and the pairs beside them."""

    tool: Joined
    work: Joined
    beside: Sequence[Beside]

    @staticmethod
    def of(setup: Setup, program: Program, wanted: Wanted) -> "Supervision":
        """Put the objects of a machine together; raise InputError where the board cannot be asked so."""
        tool = setup.carried(TOOL, setup.tool.mesh, setup.tool.name)
        work = setup.carried(WORKPIECE, setup.work[0], str(setup.work[1]))
        if not setup.machine.objects:
            return Supervision(Joined([tool], setup.scale), Joined([work], setup.scale), ())
        with_tool, with_work = (
            [body for body in setup.machine.objects if not setup.meeting(body, carrier).moving]
            for carrier in (tool, work)
        )
        sides = [tool, *with_tool], [work, *with_work]
        on_board = {frozenset((a.name, b.name)) for a in sides[0] for b in sides[1]}
        if touching := sorted(map(sorted, on_board & setup.machine.may_touch)):
            raise InputError(
                f"may_touch: {' and '.join(touching[0])}: the board is asked about all that moves with the "
                "tool against all that moves with the workpiece: leave one mesh out, or check with path"
            )
        rules = [
            rule
            for rule in setup.rules(program, 0)
            if rule.meeting and frozenset((rule.meeting.a.name, rule.meeting.b.name)) not in on_board
        ]
        one, other = (Joined(side, setup.scale) for side in sides)
        return Supervision(one, other, [_beside(rule, wanted) for rule in rules])

    def within(self, clearance: Fraction) -> "Supervision":
        """Return the same with another clearance, in millimetres; raise InputError where it does not fit."""
        return replace(self, beside=[replace(one, scene=one.scene.within(clearance)) for one in self.beside])

    def near_beside(self, scene: PathScene, segment: Segment) -> Names | None:
        """Return two objects beside the board that are not shown clear where a segment's sample covers it."""
        reach, scale = segment.reach, scene.wanted.scale
        low, high = (
            vector(c * scale for c in scene.path.position(vector(t + side * reach for t in segment.sample)))
            for side in (-1, 1)
        )
        return next((one.rule.names for one in self.beside if not one.clear(low, high)), None)


def _beside(rule: Rule, wanted: Wanted) -> Beside:
    assert rule.meeting is not None
    # Nothing turns, so that all of it is one piece.
    (piece,) = rule.pieces(wanted.step)
    program = Program(rule.program.path, piece.moves, ())
    scene = prepare_path(piece.a, piece.b, rule.files, program, wanted)
    return Beside(rule, rule.meeting, scene, scene_engine(BULK, scene.a, scene.b, scene.grid.width))
