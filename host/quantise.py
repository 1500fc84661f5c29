"""From real coordinates to the core's integers, with an exact bound on rounding; the choice of a grid.

A grid has a resolution r and an offset o. A coordinate x becomes q = round((x - o) / r), so that

    |x - (o + r q)| <= r / 2      exactly, in each coordinate.

Each point of a triangle therefore moves by at most r/2 in the Chebyshev distance, and two triangles
approach or part by at most r. Hence a clearance c is never missed with the margin
ceil(c / r) + 1 (docs/theory.md, section 6).

The band (docs/theory.md, section 6). Let each coordinate of the two meshes together be off by at most
``reading`` before rounding, and by r/2 each by rounding. Then near(Aq, Bq, m) implies

    distance(A, B) <= m r + r + reading,

so with the wanted clearance c a false alarm is a pair at a distance in (c, c + band], where
band = (m + 1) r + reading - c. `margin_for` takes m = ceil((c + reading) / r) + 1, hence

    2 r + 2 reading <= band < 3 r + 2 reading.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from fractions import Fraction
from itertools import count
from math import ceil
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from triaxis.golden.errors import InputError
from triaxis.golden.pairs import coordinate_range
from triaxis.host.stl import Facets

_FINEST, _COARSEST = Fraction(1, 10**30), Fraction(10**30)

Number = TypeVar("Number")
Vector = tuple[Fraction, Fraction, Fraction]
# The lowest and the highest corner.
Box = tuple[Vector, Vector]
NOWHERE: Vector = (Fraction(0), Fraction(0), Fraction(0))


def vector(numbers: Iterable[Number]) -> tuple[Number, Number, Number]:
    """Return the numbers, of which there are three."""
    x, y, z = numbers
    return x, y, z


def added(first: Vector, *others: Vector) -> Vector:
    """Return the sum of vectors."""
    x, y, z = first
    for a, b, c in others:
        x, y, z = x + a, y + b, z + c
    return x, y, z


@dataclass(frozen=True)
class Grid:
    """The integers' place in space: x = offset + resolution * q, with q of ``width`` signed bits."""

    resolution: Fraction
    offset: Vector
    width: int

    @property
    def rounding_bound(self) -> Fraction:
        """Return the most that any coordinate moves, in the unit of the files."""
        return self.resolution / 2

    def moved(self, move: Vector) -> "Grid":
        """Return the grid for a mesh that is moved exactly: its integers are those after the move, here."""
        offset = vector(o - m for o, m in zip(self.offset, move, strict=True))
        return Grid(self.resolution, offset, self.width)


def check_resolution(resolution: Fraction) -> None:
    """Raise InputError unless the resolution is positive and of a size that float32 knows."""
    if not _FINEST <= resolution <= _COARSEST:
        # Not more of it than fits a line, and nothing that a float could not hold.
        shown = "0" if resolution == 0 else "negative" if resolution < 0 else "out of range"
        raise InputError(f"resolution: {shown}: must be 1e-30..1e30, in the files' unit")


def box_of(facets: Facets, move: Vector = NOWHERE) -> Box:
    """Return the lowest and the highest corner of the facets' box after a move, exactly."""

    def corner(extreme: npt.NDArray[np.floating]) -> Vector:
        return vector(Fraction(float(c)) + m for c, m in zip(extreme, move, strict=True))

    return corner(facets.min((0, 1))), corner(facets.max((0, 1)))


def around(boxes: Sequence[Box]) -> Box:
    """Return the box around the boxes."""
    low, high = zip(*boxes, strict=True)
    return vector(map(min, zip(*low, strict=True))), vector(map(max, zip(*high, strict=True)))


