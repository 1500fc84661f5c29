from fractions import Fraction

import numpy as np
import pytest

from triaxis.golden.errors import InputError
from triaxis.golden.judge import judge
from triaxis.host.quantise import (
    Box,
    Grid,
    Steps,
    Vector,
    extent_of,
    false_alarm_band,
    finest_resolution,
    fits,
    grid_around,
    grown,
    margin_for,
    widest_extent,
)

WIDTHS = (8, 9, 13, 16, 24, 32)


def random_vector(rng: np.random.Generator, low: int, high: int) -> Vector:
    x, y, z = (Fraction(int(c), 1000) for c in rng.integers(low, high, 3))
    return x, y, z


def random_box(rng: np.random.Generator) -> Box:
    scale = Fraction(10) ** int(rng.integers(-4, 5))
    low = random_vector(rng, -(10**6), 10**6)
    x, y, z = (a + 1 + s for a, s in zip(low, random_vector(rng, 0, 10**6), strict=True))
    return tuple(c * scale for c in low), (x * scale, y * scale, z * scale)  # type: ignore[return-value]


@pytest.mark.parametrize("steps", Steps)
@pytest.mark.parametrize("width", WIDTHS)
def test_the_resolution_holds_the_box_and_the_next_finer_does_not(
    rng: np.random.Generator, steps: Steps, width: int
):
    for _ in range(20):
        box, unit = random_box(rng), Fraction(int(rng.integers(1, 30)), int(rng.integers(1, 30)))
        resolution = finest_resolution(box, width, unit, steps)
        assert fits([box], grid_around([box], resolution, width))
        shown = resolution * unit
        if steps is Steps.BINARY:
            assert 1 in (shown.numerator, shown.denominator)
            finer = resolution / 2
        else:
            assert Fraction(f"{float(shown):.2e}") == shown
            power = Fraction(10) ** int(f"{float(shown):e}".partition("e")[2])
            # Below 1.00 the third digit is a tenth as large.
            step = power / (1000 if shown == power else 100)
            finer = (shown - step) / unit
        assert not fits([box], grid_around([box], finer, width))


def test_room_is_left(rng: np.random.Generator):
    for _ in range(50):
        box = random_box(rng)
        resolution = finest_resolution(box, 10, room=2)
        assert fits([grown(box, 2 * resolution)], grid_around([box], resolution, 10))


def test_a_point_has_no_resolution():
    point = (Fraction(1), Fraction(1), Fraction(1))
    with pytest.raises(InputError, match="single point"):
        finest_resolution((point, point), 16)


def test_the_band_holds_for_triangles_rounded_in_any_way(rng: np.random.Generator):
    """Each vertex of A and B moves by up to r/2, A also by up to r/2 at once: near means within the band."""
    resolution = Fraction(1)
    beyond: list[Fraction] = []
    for _ in range(150):
        clearance = Fraction(int(rng.integers(0, 400)), 100)
        reading = resolution / 2
        grid = Grid(resolution, (Fraction(0), Fraction(0), Fraction(0)), 8)
        margin = margin_for(clearance, grid, reading)
        band = false_alarm_band(clearance, resolution, margin, reading)
        assert 2 * resolution + 2 * reading <= band < 3 * resolution + 2 * reading
        a, b = rng.integers(-3, 4, (2, 3, 3))
        b[:, 0] += int(margin) + int(rng.integers(-2, 4))
        # To the sides that help most to be wrong: A's and B's vertices apart, or towards each other.
        sign = int(rng.choice((-1, 1)))
        real_a = [[Fraction(int(x)) - sign * (k == 0) for k, x in enumerate(v)] for v in a]
        real_b = [[Fraction(int(x)) + sign * Fraction(k == 0, 2) for k, x in enumerate(v)] for v in b]
        real, rounded = judge(real_a, real_b, 0).distance, judge(a.tolist(), b.tolist(), 0).distance
        if rounded <= margin:
            assert real <= clearance + band
            beyond.append(real - clearance - band)
        else:
            assert real > clearance
    # The band is no larger than it must be.
    assert max(beyond) == 0


def test_an_extent_of_which_every_volume_meets_the_band(rng: np.random.Generator):
    for _ in range(100):
        width, moved = int(rng.integers(8, 33)), bool(rng.integers(2))
        band, rounding = Fraction(1), Fraction(int(rng.integers(0, 40)), 100)
        extent = widest_extent(band, width, rounding, moved)
        corner = random_vector(rng, -(10**6), 10**6)
        x, y, z = (c + extent for c in corner)
        resolution = finest_resolution((corner, (x, y, z)), width, room=int(moved))
        grid = grid_around([(corner, (x, y, z))], resolution, width)
        reading = rounding + (resolution / 2 if moved else 0)
        clearance = min(extent, Fraction(int(rng.integers(0, 10**4)), 777))
        margin = margin_for(clearance, grid, reading)
        assert false_alarm_band(clearance, resolution, margin, reading) <= band
        assert extent_of([(corner, (x, y, z))]) == extent
    assert widest_extent(Fraction(1), 16, Fraction(1)) == 0
