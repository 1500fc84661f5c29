"""Code coverage of the RTL: what the environment's own tests reach, on builds that count.

The tests check every answer as always: coverage by a core that answers wrongly is worth nothing.
"""

import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from filelock import FileLock

from triaxis.coverage.code_counters import add_files, read_counters
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
from triaxis.golden.errors import InputError
from triaxis.golden.outputs import make_folder
from triaxis.golden.processes import results_in_processes
from triaxis.sim.board_parameters import BoardParameters, parse_board_configuration
from triaxis.sim.build import built, content_hash, rtl_hash
from triaxis.sim.configuration import Configuration
from triaxis.sim.detector import DetectorPlayer
from triaxis.sim.evidence import write_evidence
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.models import (
    BOARD_SVA,
    CORE_SVA,
    MESH_SVA,
    assertions,
    board_build,
    core_build,
    detector_build,
    mesh_build,
)
from triaxis.sim.paths import BUILD, board_sources, certified_sources, mesh_sources, rtl_sources
from triaxis.sim.validity import Sources
from triaxis.sim.verilate import LIGHT, Build, described, library
from triaxis.verif.code_coverage.state_machines import covers, state_machines
from triaxis.verif.core.detector_check import ask_at_random
from triaxis.verif.testbench.assertions import with_antecedents
from triaxis.verif.testbench.settings import BURST, TEST_DATA, TEST_MODULES, Block, counters_file
from triaxis.verif.testbench.simulation import RunResult, run, run_settings
from triaxis.verif.testbench.table import table

RESULT = BUILD / "coverage" / "code.json"
COUNTERS = BUILD / "coverage" / "counters"
SOURCES = Sources(("triaxis.verif.code_coverage.run", *TEST_MODULES), ("coverage/waivers.toml", *TEST_DATA))

# Together they elaborate every generate block of dut/; the run fails if one is missing.
CORES = (
    # 576 bits of TDATA, both operands of the multipliers split, no edge x box axes, no gating.
    Configuration(32, 0, edge_box=False, gating=False),
    # Padding above the coordinates, one tag bit, multipliers with their operands swapped.
    Configuration(18, 18, tag_bits=1),
    Configuration(16, 16),
    # Multipliers whose x, not y, has a narrow top piece.
    Configuration(14, 0),
    # What certificates add, with margins and without.
    Configuration(18, 18, tag_bits=1, certified=True),
    Configuration(12, 0, certified=True),
)
DETECTOR_WIDTH = 16

# The mesh engine, where several words of lanes make a group, and several a mesh; with margins and
# certificates, and without.
_MESH = MeshConfiguration(8, 8, depth=32, group=4, lanes=2, cycle_bits=8)
ENGINES = (replace(_MESH, certified=True), replace(_MESH, margin_bits=0))
BOARDS = (parse_board_configuration("board_w12_m5_d128_g8_l4"),)
# Of progress: the cores, the wrapper, the engines and the board, each when it is built and when it is done.
STEPS = 2 * (len(CORES) + 1 + len(ENGINES) + len(BOARDS))

# The tests that run on each model, those that reach most, and the pairs that each sends.
PAIRS = 12_000
_CORE_TESTS = {"MixedTest": PAIRS, "ExtremesTest": 3000, "StallsTest": 3600, "ResetsTest": 4000}
_CERTIFIED_TESTS = {"CertificatesTest": 20_000, **_CORE_TESTS}
_MESH_TESTS = {
    "MeshRandomTest": 20_000, "MeshLimitsTest": 1, "MeshStallsTest": 5000, "MeshAbortTest": 2000,
    "MeshResetsTest": 5000, "MeshTrialsTest": 1,
}  # fmt: skip
_JUDGED_ONE_IN = 1000
_JOBS = 2


@dataclass(frozen=True)
class Run:
    """One test on one model: how many pairs were checked and how many were wrong."""

    model: str
    test: str
    checked: int
    wrong: int
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
        wrong = [f"{r.model}: {r.test}: {r.wrong} of {r.checked} wrong" for r in self.runs if r.wrong]
        idle = [f"{r.model}: {r.test}: nothing was checked" for r in self.runs if not r.checked]
        changed = ["the RTL changed during the run"] if self.changed else []
        return [*wrong, *idle, *changed, *self.assessment.problems]

    @property
    def passed(self) -> bool:
        """Return whether every bin is hit or waived, with right results."""
        return self.assessment.passed and not self.problems


Measured = Configuration | MeshConfiguration | BoardParameters | None


def own_sources(configuration: Measured) -> list[Path]:
    """Return the RTL that is measured in a build: what is below it in another measures that."""
    if isinstance(configuration, Configuration) and configuration.certified:
        return certified_sources()
    if isinstance(configuration, BoardParameters):
        return board_sources()
    return mesh_sources() if isinstance(configuration, MeshConfiguration) else rtl_sources()


