"""Pairs whose vertices are corners of the coordinate box, at which projections reach their bounds.

A projection is affine in each coordinate, so it is largest at corners; few corners do it, and a random pair
of corners hardly ever shows it in the verdict. Here all 2^18 pairs of corners are looked through once.
"""

from functools import cache
from itertools import product

import numpy as np
import numpy.typing as npt

from triaxis.golden.pairs import Pairs, coordinate_range

Corners = npt.NDArray[np.int64]

# Largest projections, in units of L^3, of two kinds: a vertex of B on an axis edge x edge against A, and an
# orientation of four vertices.
SPAN, ORIENTATION = 3, 2


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
def extreme_corners() -> tuple[Corners, Corners]:
    """Return the pairs with the largest spans, and those with the largest orientations."""
    corners = all_corners()
    largest = np.zeros(len(corners), np.int64)
    for i, j in product(range(3), repeat=2):
        largest = np.maximum(largest, np.abs(spans(corners, i, j, (j + 2) % 3)))
    oriented = np.max([np.abs(orientations(corners, vertex)) for vertex in range(3)], 0)
    return corners[largest == SPAN], corners[oriented == ORIENTATION]


def extreme_pairs(rng: np.random.Generator, count: int, width: int) -> Pairs:
    """Return pairs at such corners: a third each of largest spans, of orientations, and of these with A
    shrunk into the neighbourhood of one of its vertices; A and B swapped at random.
    """
    low, high = coordinate_range(width)
    found = [kind[rng.integers(0, len(kind), count)] for kind in extreme_corners()]
    chosen = np.where(rng.integers(0, 3, (count, 1, 1, 1)) == 0, found[0], found[1])
    pairs = np.where(chosen == 0, low, high)
    shrunk = rng.integers(0, 2, count) == 1
    centre = pairs[np.arange(count), 0, rng.integers(0, 3, count)][:, None]
    inward = np.where(centre == low, 1, -1) * rng.integers(0, 1 << (width - 4), (count, 3, 3))
    pairs[shrunk, 0] = (centre + inward)[shrunk]
    swapped = rng.integers(0, 2, (count, 1, 1, 1)) == 1
    return np.where(swapped, pairs[:, ::-1], pairs)
