"""The outcome of a regression: its runs, and the reasons for a failure."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from triaxis.coverage.report import ModelReport, percent
from triaxis.verif.regress.definition import Regression
from triaxis.verif.regress.failing import FailingSeed, bucket_of, buckets
from triaxis.verif.regress.records import PlannedRun, RunRecord, State


@dataclass(frozen=True)
class Outcome:
    """A regression that came to its end.

    ``replayed``: seeds that had failed before and were run first; ``flaky``: those that failed and passed on
    the same sources; ``kept_from_before``: how many results an earlier, killed call had left; ``illegal``:
    what was hit and must not be in configurations whose coverage is not asked for.
    """

    regression: Regression
    state: State
    folder: Path
    command: str
    launcher: str
    planned: Sequence[PlannedRun]
    records: Sequence[RunRecord]
    replayed: Sequence[FailingSeed]
    flaky: Sequence[FailingSeed]
    kept_from_before: int
    coverage: Sequence[ModelReport]
    seconds: float
    illegal: Sequence[str] = ()

    @property
    def checked(self) -> int:
        """Return how many pairs were checked."""
        return sum(record.checked for record in self.records)

    @property
    def judged(self) -> int:
        """Return how many of them the golden model judged as well."""
        return sum(record.judged for record in self.records)

    @property
    def failed(self) -> list[RunRecord]:
        """Return the runs that failed."""
        return [record for record in self.records if not record.passed]

    @property
    def fixed(self) -> list[FailingSeed]:
        """Return the failing seeds that passed, on other sources than they had failed on."""
        passed = {record.run.key for record in self.records if record.passed}
        still = {seed.run.key for seed in self.flaky}
        return [seed for seed in self.replayed if seed.run.key in passed - still]

    @cached_property
    def buckets(self) -> dict[str, list[RunRecord]]:
        """Return the failed runs by what they say, the most frequent first."""
        return buckets(self.records)

    @property
    def coverage_percent(self) -> float | None:
        """Return the share of bins that met their goals, None where no coverage was collected."""
        return percent(self.coverage) if self.coverage else None

    @property
    def problems(self) -> list[str]:
        """Return the reasons for a failure, one line each."""
        return [f"{record.run} failed: {bucket_of(record)}" for record in self.failed] + self.shortfalls

    @cached_property
    def shortfalls(self) -> list[str]:
        """Return the problems that are no run's failure: goals missed, flaky seeds, no result."""
        found = [f"{seed.run} is flaky: it failed and passed on the same sources" for seed in self.flaky]
        done = {record.run.key for record in self.records}
        found += [f"{run}: no result" for run in self.planned if run.key not in done]
        if self.checked < self.regression.least_pairs:
            found.append(f"{self.checked} pairs checked, at least {self.regression.least_pairs} are wanted")
        if self.regression.all_covered and not self.coverage:
            found.append("no coverage was collected")
        for model in self.coverage:
            # What may never be hit was hit, whatever the goals.
            found += model.problems if self.regression.all_covered else model.illegal
        return [*found, *self.illegal]

    @property
    def summary(self) -> str:
        """Return the outcome in one line."""
        covered = "" if self.coverage_percent is None else f", coverage {self.coverage_percent:.2f} %"
        passed = len(self.records) - len(self.failed)
        return (
            f"{self.regression.name}, seed {self.state.seed}: {passed} of {len(self.records)} runs passed, "
            f"{self.checked} pairs checked, {self.judged} judged by the golden model{covered}, "
            f"{self.seconds:.0f} s"
        )
