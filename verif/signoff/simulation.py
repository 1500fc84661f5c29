"""The simulations of a sign-off: builds, tests, scenes, the wrapper, functional coverage; what they found."""

import os
import time
from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any, TypeVar

from triaxis.coverage.report import ModelReport
from triaxis.coverage.waiver_upkeep import exclusion_records
from triaxis.fpga.board_build import SIGNED_OFF
from triaxis.golden.axes import NUM_AXES
from triaxis.golden.pairs import NO_AXIS
from triaxis.golden.processes import threads
from triaxis.sim.core_engine import configuration_for
from triaxis.sim.models import core_build
from triaxis.sim.validity import Sources, Validity, validity
from triaxis.sim.verilate import library
from triaxis.verif.core.detector_check import SEED_VECTORS, DetectorResult, check_detector
from triaxis.verif.core.solver_check import SolverResult, check_solvers
from triaxis.verif.counterexample.explaining import run_and_explain
from triaxis.verif.regress.coverage_models import merge_coverage
from triaxis.verif.regress.definition import in_checkout
from triaxis.verif.regress.one_job import unsent
from triaxis.verif.signoff.plan import FOLDER, VOLUME, plan
from triaxis.verif.signoff.scene_checks import SceneResult, check_real_meshes, check_scenes
from triaxis.verif.testbench.settings import TEST_DATA, TEST_MODULES, Block, RunSettings
from triaxis.verif.testbench.simulation import RunResult, build_for

SOURCES = Sources(("triaxis.verif.signoff.simulation", *TEST_MODULES), TEST_DATA)


@dataclass(frozen=True)
class SimulationResult:
    """What the runs, scenes and the wrapper's check found; ``real_meshes`` is None where none were there."""

    runs: list[RunResult]
    scenes: list[SceneResult]
    real_meshes: list[SceneResult] | None
    detector: DetectorResult
    solvers: SolverResult
    coverage: list[ModelReport]
    least_pairs: int
    valid_for: Validity
    seconds: float

    def _counts(self, block: Block) -> list[dict[str, Any]]:
        """Return what the scoreboards of a block's runs counted."""
        return [run.counts for run in self.runs if run.counts and run.settings.block is block]

    @property
    def checked(self) -> int:
        """Return how many pairs of the core's runs were checked; those of scenes are not among them."""
        return sum(int(counts["checked"]) for counts in self._counts(Block.CORE))

    @property
    def judged(self) -> int:
        """Return how many of them the golden model judged as well."""
        return sum(int(counts["judged_by_golden_model"]) for counts in self._counts(Block.CORE))

    @property
    def mesh_counts(self) -> dict[str, int]:
        """Return what the runs of the mesh engine counted in all."""
        names = ("runs", "complete_runs", "checked", "skipped_with_proof", "tested", "judged_by_golden_model")
        return {name: sum(int(counts[name]) for counts in self._counts(Block.MESH)) for name in names}

    @property
    def board_counts(self) -> dict[str, int]:
        """Return what the runs of the board counted in all: replies and clocks are checked ones."""
        names = ("checked", "clocks", "runs", "gos", "resets")
        return {name: sum(int(counts[name]) for counts in self._counts(Block.BOARD)) for name in names}

    @property
    def mismatches(self) -> int:
        """Return how many pairs were answered wrongly."""
        return sum(int(result.counts["failed"]) for result in self.runs if result.counts)

    @property
    def unjudged(self) -> list[str]:
        """Return, a line each, the claims of a configuration of which the golden model judged no pair."""
        judged: dict[str, set[int]] = defaultdict(set)
        for run in self.runs:
            if run.settings.block is Block.CORE:
                judged[run.settings.config].update(run.counts["judged_axes"] if run.counts else ())
        kinds = {NO_AXIS: "near pair"} | {
            axis: f"pair that axis {axis} separates" for axis in range(NUM_AXES)
        }
        return [
            f"the golden model judged no {kind} in {config}"
            for config, axes in judged.items()
            for axis, kind in kinds.items()
            if axis not in axes
        ]

    @property
    def _shipped(self) -> bool:
        """Return whether a run was of the very board of which a bitstream is made."""
        boards = (r.settings.board_parameters for r in self.runs if r.settings.block is Block.BOARD)
        return any(replace(board, build_id=SIGNED_OFF.build_id) == SIGNED_OFF for board in boards)

    @cached_property
    def problems(self) -> list[str]:
        """Return the reasons for a failure, one line each, as they are when first asked for."""
        found: list[str] = []
        for run in self.runs:
            name = f"{run.settings.test} in {run.settings.config}"
            if not run.passed:
                found.append(f"{name} failed")
            if run.counts and (told := unsent(run)):
                found.append(f"{name}: {told}")
        for scene in self.scenes + (self.real_meshes or []):
            if not scene.passed:
                doubt = "" if scene.agrees else "; the golden model disagrees"
                found.append(f"scene {scene.name}: {scene.found}, expected {scene.expected}{doubt}")
        if not self.mesh_counts["checked"]:
            found.append("the mesh engine decided no pair of a scene")
        if not self.board_counts["gos"]:
            found.append("the board never said go")
        if not self._shipped:
            found.append(f"no run was of {SIGNED_OFF.name}, the board of which a bitstream is made")
        if not self.scenes:
            found.append("no scene was checked")
        if self.checked < self.least_pairs:
            found.append(f"{self.checked} pairs checked, at least {self.least_pairs} are wanted")
        if self.detector.seed_vectors_clear != SEED_VECTORS:
            found.append(f"{self.detector.seed_vectors_clear} of {SEED_VECTORS} seed vectors clear")
        if self.detector.wrong or not self.detector.pairs:
            found.append(f"CollisionDetector: {self.detector.wrong} of {self.detector.pairs} pairs wrong")
        if self.solvers.different or not self.solvers.pairs:
            found.append(
                f"golden model: PPL differs on {self.solvers.different} of {self.solvers.pairs} pairs"
            )
        found += [problem for model in self.coverage for problem in model.problems]
        found += self.unjudged
        if not self.coverage:
            found.append("no coverage was collected")
        if validity(SOURCES) != self.valid_for:
            found.append("the RTL or its environment changed during the run")
        return found


