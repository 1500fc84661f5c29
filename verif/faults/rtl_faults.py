"""Faults of the core, the mesh engine and the board: the first test that sees one; the smallest pair."""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from triaxis.sim.configuration import Configuration, parse_configuration
from triaxis.sim.models import core_build
from triaxis.sim.paths import ROOT
from triaxis.sim.verilate import library
from triaxis.verif.core.failing_pairs import FailingPair, read_failing
from triaxis.verif.counterexample.finding import BareCore, Counterexample, failing_stream, find
from triaxis.verif.faults.faulty_rtl import FOLDER
from triaxis.verif.faults.known_faults import Fault, Kind
from triaxis.verif.faults.result import Attempt, Catch, Example
from triaxis.verif.faults.runs import design_sign_of, run_test
from triaxis.verif.testbench.settings import BURST, PIN, Block
from triaxis.verif.testbench.simulation import RunResult
from triaxis.verif.testbench.table import names_of

PICTURES = FOLDER / "pictures"


@dataclass(frozen=True)
class _Search:
    """The tests that look for faults of a kind, in the order in which they are tried, and how they are run.

    The short ones of the board come first: a broken copy is compiled quickly, and runs slowly.

    ``pairs``: those that a test of the core sends, and that one of the engine accounts for at least; of the
    board, replies.
    """

    design: str
    tests: tuple[str, ...]
    agent: str
    pairs: int


# No test knows a fault: kept counterexamples, seed vectors and mixtures of all families are left out.
SEARCHES = {
    Kind.CORE: _Search(
        "core",
        (
            "RandomTest", "CoplanarTest", "DegenerateTest", "PenetratingTest", "SliversTest", "TouchingTest",
            "NearMissTest", "ExtremesTest", "TinyTest", "FarTest", "StallsTest", "ResetsTest",
        ),
        BURST,
        2000,
    ),
    Kind.ENGINE: _Search(
        "engine",
        (
            "MeshGapsTest", "MeshRandomTest", "MeshLimitsTest", "MeshStallsTest", "MeshAbortTest",
            "MeshResetsTest",
        ),
        PIN,
        400,
    ),
    Kind.BOARD: _Search(
        "board",
        tuple(names_of(Block.BOARD)),
        BURST,
        60,
    ),
}  # fmt: skip


def try_rtl(fault: Fault, dut: Path, seed: int, tests: Sequence[str] = ()) -> Attempt:
    """Run tests, all generic ones unless some are named, on the RTL in ``dut``, in turn, until one fails."""
    search = SEARCHES[fault.kind]
    missed: list[str] = []
    before = 0
    for test in tests or search.tests:
        result = run_test(test, fault.config, seed, fault.name, dut, search.agent, search.pairs)
        if not result.passed:
            return _caught(fault, dut, result, tuple(missed), before)
        missed.append(test)
        before += result.counts["checked"] if result.counts else 0
    return Attempt(None, f"{', '.join(missed)} pass", clean=True)


def _caught(fault: Fault, dut: Path, result: RunResult, missed: tuple[str, ...], before: int) -> Attempt:
    """Return what a failed run says of the fault; ``before``: pairs checked by the tests that missed it."""
    test, sign = result.settings.test, design_sign_of(result)
    if sign is None:
        said = next(iter(result.errors), "no error line")
        design = SEARCHES[fault.kind].design
        return Attempt(None, f"{test} ended without a verdict on the {design}: {said} (log: {result.log})")
    replay = f"{result.settings.replay_command} --fault {fault.name}"
    catch = Catch(test, sign.message, sign.pairs, sign.clocks, missed, before, replay)
    if fault.kind is not Kind.CORE or result.failing_pairs is None:
        return Attempt(catch)
    # Built here, beside other work.
    configuration = parse_configuration(fault.config)
    library(core_build(configuration, dut))
    return Attempt(catch, example=partial(_example, fault, configuration, dut, result))


def _example(fault: Fault, configuration: Configuration, dut: Path, result: RunResult) -> Example | None:
    """Return the counterexample to which the worst of the failing pairs shrinks; None where none fails
    on the bare core.
    """
    # Loads Matplotlib.
    from triaxis.verif.counterexample.picture import draw

    assert result.failing_pairs
    core = BareCore(configuration, dut)
    chosen = _worst(core, read_failing(result.failing_pairs, configuration))
    found = None if chosen is None else find(core, chosen)
    if chosen is None or found is None:
        return None
    picture = PICTURES / f"{fault.name}.png"
    draw(found, picture)
    return _described(chosen, found, picture)


def _worst(core: BareCore, failing: list[FailingPair]) -> FailingPair | None:
    """Return the first of the failing pairs with the worst symptom: a missed collision before all others."""
    streams = [(one, failing_stream(core, one)) for one in failing]
    seen = [(core.symptom(stream), one) for one, stream in streams if stream is not None]
    return min(seen, key=lambda pair: pair[0])[1] if seen else None


def _described(before: FailingPair, found: Counterexample, picture: Path) -> Example:
    stream = found.stream
    sent = [
        {"margin": margin, "A": a, "B": b}
        for (a, b), margin in zip(stream.pairs.tolist(), stream.margins.tolist(), strict=True)
    ]
    return Example(
        before.stream.describe(),
        stream.describe(),
        found.symptom.description,
        found.core_said,
        found.right_answer,
        sent,
        picture=os.path.relpath(picture, ROOT),
    )
