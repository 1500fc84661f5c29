"""Near-misses of a face or an edge: pairs whose decision hangs on the smallest step of the lattice.

With g = gcd(c) the gap on the axis c, a normal or the product of two edges, is exactly -g, 0 or +g, the
nearest points lie inside the features that meet, and the other vertices lie to the proper sides. These are
the inputs on which floating point fails. Sizes go up to all of the range; at 32 bits, edges of the axis
are at most 2^31 - 1 (see `lattice`).
"""

import numpy as np

from triaxis.verif.core.stimulus.contact import Contact
from triaxis.verif.core.stimulus.draws import around, sizes, up_to
from triaxis.verif.core.stimulus.lattice import INSIDE, LARGEST_EDGE, Step, cross, exact, plane_step, side
from triaxis.verif.core.stimulus.stimulus import Ints, Mask, Rng, bounds, largest_extents, largest_span


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
