"""Claims are proven by the claimed axis alone."""

import numpy as np
import pytest

from triaxis.golden.axes import separating
from triaxis.golden.claim_check import claims_prove_clear
from triaxis.golden.tests.bulk_pairs import awkward_margins, awkward_pairs


@pytest.mark.parametrize("width", [8, 16, 20, 24, 32])
def test_a_claim_is_proven_exactly_where_its_axis_separates(rng, width):
    pairs = awkward_pairs(rng, 300, width)
    margins = awkward_margins(rng, pairs, width)
    separates = separating(pairs.astype(np.int64), margins.astype(np.int64))
    for axis in range(32):
        proven = claims_prove_clear(pairs, margins, np.full(len(pairs), axis))
        assert (proven == separates[:, axis]).all()
    mixed = rng.integers(0, 32, len(pairs))
    proven = claims_prove_clear(pairs, margins, mixed)
    assert (proven == separates[np.arange(len(pairs)), mixed]).all()
    assert 0 < proven.sum() < len(pairs)
