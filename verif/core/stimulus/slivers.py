"""Slivers: triangles as thin as the lattice allows, of any length, beside or across others."""

import numpy as np

from triaxis.verif.core.stimulus.draws import around, chance, sizes, up_to
from triaxis.verif.core.stimulus.lattice import line_step
from triaxis.verif.core.stimulus.stimulus import Ints, Pairs32, Rng, largest_span
from triaxis.verif.core.stimulus.symmetry import random_cube_symmetries, random_orders, random_translations


def _needles(rng: Rng, size: Ints) -> Ints:
    """Return triangles (N, 3, 3) whose third vertex is a rounding away from the line of the others."""
    count = len(size)
    end = around(rng, size[:, None], (count, 3))
    # A place along the segment, near an end as often as in the middle.
    place = up_to(rng, 1 << 20, (count, 1)) >> up_to(rng, 20, (count, 1))
    third = (end * place >> 20) + around(rng, 1, (count, 3))
    return np.stack([np.zeros_like(end), end, third], 1)


def _thinnest(rng: Rng, size: Ints) -> Ints:
    """Return triangles (N, 3, 3) of the smallest area that their long edge allows, seen along z."""
    end = around(rng, size[:, None], (len(size), 2))
    _, third, _ = line_step(end)
    flat = np.stack([np.zeros_like(end), end, third], 1)
    slope = around(rng, 1, (len(size), 2, 1))
    return np.concatenate([flat, flat @ slope], 2)


def sliver_pairs(rng: Rng, count: int, width: int) -> Pairs32:
    """Return a sliver, and another beside it, across it or anywhere, or a triangle of any shape."""
    size = sizes(rng, count, 3, (largest_span(width) - 2) // 4)
    thin = chance(rng, count, 2)[:, None, None]
    a = np.where(thin, _thinnest(rng, size), _needles(rng, size))
    kind = np.arange(count) % 4
    beside = a + around(rng, 1, (count, 1, 3))
    other = around(rng, size.reshape(-1, 1, 1), (count, 3, 3))
    # Across: through a vertex or a place close to one, so that thin meets thin.
    across = _needles(rng, size)
    rows = np.arange(count)
    across += (a[rows, up_to(rng, 2, (count,))] - across[rows, up_to(rng, 2, (count,))])[:, None]
    across += around(rng, 1, (count, 1, 3))
    b = np.where((kind == 0)[:, None, None], beside, np.where((kind == 1)[:, None, None], other, across))
    pairs = np.stack([a, b], 1)
    placed = random_translations(rng, pairs, width).astype(np.int32)
    return random_cube_symmetries(rng, random_orders(rng, placed))
