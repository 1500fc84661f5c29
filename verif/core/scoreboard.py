"""The scoreboard: every accepted pair must be answered once, in order, and exactly."""

import json
import resource
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from pathlib import Path
from typing import Any

from pyuvm import uvm_analysis_export, uvm_analysis_port, uvm_component, uvm_scoreboard

from triaxis.golden.outputs import write_whole
from triaxis.verif.core.checking import Checker
from triaxis.verif.core.failing_pairs import write_failing_pairs
from triaxis.verif.core.matching import Matcher
from triaxis.verif.testbench.batches import PairBatch, ResetSeen, ResultBatch
from triaxis.verif.testbench.handles import settings_of
from triaxis.verif.testbench.settings import failure_file, result_file
from triaxis.verif.testbench.worker import WORKER

# Batches that may wait for the checker; then the simulation waits for it. So memory stays bounded.
_WAITING = 4


def write_counts(path: Path, counts: dict[str, Any]) -> None:
    """Write a run's counts, whole or not at all."""
    write_whole(path, json.dumps(counts, indent=2) + "\n")


class _Export(uvm_analysis_export):
    """An analysis export that hands transactions to a function: a scoreboard needs two of them."""

    def __init__(self, name: str, parent: uvm_component, write: Callable[[Any], None]) -> None:
        super().__init__(name, parent)
        self._write = write

    def write(self, datum: Any) -> None:
        """Hand the transaction on."""
        self._write(datum)


class Scoreboard(uvm_scoreboard):
    """Matches in the simulator's thread and checks in the worker's, beside the simulation.

    Fails the test in check_phase, writing what failed and how to replay it. What was checked is published
    on ``checked_port`` as CoreSample, from the worker's thread and in order.
    """

    def build_phase(self) -> None:
        """Make the exports, the port for what was checked, the matcher and the checker."""
        self.settings = settings_of(self)
        self.pairs_export = _Export("pairs_export", self, self._write_pairs)
        self.results_export = _Export("results_export", self, self._write_results)
        self.checked_port = uvm_analysis_port("checked_port", self)
        self.checker = Checker(
            self.settings.configuration, self.settings.share, self.settings.seed, self.checked_port.write
        )
        self.matcher = Matcher(self.settings.configuration.queue_depth, self._enqueue)
        self._waiting: deque[Future[None]] = deque()
        self.seconds = 0.0
        # Pairs that the driver was given, which the test says at its end.
        self.sent = 0

    def start_of_simulation_phase(self) -> None:
        """Start the clock on the wall."""
        self._start = time.perf_counter()

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
        self.seconds = time.perf_counter() - self._start

    def check_phase(self) -> None:
        """Write the counts, and fail where anything did."""
        matcher, checker, folder = self.matcher, self.checker, Path(self.settings.folder)
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
            # From the reset to the end of the last check; without the start of the simulator.
            "seconds": self.seconds,
            "peak_memory_mib": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024,
        }
        write_counts(result_file(folder), counts)
        failures = matcher.failures + checker.failures
        for failure in failures:
            at = "" if failure.pair is None else f": margin {failure.margin}, {failure.pair.tolist()}"
            self.logger.error(f"{failure.message}{at}")
        about_pairs = [failure for failure in failures if failure.pair is not None]
        if about_pairs:
            write_failing_pairs(failure_file(folder), about_pairs)
        if matcher.accepted != self.sent:
            raise AssertionError(f"{self.sent} pairs sent, {matcher.accepted} seen accepted")
        # One that was dropped and one too many make up for each other in the checks of the matcher.
        if checker.checked != matcher.matched or checker.checked + matcher.discarded > matcher.accepted:
            raise AssertionError(f"{checker.checked} pairs checked, {matcher.matched} matched")
        if failures:
            raise AssertionError(f"{self.failed} failures, first: {failures[0].message}")
