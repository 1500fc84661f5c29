"""Pairs in one plane: axis-aligned or tilted, general or at the decision; some moved off the plane."""

import numpy as np

from triaxis.verif.core.stimulus.contact import Contact
from triaxis.verif.core.stimulus.draws import around, chance, sizes, up_to
from triaxis.verif.core.stimulus.lattice import side
from triaxis.verif.core.stimulus.near_miss import any_rank
from triaxis.verif.core.stimulus.near_miss_box import edge_box, edge_box_level
from triaxis.verif.core.stimulus.stimulus import Ints, Pairs32, Rng, bounds, largest_span
from triaxis.verif.core.stimulus.symmetry import random_translations


def tilted(rng: Rng, flat: Ints, room: int) -> Ints:
    """Return the images (N, 2, 3, 3) of pairs (N, 2, 3, 2), by a random integer basis of a plane each.

    ``room`` bounds the coordinates of the images, where the points allow: the basis has at least 1.
    """
    count = len(flat)
    low, high = bounds(flat.reshape(count, 12, 1))
    largest = np.maximum(-low, high)[:, 0]
    size = np.maximum(room // (2 * np.maximum(largest, 1)), 1)
    # Half of the bases are short, so that more of the plane's own lattice is used.
    size = np.where(chance(rng, count, 2), np.minimum(size, 3), size)
    return flat @ around(rng, size.reshape(-1, 1, 1, 1), (count, 1, 2, 3))


def coplanar_pairs(rng: Rng, count: int, width: int) -> Pairs32:
    """Return pairs in one plane: half axis-aligned, half tilted; a quarter moved off by one step.

    One in 3 triangles is shrunk to a segment or a point.
    """
    room = (largest_span(width) - 2) // 2
    size = sizes(rng, count, 2, room)
    aligned = around(rng, size.reshape(-1, 1, 1, 1), (count, 2, 3, 3))
    rows = np.arange(count)
    aligned[rows, :, :, up_to(rng, 2, (count,))] = 0
    # At most room / 2: the basis has components of at least 1.
    weights = np.maximum(sizes(rng, count, 2, room // 2), 2).reshape(-1, 1, 1, 1)
    images = tilted(rng, around(rng, weights, (count, 2, 3, 2)), room)
    pairs = np.where((rows % 2 == 0).reshape(-1, 1, 1, 1), aligned, images)
    for triangle in (0, 1):
        pairs[:, triangle] = any_rank(rng, *np.moveaxis(pairs[:, triangle], 1, 0))
    off = chance(rng, count, 4).reshape(-1, 1, 1)
    pairs[:, 1] += np.where(off, around(rng, 1, (count, 1, 3)), 0)
    return random_translations(rng, pairs, width).astype(np.int32)


def coplanar_near_miss(rng: Rng, count: int, width: int) -> Contact:
    """Return pairs in tilted planes that a line along an edge of A separates by a step of the plane's own
    lattice, or just fails to, or that touch there: some share of ``count``.
    """
    planar = width // 2 + 1
    parts = edge_box(rng, count - count // 3, planar, True), edge_box_level(rng, count // 3, planar, True)
    flat = np.concatenate([part.pairs[..., :2] for part in parts])
    pairs = tilted(rng, flat, largest_span(width) // 2)
    # The plane through the edge that separates may be turned: it holds a random coordinate direction.
    c = np.cross(pairs[:, 0, 1] - pairs[:, 0, 0], np.eye(3, dtype=np.int64)[up_to(rng, 2, (len(pairs),))])
    above = side(c, pairs[:, 1, 1] - pairs[:, 0, 2])
    return Contact(pairs, np.sign(c) * above[:, None])[above != 0]
