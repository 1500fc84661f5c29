"""A run over the mutants: play them, check the list of equivalent ones, say what is wrong."""

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from triaxis.sim.build import rtl_hash
from triaxis.sim.evidence import Timeline
from triaxis.sim.paths import DUT
from triaxis.verif.mutation.builds import sweep
from triaxis.verif.mutation.catalogue import Catalogue, catalogue
from triaxis.verif.mutation.equivalence import (
    EXHAUSTIVE,
    FILE,
    NOTICED,
    Evidence,
    check_equivalents,
    forget_proofs,
    read_equivalents,
)
from triaxis.verif.mutation.judging import judge
from triaxis.verif.mutation.killers import killers_hash
from triaxis.verif.mutation.outcomes import Killed, Outcome
from triaxis.verif.mutation.result import ABSENT, BY_PROOF, SURVIVING, Fate, MutationResult, fate_of
from triaxis.verif.mutation.targets import TARGETS, AnyTarget


def mutate(
    seed: int = 1,
    files: str | None = None,
    names: str | None = None,
    jobs: int = 2,
    fresh: bool = False,
    dut: Path = DUT,
    targets: tuple[AnyTarget, ...] = TARGETS,
    equivalents: Path = FILE,
    with_volume: bool = True,
    progress: Callable[[int], None] = lambda _: None,
    chosen: Catalogue | None = None,
) -> MutationResult:
    """Return what becomes of the mutants of dut/, or of those whose file and name match.

    ``fresh``: do everything again, whatever is known from
    earlier runs. Raises InputError where the RTL without mutants fails.
    """
    start, timeline = time.perf_counter(), Timeline()
    rtl, killers = rtl_hash(dut), killers_hash()
    sweep()
    everything = catalogue(dut)
    found = chosen or (everything.restricted(files, names) if files or names else everything)
    entries = read_equivalents(equivalents)
    if fresh:
        forget_proofs()
    with timeline.span("evidence of equivalence"):
        evidence = check_equivalents(entries, found.by_id, everything.by_id, jobs, dut)
    # The smallest widths alone say too little: what only they show is tried in volume as well.
    excused = frozenset(name for name, entry in evidence.equivalent.items() if entry.evidence != EXHAUSTIVE)
    outcomes = judge(found, seed, jobs, timeline, excused, dut, targets, fresh, with_volume, progress)
    fates = tuple(_fate(outcome, evidence) for outcome in outcomes)
    problems = [
        *(_survivor(fate) for fate in fates if fate.fate in (SURVIVING, ABSENT)),
        *(
            _refuted(outcome)
            for outcome in outcomes
            if outcome.killed and outcome.mutant.id in evidence.equivalent
        ),
        *evidence.problems,
    ]
    if (rtl_hash(dut), killers_hash()) != (rtl, killers):
        problems.append("the RTL, or what plays its mutants, changed during the run: run again")
    seconds = time.perf_counter() - start
    return MutationResult(fates, tuple(problems), seed, seconds, rtl, killers, tuple(timeline.spans))


def _fate(outcome: Outcome, evidence: Evidence) -> Fate:
    name = outcome.mutant.id
    entry = evidence.equivalent.get(name)
    if entry and entry.evidence == NOTICED and not outcome.killed:
        outcome = replace(outcome, killed=Killed(BY_PROOF, entry.module, "a proof that fails", 0))
    return fate_of(outcome, entry is not None)


def _survivor(fate: Fate) -> str:
    what = "survives" if fate.fate == SURVIVING else "is in none of the configurations that are played"
    return (
        f"{fate.id} {what}: {fate.place}: {fate.original} -> {fate.changed} "
        f"(replay: triaxis prove mutate --mutant {fate.id})"
    )


def _refuted(outcome: Outcome) -> str:
    assert outcome.killed is not None
    killed = outcome.killed
    return (
        f"{outcome.mutant.id}: listed as equivalent, but {killed.test} kills it in {killed.target} "
        f"({killed.symptom}): delete it from {FILE.name}"
    )
