"""Grids and poses: exact where they can be, and elsewhere within the rounding that they declare."""

from fractions import Fraction
from itertools import product
from typing import Any

import gmpy2
import numpy as np
import pytest

from triaxis.golden.errors import InputError
from triaxis.golden.judge import judge
from triaxis.host.quantise import (
    NOWHERE,
    Grid,
    Steps,
    centred_grid,
    finest_resolution,
    fits,
    grid_around,
    margin_for,
    quantise,
    vector,
)
from triaxis.host.scene import Pose, Turn, turned
from triaxis.host.stl import StlMesh


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
    with pytest.raises(InputError, match="volume: a single point: give one that has an extent"):
        finest_resolution((NOWHERE, NOWHERE), width)


# It says nothing of its types.
MPFR: Any = gmpy2

X, Y, Z = range(3)
EXACT = Fraction(0)


def mesh_of(points, rounding=EXACT):
    return StlMesh(np.resize(np.array(points, np.float64), (1, 3, 3)), rounding)


def first(mesh):
    return mesh.facets[0, 0].tolist()


def test_quarter_turns_are_exact_and_right_handed_and_follow_one_another():
    for turns, point in (
        (((Z, 90),), [-2, 1, 3]),
        (((Z, -90),), [2, -1, 3]),
        (((Z, 180),), [-1, -2, 3]),
        (((Z, 450),), [-2, 1, 3]),
        (((X, 90),), [1, -3, 2]),
        (((Y, 90),), [3, 2, -1]),
        (((Y, 270),), [-3, 2, 1]),
        (((Z, 90), (X, 90)), [-2, -3, 1]),
        (((X, 90), (Z, 90)), [3, 1, 2]),
    ):
        pose = Pose(tuple(Turn(axis, Fraction(degrees)) for axis, degrees in turns))
        mesh = turned(mesh_of([1, 2, 3]), pose.turns)
        assert first(mesh) == point
        assert (mesh.rounding, pose.exact) == (0, True)
    assert not Pose((Turn(X, Fraction(90)), Turn(Z, Fraction(1, 3)))).exact


def really(point, turns):
    """Return the turned point to 600 bits."""
    with MPFR.context(MPFR.get_context(), precision=600):
        place = [MPFR.mpfr(float(x)) for x in point]
        for turn in turns:
            angle = MPFR.mpfr(MPFR.mpq(turn.degrees)) * MPFR.const_pi() / 180
            c, s = MPFR.cos(angle), MPFR.sin(angle)
            j, k = (turn.axis + 1) % 3, (turn.axis + 2) % 3
            place[j], place[k] = c * place[j] - s * place[k], s * place[j] + c * place[k]
        return [Fraction(*map(int, x.as_integer_ratio())) for x in place]


@pytest.mark.parametrize("size", [1e-320, 1e-3, 1.0, 1e6, 1e300])
def test_turns_stay_within_their_rounding(rng, size):
    worst = Fraction(0)
    for _ in range(40):
        turns = [
            Turn(int(rng.integers(3)), Fraction(int(rng.integers(-(10**6), 10**6)), 997))
            for _ in range(rng.integers(1, 4))
        ]
        mesh = StlMesh(rng.uniform(-size, size, (2, 3, 3)), Fraction(0))
        result = turned(mesh, turns)
        for before, after in zip(mesh.facets.reshape(-1, 3), result.facets.reshape(-1, 3), strict=True):
            for real, found in zip(really(before, turns), after, strict=True):
                off = abs(real - Fraction(float(found)))
                assert off <= result.rounding
                worst = max(worst, off / result.rounding)
        assert result.rounding <= max(Fraction(size) / 2**46, Fraction(1, 2**1060))
    assert worst > Fraction(1, 50), "the bound is never approached: the test tests nothing"


def test_what_reading_moved_grows_with_a_turn():
    """An error in both coordinates can reach |c| + |s| = sqrt 2 times its size in one."""
    off = Fraction(1, 1000)
    turn = Turn(Z, Fraction(45))
    result = turned(mesh_of([1.0, 2.0, 3.0], off), [turn])
    corners = [[1 + float(dx * off), 2 + float(dy * off), 3.0] for dx, dy in product((-1, 1), repeat=2)]
    apart = max(
        abs(real - Fraction(float(found)))
        for corner in corners
        for real, found in zip(really(corner, [turn]), first(result), strict=True)
    )
    assert off < apart <= result.rounding


def test_what_cannot_be_turned_is_refused():
    huge = mesh_of([1.7e308, 1.7e308, 0.0])
    with pytest.raises(InputError, match="too large to be turned"):
        turned(huge, [Turn(Z, Fraction(45))])
