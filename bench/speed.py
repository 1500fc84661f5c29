"""Speed of the simulations, in pairs a second, all in one run on one machine, at W = 16 and M = 0.

Rounds of all measurements follow each other, so that a slow spell of the machine does not fall on one
of them alone; of each the best round counts. Seconds are of the clock on the wall here: the environments have
threads that work beside each other, and only what passes meanwhile tells of that.
"""

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from triaxis.bench.harness import FOLDER, Progress, write_result
from triaxis.golden.bulk import bulk_facts
from triaxis.golden.errors import InputError
from triaxis.sim.configuration import Configuration
from triaxis.sim.core_engine import RtlEngine
from triaxis.verif.core.stimulus.families import mixture
from triaxis.verif.core.stimulus.stimulus import Pairs32
from triaxis.verif.testbench.settings import BURST, PIN
from triaxis.verif.testbench.simulation import run, run_settings

RESULT = FOLDER / "sim.json"
CONFIGURATION = Configuration(16, 0)

# Pairs of a measurement, such that each takes several seconds.
_BARE, _BURST, _PIN, _BULK = 4 << 20, 6 << 20, 6_000, 8 << 20
_ROUNDS = 3
# The share that the golden model judges in long runs beside the kinds that are new.
ONE_IN = 1 << 16
_BATCH = 1 << 15


@dataclass(frozen=True)
class SimSpeeds:
    """Pairs a second.

    bare: the Verilated core behind a C++ loop, no checks. burst_unchecked: the burst environment
    with its stimulus and monitors. burst_checked: with checks and functional coverage. burst_soak: with
    checks, and the restrictions of a soak. pin: the pin-level environment, checked; its simulator is
    compiled quickly, not for speed, as it is always used: most of its time is Python's, at each clock.
    bulk_checker: the bulk checker alone, on one core.
    """

    bare: float
    burst_unchecked: float
    burst_checked: float
    burst_soak: float
    pin: float
    bulk_checker: float

    @property
    def ratios(self) -> dict[str, float]:
        """Return the ratios that matter."""
        return {
            "burst_unchecked / bare": self.burst_unchecked / self.bare,
            "burst_checked / bare": self.burst_checked / self.bare,
            "burst_soak / bare": self.burst_soak / self.bare,
            "burst_checked / pin": self.burst_checked / self.pin,
            "bulk_checker / bare": self.bulk_checker / self.bare,
        }


# The least that the ratios must reach.
BOUNDS = {
    "burst_checked / bare": 0.5,
    "burst_soak / bare": 0.75,
    "burst_checked / pin": 100.0,
    "bulk_checker / bare": 1.0,
}


def _batches(pairs: int, work: Callable[[Pairs32, npt.NDArray[np.uint32]], object]) -> float:
    """Return the rate of work on the mixture that the bursts send, batch by batch."""
    batch = mixture(np.random.default_rng(1), CONFIGURATION.width, 0).burst(_BATCH)
    start = time.perf_counter()
    for _ in range(pairs // _BATCH):
        work(batch.pairs, batch.margins)
    return pairs // _BATCH * _BATCH / (time.perf_counter() - start)


def _simulated(test: str, pairs: int, agent: str, one_in: int = ONE_IN, soak: bool = False) -> float:
    settings = run_settings(
        test, CONFIGURATION, 1, pairs,
        folder=FOLDER / "runs" / f"{test}-{agent}-{soak}", agent=agent, judged_one_in=one_in, soak=soak,
    )  # fmt: skip
    result = run(settings)
    if not result.passed or not result.counts:
        raise InputError(result.explain())
    return result.counts.get("matched", result.counts["checked"]) / result.counts["seconds"]


_MEASUREMENTS: dict[str, Callable[[], float]] = {
    "bare": lambda: _batches(_BARE, RtlEngine(CONFIGURATION).words),
    "burst_unchecked": lambda: _simulated("UncheckedVolumeTest", _BURST, BURST),
    "burst_checked": lambda: _simulated("VolumeTest", _BURST, BURST),
    "burst_soak": lambda: _simulated("VolumeTest", _BURST, BURST, soak=True),
    "pin": lambda: _simulated("RandomTest", _PIN, PIN),
    "bulk_checker": lambda: _batches(_BULK, bulk_facts),
}
STEPS = _ROUNDS * len(_MEASUREMENTS)


def bench_sim(progress: Progress) -> SimSpeeds:
    """Measure everything; ``progress`` is told of each of STEPS measurements."""
    best = dict.fromkeys(_MEASUREMENTS, 0.0)
    for _ in range(_ROUNDS):
        for name, measure in _MEASUREMENTS.items():
            best[name] = max(best[name], measure())
            progress(1)
    return SimSpeeds(**best)


def write_speeds(speeds: SimSpeeds, seconds: float) -> Path:
    """Write build/bench/sim.json, whole or not at all."""
    ratios = {name: round(ratio, 3) for name, ratio in speeds.ratios.items()}
    problems = [
        f"{name}: {ratios[name]}: less than {BOUNDS[name]:g}"
        for name in BOUNDS
        if speeds.ratios[name] < BOUNDS[name]
    ]
    summary = f"{round(speeds.burst_checked):,} pairs a second, checked; the bare core {round(speeds.bare):,}"
    content = {
        **{name: round(rate) for name, rate in asdict(speeds).items()},
        "ratios": ratios,
        "bounds": BOUNDS,
        "unit": "pairs a second",
        "config": CONFIGURATION.name,
    }
    return write_result(RESULT, "triaxis bench sim", problems, summary, seconds, content)
