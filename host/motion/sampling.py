"""Samples of a path on the engine's grid, and why nothing is missed between them.

A coordinate x of the tool A stands at qa = round((x - oa) / r), one of the workpiece B at qb = round((x -
ob) / r), each at most 1/2 from the real quotient. With the tool at the real position p, its point x is on
B's grid at (x - oa) / r + u, u = (p + oa - ob) / r. A sample is an integer translation T. For a point of
the path with place u,

    |D - d| <= 1/2 + 1/2 + e / r + |u - T|       (all in steps of r, all distances Chebyshev)

where D is the real distance of A at p and B, d that of the integer meshes with A at T, and e what reading
the files (and turning A) moved coordinates, both together: moving each point of A by at most t, and each of
B by at most s, changes the distance by at most t + s.

|u - T| is a convex function of u, so along a straight segment of the path it is largest at an end: the
*reach*, an exact rational, which holds the rounding of the translation (at most 1/2, T being the nearest to
the middle) and half the segment. So where the engine says at T that nothing is near at the margin

    m = ceil((c + e) / r + 1 + reach),

d > m, and D > c / r at every real position of the segment: it is proven clear, no position of it left out.

Where it says near at a segment no longer than the step s, the real distance at the segment's middle is less
than c + 2 e + r (4 + s / (2 r)): the band of false alarms.
"""

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

from triaxis.golden.exact import Rational
from triaxis.host.quantise import Vector
from triaxis.host.scene_engines import Translation

Place = tuple[Rational, Rational, Rational]


def _largest(place: Place, translation: Translation) -> Rational:
    return max(abs(x - t) for x, t in zip(place, translation, strict=True))


@dataclass(frozen=True)
class Segment:
    """A straight piece of a move: its ends, in steps on B's grid, and where in the move it lies, 0..1."""

    start: Place
    end: Place
    first: Rational
    last: Rational
    level: int = 0

    @property
    def length(self) -> Rational:
        """Return the Chebyshev length, in steps."""
        return max(abs(b - a) for a, b in zip(self.start, self.end, strict=True))

    @property
    def middle(self) -> Place:
        """Return the place half-way."""
        x, y, z = ((a + b) / 2 for a, b in zip(self.start, self.end, strict=True))
        return x, y, z

    @property
    def sample(self) -> Translation:
        """Return the integer translation nearest the middle."""
        return nearest(self.middle)

    @property
    def reach(self) -> Rational:
        """Return the Chebyshev distance, in steps, that no point of the segment exceeds from the sample."""
        sample = self.sample
        return max(_largest(self.start, sample), _largest(self.end, sample))

    def halves(self) -> "tuple[Segment, Segment]":
        """Return both halves, in the order of the path."""
        half = (self.first + self.last) / 2
        return (
            Segment(self.start, self.middle, self.first, half, self.level + 1),
            Segment(self.middle, self.end, half, self.last, self.level + 1),
        )


def round_half_up(value: Rational) -> int:
    """Return the nearest integer, halves up."""
    return int((value + Rational(1, 2)) // 1)


def nearest(place: Place) -> Translation:
    """Return the integer translation nearest a place."""
    x, y, z = (round_half_up(c) for c in place)
    return x, y, z


def upwards(value: Rational) -> int:
    """Return the smallest integer that is not less."""
    return int(-(-value // 1))


@dataclass(frozen=True)
class PathGrid:
    """How positions of the tool become places on B's grid, and clearances margins.

    ``shift`` is oa - ob; ``base`` is (c + e) / r + 1. Lengths in the unit of the files.
    """

    resolution: Fraction
    shift: Vector
    clearance: Fraction
    reading: Fraction

    @cached_property
    def base(self) -> Rational:
        """Return what the margin holds besides the reach, in steps."""
        return Rational((self.clearance + self.reading) / self.resolution + 1)

    def place(self, position: Vector) -> Place:
        """Return the place u of a position, in steps."""
        x, y, z = (Rational((p + s) / self.resolution) for p, s in zip(position, self.shift, strict=True))
        return x, y, z

    def margin(self, segment: Segment) -> int:
        """Return the margin at which a clear sample proves the whole segment clear."""
        return upwards(self.base + segment.reach)

    def proven(self, margin: int, away: Rational) -> Fraction:
        """Return the distance that is exceeded ``away`` steps from a sample that is clear at a margin."""
        return (margin - 1 - _fraction(away)) * self.resolution - self.reading

    def seen(self, margin: int, away: Rational) -> Fraction:
        """Return the distance that is not exceeded ``away`` steps from a sample that is near at a margin."""
        return (margin + 1 + _fraction(away)) * self.resolution + self.reading

    def band(self, step: Fraction) -> Fraction:
        """Return how far beyond the clearance a false alarm can be, at segments of a step."""
        return 2 * self.reading + 4 * self.resolution + step / 2


def _fraction(value: Rational) -> Fraction:
    return Fraction(int(value.numerator), int(value.denominator))
