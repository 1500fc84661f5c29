"""The published tests: right in exact arithmetic, so that their errors on floats are rounding."""

from typing import Any

import numpy as np
import pytest

from triaxis.bench.stress.lattice_families import near_misses, nearly_coplanar
from triaxis.bench.stress.orders import METHODS, in_all_orders, scaled
from triaxis.bench.stress.published.guigue_devillers import guigue_devillers
from triaxis.bench.stress.published.lone_vertex import lone_vertex
from triaxis.bench.stress.published.moller import moller
from triaxis.bench.stress.published.separating_axes import separating_axes
from triaxis.golden.bulk import bulk_facts
from triaxis.golden.rational import Rational
from triaxis.verif.core.stimulus.symmetry import VERTICES

TESTS = (separating_axes, moller, guigue_devillers)


def exact_points(pairs) -> Any:
    """Return pairs as exact rationals: (6, 3, N)."""
    points = np.empty((6, 3, len(pairs)), object)
    for index, value in np.ndenumerate(pairs.reshape(-1, 6, 3).transpose(1, 2, 0)):
        points[index] = Rational(int(value))
    return points


def grid_pairs(rng, count, flat):
    """Return pairs of proper triangles on a small grid, that touch in every way; flat: coplanar."""
    pairs = rng.integers(-4, 5, (count, 2, 3, 3))
    if flat:
        pairs[..., 2] = 0
        pairs = pairs @ rng.integers(-2, 3, (count, 1, 3, 3))
    facts = bulk_facts(pairs, 0)
    return pairs[(facts.rank_a == 2) & (facts.rank_b == 2)]


@pytest.mark.parametrize("test", TESTS)
@pytest.mark.parametrize("width", [24, 32])
def test_right_on_near_misses_in_exact_arithmetic(rng, test, width):
    pairs = near_misses(rng, 60, width)
    near = bulk_facts(pairs, 0).near
    assert 0.2 < near.mean() < 0.9
    points = exact_points(pairs)
    for order in VERTICES[rng.permutation(72)[:12]]:
        ordered = points[order]
        assert (test(ordered[:3], ordered[3:]) == near).all()


@pytest.mark.parametrize("test", TESTS)
@pytest.mark.parametrize("tilt", [2.0**-60, 0.0])
def test_right_on_nearly_coplanar_pairs_in_exact_arithmetic(rng, test, tilt):
    pairs = nearly_coplanar(rng, 80, tilt)
    facts = bulk_facts(pairs, 0)
    proper = (facts.rank_a == 2) & (facts.rank_b == 2)
    points = exact_points(pairs[proper])
    for order in VERTICES[rng.permutation(72)[:6]]:
        ordered = points[order]
        assert (test(ordered[:3], ordered[3:]) == facts.near[proper]).all()


@pytest.mark.parametrize("flat", [False, True])
def test_right_on_a_small_grid_in_exact_arithmetic(rng, flat):
    pairs = grid_pairs(rng, 250, flat)
    near = bulk_facts(pairs, 0).near
    points = exact_points(pairs)
    for order in VERTICES[rng.permutation(72)[:4]]:
        ordered = points[order]
        for test in TESTS:
            assert (test(ordered[:3], ordered[3:]) == near).all(), test.__name__


@pytest.mark.parametrize("flat", [False, True])
def test_no_rounding_on_a_small_grid(rng, flat):
    """Without divisions there is none, in either type; Moller's intervals divide, and round."""
    pairs = grid_pairs(rng, 3000, flat)
    near = bulk_facts(pairs, 0).near
    for method in METHODS:
        answers = in_all_orders(method.test, scaled(pairs).astype(method.dtype))
        if method.test is moller:
            assert (answers != near).mean() < 0.02
        else:
            assert (answers == near).all(), method.name


def test_far_from_every_decision_floats_are_right(rng):
    pairs = rng.integers(-1000, 1001, (3000, 2, 3, 3))
    clear = ~bulk_facts(pairs, 30).near
    grown = pairs.astype(np.float64)
    middle = grown.mean(2, keepdims=True)
    # Near by a distance: of triangles shrunk about their middles, so that they overlap by much.
    deep = bulk_facts(np.rint(middle + 0.9 * (grown - middle)).astype(np.int64), 0).near
    chosen = clear | deep
    assert clear.sum() > 300 and deep.sum() > 100
    for method in METHODS:
        answers = in_all_orders(method.test, scaled(pairs[chosen]).astype(method.dtype))
        assert (answers == deep[chosen]).all(), method.name


def test_each_type_rounds_as_it_does(rng):
    """14 bits are too many for float32's determinants, and not for float64's."""
    pairs = near_misses(rng, 400, 14)
    near = bulk_facts(pairs, 0).near
    for method in METHODS:
        wrong = (in_all_orders(method.test, scaled(pairs).astype(method.dtype)) != near).mean()
        assert wrong > 0.1 if method.dtype is np.float32 else wrong < 0.001, method.name


def test_lone_vertex():
    signs = np.array(
        [
            [1, -1, -1], [-1, 1, 1], [1, 0, 0], [0, 0, -1], [0, 1, 1], [1, 0, -1], [0, 0, 0], [1, 1, 1],
            [-1, 1, 0], [0, -1, -1],
        ],
        np.int8,
    ).T  # fmt: skip
    number, side = lone_vertex(signs)
    assert number.tolist()[:5] == [0, 0, 0, 2, 0]
    assert side.tolist()[:5] == [1, -1, 1, -1, -1]
    # Two vertices are alone on their sides: either will do.
    assert (number[5], side[5]) in {(0, 1), (2, -1)}
    assert side.tolist()[6:8] == [0, 0]
    assert (number[8], side[8]) in {(0, -1), (1, 1)}
    assert (number[9], side[9]) == (0, 1)
