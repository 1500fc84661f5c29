"""Morton order: boxes that stand side by side in it are side by side in space.

G. M. Morton, A computer oriented geodetic data base and a new technique in file sequencing, 1966: the bits
of the three coordinates are interleaved, the highest first, and the numbers that come of it are sorted.
"""

import numpy as np
import numpy.typing as npt

Integers = npt.NDArray[np.int64]

# Bits of a coordinate that one 64-bit key takes, three coordinates to a key.
_KEY_BITS = 21
# Two zero bits are put behind each bit by moving halves, quarters, .. apart: shift and mask of each step.
_SPREAD = (
    (32, 0x001F00000000FFFF),
    (16, 0x001F0000FF0000FF),
    (8, 0x100F00F00F00F00F),
    (4, 0x10C30C30C30C30C3),
    (2, 0x1249249249249249),
)


def morton_order(boxes: Integers) -> Integers:
    """Return the numbers (N,) of boxes (N, 2, 3), low and high corner in LSB, by where their centres lie.

    All three coordinates keep one scale, so that the cells of the order are cubes. 42 bits of twice the
    centres count: all of them for coordinates of 32 bits. Equal centres keep their order.
    """
    if not len(boxes):
        return np.zeros(0, np.int64)
    # Twice the centres: whole numbers.
    place = boxes[:, 0] + boxes[:, 1]
    place -= place.min(0)
    bits = int(place.max()).bit_length()
    place >>= max(0, bits - 2 * _KEY_BITS)
    low_key = _interleaved(place & ((1 << _KEY_BITS) - 1))
    if bits <= _KEY_BITS:
        return np.argsort(low_key, kind="stable")
    return np.lexsort((low_key, _interleaved(place >> _KEY_BITS)))


def _interleaved(place: Integers) -> npt.NDArray[np.uint64]:
    """Return numbers (N,) made of the bits of coordinates (N, 3) of at most 21 bits."""
    spread = place.astype(np.uint64)
    for shift, mask in _SPREAD:
        spread = (spread | spread << np.uint64(shift)) & np.uint64(mask)
    return spread[:, 0] | spread[:, 1] << np.uint64(1) | spread[:, 2] << np.uint64(2)