def covered(configuration: Measured) -> Build:
    """Return the build that is measured: of the core, the mesh engine, the board or (None) the wrapper."""
    match configuration:
        case None:
            build, rules = detector_build(DETECTOR_WIDTH), ()
        case BoardParameters():
            build, rules = board_build(configuration), assertions(BOARD_SVA)
        case MeshConfiguration():
            build, rules = mesh_build(configuration), assertions(MESH_SVA)
        case _:
            build, rules = core_build(configuration), assertions(CORE_SVA)
    own = own_sources(configuration)
    sources = [source for source in build.sources if source.suffix == ".sv"]
    texts = {path.name: with_antecedents(path) for path in rules}
    for machine in state_machines(sources):
        if machine.source in own:
            texts[f"{machine.name}.sv"] = covers(machine, machine.arcs(sources))
    # What counts by its cover properties alone.
    quiet = [*texts, *(source.name for source in sources if source not in own)]
    texts["counted.vlt"] = "\n".join(
        ["`verilator_config", *(f'coverage_off -file "*/{one}"' for one in quiet), ""]
    )

    def write(folder: Path) -> None:
        for name, text in texts.items():
            (folder / name).write_text(text, encoding="utf-8")

    folder = built(
        BUILD / "coverage" / f"{build.name}-{content_hash((), *texts, *texts.values())[:12]}", write
    )
    sources = (*build.sources, *(folder / name for name in sorted(texts)))
    # Little less speed than more optimising, for much less compiling.
    return replace(build, sources=sources, counters=True, assertions=True, speed=LIGHT, split=5000)


@dataclass(frozen=True)
class _Job:
    """One build, and the tests that run on it."""

    configuration: Measured
    seed: int
    pairs: int
    waivers: list[Waiver]

    @property
    def model(self) -> Build:
        """Return the build."""
        return covered(self.configuration)

    @property
    def tests(self) -> dict[str, int]:
        """Return the tests that run on it, and how many pairs or replies each is asked for."""
        if isinstance(self.configuration, BoardParameters):
            return {one.name: one.runs[0].pairs for one in table().values() if one.block is Block.BOARD}
        if isinstance(self.configuration, MeshConfiguration):
            return _MESH_TESTS
        return _CERTIFIED_TESTS if self.configuration and self.configuration.certified else _CORE_TESTS

    def build(self) -> None:
        """Build and elaborate the model, where needed."""
        library(self.model)
        described(self.model)

    def run(self) -> tuple[list[Run], Assessment]:
        """Run the tests, and assess the coverage of the model."""
        model = self.model
        file = COUNTERS / f"{model.name}.dat"
        runs = [self._ask_wrapper(file)] if self.configuration is None else self._run_tests(file)
        own = {source.stem for source in own_sources(self.configuration)}
        design = read_elaboration(described(model), model.top)
        instances = {path: one for path, one in design.items() if one.module in own}
        return runs, assess_model(ModelCoverage(model.name, read_counters(file), instances), self.waivers)

    def _run_tests(self, file: Path) -> list[Run]:
        """Run the environment's tests on the model, and add up what they covered."""
        path, model = library(self.model), self.model.name
        results: list[RunResult] = []
        for test, pairs in self.tests.items():
            count = -(-self.pairs * pairs // PAIRS)
            settings = run_settings(
                test, model, self.seed, count, folder=COUNTERS / f"{model}-{test}", agent=BURST,
                judged_one_in=_JUDGED_ONE_IN,
            )  # fmt: skip
            results.append(run(settings, model=path))
            if not results[-1].passed:
                raise InputError(f"code coverage: {results[-1].explain()}")
        folders = [Path(result.settings.folder) for result in results]
        add_files([counters_file(folder) for folder in folders], file)
        for folder in folders:
            counters_file(folder).unlink()
        return [
            Run(model, one.settings.test, one.counts["checked"], one.counts["failed"], one.seconds)
            for one in results
            if one.counts
        ]

    def _ask_wrapper(self, file: Path) -> Run:
        start = time.perf_counter()
        player = DetectorPlayer(library(self.model))
        pairs, wrong = ask_at_random(player, self.seed, DETECTOR_WIDTH)
        player.write_coverage(file)
        return Run(self.model.name, "check_detector", pairs, wrong, time.perf_counter() - start)


def _run_all(jobs: list[_Job], progress: Callable[[int], None]) -> list[tuple[list[Run], Assessment]]:
    """Build in threads, which only wait for compilers; then run in processes, whose work is Python's."""
    with ThreadPoolExecutor(_JOBS) as threads:
        for _ in threads.map(_Job.build, jobs):
            progress(1)
    done: list[tuple[list[Run], Assessment]] = []
    with closing(results_in_processes(_Job.run, jobs, workers=_JOBS)) as results:
        for outcome in results:
            done.append(outcome)
            progress(1)
    return done


def measure(
    seed: int,
    pairs: int = PAIRS,
    cores: Sequence[Configuration] = CORES,
    engines: Sequence[MeshConfiguration] = ENGINES,
    boards: Sequence[BoardParameters] = BOARDS,
    waivers: Path = WAIVERS,
    progress: Callable[[int], None] | None = None,
) -> CodeCoverage:
    """Measure code coverage; ``pairs``: those that MixedTest sends on each core, other tests in proportion.

    ``progress`` is told of each model twice: when it is built, and when it is done.
    """
    start = time.perf_counter()
    read = read_waivers(waivers)
    jobs = [_Job(one, seed, pairs, read) for one in (*boards, *engines, *cores, None)]
    # Two runs at once would write each other's counters.
    make_folder(COUNTERS)
    with FileLock(COUNTERS / ".lock"):
        before = rtl_hash()
        done = _run_all(jobs, progress or (lambda _: None))
        together = Assessment()
        for _, assessment in done:
            together.add(assessment)
        whole = conclude(together, generate_blocks([*rtl_sources(), *mesh_sources(), *board_sources()]), read)
        changed = rtl_hash() != before
    runs = [run for some, _ in done for run in some]
    return CodeCoverage(runs, whole, read, time.perf_counter() - start, before, changed)


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
