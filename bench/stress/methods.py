"""Published triangle tests that floating-point programs use, written anew in NumPy from their papers.

Each is a function of two arrays of triangles, (3, 3, N) each: vertex, coordinate, pair; it says which pairs
it takes for touching or overlapping, (N,). It computes in the type of its input and in the order that its
paper gives, without tolerances. In exact arithmetic (arrays of Python's integers or Fractions) each is right
for every pair of proper triangles: what it gets wrong there on floats is rounding.

SAT: the separating-axis test of S. Gottschalk, M. C. Lin and D. Manocha, "OBBTree", 1996, for two triangles.
Two normals and nine products of edges decide pairs in general position, and the six normals of the edges
within their planes decide coplanar ones. All seventeen are always asked, so there is no branch.

T. Moller, "A fast triangle-triangle intersection test", Journal of Graphics Tools 2(2), 1997: each triangle
against the other's plane, as an equation N.x + d = 0; then the intervals in which the line common to both
planes meets the two triangles, seen along the coordinate axis closest to that line.

P. Guigue and O. Devillers, "Fast and robust triangle-triangle overlap test using orientation predicates",
Journal of Graphics Tools 8(1), 2003: everything is the sign of a determinant of differences. Let p be the
vertex of each triangle that is alone on the upper side of the other's plane. On the line common to both
planes, A reaches from edge p q to edge p r, and so does B; which ends come first is the orientation of two
edges, one of each.
"""

from collections.abc import Iterator
from itertools import product, starmap
from typing import Any

import numpy as np
import numpy.typing as npt

# Coordinate, pair.
Vectors = npt.NDArray[Any]
# Vertex, coordinate, pair: (3, 3, N).
Triangles = npt.NDArray[Any]
# One number of each pair: (N,).
Numbers = npt.NDArray[Any]
Mask = npt.NDArray[np.bool_]


def cross(u: Vectors, v: Vectors) -> Vectors:
    """Return u x v: (3, N)."""
    return np.cross(u, v, axis=0)


def dot(u: Vectors, v: Vectors) -> Numbers:
    """Return the inner products: (N,)."""
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


def normal(triangle: Triangles) -> Vectors:
    """Return (V2 - V1) x (V3 - V1): (3, N)."""
    return cross(triangle[1] - triangle[0], triangle[2] - triangle[0])


def signs(values: Numbers) -> npt.NDArray[np.int8]:
    """Return -1, 0 or 1 for each number."""
    return (values > 0).astype(np.int8) - (values < 0).astype(np.int8)


def largest_component(vectors: Vectors) -> npt.NDArray[np.intp]:
    """Return the number of each vector's component of the largest size, the first of several: (N,)."""
    return np.abs(vectors).argmax(0)


def component(points: npt.NDArray[Any], number: npt.NDArray[np.intp]) -> npt.NDArray[Any]:
    """Return coordinate ``number`` (N,) of points (.., 3, N): (.., N)."""
    return np.choose(number, list(np.moveaxis(points, -2, 0)))


def vertex(triangle: npt.NDArray[Any], number: npt.NDArray[np.intp]) -> npt.NDArray[Any]:
    """Return vertex ``number`` (N,), cyclically, of what has three along its first dimension: (.., N)."""
    return np.choose(number, list(triangle), mode="wrap")


# Vertex, coordinate of two, pair: (3, 2, N).
Flat = npt.NDArray[Any]
Point = npt.NDArray[Any]


def seen_flat(triangle: Triangles, along: Vectors) -> Flat:
    """Return the triangles without the coordinate in which ``along`` (3, N) is largest: (3, 2, N)."""
    dropped = largest_component(along)
    return np.stack([component(triangle, (dropped + 1) % 3), component(triangle, (dropped + 2) % 3)], 1)


def turn(a: Point, b: Point, c: Point) -> Numbers:
    """Return twice the signed area of points (2, N) a, b, c: positive where they turn to the left."""
    return (a[0] - c[0]) * (b[1] - c[1]) - (a[1] - c[1]) * (b[0] - c[0])


def _turned_left(triangle: Flat) -> Flat:
    """Return the triangles with two vertices exchanged where they turn to the right."""
    right = turn(*triangle) < 0
    return np.stack(
        [triangle[0], np.where(right, triangle[2], triangle[1]), np.where(right, triangle[1], triangle[2])]
    )


