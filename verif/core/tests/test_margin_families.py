import numpy as np
import pytest

from triaxis.golden.bulk import bulk_facts
from triaxis.verif.core.stimulus.families import mixed, mixed_pairs
from triaxis.verif.core.stimulus.margins import (
    at_any_margin,
    box_gaps,
    distances,
    margin_at_decision,
    random_margins,
)


def test_random_margins_are_of_every_kind(rng):
    pairs = mixed_pairs(rng, 3000, 8)
    for largest in (0, 1, 255):
        margins = random_margins(rng, pairs, largest)
        assert margins.min() == 0
        assert margins.max() == largest
    assert (margins == 0).mean() > 0.15
    assert (margins == 7).mean() > 0.04
    assert len(np.unique(margins)) > 100
    beside = (margins - np.maximum(box_gaps(pairs), 0))[box_gaps(pairs) > 8]
    assert all((beside == step).mean() > 0.05 for step in (-1, 0, 1))


def test_box_gaps(rng):
    pairs = rng.integers(-(1 << 31), 1 << 31, (500, 2, 3, 3)).astype(np.int32)
    pairs[::2, 1] //= 1 << 20
    for pair, gap in zip(pairs.astype(np.int64), box_gaps(pairs), strict=True):
        a, b = pair
        assert gap == np.maximum(b.min(0) - a.max(0), a.min(0) - b.max(0)).max()


@pytest.mark.parametrize("width", [8, 16, 24])
def test_distances_tell_the_margin_at_which_pairs_become_near(rng, width):
    stimulus = mixed(rng, 6000, width, (1 << width) - 1)
    about = distances(stimulus.pairs)
    # Distances are fractions; where float64 cannot tell which side of a whole number, leave it out.
    sure = np.abs(about - np.rint(about)) > 1e-5
    smallest = np.ceil(about).astype(np.int64)
    assert (about > 1).mean() > 0.2
    facts = bulk_facts(stimulus.pairs, smallest)
    assert facts.near[sure].all()
    less = bulk_facts(stimulus.pairs, np.maximum(smallest - 1, 0))
    assert not less.near[sure & (smallest > 0)].any()
    # Whole ones: near at the distance itself.
    whole = ~sure & (np.rint(about) > 0)
    assert whole.sum() > 100
    at = np.rint(about).astype(np.int64)
    assert (bulk_facts(stimulus.pairs, at).level != 0)[whole].mean() > 0.8


def test_margins_at_the_decision(rng):
    pairs = mixed(rng, 20_000, 16, (1 << 16) - 1).pairs
    apart = pairs[distances(pairs) > 2]
    facts = bulk_facts(apart, margin_at_decision(rng, apart, (1 << 16) - 1))
    assert 0.3 < facts.near.mean() < 0.7
    assert (facts.near & (facts.level != 0)).mean() > 0.05
    assert (margin_at_decision(rng, apart, 0) == 0).all()
    assert margin_at_decision(rng, apart, 100).max() == 100
    # Kinds of axis that decide: box, normal, edge x edge, edge x box.
    for first, last in ((0, 3), (3, 5), (5, 14), (14, 32)):
        mask = np.uint32((1 << last) - (1 << first))
        assert (facts.separating & mask == facts.separating)[~facts.near].sum() > 50


def test_any_margin(rng):
    pairs = mixed(rng, 20_000, 16, 0).pairs
    margins = at_any_margin(rng, pairs, 1000)
    assert 0 <= margins.min() <= margins.max() <= 1000
    assert (at_any_margin(rng, pairs, 0) == 0).all()
    # A quarter, and what chance and the boxes add.
    about = distances(pairs)
    between = (about > 20) & (about < 900)
    assert 0.18 < (np.abs(margins - about) < 2)[between].mean() < 0.6
