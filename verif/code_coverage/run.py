"""A run of its own that measures code coverage of dut/: builds with counters, plays, checks, assesses.

Results are checked against the bulk checker: coverage by a core that answers wrongly is worth nothing.
"""

import signal
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import asdict, dataclass, replace
from multiprocessing import get_context
from pathlib import Path

import numpy as np
from filelock import FileLock

from triaxis.coverage.code_counters import Counters, read_counters
from triaxis.coverage.code_coverage import (
    Assessment,
    ModelCoverage,
    Total,
    assess_model,
    conclude,
    generate_blocks,
)
from triaxis.coverage.elaboration import read_elaboration
from triaxis.coverage.waiver_upkeep import waiver_records
from triaxis.coverage.waivers import WAIVERS, Waiver, read_waivers
from triaxis.golden.bulk import bulk_facts
from triaxis.golden.outputs import make_folder
from triaxis.golden.pairs import coordinate_range
from triaxis.sim.build import rtl_hash
from triaxis.sim.configuration import Configuration
from triaxis.sim.core_engine import DELIVERED, CoreError, CorePlayer, Steps
from triaxis.sim.detector import DetectorPlayer, detector_inputs
from triaxis.sim.evidence import write_evidence
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.mesh_engine import RUN, MeshPlayer
from triaxis.sim.models import core_build, detector_build, mesh_build
from triaxis.sim.paths import BUILD, SIM, mesh_sources, rtl_sources
from triaxis.sim.player import Player
from triaxis.sim.validity import Sources
from triaxis.sim.verilate import LIGHT, Build, described, library
from triaxis.verif.code_coverage.stimulus import pairs_with_margins, stimulus
from triaxis.verif.core.expectation import expected_words
from triaxis.verif.core.stimulus.schedules import disturbed
from triaxis.verif.mesh.script_stimulus import engine_directed, engine_extremes

RESULT = BUILD / "coverage" / "code.json"
COUNTERS = BUILD / "coverage" / "counters"
SOURCES = Sources(("triaxis.verif.code_coverage.run",), ("coverage/waivers.toml",))

# Together they elaborate every generate block of dut/; the run fails if one is missing.
CORES = (
    # 576 bits of TDATA, both operands of the multipliers split, no edge x box axes, no gating.
    Configuration(32, 0, edge_box=False, gating=False),
    # Padding above the coordinates, one tag bit, multipliers with their operands swapped.
    Configuration(18, 18, tag_bits=1),
    Configuration(16, 16),
    Configuration(16, 0),
)
DETECTOR_WIDTH = 16
_ENGINE_MODULES = frozenset(source.stem for source in mesh_sources())

# The mesh engine, where several words of lanes make a group, and several a mesh; with margins, and without.
_MESH = MeshConfiguration(8, 8, depth=32, group=4, lanes=2, cycle_bits=8)
ENGINES = (_MESH, replace(_MESH, margin_bits=0))
# Of progress: the cores, the wrapper and the engines, each when it is built and when it is done.
STEPS = 2 * (len(CORES) + 1 + len(ENGINES))

# Every bin of every model was hit within half of this.
PAIRS = 6_000
_JOBS = 2


@dataclass(frozen=True)
class Run:
    """One model: how many pairs it was played, how many were checked and how many were wrong.

    Of the mesh engine, how many runs.
    """

    model: str
    pairs: int
    checked: int
    wrong: int
    clocks: int
    seconds: float


@dataclass(frozen=True)
class CodeCoverage:
    """All runs, and how they cover the code.

    ``rtl_hash``: of the RTL before the run; ``changed``: it was another after it.
    """

    runs: list[Run]
    assessment: Assessment
    waivers: list[Waiver]
    seconds: float
    rtl_hash: str
    changed: bool = False

    @property
    def problems(self) -> list[str]:
        """Return what is wrong, apart from bins that are not covered."""
        wrong = [f"{r.model}: {r.wrong} of {r.checked} results are wrong" for r in self.runs if r.wrong]
        idle = [f"{r.model}: no result was checked" for r in self.runs if not r.checked]
        changed = ["the RTL changed during the run"] if self.changed else []
        return [*wrong, *idle, *changed, *self.assessment.problems]

    @property
    def passed(self) -> bool:
        """Return whether every bin is hit or waived, with right results."""
        return self.assessment.passed and not self.problems


