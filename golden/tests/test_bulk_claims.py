"""Verdicts alone against those that come with all facts."""

import numpy as np
import pytest

from triaxis.golden.bulk import bulk_claims, bulk_facts
from triaxis.golden.certificate import claims_prove_clear
from triaxis.golden.errors import InputError
from triaxis.golden.pairs import NO_AXIS
from triaxis.golden.tests.bulk_pairs import hard_pairs


def test_claims_are_those_of_the_facts(rng):
    pairs, margins = hard_pairs(rng, 8000)
    claims, facts = bulk_claims(pairs, margins), bulk_facts(pairs, margins)
    assert np.array_equal(claims, facts.claim)
    assert len(set(claims)) > 25
    clear = claims != NO_AXIS
    assert claims_prove_clear(pairs[clear], margins[clear], claims[clear]).all()
    collision = bulk_claims(pairs, 0)
    assert np.array_equal(collision, bulk_facts(pairs, 0).claim)
    assert len(set(collision)) > 25


@pytest.mark.parametrize("count", [0, 1, 7, 8, 9])
def test_any_number_of_pairs(rng, count):
    pairs, margins = (array[:count] for array in hard_pairs(rng, 8))
    assert np.array_equal(bulk_claims(pairs, margins), bulk_facts(pairs, margins).claim)


def test_bad_input_is_refused():
    with pytest.raises(InputError, match="shape"):
        bulk_claims(np.zeros((3, 3), np.int32), 0)
    with pytest.raises(InputError, match="margins"):
        bulk_claims(np.zeros((1, 2, 3, 3), np.int32), -1)
