"""Near-misses: pairs whose decision hangs on one axis alone, by the smallest step of the lattice.

With g = gcd(c) the gap on the axis c is exactly -g, 0 or +g, the nearest points lie inside the features that
meet, and the other vertices lie to the proper sides. These are the inputs on which floating point fails.
Sizes go up to all of the range; at 32 bits, edges of the axis are at most 2^31 - 1 (see `lattice`).

With A a triangle, the faces of the Minkowski difference of A, B and the cube are of few kinds: face of A and
vertex of B; edge and edge; edge of A, vertex of B and edge of the cube; vertex, vertex and face of the cube.
The last two, edge x box and box, are decisive alone only with a margin, or where the pair is flat: in a
coordinate plane for edge x box, along a coordinate axis for box. A contact inside such a face, moved by the
smallest step, is decided by its normal alone, unless another axis is parallel to it. Placing them in all
orders and symmetries reaches all 32 axes on either side.
"""

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from triaxis.golden.pairs import MIN_WIDTH
from triaxis.verif.core.stimulus.contact import Contact, placed
from triaxis.verif.core.stimulus.lattice import (
    INSIDE,
    LARGEST_EDGE,
    Reals,
    Step,
    cross,
    exact,
    line_step,
    plane_step,
    side,
)
from triaxis.verif.core.stimulus.stimulus import (
    Family,
    Ints,
    Mask,
    Rng,
    Stimulus,
    around,
    bounds,
    chance,
    collected,
    divided,
    joined,
    largest_extents,
    largest_span,
    sizes,
    up_to,
)


def reach(rng: Rng, count: int, width: int) -> Ints:
    """Return extents of contacts, up to all of the range but at most LARGEST_EDGE: (N, 1, 1)."""
    return sizes(rng, count, 6, min(largest_span(width), LARGEST_EDGE)).reshape(-1, 1, 1)


def vertices_at(rng: Rng, points: Ints, shares: tuple[int, ...]) -> Ints:
    """Return candidates (N, len(shares), 3) for vertices in the box of ``points`` (N, P, 3).

    Candidate i is anywhere between point 0 and a place 1 / 2^k of the way to a place in the box, where
    k is drawn below shares[i]: so there are small triangles as well as large ones.
    """
    low, high = (bound[:, None] for bound in bounds(points))
    anywhere = low + up_to(rng, high - low, (len(points), len(shares), 3))
    nearer = up_to(rng, np.array(shares, np.int64) - 1, (len(points), len(shares)))
    return points[:, :1] + ((anywhere - points[:, :1]) >> nearer[..., None])


def first_on(c: Ints, candidates: Ints, origin: Ints, wanted: Ints) -> tuple[Ints, Mask]:
    """Return the first of the candidates (N, K, 3) on the wanted side of the plane, and whether any is."""
    chosen, found = candidates[:, -1], np.zeros(len(c), np.bool_)
    for number in reversed(range(candidates.shape[1])):
        fits = side(c, candidates[:, number] - origin) == wanted
        chosen, found = np.where(fits[:, None], candidates[:, number], chosen), found | fits
    return chosen, found


def any_rank(rng: Rng, first: Ints, second: Ints, third: Ints) -> Ints:
    """Return triangles (N, 3, 3) of three vertices; one in 6 shrunk to a segment, one in 6 to ``first``."""
    kind = up_to(rng, 11, (len(first), 1))
    second = np.where(kind < 2, first, second)
    third = np.where(kind < 3, first, np.where(kind == 3, second, third))
    return np.stack([first, second, third], 1)


def _level(c: Ints, x: Ints) -> Mask:
    """Return whether c is not zero and c.x is 0: (N,)."""
    return ((c[:, 0] | c[:, 1] | c[:, 2]) != 0) & exact(c, x, np.zeros(len(c), np.int64))


def _vertex_over(rng: Rng, a: Ints, c: Ints, x: Ints, usable: Mask) -> Contact:
    """Return A with a B whose first vertex is A1 + x and whose others are on one side of A's plane."""
    corner = a[:, 0] + x
    points = np.concatenate([corner[:, None], a], 1)
    candidates = vertices_at(rng, points, (3, 3, 3))
    above = side(c, candidates[:, 0] - corner)
    third, found = first_on(c, candidates[:, 1:], corner, above)
    b = any_rank(rng, corner, candidates[:, 0], third)
    contact = Contact(np.stack([a, b], 1), np.sign(c) * above[:, None])
    return contact[usable & found & (above != 0)]


def face_vertex(rng: Rng, count: int, width: int) -> Contact:
    """Return A whose face a vertex of B misses by -g or +g on the normal: some share of ``count``."""
    a = up_to(rng, reach(rng, count, width), (count, 3, 3))
    return vertex_above(rng, a, plane_step(a[:, 1] - a[:, 0], a[:, 2] - a[:, 0]))


def vertex_above(rng: Rng, a: Ints, step: Step) -> Contact:
    """Return A with a B one vertex of which is a step above or below A's face: some share of the steps.

    ``step`` is over the parallelogram of A's first edge and of the last, turned round.
    """
    p, q = a[:, 1] - a[:, 0], a[:, 2] - a[:, 0]
    # Beyond the diagonal of the parallelogram: its mirror image is over A, and below it by g.
    beyond = (step.alpha + step.beta > 1)[:, None]
    x = np.where(beyond, p + q - step.x, step.x)
    clear_of_rim = np.abs(step.alpha + step.beta - 1) > INSIDE
    return _vertex_over(rng, a, step.c, x, step.found & clear_of_rim)


