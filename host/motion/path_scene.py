"""A tool, a workpiece and a program on the engine's grid.

Tool and workpiece have grids of the same resolution: the tool's around itself, in its own frame, the
workpiece's around all that the tool passes. Lengths are in the unit of the files; ``scale`` is millimetres
per unit.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import numpy as np
import numpy.typing as npt

from triaxis.golden.errors import InputError
from triaxis.golden.exact import Rational
from triaxis.golden.pairs import coordinate_range
from triaxis.host.meshcheck import AUTOMATIC_WIDTHS
from triaxis.host.motion.program import Move, Program
from triaxis.host.motion.sampling import PathGrid, Segment, round_half_up, upwards
from triaxis.host.quantise import (
    Box,
    Grid,
    Vector,
    box_of,
    check_resolution,
    fits,
    grid_around,
    quantise,
    smallest_width,
)
from triaxis.host.stl import StlMesh

Corners = tuple[list[int], list[int]]


@dataclass(frozen=True)
class Wanted:
    """What is asked of a path, in millimetres. ``step``: the longest segment on which a near pose ends the
    check."""

    clearance: Fraction
    resolution: Fraction
    step: Fraction
    scale: Fraction
    width: int | None


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
        return self.path.band(self.wanted.step / self.wanted.scale) * self.wanted.scale

    @property
    def largest_margin(self) -> int:
        """Return the largest margin of the engine."""
        return (1 << self.grid.width) - 1

    def in_files(self, position: Vector) -> Vector:
        """Return a position in millimetres in the unit of the files."""
        x, y, z = (c / self.wanted.scale for c in position)
        return x, y, z

    def segment(self, move: Move) -> Segment:
        """Return the whole move as a segment."""
        start, end = (self.path.place(self.in_files(position)) for position in (move.start, move.end))
        return Segment(start, end, Rational(0), Rational(1))

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
    room = clearance + wanted.step / scale + 4 * resolution
    boxes = [box_of(work.facets), *_swept(tool, program, scale, 2 * resolution)]
    width = wanted.width or smallest_width(boxes, resolution, room, AUTOMATIC_WIDTHS)
    grid_a = grid_around([box_of(tool.facets)], resolution, width)
    grid = grid_around(boxes, resolution, width)
    if not fits(boxes, grid):
        # Then it is the move that leaves it that is to be named, not the workpiece.
        grid = grid_around([box_of(work.facets)], resolution, width)
    x, y, z = (a - b for a, b in zip(grid_a.offset, grid.offset, strict=True))
    path = PathGrid(resolution, (x, y, z), clearance, tool.rounding + work.rounding)
    a, b = quantise(tool.facets, grid_a, names[0]), quantise(work.facets, grid, names[1])
    scene = PathScene(tool, work, a, b, program, grid, path, wanted)
    _check_margin(scene)
    _check_moves(scene)
    return scene


def _check_wanted(wanted: Wanted) -> None:
    if wanted.clearance < 0:
        raise InputError(f"clearance {float(wanted.clearance):g}: must not be negative")
    if wanted.scale <= 0:
        raise InputError(
            f"scale {float(wanted.scale):g}: must be positive: millimetres per unit of the files"
        )
    if wanted.step < wanted.resolution:
        raise InputError(
            f"step {float(wanted.step):g}: must be at least the resolution, {float(wanted.resolution):g}"
        )


def _swept(tool: StlMesh, program: Program, scale: Fraction, room: Fraction) -> Iterator[Box]:
    """Yield boxes of the tool, with room around, that together reach as far as it does on the path."""
    positions = [program.moves[0].start, *(move.end for move in program.moves)]
    for extreme, far in ((min, -room), (max, room)):
        x, y, z = (extreme(position[k] for position in positions) / scale + far for k in range(3))
        yield box_of(tool.facets, (x, y, z))


def _check_margin(scene: PathScene) -> None:
    """Raise InputError unless the margin of the shortest segments fits the engine."""
    needed = upwards(scene.path.base + Rational(1, 2) + scene.step / 2)
    if needed > scene.largest_margin:
        raise InputError(
            f"clearance {float(scene.wanted.clearance):g} with step {float(scene.wanted.step):g}: a margin "
            f"of {needed} grid steps, but width {scene.grid.width} allows {scene.largest_margin}; use a "
            "coarser resolution, a smaller step or a larger width"
        )


def _check_moves(scene: PathScene) -> None:
    """Raise InputError where the tool leaves the grid. Between two ends that fit, everything does."""
    least, most = coordinate_range(scene.grid.width)
    low, high = scene.box_a
    for move in scene.program.moves:
        for position in (move.start, move.end):
            place = scene.path.place(scene.in_files(position))
            for k, translation in enumerate(map(round_half_up, place)):
                if not (least <= low[k] + translation and high[k] + translation <= most):
                    where = " ".join(f"{n}{float(c):g}" for n, c in zip("XYZ", position, strict=True))
                    raise InputError(
                        f"{scene.program.path}: line {move.line}: at {where} the tool leaves the "
                        f"{scene.grid.width}-bit grid along {'xyz'[k]}; use a coarser resolution or a larger "
                        "width"
                    )
