"""Code coverage of the RTL: what the environment's own tests reach, on builds that count.

The tests check every answer as always: coverage by a core that answers wrongly is worth nothing.
"""

import time
from collections.abc import Callable, Iterable, Mapping, Sequence, Set
from contextlib import closing
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import pyslang
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
from triaxis.coverage.elaboration import Instance, read_elaboration
from triaxis.coverage.waiver_upkeep import waiver_records
from triaxis.coverage.waivers import Waiver, read_waivers
from triaxis.golden.errors import InputError
from triaxis.golden.outputs import make_folder
from triaxis.golden.processes import results_in_processes, threads
from triaxis.sim.board_parameters import BoardParameters, parse_board_configuration
from triaxis.sim.build import built
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
from triaxis.sim.validity import Provenance, Sources, standing
from triaxis.sim.verilate import MANY, Build, described, library
from triaxis.verif.code_coverage.state_machines import covers, state_machines
from triaxis.verif.core.detector_check import ask_at_random
from triaxis.verif.testbench.assertions import assertion_names, nodes, with_antecedents
from triaxis.verif.testbench.settings import BURST, TEST_DATA, TEST_MODULES, Block, counters_file
from triaxis.verif.testbench.simulation import run, run_settings
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
# What asks the wrapper, where others run tests.
WRAPPER_CHECK = "check_detector"

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

    ``changed``: what it is valid for was written to during the run.
    """

    runs: list[Run]
    assessment: Assessment
    waivers: list[Waiver]
    seconds: float
    valid_for: Provenance
    changed: bool = False

    @property
    def problems(self) -> list[str]:
        """Return what is wrong, apart from bins that are not covered."""
        wrong = [f"{r.model}: {r.test}: {r.wrong} of {r.checked} wrong" for r in self.runs if r.wrong]
        idle = [f"{r.model}: {r.test}: nothing was checked" for r in self.runs if not r.checked]
        changed = ["the RTL, or its environment, changed during the run"] if self.changed else []
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


def _rules(configuration: Measured) -> tuple[Path, ...]:
    """Return the files of assertions of what is measured."""
    match configuration:
        case None:
            return ()
        case BoardParameters():
            return assertions(BOARD_SVA)
        case MeshConfiguration():
            return assertions(MESH_SVA)
        case _:
            return assertions(CORE_SVA)


def asserted_in(design: Mapping[str, Instance]) -> set[tuple[str, str, str]]:
    """Return what has a label in an elaborated design: the module in which that is bound, its own, the label.

    ``design``: instances by path, outer ones first.
    """
    found: set[tuple[str, str, str]] = set()
    for path, one in design.items():
        outer = (path.rsplit(".", depth)[0] for depth in range(1, path.count(".")))
        around = next((design[place].module for place in outer if place in design), "")
        found |= {(around, one.module, label) for label in one.named}
    return found


def unbound(rules: Iterable[Path], asserted: Set[tuple[str, str, str]]) -> list[str]:
    """Return the assertions that are in none of the models where their files bind them, a line each.

    ``asserted``: those that are, as `asserted_in` gives them. Nothing else would miss one that is bound to
    nothing any more, or to one less of several modules.
    """
    labels: dict[str, list[str]] = {}
    bound: list[tuple[Path, str, str]] = []
    for path in rules:
        for name in assertion_names(path):
            module, _, label = name.partition(".")
            labels.setdefault(module, []).append(label)
        # The tree must outlive its nodes.
        tree = pyslang.syntax.SyntaxTree.fromFile(str(path))
        for bind in nodes(tree.root, pyslang.syntax.BindDirectiveSyntax):
            if isinstance(bind.instantiation, pyslang.syntax.HierarchyInstantiationSyntax):
                bound.append((path, str(bind.target).strip(), bind.instantiation.type.valueText))
    found = [
        f"{path.name}: {module}.{label} is in {target} in none of the models: is it bound there?"
        for path, target, module in bound
        for label in labels.get(module, ())
        if (target, module, label) not in asserted
    ]
    nowhere = labels.keys() - {module for _, _, module in bound}
    return found + [f"{module}: its assertions are bound to no module: bind it" for module in sorted(nowhere)]


def covered(configuration: Measured) -> Build:
    """Return the build that is measured: of the core, the mesh engine, the board or (None) the wrapper."""
    match configuration:
        case None:
            build = detector_build(DETECTOR_WIDTH)
        case BoardParameters():
            build = board_build(configuration)
        case MeshConfiguration():
            build = mesh_build(configuration)
        case _:
            build = core_build(configuration)
    own, rules = own_sources(configuration), _rules(configuration)
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

    folder = built(BUILD / "coverage" / build.name, (), (*texts, *texts.values()), write)
    sources = (*build.sources, *(folder / name for name in sorted(texts)))
    # Compiled about as quickly as with less optimising, which makes the board three times slower.
    return replace(build, sources=sources, counters=True, assertions=True, speed=MANY, split=5000)


@dataclass(frozen=True)
class _Counted:
    """A model that counts: its configuration and its build."""

    configuration: Measured
    build: Build

    @classmethod
    def make(cls, configuration: Measured) -> "_Counted":
        """Build and elaborate the model, where needed."""
        build = covered(configuration)
        library(build)
        described(build)
        return cls(configuration, build)

    def tests(self, seed: int, pairs: int) -> list["_Test"]:
        """Return the tests that run on it, and how many pairs or replies each is asked for."""
        if isinstance(self.configuration, BoardParameters):
            named = {one.name: one.runs[0].pairs for one in table().values() if one.block is Block.BOARD}
        elif isinstance(self.configuration, MeshConfiguration):
            named = _MESH_TESTS
        elif self.configuration is None:
            named = {WRAPPER_CHECK: PAIRS}
        else:
            named = _CERTIFIED_TESTS if self.configuration.certified else _CORE_TESTS
        return [_Test(self.build, name, -(-pairs * count // PAIRS), seed) for name, count in named.items()]


@dataclass(frozen=True)
class _Test:
    """One test of so many pairs on a model."""

    build: Build
    name: str
    pairs: int
    seed: int

    @property
    def folder(self) -> Path:
        """Return where it runs."""
        return COUNTERS / f"{self.build.name}-{self.name}"

    def run(self) -> Run:
        """Run it, which leaves its counters in the folder; raise InputError where it fails."""
        if self.name == WRAPPER_CHECK:
            return self._ask_wrapper()
        settings = run_settings(
            self.name, self.build.name, self.seed, self.pairs, folder=self.folder, agent=BURST,
            judged_one_in=_JUDGED_ONE_IN,
        )  # fmt: skip
        result = run(settings, model=library(self.build))
        if not result.passed or not result.counts:
            raise InputError(f"code coverage: {result.explain()}")
        counts = result.counts
        return Run(self.build.name, self.name, counts["checked"], counts["failed"], result.seconds)

    def _ask_wrapper(self) -> Run:
        start = time.perf_counter()
        player = DetectorPlayer(library(self.build))
        pairs, wrong = ask_at_random(player, self.seed, DETECTOR_WIDTH)
        make_folder(self.folder)
        player.write_coverage(counters_file(self.folder))
        return Run(self.build.name, self.name, pairs, wrong, time.perf_counter() - start)


@dataclass(frozen=True)
class _Count:
    """What the tests of a model counted together."""

    model: _Counted
    folders: Sequence[Path]
    waivers: list[Waiver]

    def assess(self) -> Assessment:
        """Add up what they counted, and assess it."""
        build = self.model.build
        file = COUNTERS / f"{build.name}.dat"
        counted = [counters_file(folder) for folder in self.folders]
        add_files(counted, file)
        for one in counted:
            one.unlink()
        own = {source.stem for source in own_sources(self.model.configuration)}
        design = read_elaboration(described(build), build.top)
        instances = {path: one for path, one in design.items() if one.module in own}
        found = assess_model(ModelCoverage(build.name, read_counters(file), instances), self.waivers)
        found.asserted = asserted_in(design)
        return found


def _run_all(
    models: Sequence[Measured], seed: int, pairs: int, waivers: list[Waiver], progress: Callable[[int], None]
) -> tuple[list[Run], list[Assessment]]:
    """Build in threads, which only wait for compilers; then run and assess in processes.

    A process takes a test, and not all of a model: the board's take as long as those of all others.
    """
    counted: list[_Counted] = []
    with threads(_JOBS) as pool:
        for one in pool.map(_Counted.make, models):
            counted.append(one)
            progress(1)
    tests = [one.tests(seed, pairs) for one in counted]
    with closing(
        results_in_processes(_Test.run, [one for some in tests for one in some], workers=_JOBS)
    ) as ran:
        runs = list(ran)
    counts = [
        _Count(one, [test.folder for test in some], waivers) for one, some in zip(counted, tests, strict=True)
    ]
    assessments: list[Assessment] = []
    with closing(results_in_processes(_Count.assess, counts, workers=_JOBS)) as assessed:
        for one in assessed:
            assessments.append(one)
            progress(1)
    return runs, assessments


def measure(
    seed: int,
    pairs: int = PAIRS,
    cores: Sequence[Configuration] = CORES,
    progress: Callable[[int], None] | None = None,
) -> CodeCoverage:
    """Measure code coverage; ``pairs``: those that MixedTest sends on each core, other tests in proportion.

    ``progress`` is told of each model twice: when it is built, and when it is done.
    """
    start = time.perf_counter()
    # Before it may wait for another run: what is loaded and read here is of now.
    before = standing(SOURCES)
    read = read_waivers()
    # Two runs at once would write each other's counters.
    make_folder(COUNTERS)
    with FileLock(COUNTERS / ".lock"):
        models = (*BOARDS, *ENGINES, *cores, None)
        runs, assessments = _run_all(models, seed, pairs, read, progress or (lambda _: None))
        together = Assessment()
        for assessment in assessments:
            together.add(assessment)
        whole = conclude(together, generate_blocks([*rtl_sources(), *mesh_sources(), *board_sources()]), read)
        rules = dict.fromkeys(path for model in models for path in _rules(model))
        whole.problems += unbound(rules, whole.asserted)
        changed = not before.stands
    return CodeCoverage(runs, whole, read, time.perf_counter() - start, before.valid_for, changed)


def _as_json(total: Total) -> dict[str, int | float | None]:
    return {**asdict(total), "percent": total.percent}


def write_json(result: CodeCoverage, seed: int, path: Path = RESULT, pairs: int = PAIRS) -> Path:
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
        **asdict(result.valid_for),
        "seconds": round(result.seconds, 1),
        "command": f"triaxis coverage code --seed {seed}" + (f" --pairs {pairs}" if pairs != PAIRS else ""),
    }
    return write_evidence(path, content, SOURCES)
