"""Curves of a program, and how far they are from their chords: arcs and helices.

A curve p(t), 0 <= t <= 1, whose second derivative is at most M long is at most M h^2 / 8 from the chord
between two of its points h apart in t, each p(t) from the point of the chord at the same t (the error of
linear interpolation). So pieces of a curve are proven clear like straight ones, with that much more margin,
and halving makes it a quarter.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise

from triaxis.host.quantise import Vector, added, vector

# Millimetres. What double precision rounds in a point below stays under it while coordinates are below
# 10^6: some ten operations of relative error 2^-53; a control, which rounds in another order, differs as
# little. So does a centre that was computed from R, but for half circles: see `centre_by_radius`.
SLACK = Fraction(1, 10**5)
# How far the radii at both ends may differ, in millimetres, and as a share: LinuxCNC's limits for inches.
_RADII, _RADII_SHARE = 0.0508 * math.sqrt(2), 0.001
# Of LinuxCNC's, too: how much a radius may be too short for its end.
_TOO_SHORT = 0.00127
# As a share of R: how far a centre is from the chord at most that may as well be on it.
_NEARLY_HALF = Fraction(2, 10**6)
# Radians; and times the radius squared, of which LinuxCNC makes a whole circle with inches for its units.
_NOTHING, _NOTHING_TIMES_SQUARE = 1e-6, 6.5e-6
# Below 10^-5 radians LinuxCNC takes an arc for a whole turn, where it joins moves.
_WHOLE = 0.99e-5
_SAMPLES, _CHORDS = 16, 32


@dataclass(frozen=True)
class Curve:
    """A way from a point to another. ``bend``: of its second derivative, in mm; ``slack``: of its points."""

    start: Vector
    end: Vector
    bend: Fraction
    slack: Fraction

    def at(self, part: Fraction) -> Vector:
        """Return a point, but for ``slack``; both ends exactly."""
        if part in (0, 1):
            return self.end if part else self.start
        return vector(Fraction(round(x * 2**30), 2**30) for x in self._point(float(part)))

    def _point(self, part: float) -> Sequence[float]:
        raise NotImplementedError

    @property
    def turns(self) -> int:
        """Return how often it goes round, rounded up; 1 where it does not."""
        return 1

    @property
    def length(self) -> float:
        """Return its length in millimetres, nearly."""
        points = [[float(c) for c in self.at(Fraction(k, _CHORDS))] for k in range(_CHORDS + 1)]
        return sum(math.dist(*ends) for ends in pairwise(points))

    def moved(self, by: Vector) -> "Curve":
        """Return the curve elsewhere."""
        raise NotImplementedError

    def extent(self) -> tuple[Vector, Vector]:
        """Return the lower and the upper corner of a box that holds all of it."""
        points = list(zip(*(self.at(Fraction(k, _SAMPLES)) for k in range(_SAMPLES + 1)), strict=True))
        room = self.bend / (8 * _SAMPLES**2) + self.slack
        return vector(min(c) - room for c in points), vector(max(c) + room for c in points)


@dataclass(frozen=True)
class Arc(Curve):
    """An arc about a centre, a helix where it moves along its axis, a spiral where the radii differ.

    ``axes``: the two of its plane, then its own. ``sweep``: radians, positive from the first to the second.
    """

    axes: tuple[int, int, int]
    centre: tuple[float, float]
    radii: tuple[float, float]
    angle: float
    sweep: float

    @property
    def turns(self) -> int:
        """Return how often it goes round, rounded up."""
        return max(1, math.ceil(abs(self.sweep) / (2 * math.pi)))

    @property
    def length(self) -> float:
        """Return that of a helix of the mean radius, which a spiral's nearly is."""
        along = float(self.end[self.axes[2]] - self.start[self.axes[2]])
        return math.hypot(sum(self.radii) / 2 * self.sweep, along)

    def _point(self, part: float) -> Sequence[float]:
        a, b, c = self.axes
        radius = self.radii[0] + (self.radii[1] - self.radii[0]) * part
        angle = self.angle + self.sweep * part
        point = [0.0] * 3
        point[a] = self.centre[0] + radius * math.cos(angle)
        point[b] = self.centre[1] + radius * math.sin(angle)
        point[c] = float(self.start[c]) + float(self.end[c] - self.start[c]) * part
        return point

    def extent(self) -> tuple[Vector, Vector]:
        """Return the corners of a box: no more than that of whole turns, however many there are."""
        low, high = (list(corner) for corner in super().extent())
        radius = above(max(self.radii)) + self.slack
        for k, centre in zip(self.axes, self.centre, strict=False):
            low[k] = max(low[k], Fraction(centre) - radius)
            high[k] = min(high[k], Fraction(centre) + radius)
        own = self.axes[2]
        low[own], high[own] = (f(self.start[own], self.end[own]) for f in (min, max))
        return vector(low), vector(high)

    def moved(self, by: Vector) -> "Arc":
        """Return the arc elsewhere."""
        a, b, _ = self.axes
        there = self.centre[0] + float(by[a]), self.centre[1] + float(by[b])
        return replace(self, start=added(self.start, by), end=added(self.end, by), centre=there)


