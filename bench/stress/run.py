"""All settings of all families, measured by a process for each processor; the same seed gives the same."""

from dataclasses import dataclass
from functools import partial

import numpy as np

from triaxis.bench.harness import Progress
from triaxis.bench.stress.families import FAMILIES, Family
from triaxis.bench.stress.measuring import WIDTHS, SettingResult, core_engine, measure
from triaxis.bench.stress.orders import OrderErrors, total
from triaxis.golden.judge import default_solver
from triaxis.golden.processes import in_processes

# Of a run: a core to build, a setting to measure.
STEPS = len(WIDTHS) + sum(len(family.settings) for family in FAMILIES)


@dataclass(frozen=True)
class Settings:
    """What was measured at several settings, and sums over them."""

    measured: tuple[SettingResult, ...]

    @property
    def core(self) -> OrderErrors:
        """Return the core's errors at its own resolution."""
        return total(one.core for one in self.measured)

    @property
    def no_miss(self) -> OrderErrors:
        """Return the errors of the no-miss mode."""
        return total(one.no_miss for one in self.measured)

    @property
    def beyond_band(self) -> int:
        """Return the number of false alarms of the no-miss mode beyond its band."""
        return sum(one.beyond_band for one in self.measured)


@dataclass(frozen=True)
class FamilyResult(Settings):
    """A family, and what was measured at each of its settings."""

    family: Family


@dataclass(frozen=True)
class StressResult:
    """What was measured, with which seed and how many pairs at each setting."""

    seed: int
    pairs: int
    families: tuple[FamilyResult, ...]

    @property
    def whole(self) -> Settings:
        """Return what was measured at the settings of all families."""
        return Settings(tuple(one for family in self.families for one in family.measured))

    @property
    def problems(self) -> list[str]:
        """Return what must not be, anywhere, with the setting."""
        return [
            f"{result.family.name} {setting.label}: {problem}"
            for result in self.families
            for setting, measured in zip(result.family.settings, result.measured, strict=True)
            for problem in measured.problems
        ]


def measure_setting(place: tuple[int, int], seed: int, pairs: int) -> SettingResult:
    """Measure a setting of a family, by their numbers."""
    family = FAMILIES[place[0]]
    rng = np.random.default_rng([seed, place[1], *family.name.encode()])
    return measure(family.settings[place[1]].make(rng, pairs))


def run_stress(seed: int, pairs: int, progress: Progress) -> StressResult:
    """Measure everything; ``progress`` is told of each of STEPS."""
    for width in WIDTHS:
        core_engine(width)
        progress(1)
    places = [(f, s) for f, family in enumerate(FAMILIES) for s in range(len(family.settings))]
    work = partial(measure_setting, seed=seed, pairs=pairs)
    measured = iter(in_processes(work, places, lambda _: progress(1), default_solver))
    families = (FamilyResult(tuple(next(measured) for _ in family.settings), family) for family in FAMILIES)
    return StressResult(seed, pairs, tuple(families))