def grid_around(boxes: Sequence[Box], resolution: Fraction, width: int) -> Grid:
    """Return the grid whose origin is the multiple of the resolution nearest the boxes' common centre.

    Raises InputError where the resolution is not a positive number of a size that float32 knows.
    """
    check_resolution(resolution)
    middle = ((a + b) / 2 for a, b in zip(*around(boxes), strict=True))
    return Grid(resolution, vector(resolution * round(c / resolution) for c in middle), width)


def centred_grid(meshes: list[Facets], resolution: Fraction, width: int) -> Grid:
    """Return the grid around the meshes: see `grid_around`."""
    return grid_around([box_of(mesh) for mesh in meshes], resolution, width)


def smallest_width(
    boxes: Sequence[Box], resolution: Fraction, clearance: Fraction, widths: tuple[int, ...]
) -> int:
    """Return the first width whose grid around the boxes holds them and the margin, or else the last."""
    check_resolution(resolution)
    for width in widths:
        if clearance / resolution + 3 <= 1 << width and fits(boxes, grid_around(boxes, resolution, width)):
            return width
    return widths[-1]


def fits(boxes: Sequence[Box], grid: Grid) -> bool:
    """Return whether the grid holds the boxes."""
    low, high = coordinate_range(grid.width)
    corners = (
        round((c - o) / grid.resolution)
        for box in boxes
        for corner in box
        for c, o in zip(corner, grid.offset, strict=True)
    )
    return all(low <= corner <= high for corner in corners)


def _round(facets: Facets, grid: Grid) -> npt.NDArray[np.float64]:
    """Return round((x - offset) / resolution), exactly, as integers held in float64.

    The quotient is first computed in float64. Each of its three operations and the conversions of
    offset and resolution is off by at most 2^-53 relatively, so the quotient y is off by less than
    2^-52 (|offset| / resolution + 4 |y|). Where y is nearer than that to a half, or too large for
    float64 to hold integers exactly, the rounding is redone in rationals.
    """
    result = np.empty(facets.shape, np.float64)
    for k in range(3):
        offset = grid.offset[k]
        with np.errstate(over="ignore", invalid="ignore"):
            y = (facets[..., k].astype(np.float64) - float(offset)) / float(grid.resolution)
        bound = 2.0**-52 * (abs(float(offset / grid.resolution)) + 4 * np.abs(y) + 1)
        to_half = np.abs(np.abs(y - np.floor(y)) - 0.5)
        doubtful = ~(to_half > bound) & (np.abs(y) < 2.0**52)
        rounded = np.rint(y)
        for index in np.argwhere(doubtful):
            exact = (Fraction(float(facets[tuple(index)][k])) - offset) / grid.resolution
            rounded[tuple(index)] = round(exact)
        result[..., k] = rounded
    return result


def quantise(facets: Facets, grid: Grid, name: str) -> npt.NDArray[np.int64]:
    """Return the facets' vertices on the grid: int64 of shape (N, 3, 3).

    Raises InputError, naming the first facet, where one falls outside the grid.
    """
    rounded = _round(facets, grid)
    low, high = coordinate_range(grid.width)
    wrong = (rounded < low) | (rounded > high)
    if wrong.any():
        facet, vertex, coordinate = (int(i) for i in np.argwhere(wrong)[0])
        span = float(grid.resolution) * 2.0**grid.width
        raise InputError(
            f"{name}: facet {facet}, vertex {vertex}, coordinate {'xyz'[coordinate]}: "
            f"{facets[facet, vertex, coordinate]} does not fit {grid.width} bits at resolution "
            f"{float(grid.resolution):g} (at most {span:g} across both meshes); use a coarser "
            "resolution or a larger width"
        )
    return rounded.astype(np.int64)


def check_clearance(clearance: Fraction) -> None:
    """Raise InputError unless a clearance is one."""
    if clearance < 0:
        raise InputError(f"clearance {float(clearance):g}: must not be negative")


def check_scale(scale: Fraction) -> None:
    """Raise InputError unless millimetres per unit are positive."""
    if scale <= 0:
        raise InputError(f"scale {float(scale):g}: must be positive: millimetres per unit of the files")


