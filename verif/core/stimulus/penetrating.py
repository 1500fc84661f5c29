"""Pairs in which edges pass through faces: one edge through a face, two edges, or one of each triangle."""

import numpy as np

from triaxis.verif.core.stimulus.draws import around, chance, up_to
from triaxis.verif.core.stimulus.stimulus import Ints, Pairs32, Rng, largest_span
from triaxis.verif.core.stimulus.symmetry import random_orders, random_translations
from triaxis.verif.core.stimulus.touching import coefficient_sizes, face, in_space


def _inside(rng: Rng, triangle: Ints) -> Ints:
    """Return points (N, 3), 4 times a point inside each triangle (N, 3, 3)."""
    more = np.eye(3, dtype=np.int64)[up_to(rng, 2, (len(triangle),))]
    return ((1 + more)[..., None] * triangle).sum(1)


def penetrating_pairs(rng: Rng, count: int, width: int) -> Pairs32:
    """Return A with a vertex above the plane of B, and an edge or two from there through B's face."""
    # Nothing below is larger than 5 * size, or 7 * size from 16 on: 8 * 5 * 3 fits 8 bits about 0.
    size = np.maximum(coefficient_sizes(rng, count, width) // 8, 8)
    b = face(rng, size // 2)
    apex = around(rng, size[:, None], (count, 3))
    apex[:, 2] = 1 + up_to(rng, size - 1, (count,))
    points = np.stack([_inside(rng, b), _inside(rng, b)], 1)
    # From the apex through each point, and as far again, or twice as far.
    times = 1 + up_to(rng, np.minimum(size // 16, 1)[:, None, None], (count, 2, 1))
    beyond = points + (points - apex[:, None]) * times
    # Or the second edge goes anywhere: it mostly misses B, which then passes through A in turn.
    anywhere = around(rng, 2 * size[:, None], (count, 3))
    beyond[:, 1] = np.where(chance(rng, count, 2)[:, None], anywhere, beyond[:, 1])
    a = np.concatenate([apex[:, None], beyond], 1)
    pairs, _, _ = in_space(rng, np.stack([a, 4 * b], 1), largest_span(width) // 2)
    return random_orders(rng, random_translations(rng, pairs, width).astype(np.int32))
