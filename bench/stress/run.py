"""All settings of all families, measured by a process for each processor; the same seed gives the same."""

import time
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from triaxis.bench.harness import FOLDER, SOURCES, Progress, write_result
from triaxis.bench.stress.families import FAMILIES, Family
from triaxis.bench.stress.measuring import ROUNDING_WIDTH, WIDTHS, SettingResult, build_cores, measure
from triaxis.bench.stress.orders import OrderErrors, total
from triaxis.golden.errors import InputError
from triaxis.golden.judge import default_solver
from triaxis.golden.processes import in_processes
from triaxis.sim.validity import Provenance, provenance
from triaxis.verif.core.stimulus.symmetry import NUM_ORDERS

RESULT = FOLDER / "stress.json"

SETTINGS = sum(len(family.settings) for family in FAMILIES)
# Steps of progress: a core to build, a setting to measure.
STEPS = len(WIDTHS) + SETTINGS
# A rate of 0.1 % is 4 of these; with fewer than the least it would hardly ever be seen.
PAIRS, LEAST_PAIRS, MOST_PAIRS = 4000, 100, 100_000


@dataclass(frozen=True)
class FamilyResult:
    """A family, and what was measured at each of its settings."""

    family: Family
    measured: tuple[SettingResult, ...]

    @property
    def core(self) -> OrderErrors:
        """Return the core's errors at its own resolution, of all settings together."""
        return total(one.core for one in self.measured)

    @property
    def no_miss(self) -> OrderErrors:
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
    def core(self) -> OrderErrors:
        """Return the core's errors at its own resolution, of all families together."""
        return total(family.core for family in self.families)

    @property
    def no_miss(self) -> OrderErrors:
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


def measure_setting(place: tuple[int, int], seed: int, pairs: int) -> SettingResult:
    """Measure a setting of a family, by their numbers."""
    family = FAMILIES[place[0]]
    rng = np.random.default_rng([seed, place[1], *family.name.encode()])
    return measure(family.settings[place[1]].make(rng, pairs))


def run_stress(seed: int, pairs: int, progress: Progress) -> StressResult:
    """Measure everything; ``progress`` is told of each of STEPS."""
    check_options(seed, pairs)
    start, stamp = time.monotonic(), provenance(SOURCES)
    build_cores(progress)
    places = [(f, s) for f, family in enumerate(FAMILIES) for s in range(len(family.settings))]
    work = partial(measure_setting, seed=seed, pairs=pairs)
    measured = in_processes(work, places, lambda _: progress(1), default_solver)
    results = tuple(
        FamilyResult(family, tuple(one for place, one in zip(places, measured, strict=True) if place[0] == f))
        for f, family in enumerate(FAMILIES)
    )
    return StressResult(seed, pairs, results, stamp, time.monotonic() - start)


def summary(result: StressResult) -> str:
    """Return what was found, in a line."""
    core, no_miss = result.core, result.no_miss
    return (
        f"core: {core.wrong} of {core.answers:,} answers wrong at its own resolution; no-miss mode: "
        f"{no_miss.misses} of {no_miss.answers:,} missed, {no_miss.false_alarms:,} false alarms"
    )


def write_numbers(result: StressResult) -> Path:
    """Write build/bench/stress.json, whole or not at all."""
    content = {
        "seed": result.seed,
        "pairs_a_setting": result.pairs,
        "orders": NUM_ORDERS,
        "core_widths": WIDTHS,
        "families": [_family(family) for family in result.families],
    }
    command = f"triaxis bench stress --seed {result.seed} --pairs {result.pairs}"
    return write_result(
        RESULT, command, result.problems, summary(result), result.seconds, content, result.provenance
    )


def _family(result: FamilyResult) -> dict[str, Any]:
    family = result.family
    settings = zip(family.settings, result.measured, strict=True)
    return {
        "name": family.name,
        "knob": family.knob,
        "about": family.about,
        "settings": [_setting(setting.label, measured) for setting, measured in settings],
    }


def _setting(label: str, measured: SettingResult) -> dict[str, Any]:
    return {
        "setting": label,
        "pairs": measured.pairs,
        "near_pairs": measured.near_pairs,
        "judged_pairs": measured.judged_pairs,
        "core_width_as_given": measured.own_width,
        "core_at_its_own_resolution": _errors(measured.core),
        "methods": {name: _errors(errors) for name, errors in measured.methods.items()},
        "rounded": {
            "width": ROUNDING_WIDTH,
            "resolution": measured.resolution,
            "without_margin": _errors(measured.rounded),
            "no_miss": _errors(measured.no_miss),
            "band_pairs": measured.band_pairs,
            "false_alarms_beyond_band": measured.beyond_band,
            "farthest_false_alarm_lsb": measured.farthest,
        },
    }


def _errors(errors: OrderErrors) -> dict[str, Any]:
    return {**asdict(errors), "wrong_rate": errors.rate, "changing_rate": errors.changing_rate}
