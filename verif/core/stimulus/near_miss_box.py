"""Near-misses on the axes that the margin's cube brings: edge x box, and box.

The gap is exactly -g, 0 or +g as in `near_miss`. These axes are decisive alone only with a margin, or
where the pair is flat: in a coordinate plane for edge x box, along a coordinate axis for box.
"""

import numpy as np

from triaxis.verif.core.stimulus.contact import Contact
from triaxis.verif.core.stimulus.draws import around, chance, sizes, up_to
from triaxis.verif.core.stimulus.lattice import INSIDE, Reals, line_step, side
from triaxis.verif.core.stimulus.near_miss import any_rank, first_on, vertices_at
from triaxis.verif.core.stimulus.stimulus import Ints, Mask, Rng, bounds, largest_span


def _over_edge(
    rng: Rng, u: Ints, x: Ints, alpha: Reals, usable: Mask, flat: bool, along: Ints | None = None
) -> Contact:
    """Return A with an edge u (N, 2), seen along z, that B's vertex x passes at alpha; others apart.

    Where ``along`` (N, 2) is not 0, B's second vertex is there from its first: along the edge.
    """
    count = len(u)
    extent = np.maximum(np.abs(u[:, 0]), np.abs(u[:, 1]))
    rise = np.zeros_like(extent) if flat else around(rng, np.minimum(extent, (1 << 31) - 1), (count,))
    edge = np.concatenate([u, rise[:, None]], 1)
    # With a margin, the height of the vertex matters only within the cube.
    corner = np.concatenate([x, np.rint(alpha * rise).astype(np.int64)[:, None]], 1)
    c = np.stack([u[:, 1], -u[:, 0], np.zeros_like(extent)], 1)
    points = np.stack([corner, np.zeros_like(edge), edge], 1)
    low, high = (bound[:, None] for bound in bounds(points))
    # Room for the other vertices beside edges along x or y.
    margin = 1 + extent[:, None, None] // 8
    roomy = np.concatenate([points, low - margin, high + margin], 1)
    if flat:
        roomy[..., 2] = 0
    candidates = vertices_at(rng, roomy, (3, 3, 3, 1, 1))
    above = side(c, candidates[:, 0] - corner)
    third_b, found_b = first_on(c, candidates[:, 1:3], corner, above)
    third_a, found_a = first_on(c, candidates[:, 3:], np.zeros_like(edge), -above)
    second_b = candidates[:, 0]
    if along is not None:
        on_edge = corner + np.concatenate([along, rise[:, None] * 0], 1)
        second_b = np.where((along[:, :1] | along[:, 1:]) != 0, on_edge, second_b)
    a = np.stack([np.zeros_like(edge), edge, third_a], 1)
    b = any_rank(rng, corner, second_b, third_b)
    contact = Contact(np.stack([a, b], 1), np.sign(c) * above[:, None])
    return contact[usable & found_a & found_b & (above != 0)]


def edge_box(rng: Rng, count: int, width: int, flat: bool) -> Contact:
    """Return A whose edge, seen along z, a vertex of B misses by -g or +g: some share of ``count``.

    ``flat``: in the plane z = 0. Otherwise use a margin of at least 1.
    """
    u = around(rng, sizes(rng, count, 6, largest_span(width) >> 1)[:, None], (count, 2))
    g, x, alpha = line_step(u)
    usable = (g > 0) & (alpha > INSIDE) & (alpha < 1 - INSIDE)
    return _over_edge(rng, u, x, alpha, usable, flat)


def edge_box_level(rng: Rng, count: int, width: int, flat: bool) -> Contact:
    """Return the same with the vertex of B exactly on the edge, as seen along z."""
    part = around(rng, sizes(rng, count, 2, largest_span(width) // 10)[:, None], (count, 2))
    before, after = 1 + up_to(rng, 2, (2, count, 1))
    u, x = (before + after) * part, before * part
    # In one of 4, an edge of B along that of A: forwards or backwards, within it or beyond.
    along = around(rng, 2, (count, 1)) * chance(rng, count, 4)[:, None] * part
    alpha, usable = (before / (before + after))[:, 0], (part[:, 0] | part[:, 1]) != 0
    return _over_edge(rng, u, x, alpha, usable, flat, along)


def box(rng: Rng, count: int, width: int, flat: bool) -> Contact:
    """Return pairs of any ranks whose boxes miss in x by -1, 0 or 1, at vertices that face each other.

    ``flat``: on the line y = z = 0. Otherwise use a margin of at least 1.
    """
    size = sizes(rng, count, 2, largest_span(width) // 2 - 1).reshape(-1, 1, 1)
    drawn = up_to(rng, size, (count, 6, 3))
    if flat:
        drawn[..., 1:] = 0
    a = any_rank(rng, *np.moveaxis(drawn[:, :3], 1, 0))
    b = any_rank(rng, *np.moveaxis(drawn[:, 3:], 1, 0))
    rows = np.arange(count)
    last, first = a[rows, a[..., 0].argmax(1)], b[rows, b[..., 0].argmin(1)]
    shift = last - first
    shift[:, 0] += around(rng, 1, (count,))
    away = np.broadcast_to(np.array([1, 0, 0]), (count, 3))
    return Contact(np.stack([a, b + shift[:, None]], 1), away)
