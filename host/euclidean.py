"""Exact Euclidean distances of facets, and an engine that clears what is only near by Chebyshev's distance.

Chebyshev's distance d of two triangles is at most their Euclidean distance, and that at most sqrt(3) d: in
the corner between, what comes near need not be within the clearance. An engine is asked at a margin m for a
clearance of c steps: the m - c cover rounding, reading and the piece of a path, which move each point by as
much in each coordinate, so by at most sqrt(3) (m - c) in all. Facets on the grid that are further apart
than

    c + sqrt(3) (m - c)        (steps, Euclidean)

are therefore further apart than c in reality. One distance or the other is enough to prove a pair clear, so
nothing is missed; what is near after both is within c + 2 sqrt(3) (m - c).
"""

import math
from collections.abc import Sequence
from fractions import Fraction
from itertools import product

import numpy as np

from triaxis.golden.exact import Rational, difference, dot
from triaxis.host.engines import Integers, SceneEngine, SceneRun, Translation
from triaxis.host.quantise import Vector
from triaxis.host.stl import StlMesh

# More than the square root of 3.
ROOT_3 = Fraction(17321, 10000)
# Pairs of which a long piece of path is not asked: it is halved instead.
_MANY = 2000

Point = Sequence[int | Fraction]


def squared_distance(a: Sequence[Point], b: Sequence[Point]) -> Fraction:
    """Return the exact squared Euclidean distance of two triangles; of segments and points as well.

    It is attained between two edges, or a vertex and the inside of a facet; or an edge goes through a facet.
    """
    # Whole numbers take a tenth of the time of fractions.
    scale = math.lcm(*(x.denominator for triangle in (a, b) for vertex in triangle for x in vertex))
    a, b = ([[int(x * scale) for x in vertex] for vertex in triangle] for triangle in (a, b))
    edges = [[(t[k], t[(k + 1) % 3]) for k in range(3)] for t in (a, b)]
    least = min(_of_segments(*p, *q) for p, q in product(*edges))
    for one, other, others_edges in ((a, b, edges[1]), (b, a, edges[0])):
        normal = _cross(difference(one[1], one[0]), difference(one[2], one[0]))
        size = dot(normal, normal)
        if not size or not least:
            continue
        heights = [dot(normal, difference(vertex, one[0])) for vertex in other]
        for vertex, height in zip(other, heights, strict=True):
            square = Rational(height * height, size)
            if square < least and _inside(vertex, one, normal):
                least = square
        for k, (start, end) in enumerate(others_edges):
            below, above = heights[k], heights[(k + 1) % 3]
            if below * above < 0:
                part = Rational(below, below - above)
                place = [p + part * (q - p) for p, q in zip(start, end, strict=True)]
                if _inside(place, one, normal):
                    least = Rational(0)
    return Fraction(int(least.numerator), int(least.denominator) * scale * scale)


def _cross(x: Point, y: Point) -> list[int | Fraction]:
    return [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]]


def _inside(point: Point, triangle: Sequence[Point], normal: Point) -> bool:
    """Return whether a point's projection along the normal is in the triangle."""
    return all(
        dot(_cross(difference(triangle[(k + 1) % 3], triangle[k]), difference(point, triangle[k])), normal)
        >= 0
        for k in range(3)
    )


def _of_segments(p: Point, p_end: Point, q: Point, q_end: Point) -> Rational:
    """Return the squared distance of two segments.

    The square is a convex function of both places, so where its minimum lies outside it is on the rim: of one
    end of either to the other. Inside it is that of the two lines, along the normal of both.
    """
    u, v, w = difference(p_end, p), difference(q_end, q), difference(p, q)
    uu, uv, vv, uw, vw = dot(u, u), dot(u, v), dot(v, v), dot(u, w), dot(v, w)
    determinant = uu * vv - uv * uv
    if determinant and 0 <= uv * vw - vv * uw <= determinant and 0 <= uu * vw - uv * uw <= determinant:
        apart = dot(_cross(u, v), w)
        return Rational(apart * apart, determinant)
    return min(_to_segment(p, q, v), _to_segment(p_end, q, v), _to_segment(q, p, u), _to_segment(q_end, p, u))


def _to_segment(point: Point, start: Point, along: Point) -> Rational:
    way, length = difference(point, start), dot(along, along)
    part = dot(way, along)
    if part <= 0:
        return Rational(dot(way, way))
    if part >= length:
        rest = difference(way, along)
        return Rational(dot(rest, rest))
    return Rational(dot(way, way) * length - part * part, length)


def euclidean_distance(a: StlMesh, i: int, b: StlMesh, j: int, move: Vector) -> float:
    """Return the distance of facet i of A, after an exact move, and facet j of B."""
    return math.sqrt(_square_of_facets(a, i, b, j, move))


def within_in_files(a: StlMesh, b: StlMesh, move: Vector, pairs: Integers, clearance: Fraction) -> Integers:
    """Return which of some pairs of facets (N, 2) are within a clearance, exactly: (K, 2)."""
    near = [[i, j] for i, j in pairs.tolist() if _square_of_facets(a, i, b, j, move) <= clearance * clearance]
    return np.array(near, np.int64).reshape(-1, 2)


def _square_of_facets(a: StlMesh, i: int, b: StlMesh, j: int, move: Vector) -> Rational:
    moved = [[Fraction(float(x)) + m for x, m in zip(vertex, move, strict=True)] for vertex in a.facets[i]]
    other = [[Fraction(float(x)) for x in vertex] for vertex in b.facets[j]]
    return squared_distance(moved, other)


class EuclideanEngine(SceneEngine):
    """An engine whose near pairs are looked at again: those that are clear by Euclid are no longer near."""

    def __init__(self, engine: SceneEngine, a: Integers, b: Integers, clearance: Fraction) -> None:
        """Take an engine and the facets (N, 3, 3) that it has loaded. ``clearance``: in steps of the grid."""
        self._engine, self._a, self._b, self._clearance = engine, a, b, clearance

    def run(self, translation: Translation, margin: int, stop_at_first: bool = False) -> SceneRun:
        """Decide all pairs, or go on to the first near one only."""
        run = self._engine.run(translation, margin, stop_at_first)
        if not run.near_count:
            return run
        if stop_at_first:
            # Of the first one alone nothing follows for the others.
            run = self._engine.run(translation, margin)
            if run.near_count > _MANY:
                return run
        bound = (self._clearance + ROOT_3 * (margin - self._clearance)) ** 2
        near: list[list[int]] = []
        for i, j in run.near.tolist():
            moved = (self._a[i] + np.array(translation)).tolist()
            if squared_distance(moved, self._b[j].tolist()) <= bound:
                near.append([i, j])
                if stop_at_first:
                    break
        run.near = np.array(near, np.int64).reshape(-1, 2)
        run.near_count = len(near)
        return run
