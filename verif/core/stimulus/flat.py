"""Pairs without volume: in one plane, of lower rank, and slivers as thin as the lattice allows."""

import numpy as np

from triaxis.verif.core.stimulus.contact import Contact
from triaxis.verif.core.stimulus.lattice import line_step, side
from triaxis.verif.core.stimulus.near_miss import any_rank, edge_box, edge_box_level
from triaxis.verif.core.stimulus.stimulus import (
    Ints,
    Pairs32,
    Rng,
    around,
    bounds,
    chance,
    largest_span,
    sizes,
    up_to,
)
from triaxis.verif.core.stimulus.symmetry import random_cube_symmetries, random_orders, random_translations


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