def face_vertex_level(rng: Rng, count: int, width: int) -> Contact:
    """Return A in whose face a vertex of B lies exactly: some share of ``count``."""
    legs = around(rng, reach(rng, count, width) // 5, (count, 2, 3))
    weights = 1 + up_to(rng, 1, (count, 3, 1))
    third = -(weights[:, 0] * legs[:, 0] + weights[:, 1] * legs[:, 1])
    a = np.stack([weights[:, 2] * legs[:, 0], weights[:, 2] * legs[:, 1], third], 1)
    c, x = cross(a[:, 1] - a[:, 0], a[:, 2] - a[:, 0]), -a[:, 0]
    return _vertex_over(rng, a, c, x, _level(c, x))


def _edges_over(rng: Rng, e: Ints, f: Ints, c: Ints, x: Ints, usable: Mask) -> Contact:
    """Return A with edge 0..e and B with edge x..x+f, their other vertices on opposite sides."""
    points = np.stack([x, np.zeros_like(e), e, x + f], 1)
    rows = np.flatnonzero(usable & (largest_extents(points) < 1 << 32))
    e, f, c, x, points = e[rows], f[rows], c[rows], x[rows], points[rows]
    candidates = vertices_at(rng, points, (1, 1, 3, 3, 3))
    above = side(c, candidates[:, 0] - x)
    third_b = candidates[:, 0]
    third_a, found = first_on(c, candidates[:, 1:], np.zeros_like(x), -above)
    kind = up_to(rng, 15, (len(rows), 1))
    third_a, third_b = np.where(kind == 0, e, third_a), np.where(kind == 1, x, third_b)
    pairs = np.stack([np.zeros_like(e), e, third_a, x, x + f, third_b], 1).reshape(-1, 2, 3, 3)
    return Contact(pairs, np.sign(c) * above[:, None])[found & (above != 0)]


def edge_edge(rng: Rng, count: int, width: int) -> Contact:
    """Return pairs of which two edges cross but for -g or +g on their product: some share of ``count``."""
    e, f = np.moveaxis(around(rng, (reach(rng, count, width) * 3) >> 2, (count, 2, 3)), 1, 0)
    return edges_above(rng, e, f, plane_step(e, f))


def edges_above(rng: Rng, e: Ints, f: Ints, step: Step) -> Contact:
    """Return pairs whose edges e and f cross but for a step, over their parallelogram: some share of them."""
    # x = alpha e - (1 - beta) f: both edges pass the other inside.
    return _edges_over(rng, e, f, step.c, step.x - f, step.found)


def edge_edge_level(rng: Rng, count: int, width: int) -> Contact:
    """Return pairs of which two edges cross exactly, at a point inside both: some share of ``count``."""
    u, v = np.moveaxis(around(rng, reach(rng, count, width) // 5, (count, 2, 3)), 1, 0)
    weights = 1 + up_to(rng, 2, (count, 4, 1))
    e, f = (weights[:, 0] + weights[:, 1]) * u, (weights[:, 2] + weights[:, 3]) * v
    c, x = cross(e, f), weights[:, 0] * u - weights[:, 2] * v
    return _edges_over(rng, e, f, c, x, _level(c, x))


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


Construction = Callable[[Rng, int, int], Contact]
FlatOrNot = Callable[[Rng, int, int, bool], Contact]


def family_of(parts: Sequence[tuple[Construction, int]], least_margin: int = 0) -> Family:
    """Return the family of pairs from constructions, each with its share."""

    def family(rng: Rng, count: int, width: int, largest_margin: int) -> Stimulus:
        def make(construction: Construction, asked: int) -> Stimulus:
            contact = construction(rng, asked, width)
            return placed(rng, contact, width, largest_margin, least_margin)

        counts = divided(count, [share for _, share in parts])
        return joined([collected(n, partial(make, made)) for (made, _), n in zip(parts, counts, strict=True)])

    return family


def _with(construction: FlatOrNot, flat: bool) -> Construction:
    return lambda rng, count, width: construction(rng, count, width, flat)


def with_flat(parts: Sequence[tuple[FlatOrNot, int]]) -> Family:
    """Return the family of box contacts: flat without a margin; with one in space, or flat (one in 8)."""
    flat = family_of([(_with(made, True), share) for made, share in parts])
    space = family_of([(_with(made, False), share) for made, share in parts], least_margin=1)

    def family(rng: Rng, count: int, width: int, largest_margin: int) -> Stimulus:
        if largest_margin == 0:
            return flat(rng, count, width, 0)
        without, within, apart = divided(count, (2, 1, 5))
        return joined(
            [
                flat(rng, without, width, 0),
                flat(rng, within, width, largest_margin),
                space(rng, apart, width, largest_margin),
            ]
        )

    return family


near_face = family_of([(face_vertex, 2), (face_vertex_level, 1)])
near_edge = family_of([(edge_edge, 2), (edge_edge_level, 1)])
near_edge_box = with_flat([(edge_box, 2), (edge_box_level, 1)])
near_box = with_flat([(box, 1)])


def sole_axis(rng: Rng, count: int, width: int, largest_margin: int) -> Stimulus:
    """Return all of these in random order: one part each of faces and boxes, two each of the edges, of which
    there are more.
    """
    kinds = (near_face, near_edge, near_edge_box, near_box)
    counts = divided(count, (1, 2, 2, 1))
    parts = joined([kind(rng, n, width, largest_margin) for kind, n in zip(kinds, counts, strict=True)])
    return parts[rng.permutation(count)]


def sole_axis_small(rng: Rng, count: int, width: int, largest_margin: int) -> Stimulus:
    """Return the same as the narrowest width has it: small numbers, where any width has few."""
    return sole_axis(rng, count, MIN_WIDTH, min(largest_margin, (1 << MIN_WIDTH) - 1))