def overlap_by_turns(a: Flat, b: Flat) -> Mask:
    """Return which pairs overlap: those where no edge of one has the other strictly on its outer side.

    By signs of turns alone, as P. Guigue and O. Devillers have it; their tree of decisions asks some of the
    same eighteen.
    """
    separated = np.zeros(a.shape[2], np.bool_)
    left_a, left_b = _turned_left(a), _turned_left(b)
    for one, other in ((left_a, left_b), (left_b, left_a)):
        for number in range(3):
            start, end = one[number], one[(number + 1) % 3]
            outside = [turn(start, end, point) < 0 for point in other]
            separated |= outside[0] & outside[1] & outside[2]
    return ~separated


def _within(number: Numbers, limit: Numbers) -> Mask:
    """Return whether a number is from 0 to a limit of either sign; where the limit is 0, it is not."""
    return ((limit > 0) & (number >= 0) & (number <= limit)) | (
        (limit < 0) & (number <= 0) & (number >= limit)
    )


def _edges_cross(p: Point, q: Point, r: Point, s: Point) -> Mask:
    """Return whether segments p q and r s have one point in common; parallel ones count as apart."""
    u, v, w = q - p, r - s, p - r
    area = u[1] * v[0] - u[0] * v[1]
    along_p = v[1] * w[0] - v[0] * w[1]
    along_r = u[0] * w[1] - u[1] * w[0]
    return _within(along_p, area) & _within(along_r, area)


def _inside(point: Point, triangle: Flat) -> Mask:
    """Return whether a point is strictly inside a triangle."""
    sides = np.stack([turn(triangle[k], triangle[(k + 1) % 3], point) for k in range(3)])
    return np.logical_and.reduce(sides > 0) | np.logical_and.reduce(sides < 0)


def overlap_by_edges(a: Flat, b: Flat) -> Mask:
    """Return which pairs overlap: an edge of one crosses one of the other, or a vertex is inside.

    As T. Moller has it: nine pairs of edges, then one vertex of each triangle against the other triangle.
    """
    near = _inside(a[0], b) | _inside(b[0], a)
    for i in range(3):
        for j in range(3):
            near |= _edges_cross(a[i], a[(i + 1) % 3], b[j], b[(j + 1) % 3])
    return near


def _axes(edges_a: Triangles, edges_b: Triangles, normal_a: Vectors, normal_b: Vectors) -> Iterator[Vectors]:
    yield from (normal_a, normal_b)
    yield from starmap(cross, product(edges_a, edges_b))
    yield from (cross(normal_a, edge) for edge in edges_a)
    yield from (cross(normal_b, edge) for edge in edges_b)


def separating_axes(a: Triangles, b: Triangles) -> Mask:
    """Return which pairs no axis separates: (N,)."""
    # Relative to a vertex of A, which costs nothing and rounds less.
    p, q, r, s, t = a[1] - a[0], a[2] - a[0], *(b - a[0])
    edges_a = np.stack([p, q - p, a[0] - a[2]])
    edges_b = np.stack([b[1] - b[0], b[2] - b[1], b[0] - b[2]])
    separated, zero = np.zeros(a.shape[2], np.bool_), np.zeros_like(p[0])
    for axis in _axes(edges_a, edges_b, normal(a), normal(b)):
        # The first vertex of A is at 0.
        on_a = np.stack([dot(axis, p), dot(axis, q), zero])
        on_b = np.stack([dot(axis, r), dot(axis, s), dot(axis, t)])
        separated |= (on_b.min(0) > on_a.max(0)) | (on_a.min(0) > on_b.max(0))
    return ~separated


Signs = npt.NDArray[np.int8]


def _lone(pattern: tuple[int, ...]) -> tuple[int, int]:
    """Return the vertex of a pattern of signs that is alone, and the side that it is on.

    On the plane counts as the other side; a vertex on the plane is alone if the others are beyond it on
    one side. (0, 0) where there is none: all on the plane, or all strictly on one side.
    """
    for number in range(3):
        others = [pattern[(number + 1) % 3], pattern[(number + 2) % 3]]
        for side in (1, -1):
            beyond = all(side * other <= 0 for other in others)
            touching = pattern[number] == 0 and all(side * other < 0 for other in others)
            if (side * pattern[number] > 0 and beyond) or touching:
                return number, side
    return 0, 0


_TABLE = np.array([_lone(pattern) for pattern in product((-1, 0, 1), repeat=3)], np.int8)


