"""The outcome of a regression: its runs, and the reasons for a failure."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from triaxis.coverage.report import ModelReport, percent
from triaxis.verif.regress.definition import Regression
from triaxis.verif.regress.failing import Bucket, FailingSeed, bucket_of, buckets
from triaxis.verif.regress.records import PlannedRun, RunRecord, State


@dataclass(frozen=True)
class Outcome:
    """A regression that came to its end.

    ``replayed``: seeds that had failed before and were run first; ``flaky``: those that failed and passed on
    the same sources; ``kept_from_before``: how many results an earlier, killed call had left.
    """

    regression: Regression
    state: State
    folder: Path
    command: str
    launcher: str
    planned: tuple[PlannedRun, ...]
    records: tuple[RunRecord, ...]
    replayed: tuple[FailingSeed, ...]
    flaky: tuple[FailingSeed, ...]
    kept_from_before: int
    coverage: tuple[ModelReport, ...]
    seconds: float

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
    def buckets(self) -> list[Bucket]:
        """Return the failures in buckets, the fullest first."""
        return buckets(self.records)

    @property
    def coverage_percent(self) -> float | None:
        """Return the share of bins that met their goals, None where no coverage was collected."""
        return percent(self.coverage) if self.coverage else None

    @property
    def problems(self) -> list[str]:
        """Return the reasons for a failure, one line each."""
        failures = [
            f"{r.run.test} in {r.run.config}, seed {r.run.seed} failed: {bucket_of(r)}" for r in self.failed
        ]
        return failures + self.shortfalls

    @cached_property
    def shortfalls(self) -> list[str]:
        """Return the problems that are no run's failure: goals missed, flaky seeds, no result."""
        found = [
            f"{s.run.test} in {s.run.config}, seed {s.run.seed} is flaky: it failed and passed on the same "
            "sources"
            for s in self.flaky
        ]
        done = {record.run.key for record in self.records}
        found += [
            f"{r.test} in {r.config}, seed {r.seed}: no result" for r in self.planned if r.key not in done
        ]
        if self.checked < self.regression.least_pairs:
            found.append(f"{self.checked} pairs checked, at least {self.regression.least_pairs} are wanted")
        if self.regression.all_covered:
            found += [problem for model in self.coverage for problem in model.problems]
        # What may never be hit was hit, whatever the goals.
        illegal = [hit for model in self.coverage for item in model.items for hit in item.illegal_hits]
        if illegal and not self.regression.all_covered:
            found += [f"illegal coverage bin {i.bin} hit {i.hits} times: {i.reason}" for i in illegal]
        return found

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
