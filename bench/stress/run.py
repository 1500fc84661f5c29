"""All settings of all families, measured by a process for each processor; the same seed gives the same."""

import os
import signal
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from multiprocessing import get_context

import numpy as np

from triaxis.bench.stress.families import FAMILIES, Family
from triaxis.bench.stress.measuring import WIDTHS, Measured, build_cores, measure
from triaxis.bench.stress.orders import Errors, total
from triaxis.golden.errors import InputError
from triaxis.golden.judge import default_solver
from triaxis.sim.provenance import Provenance, provenance

SETTINGS = sum(len(family.settings) for family in FAMILIES)
# Steps of progress: a core to build, a setting to measure.
STEPS = len(WIDTHS) + SETTINGS
# A rate of 0.1 % is 4 of these; with fewer than the least it would hardly ever be seen.
PAIRS, LEAST_PAIRS, MOST_PAIRS = 4000, 100, 100_000


@dataclass(frozen=True)
class FamilyResult:
    """A family, and what was measured at each of its settings."""

    family: Family
    measured: tuple[Measured, ...]

    @property
    def core(self) -> Errors:
        """Return the core's errors at its own resolution, of all settings together."""
        return total(one.core for one in self.measured)

    @property
    def no_miss(self) -> Errors:
        """Return the errors of the no-miss mode, of all settings together."""
        return total(one.no_miss for one in self.measured)

    @property
    def problems(self) -> list[str]:
        """Return what must not be, with the setting."""
        return [
            f"{self.family.name} {setting.label}: {problem}"
            for setting, measured in zip(self.family.settings, self.measured, strict=True)
            for problem in measured.problems
        ]


@dataclass(frozen=True)
class StressResult:
    """What was measured, with which seed and how many pairs at each setting; provenance: at the start."""

    seed: int
    pairs: int
    families: tuple[FamilyResult, ...]
    provenance: Provenance
    seconds: float

    @property
    def core(self) -> Errors:
        """Return the core's errors at its own resolution, of all families together."""
        return total(family.core for family in self.families)

    @property
    def no_miss(self) -> Errors:
        """Return the errors of the no-miss mode, of all families together."""
        return total(family.no_miss for family in self.families)

    @property
    def beyond_band(self) -> int:
        """Return the number of false alarms of the no-miss mode beyond its band."""
        return sum(one.beyond_band for family in self.families for one in family.measured)

    @property
    def problems(self) -> list[str]:
        """Return what must not be, anywhere."""
        return [problem for family in self.families for problem in family.problems]


def check_options(seed: int, pairs: int) -> None:
    """Raise InputError where one is out of range."""
    if seed < 0:
        raise InputError(f"seed {seed}: must not be negative")
    if not LEAST_PAIRS <= pairs <= MOST_PAIRS:
        raise InputError(f"pairs {pairs}: must be {LEAST_PAIRS}..{MOST_PAIRS} at each setting")


def measure_setting(place: tuple[int, int], seed: int, pairs: int) -> Measured:
    """Measure a setting of a family, by their numbers."""
    family = FAMILIES[place[0]]
    rng = np.random.default_rng([seed, place[1], *family.name.encode()])
    return measure(family.settings[place[1]].make(rng, pairs))


def _start() -> None:
    """Leave interrupts to the first process: PPL's loader would handle them itself."""
    default_solver()
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def run_stress(seed: int, pairs: int, progress: Callable[[int], None]) -> StressResult:
    """Measure everything; ``progress`` is told of each of STEPS."""
    check_options(seed, pairs)
    start, stamp = time.monotonic(), provenance()
    build_cores(progress)
    places = [(f, s) for f, family in enumerate(FAMILIES) for s in range(len(family.settings))]
    measured: dict[tuple[int, int], Measured] = {}
    pool = ProcessPoolExecutor(os.cpu_count() or 1, get_context("spawn"), initializer=_start)
    try:
        # Workers inherit the blocked signal, as in triaxis.golden.judge.
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            futures = {pool.submit(measure_setting, place, seed, pairs): place for place in places}
        finally:
            signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
        for future in as_completed(futures):
            measured[futures[future]] = future.result()
            progress(1)
    finally:
        pool.shutdown(cancel_futures=True)
    results = tuple(
        FamilyResult(family, tuple(measured[f, s] for s in range(len(family.settings))))
        for f, family in enumerate(FAMILIES)
    )
    return StressResult(seed, pairs, results, stamp, time.monotonic() - start)
