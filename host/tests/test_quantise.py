from fractions import Fraction

import numpy as np
import pytest

from triaxis.golden.errors import InputError
from triaxis.golden.judge import judge
from triaxis.host.quantise import (
    NOWHERE,
    Grid,
    Steps,
    box_of,
    centred_grid,
    false_alarm_band,
    finest_resolution,
    fits,
    grid_around,
    margin_for,
    quantise,
    vector,
)


def exact(facets):
    return [[[Fraction(float(x)) for x in v] for v in facet] for facet in facets]


@pytest.mark.parametrize("resolution", [Fraction(1, 1000), Fraction(1, 3), Fraction(1, 4096), Fraction(7)])
@pytest.mark.parametrize("centre", [0.0, 1.0, -12345.678])
def test_rounding_bound_is_exact(rng, resolution, centre):
    facets = (centre + rng.uniform(-30, 30, (60, 3, 3))).astype(np.float32)
    grid = centred_grid([facets], resolution, 32)
    q = quantise(facets, grid, "mesh")
    for facet, rounded in zip(exact(facets), q.tolist(), strict=True):
        for vertex, r in zip(facet, rounded, strict=True):
            for k in range(3):
                moved = abs(vertex[k] - (grid.offset[k] + grid.resolution * r[k]))
                assert moved <= grid.rounding_bound


def test_halves_and_their_neighbours_round_exactly():
    # Multiples of a half step, and the next float32 on either side, far from the offset.
    halves = (np.arange(-4001, 4002, 2) / 2).astype(np.float32)
    values = np.concatenate(
        [halves, np.nextafter(halves, np.float32(1e9)), np.nextafter(halves, np.float32(-1e9))]
    )
    values = np.resize(values, (len(values) // 9 + 1, 3, 3)).astype(np.float32)
    offset = Fraction(10**9)
    grid = Grid(Fraction(1), (offset, -offset, Fraction(1, 3)), 32)
    q = quantise(values, grid, "mesh")
    for facet, rounded in zip(exact(values), q.tolist(), strict=True):
        for vertex, r in zip(facet, rounded, strict=True):
            assert [round(x - o) for x, o in zip(vertex, grid.offset, strict=True)] == r


def test_no_near_pair_is_ever_missed(rng):
    """The theorem behind margin_for: within the clearance in reality means near on the grid."""
    resolution = Fraction(1, 10)
    alarms = 0
    for _ in range(300):
        facets = rng.uniform(-1, 1, (2, 3, 3)).astype(np.float32)
        facets[1] += rng.uniform(-2, 2, 3).astype(np.float32)
        grid = centred_grid([facets], resolution, 8)
        clearance = Fraction(int(rng.integers(0, 60)), 97)
        margin = margin_for(clearance, grid)
        real_a, real_b = exact(facets)
        real = judge(real_a, real_b, clearance)
        a, b = quantise(facets, grid, "mesh").tolist()
        found = judge(a, b, margin)
        assert found.near or not real.near
        if found.near:
            assert real.distance < clearance + 3 * resolution
            alarms += not real.near
    assert alarms, "the band of false alarms was never seen: the test tests nothing"


def test_a_smaller_margin_would_miss():
    """One step less than margin_for gives is too little: the bound is tight."""
    resolution = Fraction(1)
    # 2 apart in reality; the two roundings, to even, move the points one step further apart.
    a = np.full((1, 3, 3), np.float32(0.5))
    b = np.full((1, 3, 3), np.float32(2.5))
    b[..., 0] = np.float32(3.5)
    grid = Grid(resolution, NOWHERE, 8)
    qa, qb = quantise(a, grid, "a")[0].tolist(), quantise(b, grid, "b")[0].tolist()
    assert judge(exact(a)[0], exact(b)[0], 3).near
    assert margin_for(Fraction(3), grid) == 4
    assert judge(qa, qb, 4).near
    assert not judge(qa, qb, 3).near


def test_errors_name_the_place(rng):
    facets = rng.uniform(0, 100, (5, 3, 3)).astype(np.float32)
    grid = centred_grid([facets], Fraction(1, 1000), 16)
    with pytest.raises(InputError, match=r"part\.stl: facet \d, vertex \d, coordinate [xyz]: .* 16 bits"):
        quantise(facets, grid, "part.stl")
    for resolution in (Fraction(0), Fraction(-1), Fraction(1, 10**400), Fraction(10**400)):
        with pytest.raises(InputError, match="resolution"):
            centred_grid([facets], resolution, 16)
    huge = np.full((1, 3, 3), np.float32(3e38))
    huge[0, 0] = np.float32(-3e38)
    with pytest.raises(InputError, match="does not fit"):
        quantise(huge, centred_grid([huge], Fraction(1, 10**30), 32), "huge.stl")


def test_a_moved_mesh_is_rounded_where_it_stands(rng):
    facets = rng.uniform(-1, 1, (20, 3, 3)).astype(np.float32)
    grid = Grid(Fraction(1, 7), (Fraction(1, 3), Fraction(0), Fraction(-5)), 24)
    move = (Fraction(10**4, 3), Fraction(-1, 10**9), Fraction(5))
    q = quantise(facets, grid.moved(move), "mesh")
    for facet, rounded in zip(exact(facets), q.tolist(), strict=True):
        for vertex, r in zip(facet, rounded, strict=True):
            assert r == [round((x + m - o) * 7) for x, m, o in zip(vertex, move, grid.offset, strict=True)]
    low, high = box_of(facets, move)
    for k in range(3):
        assert low[k] == min(v[k] for facet in exact(facets) for v in facet) + move[k]
        assert high[k] == max(v[k] for facet in exact(facets) for v in facet) + move[k]


@pytest.mark.parametrize("steps", Steps)
@pytest.mark.parametrize("width", (8, 13, 32))
def test_the_resolution_holds_the_box_and_the_next_finer_does_not(rng, steps, width):
    for _ in range(20):
        scale = Fraction(10) ** int(rng.integers(-4, 5))
        low, sides = rng.integers(-(10**6), 10**6, (2, 3)).tolist()
        high = vector(scale * (a + 1 + abs(side)) for a, side in zip(low, sides, strict=True))
        box, unit = (vector(scale * c for c in low), high), Fraction(*rng.integers(1, 30, 2).tolist())
        resolution = finest_resolution(box, width, unit, steps)
        assert fits([box], grid_around([box], resolution, width))
        shown = resolution * unit
        if steps is Steps.BINARY:
            finer = resolution / 2
        else:
            assert Fraction(f"{float(shown):.2e}") == shown
            power = Fraction(10) ** int(f"{float(shown):e}".partition("e")[2])
            # Below 1.00 the third digit is a tenth as large.
            finer = (shown - power / (1000 if shown == power else 100)) / unit
        assert not fits([box], grid_around([box], finer, width))


def test_the_band_holds_for_triangles_rounded_in_any_way(rng):
    """Each vertex of A and B moves by up to r/2, A also by up to r/2 at once: near means within the band."""
    resolution = Fraction(1)
    beyond = []
    for _ in range(150):
        clearance = Fraction(int(rng.integers(0, 400)), 100)
        reading = resolution / 2
        grid = Grid(resolution, NOWHERE, 8)
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
