"""Runs of UVM tests on broken RTL, and what made them fail."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from triaxis.sim.clocking import PERIOD_NS
from triaxis.sim.configuration import Configuration
from triaxis.sim.paths import DUT
from triaxis.verif.faults.broken_rtl import FOLDER
from triaxis.verif.testbench.assertions import CORE_SVA, MESH_SVA, assertion_names
from triaxis.verif.testbench.settings import BURST
from triaxis.verif.testbench.simulation import RunResult, run, run_settings

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
# What the scoreboard says where an answer is wrong, and where one is lost or superfluous.
_WRONG = re.compile(
    r"core says .*, exact answer .*|tag \d+ where \d+ was due|claimed axis \d+ .* does not separate"
)
_LOST = re.compile(
    r"\d+ (?:pairs accepted and never answered|results (?:before a reset )?that answer no pair"
    r"|pairs unanswered at a reset; \d+ can be in flight)"
)
# What the scoreboard of the mesh engine says of a run; not where the judges themselves disagree.
_SCENE = re.compile(r"ERROR .*?\]: (?!golden model|bulk checker)(.*?): meshes of \d+ and \d+, translation ")
_HUNG = re.compile(r"(?:AssertionError|HungBurstError|HungRunError): (.*the (?:core|engine) hangs)$")
_PS_PER_CLOCK = 1000 * PERIOD_NS


@dataclass(frozen=True)
class Sign:
    """What gave a fault away: a wrong answer (``pairs`` until then), or a rule (``clocks`` until then)."""

    message: str
    pairs: int | None = None
    clocks: int | None = None


@dataclass(frozen=True)
class Tried:
    """Tests that were run in turn: the run that failed, None where none did, and those before it.

    ``pairs_before``: checked in the tests that passed.
    """

    failed: RunResult | None
    missed: tuple[str, ...]
    pairs_before: int


def until_one_fails(
    tests: Sequence[str],
    configuration: Configuration | str,
    seed: int,
    name: str,
    dut: Path,
    agent: str = BURST,
    pairs: int = PAIRS,
) -> Tried:
    """Run the tests on the RTL in ``dut``, one after the other, until one fails."""
    missed: list[str] = []
    before = 0
    for test in tests:
        result = run_test(test, configuration, seed, name, dut, agent, pairs)
        if not result.passed:
            return Tried(result, tuple(missed), before)
        missed.append(test)
        before += result.counts["checked"] if result.counts else 0
    return Tried(None, tuple(missed), before)


def run_test(
    test: str,
    configuration: Configuration | str,
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
    return run(settings, dut=dut)


def sign_of(result: RunResult) -> Sign | None:
    """Return what made a run fail; None where it ended without a verdict: that proves nothing."""
    if rule := _broken_rule(result):
        return rule[1]
    for pattern in (_SCOREBOARD, _RAISED):
        for line in result.errors:
            if found := pattern.search(line):
                return Sign(found[1], _pairs(result))
    return None


def core_sign_of(result: RunResult) -> Sign | None:
    """Return what the core did wrong in a run; None where the run failed for any other reason.

    A rule of verif/core/sva is broken, an answer of a kept pair is wrong, answers are lost, the core hangs.
    Trouble of the environment, a full disk or a refused stimulus, says nothing of the core.
    """
    rule = _broken_rule(result)
    if rule and rule[0] in _rules(CORE_SVA):
        return rule[1]
    said = [found[1] for line in result.errors if (found := _SCOREBOARD.search(line))]
    pairs = _pairs(result)
    if pairs is not None and result.failing_pairs is not None:
        for message in filter(_WRONG.fullmatch, said):
            return Sign(message, pairs)
    for message in filter(_LOST.fullmatch, said):
        return Sign(message)
    return _hang(result)


def engine_sign_of(result: RunResult) -> Sign | None:
    """Return what the mesh engine did wrong in a run; None where the run failed for any other reason.

    A rule of verif/mesh/sva is broken, a run is not what its scene makes it, or the engine hangs.
    """
    rule = _broken_rule(result)
    if rule and rule[0] in _rules(MESH_SVA):
        return rule[1]
    for line in result.errors:
        if found := _SCENE.search(line):
            return Sign(found[1])
    return _hang(result)


def _hang(result: RunResult) -> Sign | None:
    for line in result.errors:
        if found := _HUNG.search(line):
            return Sign(found[1])
    return None


def _broken_rule(result: RunResult) -> tuple[str, Sign] | None:
    """Return the label of the first assertion that failed, and what it says."""
    for line in result.errors:
        if found := _TIMED.search(line):
            return found[2], Sign(f"{found[2]}: {found[3]}", clocks=int(found[1]) // _PS_PER_CLOCK)
    return None


@cache
def _rules(folder: Path) -> frozenset[str]:
    """Return the labels of the assertions in a folder."""
    names = (name for path in sorted(folder.glob("*.sv")) for name in assertion_names(path))
    return frozenset(name.rpartition(".")[2] for name in names)


def _pairs(result: RunResult) -> int | None:
    return result.counts["checked_until_failure"] if result.counts else None
