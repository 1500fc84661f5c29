"""A whole grid on all cores, stopped and continued at will, and the proof that nothing is left out."""

import os
import time
from collections.abc import Callable
from contextlib import closing
from dataclasses import asdict, dataclass
from functools import cache, partial
from pathlib import Path

import numpy as np

from triaxis.golden.bulk import bulk_facts
from triaxis.golden.errors import InputError
from triaxis.golden.processes import results_in_processes
from triaxis.sim.core_engine import LockstepEngine, RtlEngine
from triaxis.sim.evidence import write_evidence
from triaxis.sim.paths import BUILD
from triaxis.sim.validity import Sources, standing, validity
from triaxis.verif.core.checking import Failure
from triaxis.verif.core.failing_pairs import write_failing_pairs
from triaxis.verif.exhaustive.check import CONFIGURATION, MARGINS, ClassResult, Core, Mismatch, check_class
from triaxis.verif.exhaustive.grid import Grid
from triaxis.verif.exhaustive.state import Identity, Progress, forget, load, save

FOLDER = BUILD / "exhaustive"
SOURCES = Sources(("triaxis.verif.exhaustive.run",))
WORKERS = min(2, os.cpu_count() or 1)
# Beyond so many mismatches the rest would say nothing new.
ENOUGH_MISMATCHES = 10_000
_KEPT = 20
# Runs that a worker does before it reports: enough to hide the cost of that, and soon done where the user
# interrupts.
_RUNS_PER_REPORT = 1 << 16
_SECONDS_BETWEEN_SAVES = 5.0
# On smaller grids, to build cores in lockstep takes longer than they save.
_LOCKSTEP_FROM = 4


@dataclass(frozen=True)
class Outcome:
    """A run that came to its end; ``new``: classes that were not run before it was continued."""

    identity: Identity
    grid: Grid
    progress: Progress
    new: int

    @property
    def runs_per_second(self) -> float:
        """Return how fast it was, pauses left out."""
        return self.progress.result.counts.runs / max(self.progress.seconds, 1e-9)

    @property
    def problems(self) -> list[str]:
        """Return the reasons for a failure, one line each."""
        counts = self.progress.result.counts
        if counts.mismatches:
            stopped = counts.classes < len(self.grid.classes)
            where = f"; stopped after {counts.classes} of {len(self.grid.classes)} classes" if stopped else ""
            return [f"{counts.mismatches} mismatches{where}"]
        return [
            f"the runs at margin {margin} cover {found} ordered pairs of {self.grid.ordered_pairs}"
            for margin, found in zip(MARGINS, counts.ordered, strict=True)
            if found != self.grid.ordered_pairs
        ]


def identity_of(size: int, seed: int) -> Identity:
    """Return what a run of this grid and seed is of, as the checkout stands."""
    return Identity(**vars(validity(SOURCES)), grid=size, seed=seed, config=CONFIGURATION.name)


def run_grid(
    grid: Grid,
    identity: Identity,
    progress: Callable[[int], None] | None = None,
    folder: Path = FOLDER,
    workers: int = WORKERS,
) -> Outcome:
    """Run what is left of the grid, and write the result; ``progress`` is told how many classes were done.

    Where it is interrupted, the state that it leaves in ``folder`` continues the run.
    """
    report, before = progress or (lambda _: None), standing(SOURCES)
    _check_identity(identity)
    # Built here, so that the workers find it.
    _core(grid.size)
    state = load(folder, identity)
    report(state.done)
    known = state.done

    def keep() -> None:
        if before.stands:
            save(folder, identity, state)

    try:
        _run_rest(grid, identity, state, report, keep, workers)
    finally:
        keep()
    before.check()
    outcome = Outcome(identity, grid, state, state.done - known)
    write_result(outcome, folder)
    forget(folder, identity)
    return outcome


