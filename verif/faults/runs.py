"""Runs of UVM tests on a broken core, and what made them fail."""

import re
from dataclasses import dataclass
from pathlib import Path

from triaxis.verif.clocking import PERIOD_NS
from triaxis.verif.configuration import Configuration
from triaxis.verif.faults.broken_rtl import FOLDER
from triaxis.verif.paths import DUT
from triaxis.verif.settings import BURST
from triaxis.verif.simulation import RunResult, run, run_settings

# The generic tests, in the order in which they are tried. None knows a fault: kept counterexamples, the seed
# vectors and mixtures of all families are left out.
TESTS = (
    "RandomTest",
    "CoplanarTest",
    "DegenerateTest",
    "PenetratingTest",
    "SliversTest",
    "TouchingTest",
    "NearMissTest",
    "ExtremesTest",
    "TinyTest",
    "FarTest",
    "StallsTest",
    "ResetsTest",
)
PAIRS = 2000
RUNS = FOLDER / "runs"
# The golden model judges one pair in so many; the bulk checker checks all.
_JUDGED_ONE_IN = 100

_TIMED = re.compile(r"\[(\d+)\] %Error: .*Assertion failed in \S*?(\w+): (.*)")
_SCOREBOARD = re.compile(r"ERROR .*?\]: (.*?)(?:: margin \d+, \[.*)?$")
_RAISED = re.compile(r"(?:AssertionError|HungBurstError|InputError): (.*)")
_PS_PER_CLOCK = 1000 * PERIOD_NS


@dataclass(frozen=True)
class Sign:
    """What gave a fault away: a wrong answer (``pairs`` until then), or a rule (``clocks`` until then)."""

    message: str
    pairs: int | None = None
    clocks: int | None = None


def run_test(
    test: str,
    configuration: Configuration,
    seed: int,
    name: str,
    dut: Path = DUT,
    agent: str = BURST,
    pairs: int = PAIRS,
) -> RunResult:
    """Run a test on the RTL in ``dut``, in a folder of its own under ``name``."""
    folder = RUNS / f"{name}-{test}-{seed}"
    settings = run_settings(
        test, configuration, seed, pairs, folder=folder, agent=agent, judged_one_in=_JUDGED_ONE_IN
    )
    return run(settings, dut=dut, shrink=False)


def sign_of(result: RunResult) -> Sign | None:
    """Return what made a run fail; None where it ended without a verdict: that proves nothing."""
    for line in result.errors:
        if found := _TIMED.search(line):
            return Sign(f"{found[2]}: {found[3]}", clocks=int(found[1]) // _PS_PER_CLOCK)
    pairs = result.counts["checked_until_failure"] if result.counts else None
    for pattern in (_SCOREBOARD, _RAISED):
        for line in result.errors:
            if found := pattern.search(line):
                return Sign(found[1], pairs)
    return None
