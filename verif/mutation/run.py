"""A run over the mutants: play them, check the list of equivalent ones, say what is wrong."""

import time
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor, wait
from dataclasses import replace
from pathlib import Path
from threading import Event

from triaxis.golden.native import written
from triaxis.sim.build import content_hash, rtl_files, rtl_hash
from triaxis.sim.evidence import Timeline
from triaxis.sim.paths import DUT
from triaxis.verif.mutation import outcomes
from triaxis.verif.mutation.builds import sweep
from triaxis.verif.mutation.catalogue import Catalogue, catalogue
from triaxis.verif.mutation.equivalence import (
    EXHAUSTIVE,
    FILE,
    NOTICED,
    PROVERS,
    Evidence,
    check_equivalents,
    evidence_hash,
    forget_proofs,
    read_equivalents,
)
from triaxis.verif.mutation.judging import judge
from triaxis.verif.mutation.killers import BLOCKS, KILLERS, OUTCOMES, killers_hash, states
from triaxis.verif.mutation.outcomes import Killed, Outcome, Store
from triaxis.verif.mutation.record import FILE as RECORD
from triaxis.verif.mutation.record import drawn, read_record
from triaxis.verif.mutation.result import ABSENT, BY_PROOF, SURVIVING, Fate, MutationResult, fate_of
from triaxis.verif.mutation.targets import TARGETS, AnyTarget

# Of the record's states: that in which all evidence of equivalence was checked and held.
EVIDENCE = "evidence"
_WHOLE = "whole"
CHANGED = "the RTL, or what plays its mutants, changed during the run: run again"


def mutate(
    seed: int = 1,
    jobs: int = 2,
    fresh: bool = False,
    dut: Path = DUT,
    targets: tuple[AnyTarget, ...] = TARGETS,
    equivalents: Path = FILE,
    with_volume: bool = True,
    progress: Callable[[int], None] = lambda _: None,
    chosen: Catalogue | None = None,
    sample: int | None = None,
    all_evidence: bool = False,
) -> MutationResult:
    """Return what becomes of the mutants of dut/, or of those that are chosen.

    ``fresh``: do everything again, whatever is known from earlier runs. ``sample``: take what is recorded,
    but for those mutants, and entries of equivalent ones, that this seed draws; of mutants whose evidence
    says more than any test, none. ``all_evidence``: of all mutants that are listed, whichever are played.
    Raises InputError where the RTL without mutants fails.
    """
    start, timeline, begun = time.perf_counter(), Timeline(), _state(dut)
    rtl, killers, proofs_of = rtl_hash(dut), killers_hash(), evidence_hash(dut)
    record_hash = content_hash([RECORD])
    sweep()
    everything = catalogue(dut)
    found = chosen or everything
    entries = read_equivalents(equivalents)
    if fresh:
        forget_proofs()
    listed = {name: entry for entry in entries for name in entry.mutants if name in found.by_id}
    # The smallest widths alone say too little: what only they show is tried in volume as well.
    in_volume = {name for entry in entries if entry.evidence == EXHAUSTIVE for name in entry.mutants}
    excused = frozenset(listed.keys() - in_volume)
    held = read_record().states.get(EVIDENCE) == proofs_of
    recorded = _recorded(found, frozenset(listed) if held else excused, dut)
    sampled, settled = frozenset[str](), dict[str, Killed | None]()
    again: frozenset[str] | None = None
    if sample is not None:
        sampled = sample_of((name for name, how in recorded.items() if how or name not in excused), sample)
        settled = _settled(recorded, sampled, found, dut, seed)
        if held:
            again = sample_of((entry.mutants[0] for entry in entries), sample)
    ended = Event()

    def prove() -> Evidence:
        with timeline.span("evidence of equivalence"):
            return check_equivalents(
                entries, (everything if all_evidence else found).by_id, everything.by_id, jobs, dut, ended,
                None if again is None else again.__contains__,
            )  # fmt: skip

    # One proof may take longer than all trials: beside them.
    with ThreadPoolExecutor(1) as beside:
        proofs = beside.submit(prove)
        try:
            judged = judge(
                found, seed, jobs, timeline, excused, dut, targets, fresh, with_volume, progress,
                read_record().places(found.mutants), settled,
            )  # fmt: skip
            evidence = proofs.result()
        except BaseException:
            ended.set()
            raise
        finally:
            # Of what is proved, too: no longer than until its last proof has ended.
            wait([proofs])
            touched = _forget_touched(begun, _state(dut))
    killed = {one.mutant.id: one.killed for one in judged}
    fates = tuple(_fate(outcome, evidence) for outcome in judged)
    problems = [
        *(_survivor(fate) for fate in fates if fate.fate in (SURVIVING, ABSENT)),
        *(
            _refuted(outcome)
            for outcome in judged
            if outcome.killed and outcome.mutant.id in evidence.equivalent
        ),
        *evidence.problems,
        *(
            f"{name}: {how.test} noticed it, as is recorded, and nothing does now: the record is wrong: run "
            "`triaxis prove mutate --record`"
            for name, how in recorded.items()
            if how and killed[name] is None
        ),
    ]
    now = rtl_hash(dut), killers_hash(), evidence_hash(dut), content_hash([RECORD])
    if touched or now != (rtl, killers, proofs_of, record_hash):
        problems.append(CHANGED)
    seconds = time.perf_counter() - start
    spans = tuple(timeline.spans)
    return MutationResult(
        fates, tuple(problems), seed, seconds, rtl, killers, spans,
        sample, len(sampled), record_hash, len(settled), evidence.entries, evidence.recorded, proofs_of,
        not evidence.problems and (held or listed.keys() >= in_volume),
    )  # fmt: skip


