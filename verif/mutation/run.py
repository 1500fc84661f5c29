"""A run over the mutants: play them, check the list of equivalent ones, say what is wrong."""

import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
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
from triaxis.verif.mutation.killers import killers_hash, states
from triaxis.verif.mutation.outcomes import Killed, Outcome
from triaxis.verif.mutation.record import Record, drawn, read_record
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
    sample: int | None = None,
) -> MutationResult:
    """Return what becomes of the mutants of dut/, or of those whose file and name match.

    ``fresh``: do everything again, whatever is known from earlier runs. ``sample``: take what is recorded,
    but for those that this seed draws. Raises InputError where the RTL without mutants fails.
    """
    start, timeline = time.perf_counter(), Timeline()
    rtl, killers = rtl_hash(dut), killers_hash()
    sweep()
    everything = catalogue(dut)
    found = chosen or (everything.restricted(files, names) if files or names else everything)
    entries = read_equivalents(equivalents)
    if fresh:
        forget_proofs()
    listed = {name: entry for entry in entries for name in entry.mutants if name in found.by_id}
    # The smallest widths alone say too little: what only they show is tried in volume as well.
    excused = frozenset(name for name, entry in listed.items() if entry.evidence != EXHAUSTIVE)
    record = read_record()
    again, settled = _taken(record, found, excused, dut, sample)
    order = record.places(found.mutants)

    def prove() -> Evidence:
        with timeline.span("evidence of equivalence"):
            return check_equivalents(entries, found.by_id, everything.by_id, 1, dut)

    # One proof may take longer than all trials: beside them.
    with ThreadPoolExecutor(1) as beside:
        proofs = beside.submit(prove)
        outcomes = judge(
            found, seed, jobs, timeline, excused, dut, targets, fresh, with_volume, progress, order, settled
        )
        evidence = proofs.result()
    killed = {one.mutant.id: one.killed for one in outcomes}
    fates = tuple(_fate(outcome, evidence) for outcome in outcomes)
    problems = [
        *(_survivor(fate) for fate in fates if fate.fate in (SURVIVING, ABSENT)),
        *(
            _refuted(outcome)
            for outcome in outcomes
            if outcome.killed and outcome.mutant.id in evidence.equivalent
        ),
        *evidence.problems,
        *(
            f"{name}: {how.test} does not notice it in {how.stage} now: what is recorded is wrong: run "
            "`triaxis prove mutate --record`"
            for name, how in again.items()
            if not _is_as_recorded(killed[name], how)
        ),
    ]
    if (rtl_hash(dut), killers_hash()) != (rtl, killers):
        problems.append("the RTL, or what plays its mutants, changed during the run: run again")
    seconds = time.perf_counter() - start
    spans = tuple(timeline.spans)
    return MutationResult(fates, tuple(problems), seed, seconds, rtl, killers, spans, len(again))


def _taken(
    record: Record, found: Catalogue, excused: frozenset[str], dut: Path, sample: int | None
) -> tuple[dict[str, Killed], dict[str, Killed | None]]:
    """Return how those mutants were killed that are recorded and played again; and those that are not played.

    Of those that are shown to be equivalent the evidence is checked again, and that no test noticed them is
    part of the record (None).
    """
    if sample is None:
        return {}, {}
    now = states(dut)
    blocks = {block for block, state in now.items() if record.states.get(block) == state}
    of_record: dict[str, Killed | None] = {
        one.id: None for one in found.mutants if one.id in excused and one.block in blocks
    }
    of_record |= record.killed(found.mutants, now)
    again = {name: how for name, how in of_record.items() if drawn(name, sample)}
    return {name: how for name, how in again.items() if how}, {
        name: how for name, how in of_record.items() if name not in again
    }


def _is_as_recorded(killed: Killed | None, how: Killed) -> bool:
    return killed is not None and (killed.stage, killed.test) == (how.stage, how.test)


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
