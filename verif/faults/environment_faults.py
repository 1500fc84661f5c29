"""Faults of a testbench, tried on our own: it must refuse, or fail, each."""

import numpy as np

from triaxis.golden.pairs import Pairs, coordinate_range
from triaxis.sim.configuration import parse_configuration
from triaxis.verif.core.stimulus.seed_vectors import seed_vectors_as_written
from triaxis.verif.faults.attempt import Attempt
from triaxis.verif.faults.catalogue import Fault
from triaxis.verif.faults.entrances import WIDTH, boundary, refusals, seed_vectors_by_width
from triaxis.verif.faults.result import Catch, Example
from triaxis.verif.faults.runs import run_test, sign_of
from triaxis.verif.testbench.settings import BURST, PIN

RANGE = "F9"
# By fault: the test that has it, the agent, and what the environment must say.
_SABOTAGE = {
    "F10-late": ("LateOperandTest", PIN, "PairHeld"),
    "F10-unsent": ("NothingSentTest", BURST, "nothing was checked"),
    "F10-unseen": ("NothingSeenTest", BURST, "nothing was checked"),
}
_PIN_PAIRS = 360
_HEALTHY = "w16_m0"


def try_environment(fault: Fault, seed: int) -> Attempt:
    """Try the fault on the environment, with the core as it is."""
    if fault.name == RANGE:
        return _try_range(fault, seed)
    test, agent, expected = _SABOTAGE[fault.name]
    configuration = parse_configuration(fault.config)
    result = run_test(test, configuration, seed, fault.name, agent=agent, pairs=_PIN_PAIRS)
    if result.passed:
        return Attempt(None, f"{test} passes")
    sign = sign_of(result)
    if sign is None or expected not in sign.message:
        said = "no verdict" if sign is None else sign.message
        return Attempt(None, f"{test} fails, but not by {expected!r}: {said} (log: {result.log})")
    return Attempt(Catch(test, sign.message, sign.pairs, sign.clocks))


def _try_range(fault: Fault, seed: int) -> Attempt:
    """Try every way in with the seed vectors as they were written, and with single steps too far."""
    written = seed_vectors_as_written()
    _, outside = boundary()
    open_to: list[str] = []
    for pairs in (written, *outside[:, None]):
        open_to += [name for name, said in refusals(pairs).items() if said is None or not _names_limit(said)]
    narrow = seed_vectors_by_width()[WIDTH - 1]
    if narrow is None:
        open_to.append("seed vectors")
    configuration = parse_configuration(fault.config)
    for agent in (BURST, PIN):
        result = run_test("WrappingVectorsTest", configuration, seed, f"{fault.name}-{agent}", agent=agent)
        sign = None if result.passed else sign_of(result)
        if sign is None or not _names_limit(sign.message):
            open_to.append(f"sequence items ({agent})")
    if open_to:
        names = ", ".join(dict.fromkeys(open_to))
        return Attempt(None, f"let in, or refused without the limit: {names}")
    said = refusals(outside[1:])
    ways = len(said) + 3
    example = _range_example(written, outside[1], next(iter(said.values())) or "")
    catch = Catch("every way in", f"{ways} of {ways} entrances refuse them")
    return Attempt(catch, example=lambda: example)


def _names_limit(message: str) -> bool:
    low, high = coordinate_range(WIDTH)
    return f"{low}..{high}" in message or f"{WIDTH} bits" in message


def _range_example(written: Pairs, smallest: Pairs, said: str) -> Example:
    high = coordinate_range(WIDTH)[1]
    first = written[np.flatnonzero((written > high).any((1, 2, 3)))[0]]
    return Example(
        f"margin 0, {first.tolist()}",
        f"margin 0, {smallest.tolist()}",
        f"does not fit {WIDTH} signed bits",
        said.partition(": ")[2],
        "refused",
        [{"margin": 0, "A": smallest[0].tolist(), "B": smallest[1].tolist()}],
    )


def try_healthy_environment(seed: int) -> Attempt:
    """Try what is in order: the same traffic from a punctual driver, pairs that fit by every way in."""
    inside, _ = boundary()
    problems = [f"{name} refuses what fits: {said}" for name, said in refusals(inside).items() if said]
    if moved := seed_vectors_by_width()[WIDTH]:
        problems.append(f"seed vectors refused where they fit: {moved}")
    configuration = parse_configuration(_HEALTHY)
    result = run_test("StallsTest", configuration, seed, "no-fault-pin", agent=PIN, pairs=_PIN_PAIRS)
    if not result.passed:
        problems.append(f"StallsTest fails: {result.errors[0]}")
    return Attempt(None, "; ".join(problems) or None, clean=not problems)
