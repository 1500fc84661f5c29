"""The safety theorem, on rationals: what rounding can do to a distance, and no more.

Each coordinate of a real pair is a whole number plus an error of at most 1/2, so every way of rounding to the
nearest, and of breaking ties, is covered. Distances are in LSB.
"""

from fractions import Fraction
from math import ceil

import pytest
from hypothesis import find, given, settings
from hypothesis import strategies as st
from hypothesis.errors import NoSuchExample

from triaxis.golden.judge import judge
from triaxis.host.quantise import Grid, margin_for

REPEATABLE = settings(deadline=None, derandomize=True, database=None, max_examples=100)
SEARCHING = settings(REPEATABLE, max_examples=1000)

HALF = Fraction(1, 2)
WHOLE = st.one_of(st.integers(-3, 3), st.integers(-300, 300))
# The worst roundings, and others.
WORST = st.sampled_from([-HALF, HALF, Fraction(0)])
ERRORS = st.one_of(WORST, st.fractions(-HALF, HALF, max_denominator=1000))
CLEARANCES = st.one_of(st.just(Fraction(0)), st.fractions(0, 6, max_denominator=60))
GRID = Grid(Fraction(1), (Fraction(0), Fraction(0), Fraction(0)), 16)


@st.composite
def roundings(draw):
    """Draw a pair of triangles: rounded, and as it was."""
    numbers = [draw(WHOLE) for _ in range(18)]
    # Vertices may coincide, within a triangle and between the two.
    for vertex in range(1, 6):
        if draw(st.booleans()) and draw(st.booleans()):
            earlier = draw(st.integers(0, vertex - 1))
            numbers[3 * vertex : 3 * vertex + 3] = numbers[3 * earlier : 3 * earlier + 3]
    errors = [draw(ERRORS) for _ in range(18)]
    return _pair(numbers), _pair([n + e for n, e in zip(numbers, errors, strict=True)])


@st.composite
def point_roundings(draw):
    """Draw a pair of points on a line, each as a triangle: with the worst roundings, or none."""
    whole = [draw(st.integers(-2, 2)) for _ in range(2)]
    real = [number + draw(WORST) for number in whole]
    return tuple(_pair(3 * [places[0], 0, 0] + 3 * [places[1], 0, 0]) for places in (whole, real))


def _pair(numbers):
    vertices = [numbers[k : k + 3] for k in range(0, 18, 3)]
    return vertices[:3], vertices[3:]


def distance(pair):
    """Return the exact distance of a pair."""
    return judge(*pair, 0).distance


def missed(rounding, clearance, margin):
    """Return whether a pair within the clearance is clear on the grid at the margin."""
    rounded, real = rounding
    return judge(*real, clearance).near and not judge(*rounded, margin).near


def beyond(rounding, margin, band):
    """Return whether a pair that is near on the grid at the margin is farther apart than margin + band."""
    rounded, real = rounding
    return judge(*rounded, margin).near and not judge(*real, margin + band).near


@REPEATABLE
@given(roundings(), CLEARANCES, st.integers(0, 5))
def test_rounding_moves_distances_by_one_lsb_at_most(rounding, extra, more):
    rounded, real = (distance(pair) for pair in rounding)
    assert abs(rounded - real) <= 1
    # The least clearance that the pair is within, or a larger one: not missed.
    clearance = real + extra
    assert margin_for(clearance, GRID) == ceil(clearance) + 1
    assert not missed(rounding, clearance, ceil(clearance) + 1)
    # The least margin at which the grid says near, or a larger one: no alarm beyond the band.
    assert not beyond(rounding, ceil(rounded) + more, 1)


@pytest.mark.parametrize("clearance", [Fraction(0), Fraction(2)])
def test_a_smaller_margin_misses(clearance):
    """Examples are found at once: the checks above can fail, and the theorem's margin is the least."""
    find(point_roundings(), lambda r: missed(r, clearance, ceil(clearance)), settings=SEARCHING)
    with pytest.raises(NoSuchExample):
        find(point_roundings(), lambda r: missed(r, clearance, ceil(clearance) + 1), settings=REPEATABLE)


@pytest.mark.parametrize("margin", [0, 3])
def test_a_narrower_band_is_exceeded(margin):
    find(point_roundings(), lambda r: beyond(r, margin, Fraction(99, 100)), settings=SEARCHING)
