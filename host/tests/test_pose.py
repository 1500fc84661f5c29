"""Poses: exact where they can be, and elsewhere within the rounding that they declare."""

from fractions import Fraction
from itertools import product
from typing import Any

import gmpy2
import numpy as np
import pytest

from triaxis.golden.errors import InputError
from triaxis.host.scene import Pose, Turn, turned
from triaxis.host.stl import StlMesh

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
