"""A tool, a workpiece and a program on the grid; samples of the path, and why nothing is missed between.

Tool and workpiece have grids of the same resolution: the tool's around itself, in its own frame, the
workpiece's around all that the tool passes. Lengths are in the unit of the files; ``scale`` is millimetres
per unit.

A coordinate x of the tool A stands at qa = round((x - oa) / r), one of the workpiece B at qb = round((x -
ob) / r), each at most 1/2 from the real quotient. With the tool at the real position p, its point x is on
B's grid at (x - oa) / r + u, u = (p + oa - ob) / r. A sample is an integer translation T. For a point of
the path with place u,

    |D - d| <= 1/2 + 1/2 + e / r + |u - T|       (all in steps of r, all distances Chebyshev)

where D is the real distance of A at p and B, d that of the integer meshes with A at T, and e what reading
the files (and turning A) moved coordinates, both together: moving each point of A by at most t, and each of
B by at most s, changes the distance by at most t + s.

|u - T| is a convex function of u, so along a straight segment of the path it is largest at an end: the
*reach*, an exact rational, which holds the rounding of the translation (at most 1/2, T being the nearest to
the middle) and half the segment. It is the largest of three coordinates, so it holds for all of the box
between the ends as well: for each way on which no axis turns back, which is all that is known of a rapid. A
curve is as far from T as its chord, and its sag (`curves`); what a control may leave the path by, the
slack, comes on top. So where the engine says at T that nothing is near at the margin

    m = ceil((c + e) / r + 1 + reach),

d > m, and D > c / r at every real position of the segment: it is proven clear, no position of it left out.

Where it says near at a segment no longer than the step s, the real distance at the segment's middle is less
than c + 2 e + r (4 + s / (2 r)), and the slack: the band of false alarms. A curve's length counts its sag
four times: twice in the reach, and as its middle is that far from that of its chord.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property

import numpy as np
import numpy.typing as npt

from triaxis.golden.errors import InputError
from triaxis.golden.exact import Rational
from triaxis.golden.pairs import coordinate_range
from triaxis.host.engines import Translation
from triaxis.host.euclidean import ROOT_3
from triaxis.host.motion.moves import Move, Program
from triaxis.host.quantise import (
    Box,
    Grid,
    Vector,
    box_of,
    check_clearance,
    check_resolution,
    check_scale,
    fits,
    grid_around,
    quantise,
    smallest_width,
    vector,
)
from triaxis.host.scene import AUTOMATIC_WIDTHS
from triaxis.host.shells import Solid, solid_of
from triaxis.host.stl import StlMesh

GridPoint = tuple[Rational, Rational, Rational]


@dataclass(frozen=True)
class Segment:
    """A piece of a move: its ends, in steps on B's grid, and where in the move it lies, 0..1.

    All of it is at most ``slack`` plus `sag` steps from its chord, or, where ``between``, from the box of its
    ends.
    ``curve``: the place of a part of the move, and its bend in steps.
    """

    start: GridPoint
    end: GridPoint
    first: Rational
    last: Rational
    level: int = 0
    slack: Rational = Rational(0)  # noqa: RUF009
    between: bool = False
    curve: tuple[Callable[[Rational], GridPoint], Rational] | None = None

    @property
    def sag(self) -> Rational:
        """Return how far a curve is from its chord, in steps (`curves`)."""
        return self.curve[1] * (self.last - self.first) ** 2 / 8 if self.curve else Rational(0)

    @property
    def length(self) -> Rational:
        """Return the Chebyshev length, in steps; of a curve with twice what it may reach beyond."""
        return max(abs(b - a) for a, b in zip(self.start, self.end, strict=True)) + 4 * self.sag

    @property
    def middle(self) -> GridPoint:
        """Return the place half-way."""
        if self.curve is not None:
            return self.curve[0]((self.first + self.last) / 2)
        return vector((a + b) / 2 for a, b in zip(self.start, self.end, strict=True))

    @property
    def sample(self) -> Translation:
        """Return the integer translation nearest the middle."""
        return nearest(self.middle)

    @property
    def reach(self) -> Rational:
        """Return the Chebyshev distance, in steps, that no point of the segment exceeds from the sample."""
        ends = zip(self.start + self.end, self.sample * 2, strict=True)
        return max(abs(x - t) for x, t in ends) + self.sag + self.slack

    def halves(self) -> "tuple[Segment, Segment]":
        """Return both halves, in the order of the path; of a box, cut across its longest side."""
        half, level = (self.first + self.last) / 2, self.level + 1
        middle = self.middle
        until, since = middle, middle
        if self.between:
            longest = max(range(3), key=lambda k: abs(self.end[k] - self.start[k]))
            until = vector(middle[k] if k == longest else self.end[k] for k in range(3))
            since = vector(middle[k] if k == longest else self.start[k] for k in range(3))
        return (
            replace(self, end=until, last=half, level=level),
            replace(self, start=since, first=half, level=level),
        )


def round_half_up(value: Rational) -> int:
    """Return the nearest integer, halves up."""
    return int((value + Rational(1, 2)) // 1)


def nearest(place: GridPoint) -> Translation:
    """Return the integer translation nearest a place."""
    return vector(map(round_half_up, place))


def upwards(value: Rational) -> int:
    """Return the smallest integer that is not less."""
    return int(-(-value // 1))


@dataclass(frozen=True)
class PathGrid:
    """How positions of the tool become places on B's grid, and clearances margins.

    ``shift`` is oa - ob; ``base`` is (c + e) / r + 1. Lengths in the unit of the files.
    """

    resolution: Fraction
    shift: Vector
    clearance: Fraction
    reading: Fraction

    @cached_property
    def base(self) -> Rational:
        """Return what the margin holds besides the reach, in steps."""
        return Rational((self.clearance + self.reading) / self.resolution + 1)

    def place(self, position: Vector) -> GridPoint:
        """Return the place u of a position, in steps."""
        return vector(Rational((p + s) / self.resolution) for p, s in zip(position, self.shift, strict=True))

    def position(self, place: GridPoint) -> Vector:
        """Return the position at a place."""
        return vector(_fraction(u) * self.resolution - s for u, s in zip(place, self.shift, strict=True))

    def margin(self, segment: Segment) -> int:
        """Return the margin at which a clear sample proves the whole segment clear."""
        return upwards(self.base + segment.reach)

    def showing(self, distance: Fraction, away: Rational) -> int:
        """Return the least margin that proves a distance ``away`` steps from a sample that is clear."""
        return upwards(Rational((distance + self.reading) / self.resolution) + 1 + away)

    def proven(self, margin: int, away: Rational) -> Fraction:
        """Return the distance that is exceeded ``away`` steps from a sample that is clear at a margin."""
        return (margin - 1 - _fraction(away)) * self.resolution - self.reading

    def seen(self, margin: int, away: Rational) -> Fraction:
        """Return the distance that is not exceeded ``away`` steps from a sample that is near at a margin."""
        return (margin + 1 + _fraction(away)) * self.resolution + self.reading

    def band(self, step: Fraction) -> Fraction:
        """Return how far beyond the clearance a false alarm can be, at segments of a step."""
        return 2 * self.reading + 4 * self.resolution + step / 2


def _fraction(value: Rational) -> Fraction:
    return Fraction(int(value.numerator), int(value.denominator))


Corners = tuple[list[int], list[int]]


@dataclass(frozen=True)
class Wanted:
    """What is asked of a path, in millimetres.

    ``step``: the longest segment on which a near pose ends the check; ``margin_bits``: of the engine, where
    these are not its width.
    """

    clearance: Fraction
    resolution: Fraction
    step: Fraction
    scale: Fraction
    width: int | None
    euclidean: bool = False
    margin_bits: int | None = None


@dataclass(frozen=True)
class PathScene:
    """Both meshes as files and as integers (N, 3, 3), the program, and the grid of its positions."""

    tool: StlMesh
    work: StlMesh
    a: npt.NDArray[np.int64]
    b: npt.NDArray[np.int64]
    program: Program
    grid: Grid
    path: PathGrid
    wanted: Wanted

    @property
    def step(self) -> Rational:
        """Return the longest segment on which a near pose ends the check, in steps of the grid."""
        return Rational(self.wanted.step / self.wanted.resolution)

    @property
    def band(self) -> Fraction:
        """Return how far beyond the clearance a false alarm can be, in millimetres."""
        slack = Rational(max(move.slack for move in self.program.moves))
        band = self.path.band(self.wanted.step / self.wanted.scale) * self.wanted.scale + _fraction(slack)
        return band * ROOT_3 if self.wanted.euclidean else band

    @property
    def largest_margin(self) -> int:
        """Return the largest margin of the engine."""
        return (1 << (self.wanted.margin_bits or self.grid.width)) - 1

    def within(self, clearance: Fraction) -> "PathScene":
        """Return the same with another clearance, in millimetres; raise InputError where it does not fit."""
        path = replace(self.path, clearance=clearance / self.wanted.scale)
        scene = replace(self, path=path, wanted=replace(self.wanted, clearance=clearance))
        _check_margin(scene)
        return scene

    def in_files(self, position: Vector) -> Vector:
        """Return a position in millimetres in the unit of the files."""
        return vector(c / self.wanted.scale for c in position)

    def place(self, position: Vector) -> GridPoint:
        """Return the place of a position in millimetres."""
        return self.path.place(self.in_files(position))

    def segment(self, move: Move) -> Segment:
        """Return the whole move as a segment."""
        step, curve = self.wanted.resolution, move.curve
        bend = (
            (lambda part: self.place(move.at(_fraction(part))), Rational(curve.bend / step))
            if curve
            else None
        )
        return Segment(
            self.place(move.start), self.place(move.end), Rational(0), Rational(1), 0,
            Rational(move.slack / step), not move.straight and curve is None, bend,
        )  # fmt: skip

    @cached_property
    def extents(self) -> npt.NDArray[np.int64]:
        """Return boxes of whole steps, low and high corner, that hold all of each move: (moves, 2, 3)."""
        step, boxes = self.wanted.resolution, list[tuple[list[int], list[int]]]()
        for move in self.program.moves:
            slack = Rational(move.slack / step)
            low, high = (self.place(corner) for corner in move.extent)
            boxes.append(([-upwards(slack - u) for u in low], [upwards(u + slack) for u in high]))
        return np.array(boxes, np.int64)

    def group(self, first: int, last: int) -> Segment:
        """Return a box of all places of moves, from the first to the one before the last, as a segment."""
        low = self.extents[first:last, 0].min(0).tolist()
        high = self.extents[first:last, 1].max(0).tolist()
        start, end = (vector(map(Rational, corner)) for corner in (low, high))
        return Segment(start, end, Rational(0), Rational(1), between=True)

    @cached_property
    def solids(self) -> tuple[Solid, Solid]:
        """Return both meshes with their shells, the tool's at translation 0."""
        return solid_of(self.a), solid_of(self.b)

    @cached_property
    def box_a(self) -> Corners:
        """Return the corners of the tool's box, at translation 0."""
        return self.a.min((0, 1)).tolist(), self.a.max((0, 1)).tolist()

    @cached_property
    def box_b(self) -> Corners:
        """Return the corners of the workpiece's box."""
        return self.b.min((0, 1)).tolist(), self.b.max((0, 1)).tolist()


