"""The grid that a user would choose for a working volume: the finest that holds it at a width."""

from collections.abc import Sequence
from fractions import Fraction

from triaxis.golden.errors import InputError
from triaxis.host.quantise import Box, Grid, fits, grid_around

# Powers of two that float32 coordinates of a machine call for, in millimetres.
_FINEST, _COARSEST = -60, 60


def finest_resolution(boxes: Sequence[Box], width: int) -> Fraction:
    """Return the finest power of two, in the unit of the boxes, whose grid around them has ``width`` bits.

    A power of two: float32 coordinates are multiples of such, so a grid fine enough rounds nothing.
    """
    for exponent in range(_FINEST, _COARSEST + 1):
        resolution = Fraction(2) ** exponent
        if fits(boxes, grid_around(boxes, resolution, width)):
            return resolution
    raise InputError(f"boxes: too large: no grid of {width} bits holds them")


def finest_grid(boxes: Sequence[Box], width: int) -> Grid:
    """Return the grid of that resolution around the boxes."""
    return grid_around(boxes, finest_resolution(boxes, width), width)
