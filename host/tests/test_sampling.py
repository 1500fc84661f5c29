"""The bounds that let a few poses stand for a whole path."""

from fractions import Fraction

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from triaxis.golden.exact import Rational
from triaxis.golden.judge import judge
from triaxis.host.motion.path_scene import PathGrid, Segment, nearest
from triaxis.host.quantise import box_of, grid_around, quantise
from triaxis.host.stl import StlMesh

ORIGIN = (Fraction(0), Fraction(0), Fraction(0))
RATIONALS = st.fractions(-1000, 1000, max_denominator=1000)
PLACES = st.tuples(RATIONALS, RATIONALS, RATIONALS)


def segment_between(start, end):
    x, y, z = map(Rational, start)
    u, v, w = map(Rational, end)
    return Segment((x, y, z), (u, v, w), Rational(0), Rational(1))


def along(segment, part):
    return [a + (b - a) * Rational(part) for a, b in zip(segment.start, segment.end, strict=True)]


@given(PLACES, PLACES, st.integers(2, 40))
def test_every_point_is_within_reach_of_the_sample(start, end, count):
    segment = segment_between(start, end)
    farthest = max(
        abs(x - t)
        for k in range(count + 1)
        for x, t in zip(along(segment, Fraction(k, count)), segment.sample, strict=True)
    )
    assert farthest <= segment.reach
    assert segment.reach <= Rational(1, 2) + segment.length / 2
    # The ends are among the points: the reach is no larger than it must be.
    assert farthest == segment.reach


@given(PLACES, PLACES)
def test_halves_make_up_the_segment(start, end):
    segment = segment_between(start, end)
    first, second = segment.halves()
    assert (first.start, first.end, second.end) == (segment.start, second.start, segment.end)
    assert (first.first, first.last, second.last) == (0, second.first, 1)
    assert first.length == second.length == segment.length / 2
    assert first.level == second.level == 1


@given(PLACES)
def test_nearest_is_within_a_half(place):
    assert all(abs(Rational(x) - t) <= Rational(1, 2) for x, t in zip(place, nearest(place), strict=True))


def exact(facets):
    return [[[Fraction(float(x)) for x in vertex] for vertex in facet] for facet in facets]


def random_scene(rng, resolution, reading):
    """Return a tool and a workpiece of a facet each, as integers too, and the grid of the path."""
    tool, work = (StlMesh(rng.uniform(-2, 2, (1, 3, 3)).astype(np.float32), reading) for _ in "ab")
    boxes = [box_of(mesh.facets) for mesh in (tool, work)]
    grid_a, grid_b = (grid_around([box], resolution, 16) for box in boxes)
    x, y, z = (a - b for a, b in zip(grid_a.offset, grid_b.offset, strict=True))
    path = PathGrid(resolution, (x, y, z), Fraction(1, 3), 2 * reading)
    return tool, work, quantise(tool.facets, grid_a, "a"), quantise(work.facets, grid_b, "b"), path


def test_real_and_integer_distance_differ_by_no_more_than_stated(rng):
    resolution = Fraction(1, 5)
    worst = 0.0
    for _ in range(150):
        tool, work, a, b, path = random_scene(rng, resolution, Fraction(0))
        x, y, z = (Fraction(float(c)) for c in rng.uniform(-3, 3, 3))
        place = path.place((x, y, z))
        translation = np.array(nearest(place)) + rng.integers(-2, 3, 3)
        away = max(abs(u - int(t)) for u, t in zip(place, translation, strict=True))
        moved = [[[c + m for c, m in zip(v, (x, y, z), strict=True)] for v in f] for f in exact(tool.facets)]
        real = judge(moved[0], exact(work.facets)[0], 0).distance / resolution
        grid = judge((a[0] + translation).tolist(), b[0].tolist(), 0).distance
        assert abs(real - grid) <= 1 + Fraction(int(away.numerator), int(away.denominator))
        worst = max(
            worst, float(abs(real - grid) / (1 + Fraction(int(away.numerator), int(away.denominator))))
        )
    assert worst > 0.5, "the bound is never approached: the test tests nothing"


def test_margins_cover_what_reading_moved():
    still = PathGrid(Fraction(1), ORIGIN, Fraction(3), Fraction(0))
    segment = segment_between((0, 0, 0), (4, 0, 0))
    assert still.margin(segment) == 3 + 1 + 2
    moved = PathGrid(Fraction(1), ORIGIN, Fraction(3), Fraction(1, 10**20))
    assert moved.margin(segment) == 7
    assert still.proven(6, Rational(2)) == 3
    assert moved.proven(7, Rational(2)) == 4 - Fraction(1, 10**20)
    assert still.seen(6, Rational(0)) == 7
    assert still.band(Fraction(4)) == 6