def prepare_path(
    tool: StlMesh, work: StlMesh, names: tuple[str, str], program: Program, wanted: Wanted
) -> PathScene:
    """Put all of it on the grid; raise InputError where something does not fit, with the line of a move."""
    _check_wanted(wanted)
    scale = wanted.scale
    resolution, clearance = wanted.resolution / scale, wanted.clearance / scale
    check_resolution(resolution)
    slack = max(move.slack for move in program.moves) / scale
    room = clearance + slack + wanted.step / scale + 4 * resolution
    boxes = [box_of(work.facets), *_swept(tool, program, scale, 2 * resolution)]
    width = wanted.width or smallest_width(boxes, resolution, room, AUTOMATIC_WIDTHS)
    grid_a = grid_around([box_of(tool.facets)], resolution, width)
    grid = grid_around(boxes, resolution, width)
    if not fits(boxes, grid):
        # Then it is the move that leaves it that is to be named, not the workpiece.
        grid = grid_around([box_of(work.facets)], resolution, width)
    shift = vector(a - b for a, b in zip(grid_a.offset, grid.offset, strict=True))
    path = PathGrid(resolution, shift, clearance, tool.rounding + work.rounding)
    a, b = quantise(tool.facets, grid_a, names[0]), quantise(work.facets, grid, names[1])
    scene = PathScene(tool, work, a, b, program, grid, path, wanted)
    _check_margin(scene)
    _check_moves(scene)
    return scene