def lone_vertex(sides: Signs) -> tuple[npt.NDArray[np.intp], Signs]:
    """Return, from the sides of the vertices (3, N), the number of the lone one and its side: (N,) each."""
    found = _TABLE[9 * sides[0].astype(np.intp) + 3 * sides[1] + sides[2] + 13]
    return found[:, 0].astype(np.intp), found[:, 1]


def all_on_one_side(sides: Signs) -> Mask:
    """Return whether all three are strictly on the same side: (N,)."""
    return np.abs(sides.sum(0)) == 3


def _interval(places: Numbers, heights: Numbers) -> tuple[Numbers, Numbers]:
    """Return where the two edges from the lone vertex cross the plane, in order: (N,) each.

    places, heights: of the vertices (3, N), along the line and above the plane.
    """
    lone, side = lone_vertex(signs(heights))
    place, height = vertex(places, lone), vertex(heights, lone)
    ends = []
    for other in (lone + 1, lone + 2):
        drop = np.where(side == 0, 1, height - vertex(heights, other))
        ends.append(place + (vertex(places, other) - place) * height / drop)
    return np.minimum(*ends), np.maximum(*ends)


def moller(a: Triangles, b: Triangles) -> Mask:
    """Return which pairs the test takes for touching or overlapping: (N,)."""
    normal_a, normal_b = normal(a), normal(b)
    shift_a, shift_b = -dot(normal_a, a[0]), -dot(normal_b, b[0])
    heights_a = np.stack([dot(normal_b, point) + shift_b for point in a])
    heights_b = np.stack([dot(normal_a, point) + shift_a for point in b])
    signs_a, signs_b = signs(heights_a), signs(heights_b)
    apart = all_on_one_side(signs_a) | all_on_one_side(signs_b)
    coplanar = ~signs_a.any(0) | ~signs_b.any(0)
    along = largest_component(cross(normal_a, normal_b))
    low_a, high_a = _interval(component(a, along), heights_a)
    low_b, high_b = _interval(component(b, along), heights_b)
    near = ~apart & (low_a <= high_b) & (low_b <= high_a)
    flat = np.flatnonzero(coplanar & ~apart)
    if len(flat):
        seen = [seen_flat(triangle[..., flat], normal_a[:, flat]) for triangle in (a, b)]
        near[flat] = overlap_by_edges(*seen)
    return near


def _heights(triangle: Triangles, plane: Triangles) -> Numbers:
    """Return the orientation of each vertex with respect to the plane of another triangle: (3, N)."""
    up = cross(plane[0] - plane[2], plane[1] - plane[2])
    return np.stack([dot(point - plane[2], up) for point in triangle])


def _orientation(a: Vectors, b: Vectors, c: Vectors, d: Vectors) -> Numbers:
    """Return det(a - d, b - d, c - d): (N,)."""
    return dot(a - d, cross(b - d, c - d))


def _from_lone(
    triangle: Triangles, lone: npt.NDArray[np.intp], turned: Mask
) -> tuple[Vectors, Vectors, Vectors]:
    """Return the vertices from the lone one on, the other way round where ``turned``: (3, N) each."""
    step = np.where(turned, 2, 1)
    return vertex(triangle, lone), vertex(triangle, lone + step), vertex(triangle, lone + 2 * step)


def guigue_devillers(a: Triangles, b: Triangles) -> Mask:
    """Return which pairs the test takes for touching or overlapping: (N,)."""
    signs_a, signs_b = signs(_heights(a, b)), signs(_heights(b, a))
    apart = all_on_one_side(signs_a) | all_on_one_side(signs_b)
    coplanar = ~signs_a.any(0) | ~signs_b.any(0)
    (lone_a, side_a), (lone_b, side_b) = lone_vertex(signs_a), lone_vertex(signs_b)
    # Exchanging q and r of one turns its plane over, and so brings p of the other to the upper side.
    p1, q1, r1 = _from_lone(a, lone_a, side_b < 0)
    p2, q2, r2 = _from_lone(b, lone_b, side_a < 0)
    first_before, last_before = _orientation(q2, p2, p1, q1) > 0, _orientation(r2, p2, r1, p1) > 0
    near = ~(apart | first_before | last_before)
    flat = np.flatnonzero(coplanar & ~apart)
    if len(flat):
        along = normal(a[..., flat])
        near[flat] = overlap_by_turns(seen_flat(a[..., flat], along), seen_flat(b[..., flat], along))
    return near
