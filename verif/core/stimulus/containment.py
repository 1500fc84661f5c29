"""Triangles that are parts of others, in any plane: strictly inside, reaching the rim, or identical."""

import numpy as np

from triaxis.verif.core.stimulus.draws import around, chance, sizes, up_to
from triaxis.verif.core.stimulus.stimulus import Ints, Pairs32, Rng, largest_span
from triaxis.verif.core.stimulus.symmetry import random_orders, random_translations


def _weights(rng: Rng, total: Ints, least: Ints) -> Ints:
    """Return barycentric weights (N, 3 points, 3 vertices), each at least ``least``, with that total."""
    count = len(total)
    rest = (total - 3 * least)[:, None]
    cuts = np.sort(up_to(rng, rest[..., None], (count, 3, 2)), -1)
    first, second = cuts[..., 0], cuts[..., 1]
    return np.stack([first, second - first, rest - second], -1) + least[:, None, None]


def contained_pairs(rng: Rng, count: int, width: int) -> Pairs32:
    """Return a triangle, a segment or a point that is a part of another triangle.

    In turn: strictly inside; touching edges from inside; with vertices at vertices; identical. One in 4 is
    moved off by one step.
    """
    most = largest_span(width)
    total = sizes(rng, count, 3, max(3, most // 16))
    outer = around(rng, ((most - 2) // 2 // total).reshape(-1, 1, 1), (count, 3, 3))
    kind = np.arange(count) % 4
    weights = _weights(rng, total, np.where(kind == 0, 1, 0))
    rows, place = np.arange(count), up_to(rng, 2, (3, count))
    # On an edge: one vertex of the outer triangle has no part in that point; at a vertex: all of it.
    weights = np.where((kind == 1)[:, None, None], _without(weights, place.T), weights)
    corners = np.eye(3, dtype=np.int64)[place[0]] * total[:, None]
    weights[:, 0] = np.where((kind == 2)[:, None], corners, weights[:, 0])
    same = np.eye(3, dtype=np.int64) * total[:, None, None]
    weights = np.where((kind == 3)[:, None, None], same, weights)
    inner = weights @ outer
    # Lower ranks: vertices that coincide.
    inner[:, 2] = np.where((chance(rng, count, 6) & (kind < 3))[:, None], inner[:, 1], inner[:, 2])
    inner[:, 1:] = np.where((chance(rng, count, 12) & (kind < 3))[:, None, None], inner[:, :1], inner[:, 1:])
    off = chance(rng, count, 4)
    inner[rows, :, place[1]] += np.where(off, around(rng, 1, (count,)), 0)[:, None]
    pairs = np.stack([inner, outer * total[:, None, None]], 1)
    return random_orders(rng, random_translations(rng, pairs, width).astype(np.int32))


def _without(weights: Ints, vertex: Ints) -> Ints:
    """Return the weights with those of one vertex (N, 3) of each point given to the next vertex."""
    chosen = vertex[..., None]
    given = np.take_along_axis(weights, chosen, -1)
    moved = weights.copy()
    np.put_along_axis(moved, chosen, 0, -1)
    following = (chosen + 1) % 3
    np.put_along_axis(moved, following, np.take_along_axis(weights, following, -1) + given, -1)
    return moved
