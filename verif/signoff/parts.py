"""The parts of a sign-off: each leaves evidence, or the reason why it has none."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from triaxis.golden.errors import InputError
from triaxis.golden.judge import CertificateError
from triaxis.sim.build import rtl_hash
from triaxis.sim.core_engine import CoreError
from triaxis.sim.evidence import read_evidence
from triaxis.sim.programs import yosys_version
from triaxis.sim.simulators import icarus_installed, icarus_version
from triaxis.sim.validity import Sources, validity
from triaxis.verif.code_coverage import run as code_coverage
from triaxis.verif.exhaustive.grid import Grid
from triaxis.verif.exhaustive.run import identity_of, result_file, run_grid
from triaxis.verif.faults import catching as faults
from triaxis.verif.faults.result import write_json
from triaxis.verif.formal import proving as formal
from triaxis.verif.lint import lint_rtl, rtl_linters
from triaxis.verif.mutation.catalogue import mutant_names
from triaxis.verif.mutation.equivalence import Equivalent, read_equivalents
from triaxis.verif.mutation.record import SEED
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
from triaxis.verif.netlist.gates import SCOPES
from triaxis.verif.netlist.module_proofs import PROOFS
from triaxis.verif.regress import four_state
from triaxis.verif.signoff.plan import FOLDER

# Points along each coordinate; `make exhaustive` does a larger grid in minutes.
GRID = 3

Progress = Callable[[int], None]
Evidence = dict[str, Any]


def _make_four_state(seed: int, progress: Progress) -> Path:
    result = four_state.run_four_state(seed, progress)
    return four_state.write_result(result, f"triaxis regress four-state --seed {seed}")


def _make_netlist(seed: int, progress: Progress) -> Path:
    return netlist.write_result(netlist.check_all(seed, progress), f"triaxis prove netlist --seed {seed}")


@dataclass(frozen=True)
class Beside:
    """A result of a command of its own: where it is, what it comes from, and how it is made."""

    path: Path
    sources: Sources
    command: str
    make: Callable[[int, Progress], Path]
    steps: Callable[[int], int]


# A sign-off shows them where they are of its RTL and environment; one as a whole makes them first.
_BESIDE = {
    "four_state": Beside(
        four_state.RESULT,
        four_state.SOURCES,
        "make four-state",
        _make_four_state,
        lambda seed: len(four_state.plan(seed)),
    ),
    "netlist": Beside(
        netlist.RESULT, netlist.SOURCES, "make netlist", _make_netlist, lambda _: len(SCOPES) + len(PROOFS)
    ),
}


@dataclass(frozen=True)
class Part:
    """What a part found, or why it found nothing: then it is absent, and the sign-off fails."""

    evidence: Evidence | None
    absent: str | None = None

    @property
    def state(self) -> str:
        """Return the verdict on it, as people read it."""
        if self.evidence is None:
            return "not measured"
        return "passed" if self.evidence["passed"] else "FAILED"

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
    for name, one in _BESIDE.items():
        part = attempt(lambda one=one: read_evidence(one.path))
        here, evidence = vars(validity(one.sources)), part.evidence
        if evidence is None:
            part = Part(None, f"run `{one.command}`")
        elif any(evidence.get(name) != value for name, value in {**here, **_tools(evidence)}.items()):
            part = Part(
                None, f"what is in build/ is of another RTL, environment or tool: run `{one.command}`"
            )
        found[name] = part
    return found


def _tools(evidence: Evidence) -> dict[str, str]:
    """Return what names the tools in a result, as today's would be: as nothing where one is absent."""
    names = [name for name in ("synthesiser", "elaborated_by") if name in evidence]
    try:
        found = {name: yosys_version() for name in names}
    except InputError:
        found = dict.fromkeys(names, "")
    if "simulator" in evidence:
        found["simulator"] = icarus_version() if icarus_installed() else ""
    return found


def make_beside(seed: int, progress: Progress) -> dict[str, Part]:
    """Return the same, and make first what is not there; the reason why it cannot be is that of its tool."""
    found = results_beside()
    for name, one in _BESIDE.items():
        if found[name].evidence is None:
            found[name] = attempt(lambda one=one: read_evidence(one.make(seed, progress)))
        else:
            progress(one.steps(seed))
    return found


def beside_steps(seed: int) -> int:
    """Return how many steps these have."""
    return sum(one.steps(seed) for one in _BESIDE.values())


def lint_part() -> Evidence:
    """Lint the RTL, as every build elaborates it, and the SystemVerilog around it."""
    start, before = time.monotonic(), rtl_hash()
    linters = lint_rtl(rtl_linters())
    # What several builds warn of is one finding, told of the first.
    found = {line: what for what, lines in reversed(linters.items()) for line in reversed(lines)}
    problems = [f"{what}: {line}" for line, what in reversed(found.items())]
    return {
        "passed": bool(linters) and not problems,
        "problems": problems,
        "summary": f"{len(problems)} findings in {len(linters)} runs of linters",
        "command": "make lint",
        "seconds": round(time.monotonic() - start, 1),
        "rtl_hash": before,
        "findings": len(problems),
        "linters": linters,
    }


def code_coverage_part(seed: int, progress: Progress) -> Evidence | None:
    """Measure code coverage."""
    return read_evidence(code_coverage.write_json(code_coverage.measure(seed, progress=progress), seed))


def exhaustive_part(seed: int) -> Evidence | None:
    """Run every ordered pair on a small grid."""
    folder = FOLDER / "exhaustive"
    run_grid(Grid(GRID), identity_of(GRID, seed), folder=folder)
    return read_evidence(result_file(folder, GRID))


def faults_part(seed: int, progress: Progress) -> Evidence | None:
    """Let every fault that a sign-off asks for be caught."""
    return read_evidence(write_json(faults.catch_all(progress, seed)))


def proofs_part(progress: Progress) -> Evidence | None:
    """Prove everything."""
    result = formal.prove_all(progress, folder=FOLDER / "formal")
    return read_evidence(formal.write_result(result, "triaxis prove formal"))


def mutation_part(seed: int, progress: Progress, whole: bool = False) -> Evidence | None:
    """Run the mutants, unless a result of this RTL and of what kills them is there; count its totals.

    ``whole``: each is played; else those that are recorded are taken from there, but for a sample. Raises
    InputError where the result is of other mutants than today's generator makes.
    """
    sample = None if whole else seed
    content = known_result(sample)
    known = content is not None
    if content is None:
        found = mutate(SEED, progress=progress, sample=sample)
        told = "" if whole else f" --sample {seed}"
        content = read_evidence(write_result(found, f"triaxis prove mutate --seed {SEED}{told}"))
        assert content is not None
    else:
        progress(len(content["mutants"]))
    fates = fates_in(content)
    if sorted(fate.id for fate in fates) != sorted(mutant_names()):
        raise InputError("the result in build/mutation/ is of other mutants than today's: run `make mutate`")
    reasons = {name: entry for entry in read_equivalents() for name in entry.mutants}
    kept = (
        "passed",
        "problems",
        "summary",
        "command",
        "seconds",
        "rtl_hash",
        "killers_hash",
        "seed",
        "sample",
        "sampled",
        "recorded",
        "entries",
        "entries_recorded",
    )
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
