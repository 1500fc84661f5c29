"""Choosing a grid: the finest resolution with which a volume fits a width, and the false alarms it costs.

The band (docs/theory.md, section 6). Let each coordinate of the two meshes together be off by at most
``reading`` before rounding, and by r/2 each by rounding. Then near(Aq, Bq, m) implies

    distance(A, B) <= m r + r + reading,

so with the wanted clearance c a false alarm is a pair at a distance in (c, c + band], where
band = (m + 1) r + reading - c. `margin_for` takes m = ceil((c + reading) / r) + 1, hence

    2 r + 2 reading <= band < 3 r + 2 reading.
"""

from collections.abc import Sequence
from enum import StrEnum
from fractions import Fraction
from math import ceil

from triaxis.golden.errors import InputError
from triaxis.host.quantise import Box, Vector, fits, grid_around

# The mantissas of a resolution as people write it.
_LEAST, _BASE = 100, 10


class Steps(StrEnum):
    """Which numbers a resolution is chosen from: three decimal digits, or powers of two."""

    DECIMAL = "decimal"
    BINARY = "binary"


def extent_of(boxes: Sequence[Box]) -> Fraction:
    """Return the longest side of the box around the boxes."""
    low = [min(box[0][k] for box in boxes) for k in range(3)]
    high = [max(box[1][k] for box in boxes) for k in range(3)]
    return max(b - a for a, b in zip(low, high, strict=True))


def grown(box: Box, by: Fraction) -> Box:
    """Return the box with each face moved outwards."""

    def moved(corner: Vector, step: Fraction) -> Vector:
        x, y, z = (c + step for c in corner)
        return x, y, z

    return moved(box[0], -by), moved(box[1], by)


def finest_resolution(
    box: Box, width: int, unit: Fraction = Fraction(1), steps: Steps = Steps.DECIMAL, room: int = 0
) -> Fraction:
    """Return the smallest resolution of its kind whose grid around the box holds it.

    ``unit``: the resolution times this is the number of that kind; ``room``: steps left free on each side.
    Raises InputError where the box is a point.
    """
    extent = extent_of([box])
    if extent == 0:
        raise InputError("volume: a single point: give one that has an extent")
    # 2^width integers, of which the outer two reach half a step further.
    resolution = _not_below(extent * unit / (1 << width), steps)
    while True:
        wanted = resolution / unit
        if fits([grown(box, room * wanted)], grid_around([box], wanted, width)):
            return wanted
        resolution = _next(resolution, steps)


def _not_below(value: Fraction, steps: Steps) -> Fraction:
    """Return the smallest number of its kind that is not below a positive value."""
    if steps is Steps.BINARY:
        power = Fraction(2) ** (value.numerator.bit_length() - value.denominator.bit_length() - 1)
        while power < value:
            power *= 2
        return power
    step = _decimal_step(value)
    return ceil(value / step) * step


def _next(value: Fraction, steps: Steps) -> Fraction:
    """Return the number of its kind that follows."""
    return value * 2 if steps is Steps.BINARY else value + _decimal_step(value)


def _decimal_step(value: Fraction) -> Fraction:
    """Return the unit of a positive number's third decimal digit."""
    step = Fraction(1)
    while value / step >= _LEAST * _BASE:
        step *= _BASE
    while value / step < _LEAST:
        step /= _BASE
    return step


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
