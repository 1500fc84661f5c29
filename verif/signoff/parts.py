"""The parts of a sign-off: each leaves evidence, or the reason why it has none."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from triaxis.golden.errors import InputError
from triaxis.golden.judge import CertificateError
from triaxis.sim.core_engine import CoreError
from triaxis.sim.evidence import read_evidence
from triaxis.sim.validity import validity
from triaxis.verif.code_coverage import run as code_coverage
from triaxis.verif.exhaustive.grid import Grid
from triaxis.verif.exhaustive.run import identity_of, result_file, run_grid
from triaxis.verif.faults import catching as faults
from triaxis.verif.faults.result import write_json
from triaxis.verif.formal import proving as formal
from triaxis.verif.mutation.catalogue import mutant_names
from triaxis.verif.mutation.equivalence import Equivalent, read_equivalents
from triaxis.verif.mutation.result import (
    EQUIVALENT,
    KILLED,
    Fate,
    fates_in,
    grouped,
    known_result,
    write_result,
)
from triaxis.verif.mutation.run import mutate
from triaxis.verif.netlist import result as netlist
from triaxis.verif.regress import four_state
from triaxis.verif.signoff.plan import FOLDER

# Points along each coordinate; `make exhaustive` does a larger grid in minutes.
GRID = 3

# Results of commands of their own, which a sign-off shows where they are of its RTL and environment: where
# each is, what it comes from, which command makes it.
_BESIDE = {
    "four_state": (four_state.RESULT, four_state.SOURCES, "make four-state"),
    "netlist": (netlist.RESULT, netlist.SOURCES, "make netlist"),
}

Progress = Callable[[int], None]
Evidence = dict[str, Any]


@dataclass(frozen=True)
class Part:
    """What a part found, or why it found nothing: then it is absent, and the sign-off fails."""

    evidence: Evidence | None
    absent: str | None = None

    @property
    def as_json(self) -> dict[str, Any]:
        """Return the part as it stands in the file."""
        return {"absent": self.absent, **(self.evidence or {})}


def attempt(make: Callable[[], Evidence | None]) -> Part:
    """Return the part that ``make`` finds; what ends it early makes it absent, and the verdict red."""
    try:
        evidence = make()
    except (InputError, CoreError, CertificateError, OSError) as error:
        return Part(None, f"{type(error).__name__}: {error}" if isinstance(error, OSError) else str(error))
    return Part(evidence, None if evidence else "it left no result")


def results_beside() -> dict[str, Part]:
    """Return what other commands left in build/ for this RTL and this environment."""
    found: dict[str, Part] = {}
    for name, (path, sources, command) in _BESIDE.items():
        part = attempt(lambda path=path: read_evidence(path))
        here, evidence = validity(sources), part.evidence
        if evidence is None:
            part = Part(None, f"run `{command}`")
        elif (evidence["rtl_hash"], evidence.get("environment_hash")) != (
            here.rtl_hash,
            here.environment_hash,
        ):
            part = Part(None, f"what is in build/ is of another RTL or environment: run `{command}`")
        found[name] = part
    return found


def code_coverage_part(seed: int, progress: Progress) -> Evidence | None:
    """Measure code coverage."""
    return read_evidence(code_coverage.write_json(code_coverage.measure(seed, progress=progress), seed))


def exhaustive_part(seed: int) -> Evidence | None:
    """Run every ordered pair on a small grid."""
    folder = FOLDER / "exhaustive"
    run_grid(Grid(GRID), identity_of(GRID, seed), folder=folder)
    return read_evidence(result_file(folder, GRID))


def faults_part(seed: int, progress: Progress) -> Evidence | None:
    """Let every fault of the catalogue be caught."""
    return read_evidence(write_json(faults.catch_all(progress, seed)))


def proofs_part(progress: Progress) -> Evidence | None:
    """Prove everything."""
    result = formal.prove_all(progress, folder=FOLDER / "formal")
    return read_evidence(formal.write_result(result, "triaxis prove formal"))


def mutation_part(seed: int, progress: Progress) -> Evidence | None:
    """Run the mutants, unless a full result of this RTL and of what kills them is there; count its totals.

    Raises InputError where it is of other mutants than today's generator makes.
    """
    content = known_result()
    known = content is not None
    if content is None:
        found = mutate(seed, progress=progress)
        content = read_evidence(write_result(found, f"triaxis prove mutate --seed {seed}"))
        assert content is not None
    else:
        progress(len(content["mutants"]))
    fates = fates_in(content)
    if sorted(fate.id for fate in fates) != sorted(mutant_names()):
        raise InputError("the result in build/mutation/ is of other mutants than today's: run `make mutate`")
    reasons = {name: entry for entry in read_equivalents() for name in entry.mutants}
    kept = ("passed", "problems", "summary", "command", "seconds", "rtl_hash", "killers_hash", "seed")
    return {
        **{key: content[key] for key in kept},
        # In seconds since the part began: those of an earlier run are none of this one.
        "stages": [] if known else content["stages"],
        "files": _totals(fates, "file"),
        "operators": _totals(fates, "operator"),
        "killed": [fate.id for fate in fates if fate.fate == KILLED],
        "survivors": [
            {"id": fate.id, "place": fate.place, "original": fate.original, "changed": fate.changed}
            for fate in fates
            if fate.fate not in (KILLED, EQUIVALENT)
        ],
        "equivalents": [_equivalent(fate, reasons) for fate in fates if fate.fate == EQUIVALENT],
    }


def _totals(fates: Sequence[Fate], key: str) -> dict[str, dict[str, int]]:
    return {
        name: {
            "mutants": row.mutants,
            "killed": row.killed,
            "equivalent": row.equivalent,
            "surviving": row.surviving + row.absent,
        }
        for name, row in grouped(fates, key).items()
    }


def _equivalent(fate: Fate, reasons: Mapping[str, Equivalent]) -> Evidence:
    """Return an equivalent mutant with its evidence; raise InputError where it is listed no more."""
    entry = reasons.get(fate.id)
    if entry is None:
        raise InputError(f"mutant {fate.id}: no longer listed as equivalent: run `make mutate`")
    proved = f"{entry.evidence}: {entry.proves}"
    return {"id": fate.id, "place": fate.place, "reason": entry.reason, "evidence": proved}
