"""The bulk checker against the linear program, which knows nothing of axes."""

import numpy as np
import pytest

from triaxis.golden.bulk import bulk_facts, bulk_verdicts
from triaxis.golden.judge import judge, judge_pairs
from triaxis.golden.tests.bulk_pairs import awkward_margins, awkward_pairs


@pytest.mark.parametrize("width", [8, 16, 24, 32])
def test_verdicts_agree(rng, width):
    pairs = awkward_pairs(rng, 300, width)
    margins = awkward_margins(rng, pairs, width)
    verdicts = bulk_verdicts(pairs, margins)
    assert (verdicts == judge_pairs(pairs, margins)).all()
    assert 0.1 < verdicts["near"].mean() < 0.9
    facts = bulk_facts(pairs, margins)
    assert (facts.near & (facts.level != 0)).any(), "none is exactly at its margin"


@pytest.mark.parametrize("width", [8, 16, 24, 32])
def test_level_pairs_are_at_the_margin_exactly(rng, width):
    pairs = awkward_pairs(rng, 400, width)
    margins = awkward_margins(rng, pairs, width)
    facts = bulk_facts(pairs, margins)
    at_margin = facts.near & (facts.level != 0)
    for (a, b), margin in zip(pairs[at_margin].tolist(), margins[at_margin].tolist(), strict=True):
        assert judge(a, b, 0).distance == margin


def test_touching_points_lie_on_the_supports(rng):
    pairs = awkward_pairs(rng, 1500, 16)
    facts = bulk_facts(pairs, 0)
    chosen = np.flatnonzero(facts.near & (facts.level != 0))
    assert len(chosen) > 100
    for index in chosen:
        a, b = pairs[index].tolist()
        witness = judge(a, b, 0).witness
        assert witness is not None
        for weights, support in (
            (witness.weights_a, facts.support_a[index]),
            (witness.weights_b, facts.support_b[index]),
        ):
            assert sum(weight for v, weight in enumerate(weights) if support >> v & 1) == 1
    sizes = {
        (int(a).bit_count(), int(b).bit_count())
        for a, b in zip(facts.support_a, facts.support_b, strict=True)
    }
    assert {(1, 1), (1, 2), (1, 3), (2, 2), (2, 1), (3, 1)} <= sizes
