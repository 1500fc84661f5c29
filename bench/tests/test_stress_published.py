"""The published tests: right in exact arithmetic, so that their errors on floats are rounding."""

from typing import Any

import numpy as np
import pytest

from triaxis.bench.stress.constructions import near_misses, nearly_coplanar
from triaxis.bench.stress.methods import guigue_devillers, moller, separating_axes
from triaxis.bench.stress.orders import METHODS, in_all_orders, scaled
from triaxis.golden.bulk import bulk_facts
from triaxis.golden.exact import Rational
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


MADE = {
    "near misses of 24 bits": lambda rng: near_misses(rng, 60, 24),
    "near misses of 32 bits": lambda rng: near_misses(rng, 60, 32),
    "nearly coplanar": lambda rng: nearly_coplanar(rng, 80, 2.0**-60),
    "coplanar": lambda rng: nearly_coplanar(rng, 80, 0.0),
    "small grid": lambda rng: grid_pairs(rng, 250, False),
    "small grid, coplanar": lambda rng: grid_pairs(rng, 250, True),
}


@pytest.mark.parametrize("made", MADE)
def test_right_in_exact_arithmetic(rng, made):
    pairs = MADE[made](rng)
    facts = bulk_facts(pairs, 0)
    proper = (facts.rank_a == 2) & (facts.rank_b == 2)
    near, points = facts.near[proper], exact_points(pairs[proper])
    assert 0 < near.sum() < len(near) > 40
    for order in VERTICES[rng.permutation(72)[:6]]:
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