Measured = Configuration | MeshConfiguration | None


def covered(configuration: Measured) -> Build:
    """Return the build that is measured: of the core, of the mesh engine, or (None) of the wrapper.

    The core in the mesh engine has no counters: it is measured by itself.
    """
    if isinstance(configuration, MeshConfiguration):
        build = mesh_build(configuration)
        # Counters change with the order of the control files.
        seen = tuple(path for path in build.sources if path.suffix == ".sv")
        build = replace(build, sources=(*seen, SIM / "counters" / "mesh_only.vlt"))
    else:
        build = core_build(configuration) if configuration else detector_build(DETECTOR_WIDTH)
    # Little less speed than more optimising, for much less compiling.
    return replace(build, counters=True, speed=LIGHT, split=5000)


@dataclass(frozen=True)
class _Job:
    """One build to play."""

    configuration: Measured
    seed: int
    count: int
    steps: Steps
    waivers: list[Waiver]

    @property
    def model(self) -> Build:
        """Return the build."""
        return covered(self.configuration)

    def build(self) -> None:
        """Build and elaborate the model, where needed."""
        library(self.model)
        described(self.model)

    def run(self) -> tuple[Run, Assessment]:
        """Play the model, check its results, and assess its coverage."""
        start, model = time.perf_counter(), self.model
        file = COUNTERS / f"{model.name}.dat"
        instances = read_elaboration(described(model), model.top)
        path = library(model)
        if isinstance(self.configuration, MeshConfiguration):
            player = MeshPlayer(path)
            played, checked, wrong, clocks = self._play_engine(player, self.configuration)
            instances = {path: one for path, one in instances.items() if one.module in _ENGINE_MODULES}
        elif self.configuration:
            player = CorePlayer(path)
            played, (checked, wrong, clocks) = self.count, self._play_core(player, self.configuration)
        else:
            player = DetectorPlayer(path)
            played, (checked, wrong, clocks) = self.count, self._play_detector(player)
        counted = _counted(player, file)
        assessment = assess_model(ModelCoverage(model.name, counted, instances), self.waivers)
        seconds = time.perf_counter() - start
        return Run(model.name, played, checked, wrong, clocks, seconds), assessment

    def _play_engine(self, player: MeshPlayer, engine: MeshConfiguration) -> tuple[int, int, int, int]:
        """Return how many runs there were, how many were right, how many scripts went wrong, the clocks."""
        plays = [*engine_directed(engine, self.seed), *engine_extremes(engine, self.seed)]
        answers = [player.play(play.script) for play in plays]
        runs = sum(int((play.script.steps["kind"] == RUN).sum()) for play in plays)
        clocks = sum(int(play.script.clocks.clip(0).sum()) for play in plays)
        return runs, sum(right for _, right in answers), sum(bool(wrong) for wrong, _ in answers), clocks

    def _play_core(self, player: CorePlayer, configuration: Configuration) -> tuple[int, int, int]:
        """Return how many results were checked, how many were wrong, and the clocks."""
        rng = np.random.default_rng([self.seed, configuration.width, configuration.margin_bits])
        sent, pairs, margins = stimulus(rng, self.count, configuration, self.steps)
        played = player.play(sent)
        if played.symptom:
            raise CoreError(f"core {configuration.name}: {played.symptom}")
        delivered = played.states == DELIVERED
        wrong = delivered & (played.words != expected_words(bulk_facts(pairs, margins), configuration))
        return int(delivered.sum()), int(wrong.sum()), played.clocks

    def _play_detector(self, player: DetectorPlayer) -> tuple[int, int, int]:
        rng = np.random.default_rng([self.seed, DETECTOR_WIDTH])
        pairs, _ = pairs_with_margins(rng, self.count, DETECTOR_WIDTH, 0)
        normals = rng.integers(*coordinate_range(DETECTOR_WIDTH), (self.count, 2, 3), endpoint=True)
        collides, _, _ = player.play(detector_inputs(pairs, normals, DETECTOR_WIDTH))
        return self.count, int((collides != bulk_facts(pairs, 0).near).sum()), 0


