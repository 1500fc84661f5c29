"""What a run over the mutants comes to, and where it is kept.

build/mutation/mutation.json is the evidence of the last full run. A sign-off takes it while the RTL and all
that kills mutants are the same, and runs the mutants otherwise.
"""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from triaxis.golden.errors import InputError
from triaxis.sim.build import content_hash, rtl_hash
from triaxis.sim.evidence import Span, read_evidence, write_evidence
from triaxis.sim.paths import DUT
from triaxis.sim.player import ASSERTION
from triaxis.verif.mutation.builds import FOLDER
from triaxis.verif.mutation.equivalence import FILE as EQUIVALENTS
from triaxis.verif.mutation.equivalence import NOTICED, evidence_hash, read_equivalents
from triaxis.verif.mutation.killers import KILLERS, killers_hash
from triaxis.verif.mutation.outcomes import Killed, Outcome
from triaxis.verif.mutation.record import FILE as RECORD

EVIDENCE = FOLDER / "mutation.json"

RUN, BY_ASSERTION, BY_ELABORATION, BY_PROOF = "run", "assertion", "elaboration", "proof"
KILLED, EQUIVALENT, SURVIVING, ABSENT = "killed", "equivalent", "surviving", "not elaborated"


@dataclass(frozen=True)
class Fate:
    """What became of one mutant; where it was killed, by what, in which test and target, and of its trials
    by which (0: as recorded, it was not played), in which stage of the run.
    """

    id: str
    kind: str
    place: str
    original: str
    changed: str
    fate: str
    by: str | None
    test: str | None
    target: str | None
    symptom: str | None
    pairs: int | None
    stage: str | None = None
    trial: int | None = None

    @property
    def file(self) -> str:
        """Return the file, as in dut/core/triaxis_box.sv."""
        return self.place.rpartition(":")[0]

    @property
    def operator(self) -> str:
        """Return the operator."""
        return self.id.split("/")[1]


def kills(fates: Iterable[Fate]) -> dict[str, Killed | None]:
    """Return how mutants were killed, None of those that were not."""
    return {
        one.id: Killed(one.test, one.target, one.symptom, one.pairs or 0, one.stage or "", one.trial or 0)
        if one.test and one.target and one.symptom
        else None
        for one in fates
    }


@dataclass(frozen=True)
class Tally:
    """How many mutants there are of something, and what became of them. ``score``: killed of those that can
    be, in percent, None where none can.
    """

    mutants: int
    by_run: int
    by_assertion: int
    by_elaboration: int
    by_proof: int
    equivalent: int
    surviving: int
    absent: int

    @property
    def killed(self) -> int:
        """Return how many were killed."""
        return self.by_run + self.by_assertion + self.by_elaboration + self.by_proof

    @property
    def score(self) -> float | None:
        """Return the mutation score: those killed, of those that are not equivalent, in percent."""
        possible = self.mutants - self.equivalent
        return 100 * self.killed / possible if possible else None


def tally(fates: Iterable[Fate]) -> Tally:
    """Return the totals of some mutants."""
    counts: Counter[str | None] = Counter()
    for fate in fates:
        counts[fate.by if fate.fate == KILLED else fate.fate] += 1
    return Tally(
        sum(counts.values()), counts[RUN], counts[BY_ASSERTION], counts[BY_ELABORATION],
        counts[BY_PROOF],
        counts[EQUIVALENT], counts[SURVIVING], counts[ABSENT],
    )  # fmt: skip


def grouped(fates: Iterable[Fate], key: str) -> dict[str, Tally]:
    """Return the totals for each value of a property of mutants: "file", "operator" or "kind"."""
    groups: dict[str, list[Fate]] = {}
    for fate in fates:
        groups.setdefault(str(getattr(fate, key)), []).append(fate)
    return {name: tally(groups[name]) for name in sorted(groups)}


def fate_of(outcome: Outcome, equivalent: bool) -> Fate:
    """Return the fate of a mutant that was played, and is listed as equivalent or not."""
    mutant, killed = outcome.mutant, outcome.killed
    fixed = (mutant.id, mutant.kind, mutant.place, mutant.original, mutant.changed)
    if killed is not None:
        by = BY_ASSERTION if killed.symptom == ASSERTION else RUN
        by = killed.test if killed.test in (BY_ELABORATION, BY_PROOF) else by
        return Fate(
            *fixed, KILLED, by, killed.test, killed.target, killed.symptom,
            killed.pairs if by in (RUN, BY_ASSERTION) and killed.trial else None, killed.stage, killed.trial,
        )  # fmt: skip
    fate = EQUIVALENT if equivalent else SURVIVING if outcome.targets else ABSENT
    return Fate(*fixed, fate, None, None, None, None, None)


@dataclass(frozen=True)
class MutationResult:
    """The fates of all mutants of a run, in a fixed order; what is wrong; how long it and its stages took.

    ``rtl_hash``, ``killers_hash``: of what the run began with, so what the fates are of. ``sample``: the seed
    by which ``sampled`` of those that are recorded were drawn, to be played; None where all were;
    ``recorded`` were not played. Of the ``entries`` of equivalent ones ``entries_recorded`` were taken as
    recorded, and those that were checked, in the state of ``evidence_hash``, hold, or not.
    """

    fates: tuple[Fate, ...]
    problems: tuple[str, ...]
    seed: int
    seconds: float
    rtl_hash: str
    killers_hash: str
    stages: tuple[Span, ...] = ()
    sample: int | None = None
    sampled: int = 0
    record_hash: str = ""
    recorded: int = 0
    entries: int = 0
    entries_recorded: int = 0
    evidence_hash: str = ""
    evidence_holds: bool = True

    @property
    def passed(self) -> bool:
        """Return whether every mutant was killed or is shown equivalent, and every entry holds."""
        return not self.problems

    @property
    def summary(self) -> str:
        """Return the outcome in one line."""
        return _summary(self.fates, self.recorded)


