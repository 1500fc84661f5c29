"""The scoreboard can fail: everything that may go wrong with results turns it red."""

import numpy as np
import pytest

from triaxis.verif.batches import PairBatch, ResultBatch
from triaxis.verif.configuration import Configuration
from triaxis.verif.matching import Matcher, expected_verdicts
from triaxis.verif.result import AXIS_SHIFT, NEAR, encode
from triaxis.verif.sequences.families import mixed_pairs, random_margins

CONFIGURATION = Configuration(16, 16)
COUNT = 120


class Traffic:
    """Pairs and the results of a faultless core."""

    def __init__(self, rng):
        self.pairs = mixed_pairs(rng, COUNT, CONFIGURATION.width)
        self.margins = random_margins(rng, self.pairs, CONFIGURATION.max_margin)
        self.tags = np.arange(COUNT)
        self.words = encode(expected_verdicts(self.pairs, self.margins, CONFIGURATION))

    def sent(self, part=slice(None)):
        zeros = np.zeros(len(self.tags[part]), np.int64)
        return PairBatch(self.pairs[part], self.margins[part], self.tags[part], zeros)

    def returned(self, part=slice(None), words=None):
        words = self.words if words is None else words
        return ResultBatch(words[part], self.tags[part], np.zeros(len(self.tags[part]), np.int64))


@pytest.fixture
def traffic(rng):
    return Traffic(rng)


def matched(sent, *returned):
    matcher = Matcher(CONFIGURATION)
    matcher.feed_pairs(sent)
    for batch in returned:
        matcher.feed_results(batch)
    matcher.finish()
    return matcher


def test_a_faultless_core_passes_however_it_is_cut(traffic):
    seen = []
    matcher = Matcher(CONFIGURATION, seen.append)
    for start in range(0, COUNT, 7):
        matcher.feed_pairs(traffic.sent(slice(start, start + 7)))
    for start in range(0, COUNT, 11):
        matcher.feed_results(traffic.returned(slice(start, start + 11)))
    assert matcher.outstanding == 0
    matcher.finish()
    assert (matcher.failed, matcher.checked) == (0, COUNT)
    assert sum(len(batch.pairs) for batch in seen) == COUNT
    assert matcher.clear_claims == int((traffic.words & NEAR == 0).sum()) > 0


def test_nothing_checked_fails():
    matcher = Matcher(CONFIGURATION)
    matcher.finish()
    assert matcher.failed
    assert "nothing was checked" in matcher.failures[0].message


def test_dropped_result(traffic):
    kept = np.delete(np.arange(COUNT), 50)
    matcher = matched(traffic.sent(), traffic.returned(kept))
    assert "tag 51 where 50 was due" in matcher.failures[0].message
    matcher = matched(traffic.sent(), traffic.returned(slice(0, -1)))
    assert "never answered" in matcher.failures[0].message


def test_duplicated_result(traffic):
    twice = np.insert(np.arange(COUNT), 50, 49)
    assert "tag 49 where 50 was due" in matched(traffic.sent(), traffic.returned(twice)).failures[0].message
    last = np.append(np.arange(COUNT), COUNT - 1)
    assert "answer no pair" in matched(traffic.sent(), traffic.returned(last)).failures[0].message


def test_reordered_results(traffic):
    order = np.arange(COUNT)
    order[[20, 21]] = order[[21, 20]]
    assert matched(traffic.sent(), traffic.returned(order)).failed >= 2


@pytest.mark.parametrize("bit", range(16))
def test_any_flipped_bit_of_a_result(traffic, bit):
    words = traffic.words.copy()
    words[33] ^= np.uint16(1 << bit)
    matcher = matched(traffic.sent(), traffic.returned(words=words))
    assert matcher.failed
    assert (matcher.failures[0].pair == traffic.pairs[33]).all()


def test_a_wrong_claim_is_disproved_by_the_checker_alone(traffic, monkeypatch):
    """Even a golden model that agreed with the core would not save a false "clear"."""
    near = int(np.flatnonzero(traffic.words & NEAR)[0])
    words = traffic.words.copy()
    words[near] = 4 << AXIS_SHIFT
    monkeypatch.setattr("triaxis.verif.matching.encode", lambda _: words)
    matcher = matched(traffic.sent(), traffic.returned(words=words))
    assert matcher.failed == 1
    assert "claimed axis 4 (normal B) does not separate" in matcher.failures[0].message


def test_reset_discards_what_is_in_flight(traffic):
    matcher = Matcher(CONFIGURATION)
    matcher.feed_pairs(traffic.sent(slice(0, 40)))
    matcher.feed_results(traffic.returned(slice(0, 25)))
    # The output side may see the reset first.
    matcher.reset_results()
    matcher.feed_results(traffic.returned(slice(40, 50)))
    matcher.reset_pairs()
    matcher.feed_pairs(traffic.sent(slice(40, 50)))
    matcher.finish()
    assert (matcher.failed, matcher.checked, matcher.discarded, matcher.resets) == (0, 35, 15, 1)


def test_a_core_that_stops_answering_is_not_excused_by_a_reset(traffic):
    matcher = Matcher(CONFIGURATION)
    matcher.feed_pairs(traffic.sent(slice(0, 80)))
    matcher.feed_results(traffic.returned(slice(0, 40)))
    matcher.reset_pairs()
    matcher.reset_results()
    assert "40 pairs unanswered at a reset" in matcher.failures[0].message


def test_a_result_that_survives_a_reset_fails(traffic):
    matcher = Matcher(CONFIGURATION)
    matcher.feed_pairs(traffic.sent(slice(0, 20)))
    matcher.reset_pairs()
    matcher.reset_results()
    matcher.feed_results(traffic.returned(slice(0, 1)))
    matcher.feed_pairs(traffic.sent(slice(40, 41)))
    matcher.finish()
    assert "tag 0 where 40 was due" in matcher.failures[0].message


def test_contract_of_the_smaller_builds(rng):
    pairs = mixed_pairs(rng, 600, 16)
    margins = np.zeros(600, np.int64)
    full = expected_verdicts(pairs, margins, Configuration(16, 0, gating=False))
    gated = expected_verdicts(pairs, margins, Configuration(16, 0))
    boxed = (full["axis"] >= 0) & (full["axis"] < 3)
    assert (gated[~boxed] == full[~boxed]).all()
    assert not gated[boxed]["coplanar"].any()
    assert full[boxed]["coplanar"].any()
    blind = expected_verdicts(pairs, margins, Configuration(16, 0, edge_box=False, gating=False))
    differs = blind["near"] != full["near"]
    assert differs.any()
    # Conservative, and said so.
    assert blind[differs]["near"].all()
    assert blind[differs]["coplanar"].all()