def _run_rest(
    grid: Grid,
    identity: Identity,
    state: Progress,
    report: Callable[[int], None],
    keep: Callable[[], None],
    workers: int,
) -> None:
    step = max(1, _RUNS_PER_REPORT // (len(MARGINS) * len(grid.triangles)))
    last = len(grid.classes)
    tasks = [(identity, start, min(start + step, last)) for start in range(state.done, last, step)]
    start, saved = time.monotonic() - state.seconds, time.monotonic()
    with closing(results_in_processes(_check_classes, tasks, workers)) as results:
        for result in results:
            state.result = _sum([state.result, result])
            state.seconds = time.monotonic() - start
            report(result.counts.classes)
            if time.monotonic() - saved > _SECONDS_BETWEEN_SAVES:
                keep()
                saved = time.monotonic()
            if state.result.counts.mismatches >= ENOUGH_MISMATCHES:
                return


def _sum(results: list[ClassResult]) -> ClassResult:
    total = ClassResult()
    for result in results:
        total.counts = total.counts + result.counts
        total.mismatches = (total.mismatches + result.mismatches)[:_KEPT]
    return total


def _core(size: int) -> Core:
    return LockstepEngine(CONFIGURATION) if size >= _LOCKSTEP_FROM else RtlEngine(CONFIGURATION)


# A run, its first class, and the one after its last.
_Task = tuple[Identity, int, int]


@cache
def _checker(identity: Identity) -> Callable[[int], ClassResult]:
    checker = partial(check_class, Grid(identity.grid), _core(identity.grid), bulk_facts, identity.seed)
    _check_identity(identity)
    return checker


def _check_identity(identity: Identity) -> None:
    if identity_of(identity.grid, identity.seed) != identity:
        raise InputError("the RTL, or its environment, changed while the run started: start it again")


def _check_classes(task: _Task) -> ClassResult:
    identity, first, end = task
    return _sum([_checker(identity)(number) for number in range(first, end)])


def result_file(folder: Path, size: int) -> Path:
    """Return where the result of a grid is written."""
    return folder / f"grid{size}.json"


def failing_file(folder: Path, size: int) -> Path:
    """Return where the first failing pairs are written."""
    return folder / f"grid{size}_failing_pairs.npz"


def replay_command(folder: Path, size: int) -> str:
    """Return the command that sends the failing pairs again."""
    path = failing_file(folder, size)
    return f".venv/bin/triaxis sim ReplayTest --config {CONFIGURATION.name} --replay {path}"


def _failure(mismatch: Mismatch) -> Failure:
    return Failure(
        mismatch.message,
        np.array(mismatch.pair, np.int64),
        mismatch.margin,
        np.array(mismatch.context, np.int64).reshape(-1, 2, 3, 3),
        np.array(mismatch.context_margins, np.int64),
    )


def write_result(outcome: Outcome, folder: Path) -> None:
    """Write the result, and the failing pairs where there are any."""
    size, result = outcome.grid.size, outcome.progress.result
    done, wanted = min(result.counts.ordered), outcome.grid.ordered_pairs
    share = "all those" if done == wanted else f"of {wanted:,}"
    failing = failing_file(folder, size)
    failing.unlink(missing_ok=True)
    if result.mismatches:
        write_failing_pairs(failing, [_failure(mismatch) for mismatch in result.mismatches])
    content = {
        "passed": not outcome.problems,
        "problems": outcome.problems,
        "summary": f"{done:,} ordered pairs, {share} on a grid of {size}",
        **asdict(outcome.identity),
        "command": f"triaxis prove exhaustive --grid {size} --seed {outcome.identity.seed}",
        "seconds": round(outcome.progress.seconds, 1),
        "margins": MARGINS,
        "triangles": len(outcome.grid.triangles),
        "classes": len(outcome.grid.classes),
        "ordered_pairs": wanted,
        "counts": asdict(result.counts),
        "mismatches": [
            {"message": mismatch.message, "pair": mismatch.pair, "margin": mismatch.margin}
            for mismatch in result.mismatches
        ],
        "replay": replay_command(folder, size) if result.mismatches else None,
    }
    write_evidence(result_file(folder, size), content, SOURCES)
