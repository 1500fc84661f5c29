"""``triaxis bench sim``: pairs a second of the simulations, all in one run, at M = 0 and mostly W = 16.

Rounds of all measurements follow each other, so that a slow spell of the machine does not fall on one
of them alone; of each the best round counts. Seconds are of the clock on the wall here: the environments have
threads that work beside each other, and only what passes meanwhile tells of that. So the ratios are told
beside what is aimed at, and are no verdict.
"""

import argparse
from collections.abc import Callable
from functools import partial
from timeit import Timer

import numpy as np
import numpy.typing as npt

from triaxis.bench import harness
from triaxis.bench.harness import Findings, Progress, report
from triaxis.coverage.core_coverage import CoreCoverage
from triaxis.golden.bulk import bulk_facts
from triaxis.golden.errors import InputError
from triaxis.host.cli.terminal import progress_bar, table
from triaxis.sim.configuration import Configuration
from triaxis.sim.core_engine import LockstepEngine, RtlEngine
from triaxis.verif.core.checking import Checker
from triaxis.verif.core.expectation import expected_words
from triaxis.verif.core.items import PairBatch, ResultBatch
from triaxis.verif.core.stimulus.families import mixture
from triaxis.verif.core.stimulus.stimulus import Pairs32
from triaxis.verif.testbench.golden_sample import Share
from triaxis.verif.testbench.settings import BURST, PIN
from triaxis.verif.testbench.simulation import run, run_settings

CONFIGURATION = Configuration(16, 0)
W24, W32 = Configuration(24, 0), Configuration(32, 0)

# Pairs of a measurement, such that each takes a second or more.
_BARE, _WIDE, _BURST, _PIN, _BULK = 1 << 20, 1 << 18, 6 << 20, 6_000, 4 << 20
_ROUNDS, _TRIES = 3, 3
# The share that the golden model judges in long runs beside the kinds that are new.
_ONE_IN = 1 << 16
_BATCH = 1 << 15

# What ratios are told, and how much each should reach. A reference: the same RTL, Verilator's arithmetic.
RATIOS = {
    ("bare", "bare_reference"): 1.5,
    ("bare_lanes", "bare_reference"): 3.0,
    ("bare_w24", "bare_w24_reference"): 2.0,
    ("bare_w32", "bare_w32_reference"): 4.0,
    ("burst_unchecked", "bare"): None,
    ("burst_checked", "bare"): 0.9,
    ("burst_soak", "bare"): 0.75,
    ("burst_checked", "pin"): 100.0,
    ("bulk_checker", "bare"): 1.0,
    ("checks", "bare"): 1.0,
}

Work = Callable[[Pairs32, npt.NDArray[np.uint32]], object]


def _batches(
    pairs: int, make: Callable[[], Work], configuration: Configuration = CONFIGURATION, batch: int = _BATCH
) -> float:
    """Return the best rate of work on the mixture that the bursts send, batch by batch, in a few tries."""
    work = make()
    stimulus = mixture(np.random.default_rng(1), configuration.width, 0).burst(batch)
    # By the clock on the wall, as the simulations beside it, which have threads.
    timer = Timer(lambda: work(stimulus.pairs, stimulus.margins))
    return pairs // batch * batch / min(timer.repeat(_TRIES, pairs // batch))


def _bare(configuration: Configuration, pairs: int, plain: bool = False) -> float:
    return _batches(pairs, lambda: RtlEngine(configuration, plain=plain).words, configuration)


def _checks() -> Work:
    """Return all that is done with answers: checks, claims, kinds, coverage; a few go to the golden model."""
    coverage = CoreCoverage(CONFIGURATION)
    checker = Checker(CONFIGURATION, Share(_ONE_IN, 0), on_checked=coverage.sample)
    made: list[tuple[PairBatch, ResultBatch]] = []

    def work(pairs: Pairs32, margins: npt.NDArray[np.uint32]) -> None:
        if not made:
            words = expected_words(bulk_facts(pairs, margins), CONFIGURATION)
            tags, waits = np.arange(len(pairs), dtype=np.uint32), np.zeros(len(pairs), np.uint16)
            made.append((PairBatch(pairs, margins, tags, waits), ResultBatch(words, tags, waits, tags)))
        checker.check(*made[0])

    return work