def _summary(fates: Iterable[Fate], recorded: int) -> str:
    total = tally(fates)
    score = "no score" if total.score is None else f"score {int(total.score * 100) / 100:.2f} %"
    told = f"; {recorded:,} as recorded" if recorded else ""
    return (
        f"{total.mutants:,} mutants: {total.killed:,} killed, {total.equivalent} equivalent, "
        f"{total.surviving + total.absent} surviving; {score}{told}"
    )


def _counts(fates: Sequence[Fate], recorded: int) -> dict[str, Any]:
    """Return all that a file says of the fates together, of which so many were not played."""
    return {
        "summary": _summary(fates, recorded),
        "total": _row(tally(fates)),
        "kinds": _tallies(fates, "kind"),
        "files": _tallies(fates, "file"),
        "operators": _tallies(fates, "operator"),
    }


def _tallies(fates: Iterable[Fate], key: str) -> dict[str, dict[str, Any]]:
    return {name: _row(row) for name, row in grouped(fates, key).items()}


def _row(row: Tally) -> dict[str, Any]:
    return {**asdict(row), "killed": row.killed, "score": row.score}


def _content(result: MutationResult, command: str) -> dict[str, Any]:
    return {
        "passed": result.passed,
        "problems": list(result.problems),
        "command": command,
        "seconds": round(result.seconds, 1),
        "finished": datetime.now(UTC).isoformat(timespec="seconds"),
        "seed": result.seed,
        "rtl_hash": result.rtl_hash,
        "killers_hash": result.killers_hash,
        "sample": result.sample,
        "sampled": result.sampled,
        "record_hash": result.record_hash,
        "evidence_hash": result.evidence_hash,
        "recorded": result.recorded,
        "entries": result.entries,
        "entries_recorded": result.entries_recorded,
        "stages": [asdict(stage) for stage in result.stages],
        **_counts(result.fates, result.recorded),
        "mutants": [asdict(fate) for fate in result.fates],
    }


def write_result(result: MutationResult, command: str, path: Path = EVIDENCE) -> Path:
    """Write the evidence of a full run."""
    return write_evidence(path, _content(result, command), KILLERS)


def known_result(sample: int | None = None, evidence: Path = EVIDENCE) -> dict[str, Any] | None:
    """Return the last full result in build/, if it is of this RTL and of what kills its mutants today.

    One for which all were played, or, where a ``sample`` is enough, that one with today's record. None where
    there is none. Raises InputError where the file is damaged.
    """
    content = read_evidence(evidence)
    names = ("rtl_hash", "killers_hash", "evidence_hash")
    now = [rtl_hash(), killers_hash(), evidence_hash(DUT)]
    if not content or [content.get(name) for name in names] != now:
        return None
    wanted = (sample, content_hash([RECORD]))
    played = content.get("sample", sample) is None
    return content if played or (content.get("sample"), content.get("record_hash")) == wanted else None


def fates_in(content: Mapping[str, Any], equivalents: Path = EQUIVALENTS) -> list[Fate]:
    """Return the fates of the mutants in a result that was written.

    Raises InputError where one is not whole, where they contradict the list of equivalent mutants, or where
    the file's counts are not theirs.
    """
    try:
        fates = [Fate(**mutant) for mutant in content["mutants"]]
        listed = {name: one.evidence for one in read_equivalents(equivalents) for name in one.mutants}
        wrong = next(filter(None, (_contradiction(fate, listed) for fate in fates)), None)
        wrong = wrong or _miscount(content, fates)
    except (KeyError, TypeError, AttributeError, IndexError) as error:
        raise InputError(f"mutation result: damaged: {error!r}: run `make mutate`") from error
    if wrong:
        raise InputError(f"mutation result: {wrong}: run `make mutate`")
    return fates


def _contradiction(fate: Fate, listed: Mapping[str, str]) -> str | None:
    """Return what is wrong with a fate, by the evidence of those listed; None where nothing is."""
    if fate.fate not in (KILLED, EQUIVALENT, SURVIVING, ABSENT):
        return f"{fate.id}: no such fate: {fate.fate}"
    if fate.fate == EQUIVALENT and listed.get(fate.id, NOTICED) == NOTICED:
        return f"{fate.id}: equivalent, but not listed as such"
    if fate.fate != KILLED:
        return None
    if fate.id in listed and fate.by != BY_PROOF:
        return f"{fate.id}: killed, but listed as equivalent"
    if fate.by == BY_PROOF and listed.get(fate.id) != NOTICED:
        return f"{fate.id}: killed by a proof, but not listed as such"
    if fate.by not in (RUN, BY_ASSERTION, BY_ELABORATION, BY_PROOF):
        return f"{fate.id}: killed, but by nothing that is known: {fate.by}"
    missing = [name for name in ("test", "target", "symptom") if not getattr(fate, name)]
    return f"{fate.id}: killed, but without {', '.join(missing)}" if missing else None


def _miscount(content: Mapping[str, Any], fates: Sequence[Fate]) -> str | None:
    """Return what the file says of all fates that they do not bear out, None where there is nothing."""
    wrong = [
        name for name, counted in _counts(fates, content["recorded"]).items() if content[name] != counted
    ]
    if wrong:
        return f"{', '.join(wrong)}: not the sum over its mutants"
    if content["recorded"] < sum(fate.trial == 0 for fate in fates):
        return "recorded: fewer than say so themselves"
    lives = any(fate.fate in (SURVIVING, ABSENT) for fate in fates)
    return "passed, with mutants that survive" if content["passed"] and lives else None
