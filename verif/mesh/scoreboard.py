"""The scoreboard of the engine: every run ends once, and its account of every pair is exact."""

import resource
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from pyuvm import uvm_analysis_export, uvm_analysis_port, uvm_component, uvm_scoreboard

from triaxis.verif.core.scoreboard import write_counts
from triaxis.verif.mesh.checking import SceneChecker, SceneFailure
from triaxis.verif.mesh.matching import RunMatcher
from triaxis.verif.testbench.handles import settings_of
from triaxis.verif.testbench.settings import result_file

# How many transactions that belong to no run are named.
_SHOWN = 10


class _Export(uvm_analysis_export):
    """An analysis export that hands transactions to a function: the scoreboard needs five of them."""

    def __init__(self, name: str, parent: uvm_component, write: Callable[[Any], None]) -> None:
        super().__init__(name, parent)
        self._write = write

    def write(self, datum: Any) -> None:
        """Hand the transaction on."""
        self._write(datum)


class MeshScoreboard(uvm_scoreboard):
    """Puts runs together from what all monitors say, and has each checked; fails the test in check_phase.

    What was checked is published on ``checked_port`` as MeshRow.
    """

    def build_phase(self) -> None:
        """Make the exports, the port for what was checked, the matcher and the checker."""
        self.settings = settings_of(self)
        configuration = self.settings.mesh_configuration
        self.checked_port = uvm_analysis_port("checked_port", self)
        self.checker = SceneChecker(
            configuration, self.settings.judged_one_in, self.settings.seed, self.checked_port.write
        )
        self.matcher = RunMatcher(configuration.depth, self.checker.check)
        self.loads_export = _Export("loads_export", self, self.matcher.load)
        self.runs_export = _Export("runs_export", self, self.matcher.run)
        self.near_export = _Export("near_export", self, self.matcher.near)
        self.core_export = _Export("core_export", self, self.matcher.core)
        self.summaries_export = _Export("summaries_export", self, self.matcher.summary)
        # Runs and triangles that the drivers were given, which the test says at its end.
        self.runs_sent = self.triangles_sent = 0

    def start_of_simulation_phase(self) -> None:
        """Start the clock on the wall."""
        self._start = time.perf_counter()

    def check_phase(self) -> None:
        """Write the counts, and fail where anything did."""
        checker, matcher = self.checker, self.matcher
        failed = checker.failed + len(matcher.stray)
        counts = {
            "sent": self.runs_sent,
            "runs": checker.runs,
            "complete_runs": checker.complete_runs,
            "runs_ended_by_reset": matcher.ended_by_reset,
            "resets": matcher.resets,
            "triangles": matcher.triangles,
            # Pairs of complete runs: each is accounted for.
            "accepted": checker.pairs,
            "checked": checker.pairs,
            "skipped_with_proof": checker.skipped,
            "tested": checker.tested,
            "near": checker.near,
            "judged_by_golden_model": checker.judged,
            "failed": failed,
            "seconds": time.perf_counter() - self._start,
            "peak_memory_mib": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024,
        }
        write_counts(result_file(Path(self.settings.folder)), counts)
        messages = [*map(_described, checker.failures), *matcher.stray[:_SHOWN]]
        for message in messages:
            self.logger.error(message)
        if failed:
            raise AssertionError(f"{failed} failures, first: {messages[0]}")
        if matcher.unfinished:
            raise AssertionError("a run without a summary")
        if (matcher.accepted, matcher.triangles) != (self.runs_sent, self.triangles_sent):
            raise AssertionError(
                f"{self.runs_sent} runs and {self.triangles_sent} triangles sent, {matcher.accepted} and "
                f"{matcher.triangles} seen accepted"
            )
        if checker.runs + matcher.ended_by_reset != matcher.accepted or not checker.runs:
            raise AssertionError(f"{checker.runs} runs checked of {matcher.accepted}")
        if not checker.pairs:
            raise AssertionError("no pair was checked: no complete run of two meshes")


def _described(failure: SceneFailure) -> str:
    run = failure.run
    asked = run.request
    return (
        f"{failure.message}: meshes of {len(run.a)} and {len(run.b)}, translation {asked.translation}, "
        f"margin {asked.margin}, mode {asked.mode}"
    )
