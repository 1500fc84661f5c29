"""Results are matched with pairs one to one: what is lost, added or out of place shows."""

import numpy as np
import pytest

from triaxis.sim.configuration import Configuration
from triaxis.verif.core.checking import Checker
from triaxis.verif.core.matching import Matcher
from triaxis.verif.core.tests.traffic import Traffic

CONFIGURATION = Configuration(16, 16)
COUNT = 120


@pytest.fixture
def traffic(rng):
    return Traffic(rng, CONFIGURATION, COUNT)


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


def test_duplicated_result(traffic):
    twice = np.insert(np.arange(COUNT), 50, 49)
    assert "tag 49 where 50 was due" in matched(traffic.sent(), traffic.returned(twice)).messages
    last = np.append(np.arange(COUNT), COUNT - 1)
    assert "answer no pair" in matched(traffic.sent(), traffic.returned(last)).messages


def test_a_drop_and_a_duplicate_do_not_make_up_for_each_other(traffic):
    order = np.insert(np.delete(np.arange(COUNT), 50), 80, 81)
    assert matched(traffic.sent(), traffic.returned(order)).failed > 20


def test_reordered_results(traffic):
    order = np.arange(COUNT)
    order[[20, 21]] = order[[21, 20]]
    assert matched(traffic.sent(), traffic.returned(order)).failed >= 2


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