def as_evidence(result: SimulationResult, seed: int, volume: int) -> dict[str, Any]:
    """Return the result as it stands in the sign-off's file."""
    return {
        "passed": not result.problems,
        "problems": result.problems,
        "summary": f"{result.checked:,} pairs checked, {result.judged:,} of them judged by the golden model; "
        f"{result.mesh_counts['checked']:,} pairs of scenes decided by the mesh engine; "
        f"{result.board_counts['checked']:,} replies of the board",
        "command": f"triaxis signoff --seed {seed} --pairs {volume}",
        "seconds": round(result.seconds, 1),
        "rtl_hash": result.valid_for.rtl_hash,
        "pairs_checked": result.checked,
        "pairs_judged_by_golden_model": result.judged,
        "mesh_engine": result.mesh_counts,
        "board": result.board_counts,
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
                "log": in_checkout(r.log),
            }
            for r in result.runs
        ],
        "scenes": [asdict(s) for s in result.scenes],
        "real_meshes": None if result.real_meshes is None else [asdict(s) for s in result.real_meshes],
        "detector": asdict(result.detector),
        "solvers": asdict(result.solvers),
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
# Scenes, real meshes, the wrapper, the golden model's solver.
_CHECKS = 4


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

    def counted(step: Callable[[], Answer]) -> Answer:
        answer = step()
        progress(1)
        return answer

    with threads(_JOBS) as pool:
        built = [pool.submit(counted, build) for build in builds]
        results = [pool.submit(counted, partial(run_and_explain, settings)) for settings in runs]
        # Here, in the main thread: PPL handles interrupts, which works in no other.
        made = counted(partial(check_scenes, FOLDER / "scenes"))
        real = counted(partial(check_real_meshes, FOLDER / "scenes"))
        detector = counted(partial(check_detector, seed))
        solvers = counted(partial(check_solvers, seed))
        for future in (*built, *results):
            future.result()
    ran = [future.result() for future in results]
    passed = [(result.settings.config, Path(result.settings.folder)) for result in ran if result.passed]
    seconds = time.monotonic() - start
    return SimulationResult(
        ran,
        made,
        real,
        detector,
        solvers,
        merge_coverage(FOLDER, (r.settings.config for r in ran), passed),
        max(volume, VOLUME),
        before,
        seconds,
    )


def _builds(runs: list[RunSettings]) -> Sequence[Callable[[], object]]:
    """Return the builds that the runs and scenes need; the widest take longest and come first."""
    wanted = {(r.config, r.agent): r for r in runs}.values()
    widest_first = sorted(wanted, key=lambda r: (-r.width, r.agent, r.config))
    return [partial(build_for, r) for r in widest_first] + [
        partial(library, core_build(configuration_for(24, 1)))
    ]
