"""The scoreboard: every accepted pair must be answered once, in order, and exactly.

A reset discards what the core holds: results before it must answer a prefix of the pairs before it.
"""

from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass, field
from pathlib import Path

from pyuvm import uvm_analysis_port

from triaxis.verif.core.checking import Checker, Failure
from triaxis.verif.core.failing_pairs import write_failing_pairs
from triaxis.verif.core.items import PairBatch, ResetSeen, ResultBatch
from triaxis.verif.testbench.environment import WORKER, CountingScoreboard, Export, settings_of
from triaxis.verif.testbench.failures import DESCRIBED, Blame, report_failure
from triaxis.verif.testbench.reports import ERROR, report
from triaxis.verif.testbench.settings import failure_file


@dataclass
class _Epoch:
    """The time between two resets."""

    pairs: deque[PairBatch] = field(default_factory=deque)
    results: deque[ResultBatch] = field(default_factory=deque)
    pairs_closed: bool = False
    results_closed: bool = False


class Matcher:
    """Takes batches from both sides in any interleaving; hands on what belongs together."""

    def __init__(self, most_in_flight: int, on_matched: Callable[[PairBatch, ResultBatch], None]) -> None:
        """Start with nothing accepted and nothing returned.

        ``most_in_flight``: pairs that the core can hold. ``on_matched`` takes pairs and results, one to one.
        """
        self.accepted = 0
        self.returned = 0
        self.matched = 0
        self.discarded = 0
        self.resets = 0
        self.failed = 0
        self.failures: list[Failure] = []
        self._most_in_flight = most_in_flight
        self._on_matched = on_matched
        self._epochs: deque[_Epoch] = deque([_Epoch()])

    @property
    def outstanding(self) -> int:
        """Return how many pairs of the present epoch have not come back yet."""
        last = self._epochs[-1]
        return sum(map(len, last.pairs)) - sum(map(len, last.results))

    def feed_pairs(self, batch: PairBatch) -> None:
        """Take pairs that the core accepted."""
        self.accepted += len(batch)
        next(e for e in self._epochs if not e.pairs_closed).pairs.append(batch)
        self._advance()

    def feed_results(self, batch: ResultBatch) -> None:
        """Take results that the core returned."""
        self.returned += len(batch)
        next(e for e in self._epochs if not e.results_closed).results.append(batch)
        self._advance()

    def reset_pairs(self) -> None:
        """Take note that the input side saw a reset."""
        next(e for e in self._epochs if not e.pairs_closed).pairs_closed = True
        self._open_epoch()

    def reset_results(self) -> None:
        """Take note that the output side saw a reset."""
        next(e for e in self._epochs if not e.results_closed).results_closed = True
        self._open_epoch()

    def finish(self) -> None:
        """Close the run: what is missing or superfluous now stays so."""
        self._advance()
        for epoch in self._epochs:
            missing, extra = sum(map(len, epoch.pairs)), sum(map(len, epoch.results))
            if extra:
                self._fail(self._superfluous(epoch, f"{extra} results that answer no pair"), extra)
            if missing:
                first = f"from pair {self.matched + self.discarded + 1} on"
                self._fail(Failure(f"{missing} pairs accepted and never answered, {first}"), missing)
        if not self.matched:
            self._fail(Failure("nothing was checked", blame=Blame.TEST))

    def _open_epoch(self) -> None:
        if self._epochs[-1].pairs_closed or self._epochs[-1].results_closed:
            self._epochs.append(_Epoch())
        self._advance()

    def _advance(self) -> None:
        while True:
            epoch = self._epochs[0]
            while epoch.pairs and epoch.results:
                self._match_front(epoch)
            if not (epoch.pairs_closed and epoch.results_closed):
                return
            extra = sum(map(len, epoch.results))
            if extra:
                what = f"{extra} results before a reset that answer no pair"
                self._fail(self._superfluous(epoch, what), extra)
            lost = sum(map(len, epoch.pairs))
            if lost > self._most_in_flight:
                most = f"{self._most_in_flight} can be in flight"
                self._fail(Failure(f"{lost} pairs unanswered at a reset; {most}"))
            self.discarded += lost
            self.resets += 1
            self._epochs.popleft()

    def _superfluous(self, epoch: _Epoch, what: str) -> Failure:
        clock = int(epoch.results[0].clocks[0])
        return Failure(f"{what}: from result {self.matched + 1} on, at clock {clock}", clock=clock)

    def _match_front(self, epoch: _Epoch) -> None:
        pairs, results = epoch.pairs.popleft(), epoch.results.popleft()
        count = min(len(pairs), len(results))
        if len(pairs) > count:
            epoch.pairs.appendleft(pairs[count:])
        if len(results) > count:
            epoch.results.appendleft(results[count:])
        self.matched += count
        self._on_matched(pairs[:count], results[:count])

    def _fail(self, failure: Failure, count: int = 1) -> None:
        self.failed += count
        report_failure(failure.message, self.matched)
        if len(self.failures) < DESCRIBED:
            self.failures.append(failure)


