"""The result of a sign-off: evidence, figures, verdict; its file and its page."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from functools import cached_property
from pathlib import Path
from typing import Any

from triaxis.coverage.stages import Judgement, judge, read_figures
from triaxis.golden.outputs import write_whole
from triaxis.sim.evidence import write_evidence
from triaxis.sim.provenance import Provenance, provenance
from triaxis.verif.signoff.figures import Value, figures
from triaxis.verif.signoff.folder import PAGE, RESULT
from triaxis.verif.signoff.page import signoff_page
from triaxis.verif.signoff.parts import Part
from triaxis.verif.signoff.tools import tool_versions


@dataclass(frozen=True)
class Signoff:
    """Evidence of every part, by name, and what was signed off."""

    parts: Mapping[str, Part]
    provenance: Provenance
    seed: int
    pairs: int
    seconds: float

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
        if provenance() != self.provenance:
            found.append("the RTL or the checkout changed during the run")
        return found + list(self.judgement.shortfalls)

    @property
    def passed(self) -> bool:
        """Return whether nothing is left open."""
        return self.judgement.passed and not self.problems

    def content(self) -> dict[str, Any]:
        """Return the sign-off as it stands in its file."""
        code = self.parts["code_coverage"].evidence
        return {
            "passed": self.passed,
            "stage": self.judgement.stage,
            "problems": self.problems,
            "summary": f"stage {self.judgement.stage or 'none'} reached",
            "figures": self.figures,
            "seed": self.seed,
            "seconds": round(self.seconds, 1),
            "date": datetime.now(UTC).isoformat(timespec="seconds"),
            "command": f"triaxis signoff --seed {self.seed} --pairs {self.pairs}",
            "tools": tool_versions(),
            "waivers": code["waivers"] if code else None,
            "parts": {name: part.as_json for name, part in self.parts.items()},
            **asdict(self.provenance),
        }


def write(result: Signoff, nights: Sequence[Mapping[str, Any]]) -> Path:
    """Write build/signoff/signoff.json and index.html, each whole or not at all; return the page."""
    content = result.content()
    page = signoff_page(content, read_figures(), nights)
    write_evidence(RESULT, content)
    return write_whole(PAGE, page)