@dataclass(frozen=True)
class Turned(Curve):
    """A curve turned about z, in radians, and then moved."""

    of: Curve
    angle: float
    by: Vector

    @property
    def turns(self) -> int:
        """Return how often the curve goes round that is turned."""
        return self.of.turns

    @property
    def length(self) -> float:
        """Return that of the curve that is turned."""
        return self.of.length

    def _point(self, part: float) -> Sequence[float]:
        x, y, z = (float(c) for c in self.of.at(Fraction(part)))
        cos, sin = math.cos(self.angle), math.sin(self.angle)
        there = x * cos - y * sin, x * sin + y * cos, z
        return [c + float(b) for c, b in zip(there, self.by, strict=True)]

    def moved(self, by: Vector) -> "Turned":
        """Return the curve elsewhere."""
        return replace(self, start=added(self.start, by), end=added(self.end, by), by=added(self.by, by))


def arc(
    start: Vector, end: Vector, axes: tuple[int, int, int], centre: tuple[Fraction, Fraction],
    clockwise: bool, turns: int, error: Fraction = Fraction(0), tolerance: Fraction = Fraction(0),
) -> Arc:  # fmt: skip
    """Return the arc about a centre; raise ValueError where there is none.

    ``error``: how far, in millimetres, the ends may be from where they are said to be: as much is taken for
    nothing, and so for a whole circle. ``tolerance``: how far moves may be from what they are joined to, in
    millimetres.
    """
    a, b, _ = axes
    first, last = ([float(p[k] - c) for k, c in zip((a, b), centre, strict=True)] for p in (start, end))
    radii = math.hypot(*first), math.hypot(*last)
    apart = abs(radii[0] - radii[1])
    if min(radii) < 1e-6:
        raise ValueError("an arc without a radius: correct its centre")
    if apart > 100 * _RADII or (apart > _RADII and apart > _RADII_SHARE * max(radii)):
        raise ValueError(
            f"the radii at both ends of the arc, {radii[0]:g} and {radii[1]:g}, differ: correct its centre"
        )
    angle = math.atan2(first[1], first[0])
    turned = (math.atan2(last[1], last[0]) - angle) * (-1 if clockwise else 1) % (2 * math.pi)
    # Next to nothing is a whole circle to some controls: which holds the little arc.
    nothing = max(_NOTHING, _NOTHING_TIMES_SQUARE / min(radii) ** 2, float(error) / min(radii))
    if turns > 1 and tolerance and _beside_chord(turned, min(radii), float(error)) <= tolerance:
        raise ValueError(
            f"an arc of {turns} turns that ends next to where it began: within the tolerance of G64 LinuxCNC "
            "leaves the turns out: give whole turns, or G61"
        )
    whole = turns if turned < nothing else turns - 1
    sweep = (turned + 2 * math.pi * whole) * (-1 if clockwise else 1)
    # |p''| of (r0 + dr t) e(angle + sweep t) is at most r sweep^2 + 2 |dr sweep|.
    bend = max(radii) * sweep**2 + 2 * apart * abs(sweep)
    return Arc(
        start, end, above(bend), SLACK + above(apart), axes, (float(centre[0]), float(centre[1])), radii,
        angle, sweep,
    )  # fmt: skip


def centre_by_radius(
    start: Vector, end: Vector, axes: tuple[int, int, int], radius: Fraction, clockwise: bool
) -> tuple[tuple[Fraction, Fraction], Fraction]:
    """Return the centre of an arc of a radius, more than a half circle where that is negative; and how far
    points of the arc may be off for it. Raises ValueError where there is none.

    Where half the chord is above (1 - 10^-12) R, LinuxCNC takes its middle for the centre, which is up to
    1.42 * 10^-6 R away; and what rounding leaves of R^2 - (chord / 2)^2, a control may be off by as well.
    Elsewhere that is below 10^-10 R.
    """
    a, b, _ = axes
    x, y = end[a] - start[a], end[b] - start[b]
    square = x * x + y * y
    if not square:
        raise ValueError("an arc by R that ends where it starts: give its centre")
    height = radius * radius - square / 4
    if height < 0:
        if math.sqrt(square) / 2 - abs(radius) > _TOO_SHORT:
            raise ValueError(f"R{float(radius):g} does not reach the end of the arc: correct it")
        height = Fraction(0)
    left = math.sqrt(height / square) * (1 if clockwise == (radius < 0) else -1)
    centre = (start[a] + end[a]) / 2 - y * Fraction(left), (start[b] + end[b]) / 2 + x * Fraction(left)
    # The radius is another by next to nothing, too.
    off = Fraction(11, 10) * _NEARLY_HALF * abs(radius)
    return centre, off if height <= (_NEARLY_HALF * radius) ** 2 else Fraction(0)


def _beside_chord(turned: float, radius: float, error: float) -> float:
    """Return how far from its chord the arc is, at least, that is left of one without its whole turns.

    LinuxCNC goes along the chord instead, by way of the arc's middle, where that is below a tolerance: all
    turns are left out then. ``turned``: radians; ``error``: of its ends.
    """
    unsure = error / radius
    if turned + unsure < _WHOLE:
        return 2 * radius
    # One that is next to whole, and may be more, may as well be next to nothing.
    least = max(turned - unsure, 0.0) if turned + unsure < 2 * math.pi + _WHOLE else 0.0
    return radius * (1 - math.cos(least / 2))


def above(length: float) -> Fraction:
    """Return a decimal that is no less, with what double precision rounds in it."""
    return Fraction(math.ceil(length * (1 + 1e-9) * 2**30), 2**30)
