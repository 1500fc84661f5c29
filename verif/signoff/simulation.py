"""The simulations of a sign-off: builds, tests, scenes, the wrapper, functional coverage; what they found."""

import os
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import Any, TypeVar

from triaxis.coverage.report import ModelReport
from triaxis.coverage.waiver_upkeep import exclusion_records
from triaxis.golden.axes import NUM_AXES
from triaxis.golden.pairs import NO_AXIS
from triaxis.sim.core_engine import configuration_for
from triaxis.sim.models import core_build
from triaxis.sim.validity import Sources, Validity, validity
from triaxis.sim.verilate import library
from triaxis.verif.core.detector_check import SEED_VECTORS, DetectorResult, check_detector
from triaxis.verif.counterexample.explaining import run_and_explain
from triaxis.verif.regress.coverage_models import merge_coverage
from triaxis.verif.regress.one_job import MOST_OF
from triaxis.verif.signoff.plan import FOLDER, VOLUME, plan
from triaxis.verif.signoff.scene_checks import SceneResult, check_real_meshes, check_scenes
from triaxis.verif.testbench.settings import TEST_MODULES, RunSettings
from triaxis.verif.testbench.simulation import RunResult, build_for

SOURCES = Sources(("triaxis.verif.signoff.simulation", *TEST_MODULES), ("verif/core/kept/*.json",))


@dataclass(frozen=True)
class SimulationResult:
    """What the runs, scenes and the wrapper's check found; ``real_meshes`` is None where none were there."""

    runs: list[RunResult]
    scenes: list[SceneResult]
    real_meshes: list[SceneResult] | None
    detector: DetectorResult
    coverage: list[ModelReport]
    least_pairs: int
    valid_for: Validity
    seconds: float

    @property
    def core_runs(self) -> list[RunResult]:
        """Return the runs of the core."""
        return [run for run in self.runs if not run.settings.of_mesh_engine]

    @property
    def mesh_runs(self) -> list[RunResult]:
        """Return the runs of the mesh engine."""
        return [run for run in self.runs if run.settings.of_mesh_engine]

    @property
    def checked(self) -> int:
        """Return how many pairs of the core's runs were checked; those of scenes are not among them."""
        return sum(int(result.counts["checked"]) for result in self.core_runs if result.counts)

    @property
    def judged(self) -> int:
        """Return how many of them the golden model judged as well."""
        counts = (result.counts for result in self.core_runs if result.counts)
        return sum(int(count["judged_by_golden_model"]) for count in counts)

    @property
    def mesh_counts(self) -> dict[str, int]:
        """Return what the runs of the mesh engine counted in all."""
        counts = [result.counts for result in self.mesh_runs if result.counts]
        names = ("runs", "complete_runs", "checked", "skipped_with_proof", "tested", "judged_by_golden_model")
        return {name: sum(int(count[name]) for count in counts) for name in names}

    @property
    def mismatches(self) -> int:
        """Return how many pairs were answered wrongly."""
        return sum(int(result.counts["failed"]) for result in self.runs if result.counts)

    @property
    def judged_axes(self) -> dict[str, set[int]]:
        """Return, by configuration, the claims of which the golden model judged a pair."""
        found: dict[str, set[int]] = {}
        for result in self.core_runs:
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
            if r.counts and r.counts["accepted"] < MOST_OF * r.settings.pairs
        ]
        found += [
            f"scene {s.name}: {s.found}, expected {s.expected}"
            + ("" if s.agrees else "; the golden model disagrees")
            for s in self.scenes + (self.real_meshes or [])
            if not s.passed
        ]
        if not self.mesh_counts["checked"]:
            found.append("no pair of a scene was accounted for by the mesh engine")
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
        if validity(SOURCES) != self.valid_for:
            found.append("the RTL or its environment changed during the run")
        return found


def _claim_names(judged: set[int]) -> list[str]:
    """Return the names of the claims that are missing."""
    missing = sorted({NO_AXIS, *range(NUM_AXES)} - judged)
    return ["nothing, being near" if axis == NO_AXIS else f"axis {axis}" for axis in missing]


