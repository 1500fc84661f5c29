"""General pairs: at all scales, far apart, and on grids of a few steps."""

import numpy as np

from triaxis.golden.pairs import coordinate_range
from triaxis.verif.core.stimulus.draws import of_bits, words
from triaxis.verif.core.stimulus.stimulus import Pairs32, Rng
from triaxis.verif.core.stimulus.symmetry import random_translations


def random_pairs(rng: Rng, count: int, width: int) -> Pairs32:
    """Return general pairs whose boxes mostly overlap, at all scales; some share one or two vertices."""
    # The larger of two draws: large pairs come up more often. Coordinates and the offset have as many bits
    # each, so their sum has one more: width at most.
    bits = rng.integers(2, width, (2, count, 1, 1, 1), np.int32).max(0)
    pairs = of_bits(rng, bits, (count, 2, 3, 3))
    nearer = rng.integers(0, 4, (count, 1, 1), np.int32)
    pairs[:, 1] >>= np.maximum(nearer - 1, 0)
    apart = of_bits(rng, bits[:, 0], (count, 1, 3))
    pairs[:, 1] += np.where(nearer % 2 == 0, apart, 0)
    return random_translations(rng, pairs, width)


def shared_pairs(rng: Rng, count: int, width: int) -> Pairs32:
    """Return general pairs that share a vertex, or an edge."""
    pairs = random_pairs(rng, count, width)
    pairs[:, 1, 0] = pairs[:, 0, 0]
    pairs[::2, 1, 1] = pairs[::2, 0, 1]
    return pairs


def far_pairs(rng: Rng, count: int, width: int) -> Pairs32:
    """Return small triangles anywhere in the range: nearly all are decided by their boxes."""
    bits = rng.integers(2, width // 2 + 1, (count, 1, 1, 1), np.int32)
    centre = of_bits(rng, np.array(width), (count, 2, 1, 3))
    low, high = coordinate_range(width)
    half = np.left_shift(np.int32(1), bits - 1)
    centre = np.minimum(np.maximum(centre, low + half), high - (half - 1))
    return centre + of_bits(rng, bits, (count, 2, 3, 3))


def tiny_pairs(rng: Rng, count: int, width: int) -> Pairs32:
    """Return pairs on a grid of a few steps, around zero: nothing but coincidences."""
    size = rng.integers(1, 5, (count, 1, 1, 1), np.int32)
    return (words(rng, (count, 2, 3, 3)) & 0x7FFF) % (2 * size + 1) - size


def extreme_pairs(rng: Rng, count: int, width: int) -> Pairs32:
    """Return pairs with coordinates at and beside the limits, zero and the powers of two.

    One in 4 lies in a coordinate plane, one in 8 on a line along a coordinate axis.
    """
    low, high = coordinate_range(width)
    values = [low, low + 1, -1, 0, 1, high - 1, high, low // 2, high // 2, 1 - high, low, high]
    # Half of the pairs have the limits alone, the last two of the values.
    drawn = words(rng, (count, 2, 3, 3)) & 0x7FFF
    drawn[::2] %= len(values) - 2
    drawn[1::2] = len(values) - 2 + (drawn[1::2] & 1)
    pairs = np.array(values, np.int32)[drawn]
    rows, coordinate = np.arange(0, count, 4), rng.integers(0, 3, (count + 3) // 4)
    # A number of one vertex for all.
    pairs[rows, :, :, coordinate] = pairs[rows, 0, 0, coordinate][:, None, None]
    rows, coordinate = rows[::2] + 1, (coordinate[::2] + 1) % 3
    rows, coordinate = rows[rows < count], coordinate[: np.count_nonzero(rows < count)]
    for step in (0, 1):
        pairs[rows, :, :, coordinate - step] = pairs[rows, 0, 0, coordinate - step][:, None, None]
    return pairs
