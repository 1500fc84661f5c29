"""Faults of a testbench, tried on our own: it must refuse, or fail, each.

Every way by which pairs come in from outside the simulator is tried with coordinates that do not fit. In the
simulator the driver of sequence items is one more: see `triaxis.verif.faults.fault_tests`.
"""

from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from triaxis.golden.errors import InputError
from triaxis.golden.pairs import Pairs, coordinate_range, read_pairs
from triaxis.host.quantise import Grid, quantise
from triaxis.sim.configuration import Configuration
from triaxis.sim.detector import detect
from triaxis.sim.paths import DUT
from triaxis.verif.core.checking import Failure
from triaxis.verif.core.failing_pairs import read_failing, read_failing_pairs, write_failing_pairs
from triaxis.verif.core.stimulus.seed_vectors import seed_vectors, seed_vectors_as_written
from triaxis.verif.faults.known_faults import Fault
from triaxis.verif.faults.result import Attempt, Catch, Example
from triaxis.verif.faults.runs import run_test, sign_of
from triaxis.verif.testbench.failures import Blame
from triaxis.verif.testbench.settings import BURST, PIN

WIDTH = 16
_CORE = Configuration(WIDTH)
_ORIGIN = (Fraction(0), Fraction(0), Fraction(0))


def verdict_file(pairs: Pairs, folder: Path) -> None:
    """Read the pairs as ``triaxis verdict`` does."""
    path = folder / "pairs.npy"
    np.save(path, pairs)
    read_pairs(path, WIDTH)


def _archive(pairs: Pairs, folder: Path, context: Pairs) -> Path:
    path = folder / "failing_pairs.npz"
    margins = np.zeros(len(context), np.int64)
    write_failing_pairs(path, [Failure("", pair, 0, context, margins) for pair in pairs])
    return path


def replay_file(pairs: Pairs, folder: Path) -> None:
    """Read the pairs as ``triaxis sim ReplayTest`` does."""
    read_failing_pairs(_archive(pairs, folder, pairs), _CORE)


def shrink_context(pairs: Pairs, folder: Path) -> None:
    """Read the pairs as ``triaxis regress shrink`` does what came before a failing pair."""
    read_failing(_archive(np.zeros_like(pairs), folder, pairs), _CORE)


def mesh(pairs: Pairs, _: Path) -> None:
    """Quantise the triangles as ``triaxis check`` does facets, on a grid of whole numbers."""
    facets = pairs.reshape(-1, 3, 3).astype(np.float32)
    quantise(facets, Grid(Fraction(1), _ORIGIN, WIDTH), "mesh")


def wrapper(pairs: Pairs, _: Path) -> None:
    """Ask the wrapper CollisionDetector about the pairs."""
    detect(pairs, np.zeros((len(pairs), 2, 3), np.int64))


def wrapper_normals(pairs: Pairs, _: Path) -> None:
    """Hand the wrapper the first vertices for normals."""
    detect(np.zeros_like(pairs), pairs[:, :, 0])


ENTRANCES: dict[str, Callable[[Pairs, Path], None]] = {
    "pairs of `triaxis verdict`": verdict_file,
    "pairs of ReplayTest": replay_file,
    "context of `triaxis regress shrink`": shrink_context,
    "mesh of `triaxis check`": mesh,
    "pairs of the wrapper": wrapper,
    "normals of the wrapper": wrapper_normals,
}


def refusals(pairs: Pairs) -> dict[str, str | None]:
    """Return what each entrance says of the pairs; None where it lets them in."""
    said: dict[str, str | None] = {}
    with TemporaryDirectory() as folder:
        for name, enter in ENTRANCES.items():
            try:
                enter(pairs, Path(folder))
                said[name] = None
            except InputError as error:
                said[name] = str(error)
    return said


def boundary() -> tuple[Pairs, Pairs]:
    """Return pairs at both ends of the range, and pairs one step beyond them: (2, 2, 3, 3) each.

    In each, one coordinate differs from 0: x of the first vertex of A.
    """
    inside = np.zeros((2, 2, 3, 3), np.int64)
    inside[:, 0, 0, 0] = coordinate_range(WIDTH)
    outside = inside.copy()
    outside[:, 0, 0, 0] += (-1, 1)
    return inside, outside


def seed_vectors_by_width() -> dict[int, str | None]:
    """Return, by width, what a core that is too narrow for the seed vectors is told; None: they fit."""
    said: dict[int, str | None] = {}
    for width in (WIDTH - 1, WIDTH):
        try:
            seed_vectors(width)
            said[width] = None
        except InputError as error:
            said[width] = str(error)
    return said


RANGE = "F9"
# By fault: the test that has it, the agent, and what must give it away: a rule, or what is blamed.
_SABOTAGE = {
    "F10-late": ("LateOperandTest", PIN, "PairHeld"),
    "F10-unsent": ("NothingSentTest", BURST, Blame.TEST),
    "F10-unseen": ("NothingSeenTest", BURST, Blame.TEST),
}
_PIN_PAIRS = 360
_HEALTHY = "w16_m0"


def try_environment(fault: Fault, seed: int) -> Attempt:
    """Try the fault on the environment, with the core as it is."""
    if fault.name == RANGE:
        return _try_range(fault, seed)
    test, agent, expected = _SABOTAGE[fault.name]
    result = run_test(test, fault.config, seed, fault.name, DUT, agent, _PIN_PAIRS)
    if result.passed:
        return Attempt(None, f"{test} passes")
    sign = sign_of(result)
    if sign is None or sign.by != expected:
        said = "no verdict" if sign is None else sign.message
        return Attempt(None, f"{test} fails, but not by {expected}: {said} (log: {result.log})")
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
    for agent in (BURST, PIN):
        name = f"{fault.name}-{agent}"
        result = run_test("WrappingVectorsTest", fault.config, seed, name, DUT, agent, _PIN_PAIRS)
        sign = None if result.passed else sign_of(result)
        if sign is None or sign.by != InputError.__name__ or not _names_limit(sign.message):
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
    result = run_test("StallsTest", _HEALTHY, seed, "no-fault-pin", DUT, PIN, _PIN_PAIRS)
    if not result.passed:
        problems.append(f"StallsTest fails: {result.errors[0]}")
    return Attempt(None, "; ".join(problems) or None, clean=not problems)
