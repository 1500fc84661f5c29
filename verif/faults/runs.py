"""Runs of UVM tests on broken RTL, and what made them fail."""

import re
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from triaxis.sim.configuration import Configuration
from triaxis.sim.models import BOARD_SVA, CORE_SVA, MESH_SVA
from triaxis.verif.faults.faulty_rtl import FOLDER
from triaxis.verif.testbench.assertions import assertion_names
from triaxis.verif.testbench.failures import Blame, HungError
from triaxis.verif.testbench.settings import Block
from triaxis.verif.testbench.simulation import RunResult, run, run_settings

RUNS = FOLDER / "runs"
# The golden model judges one pair in so many; the bulk checker checks all.
_JUDGED_ONE_IN = 100

_SVA = {Block.CORE: CORE_SVA, Block.MESH: MESH_SVA, Block.BOARD: BOARD_SVA}
# The end of a traceback: the exception's type, and what it says.
_RAISED = re.compile(r"(?:[\w.]+\.)?(AssertionError|HungError|InputError): (.*)")


@dataclass(frozen=True)
class Sign:
    """What gave a fault away: ``pairs`` until then where it is about a pair, ``clocks`` where it is a rule.

    ``by``: the label of the rule, what the scoreboard blames, or the type of the exception.
    """

    by: str
    message: str
    pairs: int | None = None
    clocks: int | None = None


def run_test(
    test: str, configuration: Configuration | str, seed: int, name: str, dut: Path, agent: str, pairs: int
) -> RunResult:
    """Run a test on the RTL in ``dut``, in a folder of its own under ``name``."""
    folder = RUNS / f"{name}-{test}-{seed}"
    settings = run_settings(
        test, configuration, seed, pairs, folder=folder, agent=agent, judged_one_in=_JUDGED_ONE_IN
    )
    return run(settings, dut=dut)


def sign_of(result: RunResult) -> Sign | None:
    """Return what made a run fail; None where it ended without a verdict: that proves nothing."""
    found = [_broken_rule(result), *_scoreboard_signs(result), *_exceptions(result)]
    return next((sign for sign in found if sign is not None), None)


def design_sign_of(result: RunResult) -> Sign | None:
    """Return what the core or the engine did wrong in a run; None where the run failed for any other reason.

    A rule of its sva folder is broken; an answer is wrong, where pairs are kept that show it; answers are
    lost, or a run is not what its scene makes it; it hangs. Trouble of the environment, a full disk or a
    refused stimulus, says nothing of the design.
    """
    rule = _broken_rule(result)
    if rule and rule.by in _rules(_SVA[result.settings.block]):
        return rule
    found = [sign for sign in _scoreboard_signs(result) if sign.by == Blame.DESIGN]
    if result.failing_pairs is None:
        found = [sign for sign in found if sign.pairs is None]
    found += [sign for sign in _exceptions(result) if sign.by == HungError.__name__]
    # A wrong answer has pairs to show for it, and so says most.
    return min(found, key=lambda sign: sign.pairs is None, default=None)


def _scoreboard_signs(result: RunResult) -> list[Sign]:
    """Return what the scoreboard found."""
    counts = result.counts or {}
    until = counts.get("checked_until_failure")
    return [
        Sign(one["blame"], one["message"], until if one.get("of_pair") else None)
        for one in counts.get("failures", [])
    ]


def _exceptions(result: RunResult) -> list[Sign]:
    found = [_RAISED.search(line) for line in result.errors]
    return [Sign(one[1], one[2]) for one in found if one]


def _broken_rule(result: RunResult) -> Sign | None:
    rule = result.rule
    return Sign(rule.name, f"{rule.name}: {rule.said}", clocks=rule.clock) if rule else None


@cache
def _rules(folder: Path) -> frozenset[str]:
    """Return the labels of the assertions in a folder."""
    names = (name for path in sorted(folder.glob("*.sv")) for name in assertion_names(path))
    return frozenset(name.rpartition(".")[2] for name in names)