def margin_for(clearance: Fraction, grid: Grid, reading: Fraction = Fraction(0)) -> int:
    """Return the margin, in LSB, with which no pair within ``clearance`` is missed.

    ``reading`` is how far coordinates may have moved, both meshes' together, before they came here.
    Raises InputError where the clearance is negative or larger than the grid can express.
    """
    check_clearance(clearance)
    margin = ceil((clearance + reading) / grid.resolution) + 1
    limit = (1 << grid.width) - 1
    if margin > limit:
        raise InputError(
            f"clearance {float(clearance):g}: {margin} steps of {float(grid.resolution):g}, but width "
            f"{grid.width} allows {limit}; use a coarser resolution or a larger width"
        )
    return margin


# The mantissas of a resolution as people write it.
_LEAST, _BASE = 100, 10


class Steps(StrEnum):
    """Which numbers a resolution is chosen from: three decimal digits, or powers of two."""

    DECIMAL = "decimal"
    BINARY = "binary"


def extent_of(boxes: Sequence[Box]) -> Fraction:
    """Return the longest side of the box around the boxes."""
    return max(b - a for a, b in zip(*around(boxes), strict=True))


def grown(box: Box, by: Fraction) -> Box:
    """Return the box with each face moved outwards."""
    return vector(c - by for c in box[0]), vector(c + by for c in box[1])


def finest_resolution(
    box: Box,
    width: int,
    unit: Fraction = Fraction(1),
    steps: Steps = Steps.DECIMAL,
    room: int = 0,
    least: Fraction = Fraction(0),
) -> Fraction:
    """Return the smallest resolution of its kind, and at ``least`` this, whose grid around the box holds it.

    ``unit``: the resolution times this is the number of that kind; ``room``: steps left free on each side.
    Raises InputError where the box is a point.
    """
    extent = extent_of([box])
    if extent == 0:
        raise InputError("volume: a single point: give one that has an extent")
    # 2^width integers, of which the outer two reach half a step further.
    numbers = (number / unit for number in _numbers_from(max(extent / (1 << width), least) * unit, steps))
    return next(r for r in numbers if fits([grown(box, room * r)], grid_around([box], r, width)))


def _numbers_from(value: Fraction, steps: Steps) -> Iterator[Fraction]:
    """Yield the numbers of a kind that are not below a positive value, ascending."""
    if steps is Steps.BINARY:
        power = Fraction(2) ** (value.numerator.bit_length() - value.denominator.bit_length() - 1)
        yield from (number for doublings in count() if (number := power * 2**doublings) >= value)
    while True:
        # The unit of its third decimal digit.
        step = Fraction(1)
        while value / step >= _LEAST * _BASE:
            step *= _BASE
        while value / step < _LEAST:
            step /= _BASE
        number = ceil(value / step) * step
        yield number
        value = number + step


def false_alarm_band(
    clearance: Fraction, resolution: Fraction, margin: int, reading: Fraction = Fraction(0)
) -> Fraction:
    """Return how far beyond the clearance a pair can be that the core calls near, at most.

    ``reading``: as `margin_for` takes it.
    """
    return (margin + 1) * resolution + reading - clearance


def widest_extent(
    band: Fraction, width: int, rounding: Fraction = Fraction(0), moved: bool = False
) -> Fraction:
    """Return an extent whose every volume meets a band at a width, at any clearance; 0 where there is none.

    ``rounding``: as ``reading`` above, without the translation's; ``moved``: a translation is rounded too, by
    r/2. From band < 3 r + 2 reading, and a grid of 2^width - 4 - 2 steps with room for both roundings.
    """
    resolution = (band - 2 * rounding) / (4 if moved else 3)
    # Three decimal digits are at most a hundredth coarser than what is needed.
    return max(Fraction(0), resolution * ((1 << width) - 6) * Fraction(100, 101))
