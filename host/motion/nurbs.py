"""Splines of a program, how far they are from their chords, and how far LinuxCNC's arcs leave them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise

from triaxis.host.motion.curves import SLACK, Curve, above
from triaxis.host.quantise import Vector, added, vector

# Of the parameter, to both sides: over which LinuxCNC takes the direction. Of a coordinate, times the order:
# more than double precision rounds in it. Of a direction, in radians: how far rounding may turn it.
_STEP, _NOISE, _UNSURE = 1e-5, 1e-15, 1e-3
# What the directions at both ends of a step differ by at least, as 1 less their inner product. Where they are
# alike, what LinuxCNC computes is rounding: it leaves the step out, or goes the long way round.
_STRAIGHT = 1e-9
# Ten times what rounding may turn them by, squared; what it rounds in the length of tangents, over that.
_CLEARLY, _CANCELLED = 50, 4e-15
# Points of each arc that are compared with the curve.
_COMPARED = 8
# A control point with its weight w, as (w x, w y, w z, w).
_Weighted = tuple[float, float, float, float]


@dataclass(frozen=True)
class Nurbs(Curve):
    """A part, between two parameters, of a NURBS with knots 0, 1, .., of which both ends stand order times.

    By C. de Boor's algorithm, in double precision: means of control points, so that little is rounded.
    ``points``: of all ``count`` those that the part depends on, from number ``first`` on.
    """

    points: tuple[_Weighted, ...]
    first: int
    count: int
    order: int
    part: tuple[float, float]

    def _point(self, part: float) -> Sequence[float]:
        low, high = self.part
        return self.place(low + (high - low) * part)

    def place(self, at: float) -> Sequence[float]:
        """Return the point at a parameter, from 0 to the number of spans."""
        span = min(int(at), self.first + len(self.points) - self.order)
        held = [list(point) for point in self.points[span - self.first : span - self.first + self.order]]
        for r in range(1, self.order):
            for k in range(self.order - 1, r - 1, -1):
                low, high = self.knot(span + k), self.knot(span + k + self.order - r)
                share = (at - low) / (high - low)
                held[k] = [p + (q - p) * share for p, q in zip(held[k - 1], held[k], strict=True)]
        *point, weight = held[-1]
        return [c / weight for c in point]

    def knot(self, number: int) -> int:
        """Return a knot."""
        return min(max(number - self.order + 1, 0), self.count - self.order + 1)

    def moved(self, by: Vector) -> "Nurbs":
        """Return the curve elsewhere."""
        x, y, z = (float(c) for c in by)
        points = tuple((a + w * x, b + w * y, c + w * z, w) for a, b, c, w in self.points)
        return replace(self, start=added(self.start, by), end=added(self.end, by), points=points)

    def between(self, start: Vector, end: Vector, low: float, high: float) -> "Nurbs":
        """Return the part between two parameters, and how much it may bend."""
        first = min(int(low), self.count - self.order)
        last = max(math.ceil(high), first + 1) + self.order - 1
        held = self.points[first - self.first : last - self.first]
        part = replace(self, start=start, end=end, points=held, first=first, part=(low, high))
        return replace(part, bend=above(part._bound()))

    def _bound(self) -> float:
        """Return what no second derivative of the part is longer than.

        Of p = N / w it is (N'' - 2 w' p' - w'' p) / w; derivatives of N and w are means of the differences of
        control points over their knots, and so at most the largest. Wherever the origin is, p'' is the same:
        it is taken near by.
        """
        origin = [c / self.points[0][3] for c in self.points[0][:3]]
        numbers = [[*(c - w * o for c, o in zip(p, origin, strict=True)), w] for *p, w in self.points]
        reach = max(math.hypot(*n[:3]) / n[3] for n in numbers)
        lengths = []
        for derived in (1, 2):
            degree = self.order - derived
            numbers = [
                [
                    (b - a)
                    * degree
                    / (self.knot(self.first + k + self.order) - self.knot(self.first + k + derived))
                    for a, b in zip(p, q, strict=True)
                ]
                for k, (p, q) in enumerate(pairwise(numbers))
            ]
            lengths.append([max(math.hypot(*n[:3]) for n in numbers), max(abs(n[3]) for n in numbers)])
        (n1, w1), (n2, w2) = lengths
        least = min(w for *_, w in self.points)
        speed = (n1 + w1 * reach) / least
        span = self.part[1] - self.part[0]
        return (n2 + 2 * w1 * speed + w2 * reach) / least * span**2


def nurbs(
    points: Sequence[Vector], weights: Sequence[Fraction], order: int, plane: tuple[int, int], far: float
) -> list[Nurbs]:
    """Return a NURBS in a plane, in parts, each with what a control may be off it.

    LinuxCNC goes through four places for each control point, at equal steps of the parameter, by two arcs
    from one to the next that have the curve's directions there. ``far``: of its coordinates at most, in which
    it computes these. Raises ValueError where the curve has no direction that rounding leaves alone, or one
    that two arcs do not follow.
    """
    last = len(points) - order + 1
    held = tuple(
        (float(x * w), float(y * w), float(z * w), float(w))
        for (x, y, z), w in zip(points, weights, strict=True)
    )
    whole = Nurbs(points[0], points[-1], Fraction(0), SLACK, held, 0, len(points), order, (0.0, float(last)))
    steps = 4 * len(points)
    places = [last * k / steps for k in range(steps + 1)]
    inner = [vector(Fraction(c) for c in whole.place(at)) for at in places[1:-1]]
    ends = [points[0], *inner, points[-1]]
    noise = _NOISE * order * max(far, *(abs(float(c)) for point in points for c in point))
    ways = [_direction(whole, at, float(last), noise) for at in places]
    parts: list[Nurbs] = []
    for k in range(steps):
        part = whole.between(ends[k], ends[k + 1], places[k], places[k + 1])
        off = _off_arcs(part, plane, ways[k], ways[k + 1])
        parts.append(replace(part, slack=SLACK + above(off)))
    return parts


@dataclass(frozen=True)
class _Way:
    """A direction of length 1, and how far, in radians, rounding may have turned it."""

    of: Sequence[float]
    unsure: float


def _direction(curve: Nurbs, at: float, last: float, noise: float) -> _Way:
    low, high = (curve.place(min(max(at + step, 0.0), last)) for step in (-_STEP, _STEP))
    way = [b - a for a, b in zip(low, high, strict=True)]
    length = math.hypot(*way)
    if length * _UNSURE <= noise:
        raise ValueError("a spline that stands still somewhere: write it as plain moves")
    return _Way([c / length for c in way], 2 * noise / length)


def _off_arcs(part: Nurbs, plane: tuple[int, int], first: _Way, last: _Way) -> float:
    """Return how far from a part two arcs may be that leave by one direction and arrive by the other.

    Their points q are compared with points of the part. Between two of each, an arc is no further from its
    chord than c^2 / 4 r, c its length; the chord from that of the part no further than the ends; and the part
    no further from its own than the bend allows. What rounding does to directions and tangents comes on top.
    """
    start, end = ([float(p[k]) for k in plane] for p in (part.start, part.end))
    leaving, arriving = ([way.of[k] for k in plane] for way in (first, last))
    chord = [b - a for a, b in zip(start, end, strict=True)]
    differ = 1 - _dot(leaving, arriving)
    if differ < max(_STRAIGHT, _CLEARLY * max(first.unsure, last.unsure) ** 2):
        raise ValueError(
            "a spline that is straight over a step of the control, where LinuxCNC goes elsewhere: write it "
            "as plain moves"
        )
    # Both arcs have tangents of length beta: |chord - beta (leaving + arriving)| = 2 beta.
    c, b = _dot(chord, chord), -2 * _dot(chord, [x + y for x, y in zip(leaving, arriving, strict=True)])
    below = math.sqrt(b * b + 8 * differ * c) - b
    beta = 2 * c / below if below > 0 else math.inf
    rounded = math.hypot(*chord) * (4 * (first.unsure + last.unsure) + _CANCELLED / differ)
    corners = [
        [x + beta * y for x, y in zip(start, leaving, strict=True)],
        [x - beta * y for x, y in zip(end, arriving, strict=True)],
    ]
    middle = [(x + y) / 2 for x, y in zip(*corners, strict=True)]
    off, at, gap = 0.0, 0.0, 0.0
    for (one, corner, other), begin in zip(
        ((start, corners[0], middle), (middle, corners[1], end)), (0.0, 0.5), strict=True
    ):
        way, side = ([y - x for x, y in zip(one, to, strict=True)] for to in (other, corner))
        size, weight = math.hypot(*way), _dot(way, side) / (math.hypot(*way) * math.hypot(*side) or math.nan)
        # Both sides at the corner are as long: less than half a turn, unless there is none.
        if not weight > 0:
            raise ValueError("a spline that two arcs do not follow over a step: write it as plain moves")
        curved = 2 * math.sqrt(max(1 - weight * weight, 0.0)) / size
        before: Sequence[float] = one
        for k in range(1, _COMPARED + 1):
            share = k / _COMPARED
            parts = (1 - share) ** 2, 2 * share * (1 - share) * weight, share**2
            point = [_dot(parts, xs) / sum(parts) for xs in zip(one, corner, other, strict=True)]
            to = 1.0 if begin and k == _COMPARED else _nearest(part, plane, point, begin + share / 2)
            to = max(to, at)
            there = [part._point(to)[k] for k in plane]
            ends, gap = gap, math.dist(point, there)
            step = math.dist(before, point)
            off = max(off, max(ends, gap) + step**2 * curved / 4 + float(part.bend) * (to - at) ** 2 / 8)
            at, before = to, point
    return off + rounded


def _dot(x: Sequence[float], y: Sequence[float]) -> float:
    return sum(a * b for a, b in zip(x, y, strict=True))


def _nearest(part: Nurbs, plane: tuple[int, int], point: Sequence[float], guess: float) -> float:
    """Return about which share of a part is nearest to a point."""
    for _ in range(3):
        low, high = max(guess - 0.01, 0.0), min(guess + 0.01, 1.0)
        one, other = ([part._point(at)[k] for k in plane] for at in (low, high))
        way = [y - x for x, y in zip(one, other, strict=True)]
        along = _dot(way, [y - x for x, y in zip(one, point, strict=True)]) / (_dot(way, way) or math.nan)
        guess = min(max(low + along * (high - low), 0.0), 1.0) if along == along else guess
    return guess
