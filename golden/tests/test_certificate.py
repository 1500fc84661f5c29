"""Certificates prove what they say and no more, one by one and on arrays."""

from fractions import Fraction

import numpy as np
import pytest

from triaxis.golden.axes import separating
from triaxis.golden.certificate import axis_proves_clear, claims_prove_clear, witness_proves_near
from triaxis.golden.tests.bulk_pairs import awkward_margins, awkward_pairs

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
    assert 0 < proven.sum() < len(pairs)
