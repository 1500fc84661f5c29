"""The result of a sign-off: what it found, what stands against it, and its file."""

import json
import platform
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path

from triaxis.coverage.report import ModelReport, percent
from triaxis.golden.axes import NUM_AXES
from triaxis.golden.pairs import NO_AXIS
from triaxis.verif.paths import BUILD
from triaxis.verif.signoff.detector_check import SEED_VECTORS, DetectorResult
from triaxis.verif.provenance import Provenance, provenance
from triaxis.verif.signoff.scene_checks import SceneResult
from triaxis.verif.simulation import RunResult
from triaxis.verif.toolchain import verilator

FOLDER = BUILD / "signoff"
RESULT = FOLDER / "signoff.json"
# Tests send whole groups: some pairs less than they were asked for.
_MOST_OF = 0.9


@dataclass(frozen=True)
class SignoffResult:
    """Everything that the sign-off found; ``real_meshes`` is None where none were there."""

    runs: list[RunResult]
    scenes: list[SceneResult]
    real_meshes: list[SceneResult] | None
    detector: DetectorResult
    coverage: list[ModelReport]
    least_pairs: int
    provenance: Provenance
    seconds: float

    @property
    def checked(self) -> int:
        """Return how many pairs were checked."""
        return sum(int(result.counts["checked"]) for result in self.runs if result.counts)

    @property
    def judged(self) -> int:
        """Return how many of them the golden model judged as well."""
        return sum(int(result.counts["judged_by_golden_model"]) for result in self.runs if result.counts)

    @property
    def judged_axes(self) -> dict[str, set[int]]:
        """Return, by configuration, the claims of which the golden model judged a pair."""
        found: dict[str, set[int]] = {}
        for result in self.runs:
            axes = set(result.counts["judged_axes"]) if result.counts else set()
            found.setdefault(result.settings.config, set()).update(axes)
        return found

    @cached_property
    def problems(self) -> list[str]:
        """Return what stands against a pass, one line each: as it is when first asked."""
        found = [f"{r.settings.test} in {r.settings.config} failed" for r in self.runs if not r.passed]
        found += [
            f"{r.settings.test} in {r.settings.config}: {r.counts['accepted']} of {r.settings.pairs} "
            "pairs sent"
            for r in self.runs
            if r.counts and r.counts["accepted"] < _MOST_OF * r.settings.pairs
        ]
        found += [
            f"scene {s.name}: {s.found}, expected {s.expected}"
            + ("" if s.agrees else "; the golden model disagrees")
            for s in self.scenes + (self.real_meshes or [])
            if not s.passed
        ]
        if not self.scenes:
            found.append("no scene was checked")
        if self.checked < self.least_pairs:
            found.append(f"{self.checked} pairs checked, at least {self.least_pairs} are wanted")
        if self.detector.seed_vectors_clear != SEED_VECTORS:
            found.append(f"{self.detector.seed_vectors_clear} of {SEED_VECTORS} seed vectors clear")
        if self.detector.wrong or not self.detector.pairs:
            found.append(f"CollisionDetector: {self.detector.wrong} of {self.detector.pairs} pairs wrong")
        found += [problem for model in self.coverage for problem in model.problems]
        found += [
            f"the golden model judged no pair that is decided by {name}, in {config}"
            for config, axes in self.judged_axes.items()
            for name in _claim_names(axes)
        ]
        if not self.coverage:
            found.append("no coverage was collected")
        if provenance() != self.provenance:
            found.append("the RTL or the checkout changed during the run")
        return found


def _claim_names(judged: set[int]) -> list[str]:
    """Return the names of the claims that are missing."""
    missing = sorted({NO_AXIS, *range(NUM_AXES)} - judged)
    return ["nothing, being near" if axis == NO_AXIS else f"axis {axis}" for axis in missing]


def write_json(result: SignoffResult, seed: int) -> Path:
    """Write the result as build/signoff/signoff.json, whole or not at all."""
    content = {
        "passed": not result.problems,
        "problems": result.problems,
        "seed": seed,
        "seconds": round(result.seconds, 1),
        **asdict(result.provenance),
        "verilator": str(verilator()),
        "python": platform.python_version(),
        "command": f"triaxis signoff --seed {seed} --pairs {result.least_pairs}",
        "pairs_checked": result.checked,
        "pairs_judged_by_golden_model": result.judged,
        "runs": [
            {
                "test": r.settings.test,
                "config": r.settings.config,
                "seed": r.settings.seed,
                "passed": r.passed,
                "seconds": round(r.seconds, 1),
                "counts": r.counts,
                "replay": r.settings.replay_command,
            }
            for r in result.runs
        ],
        "scenes": [asdict(s) for s in result.scenes],
        "real_meshes": None if result.real_meshes is None else [asdict(s) for s in result.real_meshes],
        "detector": asdict(result.detector),
        "coverage": {
            "percent": percent(result.coverage),
            "models": {
                model.model: {item.name: {"hit": item.hit, "total": item.total} for item in model.items}
                for model in result.coverage
            },
        },
    }
    FOLDER.mkdir(parents=True, exist_ok=True)
    partial = RESULT.with_suffix(".partial")
    partial.write_text(json.dumps(content, indent=2) + "\n")
    partial.replace(RESULT)
    return RESULT
