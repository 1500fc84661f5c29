"""How far the testplan is met: computed from results, testpoint by testpoint, never ticked by hand."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from triaxis.coverage.report import ModelReport
from triaxis.coverage.stages import STAGES
from triaxis.coverage.testplan import KINDS, Testplan, Testpoint
from triaxis.coverage.testplan_lint import Inventory

_SHOWN = 3


@dataclass(frozen=True)
class PlanResults:
    """What ran and how it went, by name: true passed. None: that kind was not measured at all.

    ``mutants``: true killed. ``equivalent``: mutants that behave as the original does, which nobody kills:
    they count neither way. ``coverage``: a report for each configuration that was measured.
    """

    tests: Mapping[str, bool] | None = None
    proofs: Mapping[str, bool] | None = None
    faults: Mapping[str, bool] | None = None
    checks: Mapping[str, bool] | None = None
    mutants: Mapping[str, bool] | None = None
    equivalent: frozenset[str] = frozenset()
    coverage: Sequence[ModelReport] | None = None


@dataclass(frozen=True)
class Tally:
    """How many passed, failed and were not run. For bins: hit, missing or illegally hit, not measured."""

    passed: int
    failed: int
    not_run: int

    @property
    def total(self) -> int:
        """Return how many there are."""
        return self.passed + self.failed + self.not_run


@dataclass(frozen=True)
class TestpointStatus:
    """How far one testpoint is met.

    ``tallies``: by kind, None where nothing of it was measured; assertions are those that exist: one that
    fails ends its simulation, and so shows as a failed test. ``failing``: the first of what failed, by name.
    """

    name: str
    stage: str
    goal: str
    tallies: Mapping[str, Tally | None]
    passed: bool | None
    failing: tuple[str, ...]

    def content(self) -> dict[str, Any]:
        """Return it for a file: for each kind how many passed, of how many; null: none, or not measured.

        ``others`` are proofs, faults and checks together.
        """
        pairs = {kind: self._pair(kind) for kind in ("tests", "bins", "mutants", "assertions")}
        others = self._pair("proofs", "faults", "checks")
        keys = {"name": self.name, "stage": self.stage, "goal": self.goal, "passed": self.passed}
        return {**keys, **pairs, "others": others, "failing": list(self.failing)}

    def _pair(self, *kinds: str) -> list[int] | None:
        every = [self.tallies[kind] for kind in kinds]
        measured = [tally for tally in every if tally is not None]
        total = sum(tally.total for tally in measured)
        # What was measured in part must not look whole.
        whole = total and len(measured) == len(every)
        return [sum(tally.passed for tally in measured), total] if whole else None


def every_run_passed(runs: Iterable[tuple[str, bool]]) -> dict[str, bool]:
    """Return results by name: of several runs under one name, in several configurations, all must pass."""
    results: dict[str, bool] = {}
    for name, passed in runs:
        results[name] = results.get(name, True) and passed
    return results


def progress(plan: Testplan, inventory: Inventory, results: PlanResults) -> list[TestpointStatus]:
    """Return how far each testpoint is met, those of V1 first.

    A testpoint has passed (true) when all that it names ran and passed, all its bins met their goals in every
    configuration, and all its mutants are killed; it has failed (false) when something failed; otherwise
    something has not run (None).
    """
    fates = {kind: _fates(kind, inventory, results) for kind in KINDS}
    found = [_status(testpoint, inventory, fates) for testpoint in plan.testpoints]
    # Of a stage that there is not the linter tells.
    return sorted(found, key=lambda status: (*STAGES, status.stage).index(status.stage))


# Results of each name, by configuration where there are several; None: not run.
Fates = Mapping[str, Mapping[str, bool | None]]


def _fates(kind: str, inventory: Inventory, results: PlanResults) -> Fates | None:
    """Return the results of a kind; None where it was not measured at all."""
    if kind == "bins":
        return None if results.coverage is None else _bin_fates(inventory, results.coverage)
    if kind == "assertions":
        return {name: {"": True} for name in inventory.assertions}
    found: Mapping[str, bool] | None = getattr(results, kind)
    if found is None:
        return None
    counted = inventory.names(kind) - (results.equivalent if kind == "mutants" else frozenset())
    return {name: {"": found.get(name)} for name in counted}


def _bin_fates(inventory: Inventory, reports: Sequence[ModelReport]) -> Fates:
    """Return the results of bins by model; an illegal bin has one only where it was hit."""
    fates: dict[str, dict[str, bool | None]] = {name: {} for name in inventory.names("bins")}
    by_model = {report.model: report for report in reports}
    for model, bins in inventory.bins.items():
        items = by_model[model].items if model in by_model else ()
        measured = {item.name for item in items}
        missing = {f"{item.name}.{name}" for item in items for name in item.missing}
        for name in bins:
            fates[name][model] = name not in missing if name.partition(".")[0] in measured else None
        for hit in (f"{item.name}.{illegal.bin}" for item in items for illegal in item.illegal_hits):
            fates.setdefault(hit, {})[model] = False
    return fates


def _status(testpoint: Testpoint, inventory: Inventory, fates: Mapping[str, Fates | None]) -> TestpointStatus:
    tallies: dict[str, Tally | None] = {}
    failing: list[str] = []
    for kind in KINDS:
        known = fates[kind]
        if known is None:
            tallies[kind] = None if testpoint.entries(kind) else Tally(0, 0, 0)
            continue
        tallies[kind] = _tally(testpoint, inventory, kind, known)
        owned = sorted(inventory.owned(testpoint, kind))
        failing += [name for name in owned if False in known.get(name, {}).values()]
    named = [tallies[kind] for kind in KINDS if testpoint.entries(kind)]
    passed = _passed(named)
    return TestpointStatus(
        testpoint.name, testpoint.stage, testpoint.goal, tallies, passed, tuple(failing[:_SHOWN])
    )


def _tally(testpoint: Testpoint, inventory: Inventory, kind: str, fates: Fates) -> Tally:
    """Return the results of what a testpoint names; what it names and does not exist has not run."""
    names = inventory.owned(testpoint, kind)
    found = [fate for name in names for fate in fates.get(name, {}).values()]
    unknown = sum(not inventory.matching(kind, entry) for entry in testpoint.entries(kind))
    return Tally(found.count(True), found.count(False), found.count(None) + unknown)


def _passed(tallies: Sequence[Tally | None]) -> bool | None:
    """Return the verdict over the kinds that a testpoint names."""
    if any(tally is not None and tally.failed for tally in tallies):
        return False
    # Nothing that passed is no proof either: mutants may all be equivalent.
    complete = all(tally is not None and tally.passed and not tally.not_run for tally in tallies)
    return True if tallies and complete else None
