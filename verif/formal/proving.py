"""All proofs, some at a time, and the file that keeps what came of them."""

import fnmatch
import os
import time
from collections.abc import Callable, Sequence
from concurrent.futures import as_completed
from dataclasses import asdict, dataclass
from pathlib import Path

from filelock import FileLock

from triaxis.golden.errors import InputError
from triaxis.golden.outputs import make_folder
from triaxis.golden.processes import threads
from triaxis.sim.evidence import write_evidence
from triaxis.sim.paths import BUILD, DUT, ROOT
from triaxis.sim.validity import Provenance, Sources, standing
from triaxis.verif.formal.cone import UNPROVED_FILE, Covered, all_registers, by_modules, read_unproved
from triaxis.verif.formal.proof import Outcome, Proof, Result, require_tools
from triaxis.verif.formal.proofs import proofs

FOLDER = BUILD / "formal"
RESULT = FOLDER / "formal.json"
SOURCES = Sources(
    ("triaxis.verif.formal.proving",),
    (str(UNPROVED_FILE.relative_to(ROOT)),),
)


@dataclass(frozen=True)
class FormalResult:
    """What came of some or all proofs."""

    outcomes: tuple[Outcome, ...]
    complete: bool
    seconds: float
    valid_for: Provenance
    changed: bool = False
    # None where only some proofs were run; in place of it, why no register is known.
    registers: Covered | str | None = None

    @property
    def problems(self) -> list[str]:
        """Return what is not proved, one line each."""
        findings = [outcome.finding for outcome in self.outcomes]
        found = [problem for finding in findings for problem in finding.problems]
        found += [f"not decided: {reason}" for finding in findings for reason in finding.undecided]
        if isinstance(self.registers, str):
            found.append(f"not decided: registers: {self.registers}")
        elif self.registers:
            found += self.registers.problems
        return [*found, "the RTL or its proofs changed meanwhile"] if self.changed else found

    @property
    def exceptions(self) -> list[str]:
        """Return which proofs could not be tried here, a line each: no failure, and no proof."""
        absent = ((outcome.proof.name, outcome.finding.absent) for outcome in self.outcomes)
        return [f"{name}: {Result.ABSENT}: {reason}" for name, reason in absent if reason is not None]

    @property
    def proved(self) -> int:
        """Return how many proofs hold."""
        return sum(outcome.passed for outcome in self.outcomes)

    @property
    def passed(self) -> bool:
        """Return whether everything that could be tried is proved, and something was."""
        return self.proved > 0 and not self.problems

    @property
    def summary(self) -> str:
        """Return the result in a line."""
        open_ = f", {self.undecided} not decided" if self.undecided else ""
        open_ += f", {len(self.exceptions)} {Result.ABSENT}" if self.exceptions else ""
        return f"{self.proved} of {len(self.outcomes)} proofs hold{open_}, in {self.seconds:.0f} s"

    @property
    def undecided(self) -> int:
        """Return how many proofs came to no end."""
        return sum(outcome.finding.result is Result.UNDECIDED for outcome in self.outcomes)


def proof_names() -> list[str]:
    """Return the names of all proofs."""
    return [proof.name for proof in proofs()]


def prove_all(
    progress: Callable[[int], None], dut: Path = DUT, only: str = "*", jobs: int = 2, folder: Path = FOLDER
) -> FormalResult:
    """Run the proofs whose names match ``only``, ``jobs`` at a time; raise InputError where none does.

    ``dut`` may be another folder of RTL with the same files. ``folder`` takes logs, and traces of what fails.
    """
    require_tools()
    chosen = [proof for proof in proofs() if fnmatch.fnmatchcase(proof.name, only)]
    if not chosen:
        raise InputError(f"proof {only}: no such proof: choose of {', '.join(proof_names())}")
    if jobs < 1:
        raise InputError(f"jobs {jobs}: must be at least 1")
    outcomes: dict[str, Outcome] = {}
    # Before it waits: what is loaded here is of now.
    before = standing(SOURCES, dut)
    make_folder(folder)
    # Another run in the same folder is waited for.
    with FileLock(folder / ".lock"), threads(jobs) as pool:
        start = time.monotonic()
        running = [pool.submit(outcome_of, proof, dut, folder / proof.name) for proof in chosen]
        for future in as_completed(running):
            outcomes[future.result().proof.name] = future.result()
            progress(1)
        ordered = tuple(outcomes[proof.name] for proof in chosen)
        complete = len(chosen) == len(proofs())
        registers = _covered(ordered, dut, folder / "registers") if complete else None
    seconds = time.monotonic() - start
    return FormalResult(ordered, complete, seconds, before.valid_for, not before.stands, registers)


def _covered(outcomes: Sequence[Outcome], dut: Path, folder: Path) -> Covered | str:
    """Return which registers the proofs that hold look at, or why that is not known."""
    found = (outcome.finding.registers for outcome in outcomes if outcome.passed)
    try:
        return Covered(all_registers(dut, folder), frozenset().union(*found), read_unproved())
    except InputError as error:
        return str(error)


def outcome_of(proof: Proof, dut: Path, folder: Path) -> Outcome:
    """Try a proof; return what came of it, and the seconds it took."""
    start = time.monotonic()
    finding = proof.prove(dut, folder)
    return Outcome(proof, finding, time.monotonic() - start)


def write_result(result: FormalResult, command: str, path: Path = RESULT) -> Path:
    """Write the result of all proofs; raise ValueError for a part of them."""
    if not result.complete:
        raise ValueError("a part of the proofs is no evidence")
    content = {
        **asdict(result.valid_for),
        "passed": result.passed,
        "problems": result.problems,
        "summary": result.summary,
        "command": command,
        "seconds": round(result.seconds, 1),
        "proofs": [_entry(outcome) for outcome in result.outcomes],
        "total": len(result.outcomes),
        "proved": result.proved,
        "undecided": result.undecided,
        "exceptions": result.exceptions,
        "registers": result.registers.content if isinstance(result.registers, Covered) else None,
    }
    return write_evidence(path, content, SOURCES)


def _entry(outcome: Outcome) -> dict[str, object]:
    proof, finding = outcome.proof, outcome.finding
    return {
        "name": proof.name,
        "claim": proof.claim,
        "method": str(proof.method),
        "parameters": dict(proof.parameters),
        "assumptions": list(proof.assumptions),
        "passed": outcome.passed,
        "result": finding.result,
        "problems": [*finding.problems, *finding.undecided],
        "facts": dict(finding.facts),
        # None of a proof that looks at no netlist.
        "registers": by_modules(finding.registers),
        "seconds": round(outcome.seconds, 1),
        "log": None if finding.log is None else os.path.relpath(finding.log, ROOT),
    }
