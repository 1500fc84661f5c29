from dataclasses import fields

import numpy as np
import pytest

from triaxis.golden import bulk
from triaxis.golden.axes import separating
from triaxis.golden.bulk import bulk_facts, bulk_verdicts
from triaxis.golden.errors import InputError
from triaxis.golden.facts import Facts
from triaxis.golden.pairs import VERDICT, coordinate_range
from triaxis.golden.tests.bulk_pairs import awkward_margins, awkward_pairs
from triaxis.golden.tests.bulk_reference import slow_facts

WIDTHS = (8, 16, 24, 32)
NAMES = [field.name for field in fields(Facts)]


def packed(separates):
    return (separates << np.arange(32, dtype=np.uint64)).sum(1, dtype=np.uint64).astype(np.uint32)


def assert_equal(facts, expected):
    for name in NAMES:
        wrong = np.flatnonzero(getattr(facts, name) != getattr(expected, name))
        assert len(wrong) == 0, f"{name} of pair {wrong[0]}"


@pytest.mark.parametrize("width", WIDTHS)
def test_facts_are_what_they_are_defined_to_be(rng, width):
    pairs = awkward_pairs(rng, 300, width)
    margins = awkward_margins(rng, pairs, width)
    facts = bulk_facts(pairs, margins)
    for index, ((a, b), margin) in enumerate(zip(pairs.tolist(), margins.tolist(), strict=True)):
        found = {name: int(getattr(facts, name)[index]) for name in NAMES}
        assert found == slow_facts(a, b, margin), f"pair {[a, b]}, margin {margin}"
    # Nothing above was trivial.
    for name in NAMES:
        assert len(np.unique(getattr(facts, name))) > 1, name
    for name in ("level", "clear_step", "near_step"):
        assert ((getattr(facts, name) != 0) & (margins > 0)).any(), name
    assert (set(facts.rank_a), set(facts.order_a)) == ({0, 1, 2}, {0, 1, 2, 3, 4, 5})
    # Steps on normals and edge x edge axes, and among pairs that fill the range.
    filling = np.ptp(pairs.reshape(len(pairs), 6, 3), axis=1).max(1) >= 1 << (width - 2)
    assert (facts.clear_step[filling] & 0x3FF8).any()
    assert (facts.near_step[filling] & 0x3FF8).any()


@pytest.mark.parametrize(("width", "count"), [(8, 20000), (16, 20000), (17, 20000), (20, 2000), (32, 2000)])
def test_separating_axes_agree_with_their_definition(rng, width, count):
    pairs = awkward_pairs(rng, count, width)
    margins = awkward_margins(rng, pairs, width)
    expected = packed(separating(pairs, margins))
    assert (bulk_facts(pairs, margins).separating == expected).all()


@pytest.mark.parametrize("width", [16, 17, 32])
def test_all_coordinates_at_the_limits(rng, width):
    low, high = coordinate_range(width)
    pairs = rng.choice(np.array([low, high]), (1000, 2, 3, 3))
    for margin in (0, 1, high - low - 1, high - low):
        margins = np.full(len(pairs), margin)
        expected = packed(separating(pairs, margins))
        assert (bulk_facts(pairs, margins).separating == expected).all()


def test_a_margin_that_reaches_everything():
    corner = (1 << 31) - 1
    a, b = np.full((3, 3), -1 - corner), np.full((3, 3), corner)
    pairs = np.stack([a, b])[None]
    assert bulk_facts(pairs, (1 << 32) - 1).near.all()
    assert bulk_facts(pairs, (1 << 32) - 1).level[0] == 0b111
    assert bulk_facts(pairs, (1 << 32) - 2).clear_step[0] == 0b111
    close = np.zeros((1, 2, 3, 3), np.int32)
    close[:, 1] = 5
    for margin, field in ((4, "clear_step"), (5, "level"), (6, "near_step")):
        assert getattr(bulk_facts(close, margin), field)[0] == 0b111
    for margin in (7, 8, 1 << 31, (1 << 32) - 1):
        assert_equal(bulk_facts(close, margin), bulk_facts(close, 7))


def test_bad_input_is_refused():
    pairs = np.zeros((3, 2, 3, 3), np.int64)
    pairs[2, 1, 0, 2] = 1 << 31
    with pytest.raises(InputError, match="pair 2, triangle B, vertex 0, coordinate z: 2147483648 is outside"):
        bulk_facts(pairs, 0)
    with pytest.raises(InputError, match=r"shape \(2, 3, 3\)"):
        bulk_facts(pairs[0].astype(np.int32), 0)
    with pytest.raises(InputError, match="type float64"):
        bulk_facts(pairs * 0.5, 0)
    good = pairs[:2]
    for margins in (np.array([0, -1]), np.array([0, 1 << 32])):
        with pytest.raises(InputError, match=r"margins: number 1: .*: must be 0\.\.4294967295"):
            bulk_facts(good, margins)
    with pytest.raises(InputError, match=r"must be integers of shape \(2,\)"):
        bulk_facts(good, np.zeros(3, np.int64))
    with pytest.raises(InputError, match="margins: float64"):
        bulk_facts(good, np.zeros(2))


def test_verdicts_and_progress(rng, monkeypatch):
    monkeypatch.setattr(bulk, "_CHUNK", 64)
    pairs = awkward_pairs(rng, 200, 16)
    margins = awkward_margins(rng, pairs, 16)
    done = []
    verdicts = bulk_verdicts(pairs, margins, done.append)
    assert verdicts.dtype == VERDICT
    assert (verdicts == bulk_facts(pairs, margins).verdicts).all()
    assert sum(done) == len(pairs)
    assert len(done) == -(-len(pairs) // 64)
    assert len(bulk_verdicts(pairs[:0], 0)) == 0