def as_evidence(result: SimulationResult, seed: int, volume: int) -> dict[str, Any]:
    """Return the result as it stands in the sign-off's file."""
    return {
        "passed": not result.problems,
        "problems": result.problems,
        "summary": f"{result.checked:,} pairs checked, {result.judged:,} of them judged by the golden model; "
        f"{result.mesh_counts['checked']:,} pairs of scenes accounted for by the mesh engine",
        "command": f"triaxis signoff --seed {seed} --pairs {volume}",
        "seconds": round(result.seconds, 1),
        "rtl_hash": result.valid_for.rtl_hash,
        "pairs_checked": result.checked,
        "pairs_judged_by_golden_model": result.judged,
        "mesh_engine": result.mesh_counts,
        "mismatches": result.mismatches,
        "runs": [
            {
                "test": r.settings.test,
                "config": r.settings.config,
                "agent": r.settings.agent,
                "seed": r.settings.seed,
                "passed": r.passed,
                "seconds": round(r.seconds, 1),
                "counts": r.counts,
                "explanation": None if r.passed else r.explain().splitlines(),
                "replay": r.settings.replay_command,
            }
            for r in result.runs
        ],
        "scenes": [asdict(s) for s in result.scenes],
        "real_meshes": None if result.real_meshes is None else [asdict(s) for s in result.real_meshes],
        "detector": asdict(result.detector),
        "exclusions": exclusion_records(result.coverage),
        "coverage": {
            model.model: {
                item.name: {"hit": item.hit, "total": item.total, "meaning": item.meaning}
                for item in model.items
            }
            for model in result.coverage
        },
    }


Answer = TypeVar("Answer")

_JOBS = min(2, os.cpu_count() or 1)
# Scenes, real meshes, the wrapper.
_CHECKS = 3


def step_count(seed: int, volume: int) -> int:
    """Return how many steps the simulations have."""
    runs = plan(seed, volume)
    return len(_builds(runs)) + len(runs) + _CHECKS


def simulate(seed: int, progress: Callable[[int], None], volume: int = VOLUME) -> SimulationResult:
    """Run everything; ``progress`` is told of each step done."""
    start = time.monotonic()
    before = validity(SOURCES)
    runs = plan(seed, volume)
    builds = _builds(runs)

    def one_build(build: Callable[[], Path]) -> None:
        build()
        progress(1)

    def one_check(check: Callable[[], Answer]) -> Answer:
        answer = check()
        progress(1)
        return answer

    def one_run(settings: RunSettings) -> RunResult:
        result = run_and_explain(settings)
        progress(1)
        return result

    with ThreadPoolExecutor(_JOBS) as pool:
        built = [pool.submit(one_build, build) for build in builds]
        results = [pool.submit(one_run, settings) for settings in runs]
        try:
            # Here, in the main thread: the solver's handler of interrupts works in no other.
            made = one_check(partial(check_scenes, FOLDER / "scenes"))
            real = one_check(partial(check_real_meshes, FOLDER / "scenes"))
            detector = one_check(partial(check_detector, seed))
            for future in (*built, *results):
                future.result()
        except BaseException:
            # An error or an interrupt: start nothing more.
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    ran = [future.result() for future in results]
    passed = [(result.settings.config, Path(result.settings.folder)) for result in ran if result.passed]
    seconds = time.monotonic() - start
    return SimulationResult(
        ran,
        made,
        real,
        detector,
        merge_coverage(FOLDER, (r.settings.config for r in ran), passed),
        max(volume, VOLUME),
        before,
        seconds,
    )


def _builds(runs: list[RunSettings]) -> list[Callable[[], Path]]:
    """Return the builds that the runs and scenes need; the widest take longest and come first."""
    wanted = {(r.config, r.agent): r for r in runs}.values()
    widest_first = sorted(wanted, key=lambda r: (-r.width, r.agent, r.config))
    return [partial(build_for, r) for r in widest_first] + [
        partial(library, core_build(configuration_for(24, 1)))
    ]