def _simulated(test: str, pairs: int, agent: str, soak: bool = False, seconds: str = "seconds") -> float:
    settings = run_settings(
        test, CONFIGURATION, 1, pairs,
        folder=harness.FOLDER / "runs" / f"{test}-{agent}-{soak}", agent=agent, judged_one_in=_ONE_IN,
        soak=soak,
    )  # fmt: skip
    result = run(settings)
    if not result.passed or not result.counts:
        raise InputError(result.explain())
    return result.counts.get("matched", result.counts["checked"]) / result.counts[seconds]


# The Verilated core behind a C++ loop, no checks, alone and many in lockstep; the burst environment with its
# stimulus and monitors; with checks and functional coverage; with checks, and the restrictions of a soak; the
# pin-level environment, checked, whose simulator is compiled quickly, as it is always used; the bulk checker;
# all that a pair goes through after it.
MEASUREMENTS: dict[str, Callable[[], float]] = {
    "bare": partial(_bare, CONFIGURATION, _BARE),
    "bare_reference": partial(_bare, CONFIGURATION, _BARE, plain=True),
    "bare_lanes": partial(_batches, 4 * _BARE, lambda: LockstepEngine(CONFIGURATION).words, batch=1 << 18),
    "bare_w24": partial(_bare, W24, _WIDE),
    "bare_w24_reference": partial(_bare, W24, _WIDE, plain=True),
    "bare_w32": partial(_bare, W32, _WIDE // 4),
    "bare_w32_reference": partial(_bare, W32, _WIDE // 4, plain=True),
    "burst_unchecked": partial(_simulated, "UncheckedVolumeTest", _BURST, BURST),
    "burst_checked": partial(_simulated, "VolumeTest", _BURST, BURST),
    "burst_checked_per_cpu_second": partial(_simulated, "VolumeTest", _BURST, BURST, seconds="cpu_seconds"),
    "burst_soak": partial(_simulated, "VolumeTest", _BURST, BURST, soak=True),
    "pin": partial(_simulated, "RandomTest", _PIN, PIN),
    "bulk_checker": partial(_batches, _BULK, lambda: bulk_facts),
    "checks": partial(_batches, _BULK, _checks),
}


def add_sim(parser: argparse.ArgumentParser) -> None:
    """Measure pairs a second of the bare core (W = 16, 24 and 32, each beside a build with Verilator's
    own arithmetic; W = 16 in lockstep too), the burst environment, the pin environment and the bulk
    checker, at M = 0, and tell their ratios beside what is aimed at: rates of one machine at one time,
    which no verdict follows from. Writes build/bench/sim.json.
    """
    parser.set_defaults(run=lambda _: report(harness.FOLDER / "sim.json", _measured))


def _measured() -> Findings:
    with progress_bar("measurements", _ROUNDS * len(MEASUREMENTS)) as progress:
        return findings(rates(progress))


def rates(progress: Progress) -> dict[str, float]:
    """Return the best rate of each measurement, in pairs a second; ``progress`` is told of each round."""
    best = dict.fromkeys(MEASUREMENTS, 0.0)
    for _ in range(_ROUNDS):
        for name, measure in MEASUREMENTS.items():
            best[name] = max(best[name], measure())
            progress(1)
    return best


def findings(best: dict[str, float]) -> Findings:
    """Return what is told of the rates."""
    shown = table("M = 0, W = 16 or as said, best of several rounds", ("what", "pairs/s"))
    for name, rate in best.items():
        shown.add_row(name, f"{rate:,.0f}")
    compared = table("ratios", ("ratio", "measured", "aimed at", ""))
    ratios: dict[str, float] = {}
    for (one, other), aim in RATIOS.items():
        name, ratio = f"{one} / {other}", best[one] / best[other]
        ratios[name] = round(ratio, 3)
        told = ("", "") if aim is None else (f"{aim:g}", "reached" if ratio >= aim else "less")
        compared.add_row(name, f"{ratio:.2f}", *told)
    content = {
        **{name: round(rate) for name, rate in best.items()},
        "ratios": ratios,
        "bounds": {f"{one} / {other}": aim for (one, other), aim in RATIOS.items() if aim is not None},
        "unit": "pairs a second",
        "config": CONFIGURATION.name,
    }
    summary = f"{best['burst_checked']:,.0f} pairs a second, checked; the bare core {best['bare']:,.0f}"
    return Findings("triaxis bench sim", summary, [], content, [shown, compared])