def _check_wanted(wanted: Wanted) -> None:
    check_clearance(wanted.clearance)
    check_scale(wanted.scale)
    if wanted.step < wanted.resolution:
        raise InputError(
            f"step {float(wanted.step):g}: must be at least the resolution, {float(wanted.resolution):g}"
        )


def _swept(tool: StlMesh, program: Program, scale: Fraction, room: Fraction) -> Iterator[Box]:
    """Yield boxes of the tool, with room around, that together reach as far as it does on the path."""
    lows, highs = zip(*(move.extent for move in program.moves), strict=True)
    slack = max(move.slack for move in program.moves)
    for extreme, corners, far in ((min, lows, -room), (max, highs, room)):
        further = far + slack / scale * (1 if far > 0 else -1)
        yield box_of(tool.facets, vector(extreme(c) / scale + further for c in zip(*corners, strict=True)))


def _check_margin(scene: PathScene) -> None:
    """Raise InputError unless the margin of the shortest segments fits the engine."""
    slack = Rational(max(move.slack for move in scene.program.moves) / scene.wanted.resolution)
    needed = upwards(scene.path.base + Rational(1, 2) + scene.step / 2 + slack)
    if needed > scene.largest_margin:
        raise InputError(
            f"clearance {float(scene.wanted.clearance):g} with step {float(scene.wanted.step):g}: a margin "
            f"of {needed} grid steps, but the engine's is at most {scene.largest_margin}; use a "
            "coarser resolution, a smaller step or a larger width"
        )


def _check_moves(scene: PathScene) -> None:
    """Raise InputError where the tool leaves the grid. Between two ends that fit, everything does."""
    least, most = coordinate_range(scene.grid.width)
    low, high = scene.box_a
    outside = (scene.extents[:, 0] + low < least) | (scene.extents[:, 1] + high > most)
    if outside.any():
        number, k = (int(x[0]) for x in np.nonzero(outside))
        move = scene.program.moves[number]
        ends = [move.end, move.start] if number else [move.start, move.end]
        position = max(ends, key=lambda end: abs(scene.place(end)[k]))
        where = " ".join(f"{n}{float(c):g}" for n, c in zip("XYZ", position, strict=True))
        raise InputError(
            f"{scene.program.path}: line {move.line}: at {where} the tool leaves the {scene.grid.width}-bit "
            f"grid along {'xyz'[k]}; use a coarser resolution or a larger width"
        )
