"""Faults of the core: the first generic test that sees one, and the smallest pair that shows it."""

import os
from functools import partial
from pathlib import Path

from triaxis.sim.configuration import Configuration, parse_configuration
from triaxis.sim.models import core_build
from triaxis.sim.paths import ROOT
from triaxis.sim.verilate import library
from triaxis.verif.core.failing_pairs import FailingPair, read_failing
from triaxis.verif.counterexample.finding import BareCore, Counterexample, failing_stream, find
from triaxis.verif.faults.attempt import Attempt
from triaxis.verif.faults.broken_rtl import FOLDER
from triaxis.verif.faults.catalogue import Fault
from triaxis.verif.faults.result import Catch, Example
from triaxis.verif.faults.runs import TESTS, core_sign_of, until_one_fails
from triaxis.verif.testbench.simulation import RunResult

PICTURES = FOLDER / "pictures"


def try_core(fault: Fault, dut: Path, seed: int) -> Attempt:
    """Run the generic tests on the RTL in ``dut``, one after the other, until one fails."""
    configuration = parse_configuration(fault.config)
    tried = until_one_fails(TESTS, configuration, seed, fault.name, dut)
    result = tried.failed
    if result is None:
        return Attempt(None, f"{', '.join(TESTS)} pass", clean=True)
    test = result.settings.test
    sign = core_sign_of(result)
    if sign is None:
        said = next(iter(result.errors), "no error line")
        return Attempt(None, f"{test} ended without a verdict on the core: {said} (log: {result.log})")
    replay = f"{result.settings.replay_command} --fault {fault.name}"
    catch = Catch(test, sign.message, sign.pairs, sign.clocks, tried.missed, tried.pairs_before, replay)
    if result.failing_pairs is None:
        return Attempt(catch)
    # Built here, beside other work.
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
