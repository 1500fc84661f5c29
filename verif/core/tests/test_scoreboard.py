"""The scoreboard's parts can fail: wrong, lost and added answers turn them red, so does a wrong checker."""

from dataclasses import replace

import numpy as np
import pytest

from triaxis.golden.bulk import bulk_facts
from triaxis.sim.configuration import Configuration
from triaxis.sim.result import COPLANAR, NEAR
from triaxis.verif.core import checking
from triaxis.verif.core.checking import Checker
from triaxis.verif.core.expectation import expected_words
from triaxis.verif.core.items import PairBatch, ResultBatch
from triaxis.verif.core.scoreboard import Matcher
from triaxis.verif.core.stimulus.families import mixed, mixed_pairs
from triaxis.verif.testbench.golden_sample import EVERYTHING, GoldenSample, Share


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
        clocks = np.arange(len(tags))[part] + FIRST_CLOCK
        return ResultBatch(words[part], tags[part], np.zeros(len(tags[part]), np.int64), clocks)


CONFIGURATION = Configuration(16, 16)
FIRST_CLOCK = 1000
COUNT = 150


@pytest.fixture
def traffic(rng):
    return Traffic(rng, CONFIGURATION, COUNT)


@pytest.mark.parametrize("bit", range(16))
def test_any_flipped_bit_of_a_result_is_told_with_the_pairs_before(traffic, bit):
    words = traffic.words.copy()
    words[103] ^= np.uint16(1 << bit)
    checker = Checker(CONFIGURATION)
    for part in (slice(0, 100), slice(100, None)):
        checker.check(traffic.sent(part), traffic.returned(part, words))
    failure = checker.failures[0]
    assert failure.message.startswith("result 104 at clock 1103: ") and failure.record()["clock"] == 1103
    assert (failure.pair == traffic.pairs[103]).all()
    assert (failure.context == traffic.pairs[39:103]).all()
    assert (failure.context_margins == traffic.margins[39:103]).all()


@pytest.mark.parametrize(
    ("near", "above", "share", "said"),
    [
        (True, 1 << 4, Share(1 << 15, 0), "claimed axis 4 (normal B) does not separate"),
        (False, 0, EVERYTHING, "bulk checker and golden model disagree"),
    ],
)
def test_a_bulk_checker_that_errs_with_the_core_is_caught(traffic, monkeypatch, near, above, share, said):
    facts = bulk_facts(traffic.pairs, traffic.margins)
    at = np.flatnonzero(facts.near == near)[0]
    wrong = replace(facts, above=facts.above.copy(), below=facts.below.copy())
    wrong.above[at] = above
    wrong.below[at] = 0
    monkeypatch.setattr(checking, "bulk_facts", lambda *_: wrong)
    checker = Checker(CONFIGURATION, share=share)
    checker.check(traffic.sent(), traffic.returned(words=expected_words(wrong, CONFIGURATION)))
    assert checker.failed == 1
    assert said in checker.failures[0].message


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
    assert set(facts.kind[first]) == set(facts.kind)
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


def test_a_faultless_core_passes_however_it_is_cut_and_nothing_at_all_does_not(traffic):
    bench = Bench()
    bench.matcher.finish()
    assert "nothing was checked" in bench.messages
    bench = Bench()
    for start in range(0, COUNT, 7):
        bench.matcher.feed_pairs(traffic.sent(slice(start, start + 7)))
    for start in range(0, COUNT, 11):
        bench.matcher.feed_results(traffic.returned(slice(start, start + 11)))
    assert bench.matcher.outstanding == 0
    bench.matcher.finish()
    assert (bench.failed, bench.matcher.matched, bench.checker.checked) == (0, COUNT, COUNT)
    assert bench.checker.judged == COUNT
    assert bench.checker.clear_claims == int((traffic.words & NEAR == 0).sum()) > 0


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
    # More than can be in flight: a core that stops answering is not excused by a reset.
    matcher.feed_pairs(traffic.sent(slice(50, 90)))
    matcher.reset_pairs()
    matcher.reset_results()
    assert "40 pairs unanswered at a reset" in bench.messages


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
