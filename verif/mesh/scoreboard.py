"""The scoreboard of the engine: every run ends once, and its account of every pair is exact."""

from collections.abc import Callable

import numpy as np
from pyuvm import uvm_analysis_port

from triaxis.verif.core.items import ResetSeen
from triaxis.verif.mesh.checking import SceneChecker, SceneFailure
from triaxis.verif.mesh.items import (
    AbortAsked,
    CorePairs,
    Loaded,
    MeshState,
    NearTaken,
    ObservedRun,
    RunAccepted,
    Summary,
)
from triaxis.verif.testbench.environment import CountingScoreboard, Export, settings_of
from triaxis.verif.testbench.failures import DESCRIBED, Blame, report_failure
from triaxis.verif.testbench.reports import ERROR, report

_EMPTY = np.empty((0, 3, 3), np.int64)


class RunMatcher:
    """Follows the meshes and the run that is going on; hands each run on once its summary was taken.

    What belongs to no run is kept in ``stray``, a line each.
    """

    def __init__(self, depth: int, on_run: Callable[[ObservedRun, Summary], None]) -> None:
        """Start with empty meshes and no run. ``depth``: triangles that a mesh holds."""
        self._on_run = on_run
        self._meshes = (MeshState(depth), MeshState(depth))
        self._run: ObservedRun | None = None
        # Whether the last triangle came at the same edge as the run that is about to be seen.
        self._loaded_now = False
        self._was_reset = True
        self.accepted = self.triangles = self.resets = self.ended_by_reset = 0
        self.stray: list[str] = []

    @property
    def unfinished(self) -> bool:
        """Return whether a run has no summary yet."""
        return self._run is not None

    def _told_of(self, stray: str) -> None:
        self.stray.append(stray)
        report_failure(stray)

    def load(self, datum: Loaded) -> None:
        """Follow a load."""
        self.triangles += len(datum.triangles)
        self._meshes[datum.mesh].take(datum)
        if self._run is None:
            self._loaded_now = datum.with_run
            return
        # Accepted at the very edge at which the run was: it belongs to it.
        if not datum.with_run:
            self._told_of(f"mesh {datum.mesh} was loaded during a run")
        self._show_meshes(self._run)
        self._run.loaded_with_run = True

    def run(self, datum: RunAccepted | AbortAsked) -> None:
        """Begin a run, or note that it is aborted."""
        if isinstance(datum, AbortAsked):
            if self._run is not None:
                self._run.aborts.append(datum.at)
            return
        if self._run is not None:
            self._told_of("a run was accepted during a run")
        self.accepted += 1
        reset, self._was_reset = self._was_reset, False
        self._run = ObservedRun(datum, _EMPTY, _EMPTY, (False, False), (False, False), reset)
        self._show_meshes(self._run)
        self._run.loaded_with_run, self._loaded_now = self._loaded_now, False

    def _show_meshes(self, run: ObservedRun) -> None:
        """Let a run have the meshes as they are."""
        a, b = self._meshes
        run.a, run.b = a.triangles, b.triangles
        run.overfull = a.overfull, b.overfull
        run.reloaded = a.reloaded, b.reloaded

    def near(self, datum: NearTaken) -> None:
        """Note near pairs."""
        if self._run is not None:
            self._run.near.append(datum)
        elif len(datum.pairs):
            self._told_of(f"{len(datum.pairs)} near pairs without a run")

    def core(self, datum: CorePairs) -> None:
        """Note pairs that reached the core."""
        if self._run is not None:
            self._run.reached.append(datum)
        elif len(datum.pairs):
            self._told_of(f"{len(datum.pairs)} pairs in the core without a run")

    def summary(self, datum: Summary | ResetSeen) -> None:
        """End a run; or forget it and the meshes: a reset empties them."""
        if isinstance(datum, ResetSeen):
            self._reset()
            return
        if self._run is None:
            self._told_of(f"a summary without a run at clock {datum.clock}: status {datum.status}")
            return
        run, self._run = self._run, None
        for mesh in self._meshes:
            mesh.reloaded = False
        self._on_run(run, datum)

    def _reset(self) -> None:
        self.resets += 1
        self._was_reset = True
        self.ended_by_reset += self._run is not None
        self._run = None
        for mesh in self._meshes:
            mesh.empty()


class MeshScoreboard(CountingScoreboard):
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
        self.loads_export = Export("loads_export", self, self.matcher.load)
        self.runs_export = Export("runs_export", self, self.matcher.run)
        self.near_export = Export("near_export", self, self.matcher.near)
        self.core_export = Export("core_export", self, self.matcher.core)
        self.summaries_export = Export("summaries_export", self, self.matcher.summary)
        # Runs and triangles that the drivers were given, which the test says at its end.
        self.runs_sent = self.triangles_sent = 0

    @property
    def failed(self) -> int:
        """Return how many failures there are so far."""
        return self.checker.failed + len(self.matcher.stray)

    def check_phase(self) -> None:
        """Write the counts, and fail where anything did."""
        checker, matcher = self.checker, self.matcher
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
            "failed": self.failed,
            "failures": [
                *(one.record() for one in checker.failures),
                *({"blame": Blame.TEST, "message": stray} for stray in matcher.stray[:DESCRIBED]),
            ],
        }
        self.write_counts(counts)
        messages = [*map(_described, checker.failures), *matcher.stray[:DESCRIBED]]
        for message in messages:
            report(ERROR, message, "SCOREBOARD")
        if self.failed:
            raise AssertionError(f"{self.failed} failures, first: {messages[0]}")
        if matcher.resets != self.resets_sent:
            raise AssertionError(f"{self.resets_sent} resets sent, {matcher.resets} seen")
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
        f"run {failure.number} at clock {failure.clock}: {failure.message}: meshes of "
        f"{len(run.a)} and {len(run.b)}, translation {asked.translation}, "
        f"margin {asked.margin}, mode {asked.mode}"
    )
