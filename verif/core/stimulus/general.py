"""General pairs: at all scales, far apart, on grids of a few steps, and at the limits of the range.

A projection is affine in each coordinate, so it is largest at corners (docs/theory.md, section 5). Few
corners do it, and a random pair hardly ever shows it in the verdict: those with the largest projections are
looked up.
"""

from functools import cache
from itertools import product

import numpy as np
import numpy.typing as npt

from triaxis.golden.pairs import Pairs, coordinate_range
from triaxis.verif.core.stimulus.margins import at_any_margin
from triaxis.verif.core.stimulus.stimulus import Pairs32, Rng, Stimulus, of_bits, words
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


Corners = npt.NDArray[np.int64]

# Largest projections, in units of L^3, of two kinds: a vertex of B on an axis edge x edge against A, and an
# orientation of four vertices.
SPAN, ORIENTATION = 3, 2
# Where a triangle shrinks into the neighbourhood of a corner, it has so many bits less than the box.
_SHRUNK_BITS = 4


def all_corners() -> Corners:
    """Return all pairs of triangles with coordinates 0 and 1: (2^18, 2, 3, 3)."""
    return np.array(list(product((0, 1), repeat=18)), np.int64).reshape(-1, 2, 3, 3)


def _edge(triangle: Corners, number: int) -> Corners:
    return triangle[:, (number + 1) % 3] - triangle[:, number]


def spans(corners: Corners, edge_a: int, edge_b: int, vertex: int) -> npt.NDArray[np.int64]:
    """Return where a vertex of B projects on edge_a x edge_b, relative to edge_a's first vertex: (N,)."""
    a, b = corners[:, 0], corners[:, 1]
    axis = np.cross(_edge(a, edge_a), _edge(b, edge_b))
    return ((b[:, vertex] - a[:, edge_a]) * axis).sum(1)


def orientations(corners: Corners, vertex: int) -> npt.NDArray[np.int64]:
    """Return where a vertex of A projects on the normal of B, relative to B's first vertex: (N,)."""
    a, b = corners[:, 0], corners[:, 1]
    normal = np.cross(b[:, 1] - b[:, 0], b[:, 2] - b[:, 0])
    return ((a[:, vertex] - b[:, 0]) * normal).sum(1)


@cache
def _largest() -> tuple[Corners, Corners]:
    """Return the pairs with the largest spans, and those with the largest orientations.

    Only those with the first vertex of A at the origin: the others are their reflections.
    """
    rest = np.arange(1 << 15)[:, None] >> np.arange(15) & 1
    corners = np.concatenate([np.zeros((len(rest), 3), np.int64), rest], 1).reshape(-1, 2, 3, 3)
    span = [spans(corners, i, j, (j + 2) % 3) for i, j in product(range(3), repeat=2)]
    orientation = [orientations(corners, vertex) for vertex in range(3)]
    return (
        corners[np.abs(span).max(0) == SPAN],
        corners[np.abs(orientation).max(0) == ORIENTATION],
    )


def largest_pairs(rng: Rng, count: int, width: int) -> Pairs:
    """Return pairs with the largest spans, a third, and orientations.

    Half with A shrunk into the neighbourhood of one of its vertices; A and B swapped at random.
    """
    low, high = coordinate_range(width)
    found = [kind[rng.integers(0, len(kind), count)] for kind in _largest()]
    chosen = np.where(rng.integers(0, 3, (count, 1, 1, 1)) == 0, found[0], found[1])
    chosen = chosen ^ rng.integers(0, 2, (count, 1, 1, 3))
    pairs = np.where(chosen == 0, low, high)
    shrunk = rng.integers(0, 2, count) == 1
    centre = pairs[np.arange(count), 0, rng.integers(0, 3, count)][:, None]
    inward = np.where(centre == low, 1, -1) * rng.integers(0, 1 << (width - _SHRUNK_BITS), (count, 3, 3))
    pairs[shrunk, 0] = (centre + inward)[shrunk]
    swapped = rng.integers(0, 2, (count, 1, 1, 1)) == 1
    return np.where(swapped, pairs[:, ::-1], pairs)


def diagonal_pairs(rng: Rng, count: int, width: int) -> Pairs:
    """Return pairs whose N_A . (edge of B) is the largest, 3 L^3, in all orders and signs.

    A has the three neighbours of a corner of the coordinate box, so its normal runs along a diagonal of
    the box; an edge of B is that diagonal.
    """
    low, high = coordinate_range(width)
    corner = rng.integers(0, 2, (count, 1, 3))
    a = corner ^ np.eye(3, dtype=np.int64)
    b = np.concatenate([corner, 1 - corner, rng.integers(0, 2, (count, 1, 3))], 1)
    order = rng.permuted(np.broadcast_to(np.arange(3), (count, 2, 3)), axis=2)
    bits = np.take_along_axis(np.stack([a, b], 1), order[..., None], axis=2)
    return np.where(bits == 0, low, high)


def corner_pairs(rng: Rng, count: int, width: int) -> Pairs:
    """Return pairs at any corners, half of them with coordinates one step inside."""
    low, high = coordinate_range(width)
    corners = np.where(rng.integers(0, 2, (count, 2, 3, 3)) == 0, low, high)
    beside = corners + np.where(corners == low, 1, -1) * rng.integers(0, 2, (count, 2, 3, 3))
    return np.where(rng.integers(0, 2, (count, 1, 1, 1)) == 0, corners, beside)


def at_corners(rng: Rng, count: int, width: int, largest_margin: int) -> Stimulus:
    """Return pairs of all these kinds.

    Half have no margin, which would hide what a bound does; a quarter has the largest, where thresholds are.
    """
    kinds = (largest_pairs, largest_pairs, diagonal_pairs, corner_pairs)
    each = -(-count // len(kinds))
    pairs = np.concatenate([kind(rng, each, width) for kind in kinds]).astype(np.int32)
    pairs = pairs[rng.permutation(len(pairs))[:count]]
    margins = at_any_margin(rng, pairs, largest_margin).astype(np.uint32)
    margins[::2] = 0
    margins[1::4] = largest_margin
    return Stimulus(np.ascontiguousarray(pairs), margins)
