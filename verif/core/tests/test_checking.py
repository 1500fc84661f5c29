"""The checker can fail: every wrong answer turns it red, and so does a wrong checker."""

from dataclasses import replace

import numpy as np
import pytest

from triaxis.golden.bulk import bulk_facts
from triaxis.golden.facts import axis_bit
from triaxis.sim.configuration import Configuration
from triaxis.sim.result import COPLANAR, NEAR
from triaxis.verif.core import checking
from triaxis.verif.core.checking import DESCRIBED, Checker
from triaxis.verif.core.expectation import expected_words
from triaxis.verif.core.stimulus.families import mixed_pairs
from triaxis.verif.core.tests.traffic import Traffic
from triaxis.verif.testbench.golden_sample import GoldenSample, Share, kinds

CONFIGURATION = Configuration(16, 16)
COUNT = 150


@pytest.fixture
def traffic(rng):
    return Traffic(rng, CONFIGURATION, COUNT)


def checked(traffic, words=None, share=None, seen=None):
    arguments = {} if share is None else {"share": share}
    checker = Checker(CONFIGURATION, **arguments, on_checked=(seen or []).append)
    checker.check(traffic.sent(), traffic.returned(words=words))
    return checker


def test_right_answers_pass_and_are_published(traffic):
    seen = []
    checker = Checker(CONFIGURATION, on_checked=seen.append)
    checker.check(traffic.sent(), traffic.returned())
    assert (checker.failed, checker.checked, checker.judged) == (0, COUNT, COUNT)
    assert checker.clear_claims == int((traffic.words & NEAR == 0).sum()) > 0
    assert len(seen[0].facts) == COUNT


@pytest.mark.parametrize("bit", range(16))
def test_any_flipped_bit_of_a_result(traffic, bit):
    words = traffic.words.copy()
    words[33] ^= np.uint16(1 << bit)
    checker = checked(traffic, words)
    assert checker.failed
    failure = checker.failures[0]
    assert (failure.pair == traffic.pairs[33]).all()
    assert failure.context is not None
    assert len(failure.context) == 33
    assert (failure.context == traffic.pairs[:33]).all()


def test_context_reaches_into_the_batch_before(traffic):
    words = traffic.words.copy()
    words[103] ^= np.uint16(NEAR)
    checker = Checker(CONFIGURATION)
    checker.check(traffic.sent(slice(0, 100)), traffic.returned(slice(0, 100), words))
    checker.check(traffic.sent(slice(100, None)), traffic.returned(slice(100, None), words))
    failure = checker.failures[0]
    assert (failure.context == traffic.pairs[39:103]).all()
    assert (failure.context_margins == traffic.margins[39:103]).all()


def test_a_wrong_tag(traffic):
    checker = Checker(CONFIGURATION)
    checker.check(traffic.sent(), traffic.returned(tags=np.where(traffic.tags == 7, 8, traffic.tags)))
    assert "tag 8 where 7 was due" in checker.failures[0].message


def lying_facts(traffic, monkeypatch, **changes):
    """Let the bulk checker say otherwise of one pair; return the words of a core that agrees with it."""
    wrong = replace(bulk_facts(traffic.pairs, traffic.margins), **changes)
    monkeypatch.setattr(checking, "bulk_facts", lambda *_: wrong)
    return expected_words(wrong, CONFIGURATION)


def test_a_false_clear_is_disproved_even_where_core_and_bulk_checker_agree(traffic, monkeypatch):
    facts = bulk_facts(traffic.pairs, traffic.margins)
    above = facts.above.copy()
    above[np.flatnonzero(facts.near)[0]] = axis_bit(4)
    words = lying_facts(traffic, monkeypatch, above=above)
    checker = checked(traffic, words, Share(1 << 15, 0))
    assert checker.failed == 1
    assert "claimed axis 4 (normal B) does not separate" in checker.failures[0].message


def test_a_bulk_checker_that_errs_with_the_core_is_caught_by_the_golden_model(traffic, monkeypatch):
    facts = bulk_facts(traffic.pairs, traffic.margins)
    clear = np.flatnonzero(~facts.near)[0]
    above, below = facts.above.copy(), facts.below.copy()
    above[clear] = below[clear] = 0
    words = lying_facts(traffic, monkeypatch, above=above, below=below)
    checker = checked(traffic, words)
    assert checker.failed == 1
    assert "bulk checker and golden model disagree" in checker.failures[0].message


def test_failures_are_counted_and_only_some_described(traffic):
    checker = checked(traffic, traffic.words ^ np.uint16(NEAR), Share(1 << 15, 0))
    assert checker.failed >= COUNT
    assert len(checker.failures) == DESCRIBED


def test_contract_of_the_smaller_builds(rng):
    pairs = mixed_pairs(rng, 3000, 16)
    facts = bulk_facts(pairs, 0)
    full = expected_words(facts, Configuration(16, 0, gating=False))
    gated = expected_words(facts, Configuration(16, 0))
    boxed = ~facts.near & (facts.claim < 3)
    assert (gated[~boxed] == full[~boxed]).all()
    assert not (gated[boxed] & COPLANAR).any()
    assert (full[boxed] & COPLANAR).any()
    blind = expected_words(facts, Configuration(16, 0, edge_box=False, gating=False))
    differs = (blind ^ full) & NEAR != 0
    assert differs.any()
    # Conservative, and said so.
    assert (blind[differs] & (NEAR | COPLANAR) == NEAR | COPLANAR).all()


def test_the_golden_model_gets_every_kind_and_a_random_share(rng):
    facts = bulk_facts(mixed_pairs(rng, 20_000, 16), 0)
    sample = GoldenSample(Share(1 << 10, 10_000), 1)
    first = sample.choose(facts)
    assert set(kinds(facts)[first]) == set(kinds(facts))
    # The second time nothing is new: what is left is the random share.
    assert 5 <= len(sample.choose(facts)) <= 50
    assert len(GoldenSample(Share(1), 1).choose(facts)) == len(facts)


def test_new_kinds_wait_where_there_are_too_many_at_a_time(rng):
    facts = bulk_facts(mixed_pairs(rng, 20_000, 16), 0)
    sample = GoldenSample(Share(1 << 15, 8), 1)
    chosen = [len(sample.choose(facts)) for _ in range(3)]
    assert all(8 <= count <= 14 for count in chosen)