def sample_of(recorded: Iterable[str], seed: int) -> frozenset[str]:
    """Return what a seed draws of what is recorded: one at least, where there is any."""
    names = sorted(recorded)
    found = frozenset(name for name in names if drawn(name, seed))
    return found or frozenset(names[seed % len(names)] for _ in names[:1])


def _recorded(found: Catalogue, equivalent: frozenset[str], dut: Path) -> dict[str, Killed | None]:
    """Return how mutants were killed that are recorded of this state.

    None of those that are ``equivalent``: that no test noticed them is part of the record, too.
    """
    record, now = read_record(), states(dut)
    blocks = {block for block, state in now.items() if record.states.get(block) == state}
    lives = {one.id: None for one in found.mutants if one.id in equivalent and one.block in blocks}
    return lives | record.killed(found.mutants, now)


def _settled(
    recorded: Mapping[str, Killed | None], sampled: frozenset[str], found: Catalogue, dut: Path, seed: int
) -> dict[str, Killed | None]:
    """Return those that are not played: recorded, not in the sample, nor known here to survive.

    What is known here of the sample is forgotten, so that it is played.
    """
    store = Store(found, dut, seed, False)
    for name in sampled:
        store.killed.pop(name, None)
        store.surviving.discard(name)
        store.excused.discard(name)
    store.save()
    return {name: how for name, how in recorded.items() if name not in sampled | store.surviving}


def _state(dut: Path) -> dict[str, list[object]]:
    """Return how the files stand that decide outcomes, by block, and those that decide a run as a whole."""
    rtl = rtl_files(dut)
    files = {
        block: [
            *(path for path in rtl if path.relative_to(dut).parts[0] in BLOCKS[:number]),
            *OUTCOMES[block].files(),
        ]
        for number, block in enumerate(BLOCKS, 1)
    }
    files[_WHOLE] = [*rtl, *KILLERS.files(), *PROVERS.files(), RECORD]
    return {what: [*paths, *written(paths)] for what, paths in files.items()}


def _forget_touched(before: Mapping[str, object], after: Mapping[str, object]) -> bool:
    """Forget what became of mutants of blocks of which something was written in between, and what was proved
    with it; return whether anything was.

    It may be again what it was before: then no hash tells that mutants were tried on something else.
    """
    touched = {what for what, state in before.items() if after[what] != state}
    for block in touched - {_WHOLE}:
        for path in outcomes.FOLDER.glob(f"outcomes-{block}-*.json"):
            path.unlink()
    if touched:
        forget_proofs()
    return bool(touched)


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
