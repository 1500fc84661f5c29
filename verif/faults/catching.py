"""Runs the catalogue: every fault is put in, and must be caught; where there is none, nothing may be."""

import os
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from filelock import FileLock

from triaxis.golden.outputs import make_folder
from triaxis.golden.processes import threads
from triaxis.sim.paths import DUT
from triaxis.sim.validity import Standing, standing
from triaxis.verif.faults import runs
from triaxis.verif.faults.environment_faults import try_environment, try_healthy_environment
from triaxis.verif.faults.faulty_rtl import faulty_rtl
from triaxis.verif.faults.known_faults import FAULTS, Fault, Kind
from triaxis.verif.faults.result import SOURCES, Attempt, FaultsResult, Outcome
from triaxis.verif.faults.rtl_faults import SEARCHES, try_rtl
from triaxis.verif.faults.wrapper_faults import try_wrapper

_JOBS = min(2, os.cpu_count() or 1)


def _signed_off() -> tuple[Fault, ...]:
    return tuple(fault for fault in FAULTS if fault.signed_off)


def signed_off_names() -> tuple[str, ...]:
    """Return the names of the faults that a sign-off must see caught."""
    return tuple(fault.name for fault in _signed_off())


def catch(fault: Fault, seed: int) -> Outcome:
    """Put the fault into a copy of dut/, or into the environment, and see what catches it.

    Raises InputError where the RTL is no longer what the fault changes.
    """
    broken = faulty_rtl(fault) if fault.patch else DUT
    return _concluded(fault, *_tried(fault, broken, seed), seed)


def catch_all(
    progress: Callable[[int], None], seed: int = 1, faults: Sequence[Fault] | None = None, dut: Path = DUT
) -> FaultsResult:
    """Try the faults, those of a sign-off unless others are named; ``progress`` is told of each.

    Waits while another process does. Raises InputError, before anything runs, where the RTL is no longer what
    a fault changes.
    """
    # Before it waits: what is loaded here is of now.
    before = standing(SOURCES, dut)
    make_folder(runs.RUNS)
    with FileLock(runs.RUNS / ".lock"):
        return _catch_all(progress, seed, faults, dut, before)


def _catch_all(
    progress: Callable[[int], None], seed: int, faults: Sequence[Fault] | None, dut: Path, before: Standing
) -> FaultsResult:
    start = time.monotonic()
    chosen = _signed_off() if faults is None else tuple(faults)
    folders = [faulty_rtl(fault, dut) if fault.patch else dut for fault in chosen]
    outcomes: list[Outcome] = []
    with threads(_JOBS) as pool:
        tries = [pool.submit(_tried, *each, seed) for each in zip(chosen, folders, strict=True)]
        for fault, future in zip(chosen, tries, strict=True):
            # Shrinking and drawing are for the main thread, beside the tries of other faults.
            outcomes.append(_concluded(fault, *future.result(), seed))
            progress(1)
    wrong = control(outcomes, seed, dut)
    return FaultsResult(outcomes, wrong, before.valid_for, not before.stands, seed, time.monotonic() - start)


def _tried(fault: Fault, broken: Path, seed: int) -> tuple[Attempt, float]:
    """Return what came of trying the fault, and the seconds that it took."""
    start = time.monotonic()
    if fault.kind in SEARCHES:
        attempt = try_rtl(fault, broken, seed)
    elif fault.kind is Kind.WRAPPER:
        attempt = try_wrapper(broken, seed)
    else:
        attempt = try_environment(fault, seed)
    return attempt, time.monotonic() - start


def _concluded(fault: Fault, attempt: Attempt, seconds: float, seed: int) -> Outcome:
    start = time.monotonic()
    example = attempt.example()
    seconds += time.monotonic() - start
    return Outcome(fault, seed, seconds, attempt.catch, example, attempt.reason)


def control(outcomes: Iterable[Outcome], seed: int, dut: Path = DUT) -> list[str]:
    """Return what those that caught a fault find where it is not put in: nothing, or no catch counts."""
    wanted: dict[tuple[str, ...], Callable[[], Attempt]] = {}
    for fault, catch in ((one.fault, one.catch) for one in outcomes):
        if catch is None:
            continue
        if fault.kind in SEARCHES:
            healthy = replace(fault, name=f"no-fault-{fault.config}")
            wanted[fault.config, catch.test] = partial(try_rtl, healthy, dut, seed, (catch.test,))
        elif fault.kind is Kind.WRAPPER:
            wanted["wrapper",] = partial(try_wrapper, dut, seed)
        else:
            wanted["environment",] = partial(try_healthy_environment, seed)
    with threads(_JOBS) as pool:
        tried = list(pool.map(lambda attempt: attempt(), wanted.values()))
    return [f"{a.catch.test}: {a.catch.message}" if a.catch else str(a.reason) for a in tried if not a.clean]
