"""Points, segments and triangles in every combination: random, sharing a vertex, and all on one line."""

import numpy as np

from triaxis.verif.core.stimulus.draws import around, chance, sizes, up_to
from triaxis.verif.core.stimulus.stimulus import Ints, Pairs32, Rng, largest_span
from triaxis.verif.core.stimulus.symmetry import random_translations

_STEPS = 6


def of_rank(rng: Rng, rank: Ints, size: Ints) -> Ints:
    """Return triangles (N, 3, 3) within -size..size of rank at most ``rank`` (N,).

    0: points, 1: segments with collinear vertices in any order, 2: triangles.
    """
    count = len(rank)
    size = size.reshape(-1, 1, 1)
    triangle = around(rng, size, (count, 3, 3))
    point = triangle[:, :1] // 2
    direction = around(rng, size // (2 * _STEPS), (count, 1, 3))
    segment = point + around(rng, _STEPS, (count, 3, 1)) * direction
    choice = rank.reshape(-1, 1, 1)
    return np.where(choice == 0, point, np.where(choice == 1, segment, triangle))


def _collinear(rng: Rng, size: Ints) -> Ints:
    """Return pairs of segments and points on one line, a third of the lines along a coordinate axis."""
    count = len(size)
    direction = around(rng, size[:, None] // _STEPS, (count, 3))
    along = np.eye(3, dtype=np.int64)[up_to(rng, 2, (count,))]
    direction = np.where(chance(rng, count, 3)[:, None], along * direction, direction)
    places = around(rng, _STEPS, (count, 2, 3, 1))
    places[::3, 1] = places[::3, 1, :1]
    return places * direction[:, None, None]


def degenerate_pairs(rng: Rng, count: int, width: int) -> Pairs32:
    """Return every combination of ranks in turn; nearly half share a vertex, one in 8 is on one line."""
    combination = np.arange(count) % 9
    # Where a vertex is shared, the extents of both, 2 size each, add up.
    size = sizes(rng, count, 2, largest_span(width) // 4)
    a, b = of_rank(rng, combination // 3, size), of_rank(rng, combination % 3, size)
    rows, vertex = np.arange(count), up_to(rng, 2, (2, count))
    meet = a[rows, vertex[0]] - b[rows, vertex[1]]
    b += np.where(chance(rng, count, 2)[:, None], meet, 0)[:, None]
    pairs = np.stack([a, b], 1)
    lines = rows % 8 == 7
    pairs[lines] = _collinear(rng, size[lines])
    return random_translations(rng, pairs, width).astype(np.int32)
