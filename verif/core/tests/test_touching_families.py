import numpy as np
import pytest

from triaxis.golden.bulk import bulk_facts
from triaxis.verif.core.stimulus.contact import one_step, placed
from triaxis.verif.core.stimulus.families import FAMILIES, TOUCHING
from triaxis.verif.core.stimulus.sole_axis import family_of
from triaxis.verif.core.stimulus.stimulus import Stimulus

# How many vertices of the two span what touches, and whether any axis is at the margin at all: triangles that
# overlap in one plane touch in all of both.
SUPPORTS = {
    "vertex-vertex": (1, 1),
    "vertex-edge": (1, 2),
    "vertex-face": (1, 3),
    "edge-edge": (2, 2),
    "edge-face": (2, 3),
    "face-face": (3, 3),
    "shared edge": (2, 2),
}


def facts_of(stimulus: Stimulus):
    return bulk_facts(stimulus.pairs, stimulus.margins)


@pytest.mark.parametrize("width", [8, 13, 16, 24, 32])
@pytest.mark.parametrize("name", TOUCHING)
def test_features_touch_and_no_more(rng, name, width):
    stimulus = family_of([(TOUCHING[name], 1)])(rng, 2000, width, 0)
    facts = facts_of(stimulus)
    assert facts.near.all()
    proper = (facts.rank_a == 2) & (facts.rank_b == 2)
    assert proper.mean() > 0.4
    supports = np.sort(np.bitwise_count(np.stack([facts.support_a, facts.support_b], 1)), 1)
    assert (supports[proper] == SUPPORTS[name]).all()
    touching = proper & (facts.level != 0)
    assert (touching == proper).all() if name != "face-face" else facts.coplanar.all()


@pytest.mark.parametrize("name", TOUCHING)
def test_pairs_touch_at_any_margin(rng, name):
    stimulus = family_of([(TOUCHING[name], 1)])(rng, 3000, 16, (1 << 16) - 1)
    with_margin = stimulus[stimulus.margins > 0]
    assert len(with_margin) > 1500
    assert np.median(with_margin.margins) > 50
    facts = facts_of(with_margin)
    assert facts.near.all()
    # One less, and all are clear that have a direction to go; in one plane, they may still overlap.
    less = bulk_facts(with_margin.pairs, with_margin.margins - 1)
    assert (less.near & (facts.level != 0)).sum() == 0
    assert (facts.level != 0).mean() > 0.9 or name == "face-face"


@pytest.mark.parametrize("name", TOUCHING)
def test_one_unit_away_and_into(rng, name):
    contact = TOUCHING[name](rng, 3000, 16)
    moved = one_step(rng, contact)
    shift = (moved.pairs - contact.pairs)[:, 1]
    assert (shift == shift[:, :1]).all()
    assert (moved.pairs[:, 0] == contact.pairs[:, 0]).all()
    outward = (shift[:, 0] * contact.away).sum(1)
    assert set(outward) == {-1, 0, 1}
    facts = facts_of(placed(rng, _fitting(moved, 16), 16, 0))
    # A third and more: a vertex may also leave sideways.
    assert 0.25 < 1 - facts.near.mean() < 0.75
    # Every pair that moved outward is clear.
    kept = _fitting(contact, 16)
    assert bulk_facts(kept.pairs, 0).near.all()
    out = moved.pairs[outward == 1]
    assert not bulk_facts(out, 0).near.any()
    still = moved.pairs[outward == 0]
    assert bulk_facts(still, 0).near.all()


def _fitting(contact, width):
    extents = np.ptp(contact.pairs.reshape(-1, 6, 3), axis=1).max(1)
    return contact[extents < 1 << width]


@pytest.mark.parametrize("name", [n for n in FAMILIES if n.startswith("touching")])
def test_families_touch_miss_and_pass(rng, name):
    for largest in (0, 255):
        facts = facts_of(FAMILIES[name](rng, 3000, 16, largest))
        assert 0.6 < facts.near.mean() < 0.95
        touching = facts.near & (facts.level != 0)
        assert touching.mean() > 0.4 or name.endswith("face-face")
