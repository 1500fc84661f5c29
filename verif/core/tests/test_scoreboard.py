"""The scoreboard's parts can fail: wrong, lost and added answers turn them red, so does a wrong checker."""

from dataclasses import replace

import numpy as np
import pytest

from triaxis.golden.bulk import bulk_facts
from triaxis.sim.configuration import Configuration
from triaxis.sim.result import COPLANAR, NEAR
from triaxis.verif.core import checking
from triaxis.verif.core.checking import DESCRIBED, Checker
from triaxis.verif.core.expectation import expected_words
from triaxis.verif.core.items import PairBatch, ResultBatch
from triaxis.verif.core.scoreboard import Matcher
from triaxis.verif.core.stimulus.families import mixed, mixed_pairs
from triaxis.verif.testbench.golden_sample import GoldenSample, Share, kinds


class Traffic:
    """Mixed pairs of a configuration, and their result words."""

    def __init__(self, rng, configuration, count):
        made = mixed(rng, count, configuration.width, configuration.max_margin)
        self.pairs, self.margins = made.pairs, made.margins
        self.tags = np.arange(count)
        self.words = expected_words(bulk_facts(self.pairs, self.margins), configuration)

    def sent(self, part=slice(None)):
        zeros = np.zeros(len(self.tags[part]), np.int64)
        return PairBatch(self.pairs[part], self.margins[part], self.tags[part], zeros)

    def returned(self, part=slice(None), words=None, tags=None):
        words = self.words if words is None else words
        tags = self.tags if tags is None else tags
        return ResultBatch(words[part], tags[part], np.zeros(len(tags[part]), np.int64))


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
    above[np.flatnonzero(facts.near)[0]] = np.uint32(1 << 4)
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


class Bench:
    """A matcher with its checker."""

    def __init__(self):
        self.checker = Checker(CONFIGURATION)
        self.matcher = Matcher(CONFIGURATION.queue_depth, self.checker.check)

    @property
    def failed(self):
        return self.matcher.failed + self.checker.failed

    @property
    def messages(self):
        return " | ".join(f.message for f in self.matcher.failures + self.checker.failures)


def matched(sent, *returned):
    bench = Bench()
    bench.matcher.feed_pairs(sent)
    for batch in returned:
        bench.matcher.feed_results(batch)
    bench.matcher.finish()
    return bench


def test_a_faultless_core_passes_however_it_is_cut(traffic):
    bench = Bench()
    for start in range(0, COUNT, 7):
        bench.matcher.feed_pairs(traffic.sent(slice(start, start + 7)))
    for start in range(0, COUNT, 11):
        bench.matcher.feed_results(traffic.returned(slice(start, start + 11)))
    assert bench.matcher.outstanding == 0
    bench.matcher.finish()
    assert (bench.failed, bench.matcher.matched, bench.checker.checked) == (0, COUNT, COUNT)


def test_nothing_checked_fails():
    matcher = Matcher(CONFIGURATION.queue_depth, lambda *_: None)
    matcher.finish()
    assert matcher.failed
    assert "nothing was checked" in matcher.failures[0].message


def test_dropped_result(traffic):
    kept = np.delete(np.arange(COUNT), 50)
    assert "tag 51 where 50 was due" in matched(traffic.sent(), traffic.returned(kept)).messages
    assert "never answered" in matched(traffic.sent(), traffic.returned(slice(0, -1))).messages


def test_a_drop_and_a_duplicate_do_not_make_up_for_each_other(traffic):
    order = np.insert(np.delete(np.arange(COUNT), 50), 80, 81)
    assert matched(traffic.sent(), traffic.returned(order)).failed > 20


def test_reset_discards_what_is_in_flight(traffic):
    bench = Bench()
    matcher = bench.matcher
    matcher.feed_pairs(traffic.sent(slice(0, 40)))
    matcher.feed_results(traffic.returned(slice(0, 25)))
    # The output side may see the reset first.
    matcher.reset_results()
    matcher.feed_results(traffic.returned(slice(40, 50)))
    matcher.reset_pairs()
    matcher.feed_pairs(traffic.sent(slice(40, 50)))
    matcher.finish()
    assert (bench.failed, matcher.matched, matcher.discarded, matcher.resets) == (0, 35, 15, 1)


def test_a_core_that_stops_answering_is_not_excused_by_a_reset(traffic):
    matcher = Matcher(CONFIGURATION.queue_depth, lambda *_: None)
    matcher.feed_pairs(traffic.sent(slice(0, 80)))
    matcher.feed_results(traffic.returned(slice(0, 40)))
    matcher.reset_pairs()
    matcher.reset_results()
    assert "40 pairs unanswered at a reset" in matcher.failures[0].message


def test_a_result_that_survives_a_reset_fails(traffic):
    bench = Bench()
    matcher = bench.matcher
    matcher.feed_pairs(traffic.sent(slice(0, 20)))
    matcher.reset_pairs()
    matcher.reset_results()
    matcher.feed_results(traffic.returned(slice(0, 1)))
    matcher.feed_pairs(traffic.sent(slice(40, 41)))
    matcher.finish()
    assert "tag 0 where 40 was due" in bench.messages
