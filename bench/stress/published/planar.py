"""Two triangles in one plane, seen along the coordinate axis closest to its normal."""

from typing import Any

import numpy as np
import numpy.typing as npt

from triaxis.bench.stress.published.vectors import (
    Mask,
    Numbers,
    Triangles,
    Vectors,
    component,
    largest_component,
)

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
    sides = [turn(triangle[k], triangle[(k + 1) % 3], point) for k in range(3)]
    left, right = np.ones(point.shape[1], np.bool_), np.ones(point.shape[1], np.bool_)
    for side in sides:
        left &= side > 0
        right &= side < 0
    return left | right


def overlap_by_edges(a: Flat, b: Flat) -> Mask:
    """Return which pairs overlap: an edge of one crosses one of the other, or a vertex is inside.

    As T. Moller has it: nine pairs of edges, then one vertex of each triangle against the other triangle.
    """
    near = _inside(a[0], b) | _inside(b[0], a)
    for i in range(3):
        for j in range(3):
            near |= _edges_cross(a[i], a[(i + 1) % 3], b[j], b[(j + 1) % 3])
    return near
