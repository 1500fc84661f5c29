"""Ranks are exact, axes those of the definition, and certificates prove what they say and no more."""

from fractions import Fraction
from itertools import permutations

import numpy as np
import pytest

from triaxis.golden import axes
from triaxis.golden.axes import NUM_AXES, axis_name, axis_vector, separating
from triaxis.golden.certificate import axis_proves_clear, claims_prove_clear, witness_proves_near
from triaxis.golden.exact import coplanar, rank, triangle_rank
from triaxis.golden.tests.bulk_pairs import awkward_margins, awkward_pairs

TRIANGLE = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
SEGMENT = [[0, 0, 0], [3, 6, 9], [1, 2, 3]]
POINT = [[5, -5, 5]] * 3


@pytest.mark.parametrize(("triangle", "expected"), [(TRIANGLE, 2), (SEGMENT, 1), (POINT, 0)])
def test_triangle_rank_in_every_order(triangle, expected):
    assert {triangle_rank(order) for order in permutations(triangle)} == {expected}


def test_rank_is_exact_where_floating_point_is_not():
    big = 10**30
    assert rank([[big, 1, 0], [big * 3, 3, 0]]) == 1
    assert rank([[big, 1, 0], [big * 3, 4, 0]]) == 2
    assert rank([[Fraction(1, 3), 0, 0], [0, Fraction(1, 10**20), 0], [0, 0, 1]]) == 3


def test_coplanar():
    assert coplanar(TRIANGLE, [[7, 7, 0], [9, 0, 0], [1, 1, 0]])
    assert not coplanar(TRIANGLE, [[7, 7, 0], [9, 0, 0], [1, 1, 1]])
    assert coplanar(SEGMENT, POINT)
    # Two skew segments are degenerate triangles in no common plane.
    assert not coplanar([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 1], [0, 0, 1], [0, 2, 1]])


@pytest.mark.parametrize("size", [3, 50, 2**18, 2**31 - 1])
def test_arrays_and_single_axes_agree(rng, size):
    pairs = rng.integers(-size, size + 1, (40, 2, 3, 3))
    margins = rng.integers(0, 3, 40)
    expected = [
        [axis_proves_clear(a, b, m, axis_vector(n, a, b)) for n in range(NUM_AXES)]
        for (a, b), m in zip(pairs.tolist(), margins.tolist(), strict=True)
    ]
    assert (separating(pairs, margins) == np.array(expected)).all()


def test_64_bits_suffice_up_to_their_limit(monkeypatch):
    low, high = -(1 << (axes._INT64_WIDTH - 1)), (1 << (axes._INT64_WIDTH - 1)) - 1
    rng = np.random.default_rng(3)
    pairs = np.where(rng.integers(0, 2, (3000, 2, 3, 3)) == 0, low, high)
    margins = np.where(rng.integers(0, 2, 3000) == 0, 0, high - low)
    fast = separating(pairs, margins)
    monkeypatch.setattr(axes, "_INT64_WIDTH", 1)
    assert (separating(pairs, margins) == fast).all()


def test_numbering():
    a = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    b = [[0, 0, 9], [0, 2, 9], [3, 0, 9]]
    assert [axis_vector(n, a, b) for n in range(3)] == [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
    assert axis_vector(3, a, b) == [0, 0, 1]
    assert axis_vector(4, a, b) == [0, 0, -6]
    # Edge 0 of A is (1, 0, 0), edge 1 of B is (3, -2, 0).
    assert axis_vector(5 + 1, a, b) == [0, 0, -2]
    # Edge 0 of A x coordinate y; edge 2 of B, (-3, 0, 0), x coordinate z.
    assert axis_vector(14 + 1, a, b) == [0, 0, 1]
    assert axis_vector(23 + 3 * 2 + 2, a, b) == [0, 3, 0]
    assert len({axis_name(n) for n in range(NUM_AXES)}) == NUM_AXES


A = [[0, 0, 0], [4, 0, 0], [0, 4, 0]]
B = [[0, 0, 3], [4, 0, 3], [0, 4, 5]]
HALF = Fraction(1, 2)


def test_witness():
    assert witness_proves_near(A, B, 3, [1, 0, 0], [1, 0, 0])
    assert witness_proves_near(A, B, 3, [HALF, HALF, 0], [HALF, HALF, 0])
    assert not witness_proves_near(A, B, 2, [1, 0, 0], [1, 0, 0])
    # Weights that are no point of the triangle prove nothing.
    assert not witness_proves_near(A, B, 3, [1, 1, -1], [1, 1, -1])
    assert not witness_proves_near(A, B, 3, [0, 0, 0], [0, 0, 0])
    assert not witness_proves_near(A, B, 3, [HALF, 0, 0], [1, 0, 0])


def test_axis():
    assert axis_proves_clear(A, B, 2, [0, 0, 1])
    assert axis_proves_clear(A, B, 2, [0, 0, -7])
    assert not axis_proves_clear(A, B, 3, [0, 0, 1])
    assert not axis_proves_clear(A, B, 0, [1, 0, 0])
    assert not axis_proves_clear(A, B, 0, [0, 0, 0])


@pytest.mark.parametrize("width", [8, 20, 32])
def test_a_claim_is_proven_exactly_where_its_axis_separates(rng, width):
    pairs = awkward_pairs(rng, 300, width)
    margins = awkward_margins(rng, pairs, width)
    separates = separating(pairs.astype(np.int64), margins.astype(np.int64))
    for axis in range(32):
        proven = claims_prove_clear(pairs, margins, np.full(len(pairs), axis))
        assert (proven == separates[:, axis]).all()
    assert 0 < separates.sum() < separates.size