# Batches that may wait for the checker; then the simulation waits for it. So memory stays bounded.
_WAITING = 4


class Scoreboard(CountingScoreboard):
    """Matches in the simulator's thread and checks in the worker's, beside the simulation.

    Fails the test in check_phase, writing what failed and how to replay it. What was checked is published
    on ``checked_port`` as CoreSample, from the worker's thread and in order.
    """

    def build_phase(self) -> None:
        """Make the exports, the port for what was checked, the matcher and the checker."""
        self.settings = settings_of(self)
        self.pairs_export = Export("pairs_export", self, self._write_pairs)
        self.results_export = Export("results_export", self, self._write_results)
        self.checked_port = uvm_analysis_port("checked_port", self)
        self.checker = Checker(
            self.settings.configuration, self.settings.share, self.settings.seed, self.checked_port.write
        )
        self.matcher = Matcher(self.settings.configuration.queue_depth, self._enqueue)
        self._waiting: deque[Future[None]] = deque()
        # Pairs that the driver was given, which the test says at its end.
        self.sent = 0

    @property
    def failed(self) -> int:
        """Return how many failures there are so far."""
        return self.matcher.failed + self.checker.failed

    def _write_pairs(self, datum: PairBatch | ResetSeen) -> None:
        if isinstance(datum, ResetSeen):
            self.matcher.reset_pairs()
        else:
            self.matcher.feed_pairs(datum)

    def _write_results(self, datum: ResultBatch | ResetSeen) -> None:
        if isinstance(datum, ResetSeen):
            self.matcher.reset_results()
        else:
            self.matcher.feed_results(datum)

    def _enqueue(self, pairs: PairBatch, results: ResultBatch) -> None:
        while len(self._waiting) >= _WAITING:
            # An error in the checker comes out here.
            self._waiting.popleft().result()
        self._waiting.append(WORKER.submit(self.checker.check, pairs, results))

    def extract_phase(self) -> None:
        """Close the run: wait for the checker."""
        self.matcher.finish()
        while self._waiting:
            self._waiting.popleft().result()

    def check_phase(self) -> None:
        """Write the counts, and fail where anything did."""
        matcher, checker, folder = self.matcher, self.checker, Path(self.settings.folder)
        failures = matcher.failures + checker.failures
        counts = {
            "sent": self.sent,
            "accepted": matcher.accepted,
            "returned": matcher.returned,
            "checked": checker.checked,
            "checked_until_failure": checker.until_failure,
            "clear_claims_rechecked": checker.clear_claims,
            "judged_by_golden_model": checker.judged,
            "judged_axes": sorted(checker.judged_axes),
            "kinds_met": checker.sample.kinds_met,
            "kinds_judged": checker.sample.kinds_chosen,
            "discarded_by_reset": matcher.discarded,
            "resets": matcher.resets,
            "failed": self.failed,
            "failures": [failure.record() for failure in failures],
        }
        self.write_counts(counts)
        for failure in failures:
            at = "" if failure.pair is None else f": margin {failure.margin}, {failure.pair.tolist()}"
            report(ERROR, f"{failure.message}{at}", "SCOREBOARD")
        about_pairs = [failure for failure in failures if failure.pair is not None]
        if about_pairs:
            write_failing_pairs(failure_file(folder), about_pairs)
        if matcher.resets != self.resets_sent:
            raise AssertionError(f"{self.resets_sent} resets sent, {matcher.resets} seen")
        if matcher.accepted != self.sent:
            raise AssertionError(f"{self.sent} pairs sent, {matcher.accepted} seen accepted")
        # One that was dropped and one too many make up for each other in the checks of the matcher.
        if checker.checked != matcher.matched or checker.checked + matcher.discarded > matcher.accepted:
            raise AssertionError(f"{checker.checked} pairs checked, {matcher.matched} matched")
        if failures:
            raise AssertionError(f"{self.failed} failures, first: {failures[0].message}")