def _counted(player: Player, file: Path) -> Counters:
    player.write_coverage(file)
    return read_counters(file)


def _run_job(job: _Job) -> tuple[Run, Assessment]:
    return job.run()


def _ignore_interrupts() -> None:
    """Leave an interrupt to the process that waits for the workers."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _run_all(jobs: list[_Job], progress: Callable[[int], None]) -> list[tuple[Run, Assessment]]:
    """Build in threads, which only wait for compilers; then run in processes, whose work is Python's."""
    with ThreadPoolExecutor(_JOBS) as threads:
        for _ in threads.map(_Job.build, jobs):
            progress(1)
    done: list[tuple[Run, Assessment]] = []
    pool = ProcessPoolExecutor(_JOBS, get_context("spawn"), initializer=_ignore_interrupts)
    try:
        for outcome in pool.map(_run_job, jobs):
            done.append(outcome)
            progress(1)
    finally:
        pool.shutdown(cancel_futures=True)
    return done


def measure(
    seed: int,
    count: int = PAIRS,
    cores: Sequence[Configuration] = CORES,
    engines: Sequence[MeshConfiguration] = ENGINES,
    waivers: Path = WAIVERS,
    progress: Callable[[int], None] | None = None,
) -> CodeCoverage:
    """Measure code coverage with ``count`` pairs on each core and on the wrapper, and scenes on each engine.

    ``progress`` is told of each model twice: when it is built, and when it is done.
    """
    start = time.perf_counter()
    read = read_waivers(waivers)
    steps = disturbed(np.random.default_rng(seed))
    jobs = [_Job(one, seed, count, steps, read) for one in (*cores, None, *engines)]
    # Two runs at once would write each other's counters.
    make_folder(COUNTERS)
    with FileLock(COUNTERS / ".lock"):
        before = rtl_hash()
        done = _run_all(jobs, progress or (lambda _: None))
        together = Assessment()
        for _, assessment in done:
            together.add(assessment)
        whole = conclude(together, generate_blocks([*rtl_sources(), *mesh_sources()]), read)
        changed = rtl_hash() != before
    return CodeCoverage([run for run, _ in done], whole, read, time.perf_counter() - start, before, changed)


def _as_json(total: Total) -> dict[str, int | float | None]:
    return {**asdict(total), "percent": total.percent}


def write_json(result: CodeCoverage, seed: int, path: Path = RESULT) -> Path:
    """Write the result, whole or not at all."""
    assessment = result.assessment
    content = {
        "passed": result.passed,
        "summary": ", ".join(
            f"{kind} {total.hit + total.waived:,} of {total.total:,}"
            for kind, total in assessment.totals.items()
        ),
        "totals": {kind: _as_json(total) for kind, total in assessment.totals.items()},
        "files": {
            file: {k: _as_json(total) for (f, k), total in sorted(assessment.files.items()) if f == file}
            for file in sorted({file for file, _ in assessment.files})
        },
        "uncovered": [asdict(bin_) for bin_ in assessment.uncovered],
        "problems": result.problems,
        "waivers_void": len(assessment.void),
        "waivers": waiver_records(result.waivers, assessment.waived),
        "runs": [{**asdict(run), "seconds": round(run.seconds, 1)} for run in result.runs],
        "seed": seed,
        "rtl_hash": result.rtl_hash,
        "seconds": round(result.seconds, 1),
        "command": f"triaxis coverage code --seed {seed}",
    }
    return write_evidence(path, content, SOURCES)
