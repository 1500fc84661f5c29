"""Pairs whose vertices are corners of the coordinate box, at which projections reach their bounds.

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
from triaxis.verif.core.stimulus.stimulus import Rng, Stimulus

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
    """Return pairs of all these kinds; half without a margin, which would hide what a bound does."""
    kinds = (largest_pairs, largest_pairs, diagonal_pairs, corner_pairs)
    each = -(-count // len(kinds))
    pairs = np.concatenate([kind(rng, each, width) for kind in kinds]).astype(np.int32)
    pairs = pairs[rng.permutation(len(pairs))[:count]]
    margins = at_any_margin(rng, pairs, largest_margin).astype(np.uint32)
    margins[::2] = 0
    return Stimulus(np.ascontiguousarray(pairs), margins)
