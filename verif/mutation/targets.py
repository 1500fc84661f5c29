"""The models in which mutants are looked for: chosen so that every generate branch is in one of them.

And which parts of dut/ a target elaborates, and what the package's functions give: by pyslang, in no time.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

from triaxis.golden.errors import InputError
from triaxis.golden.pairs import MAX_WIDTH, MIN_WIDTH
from triaxis.sim.board_parameters import BoardParameters, parse_board_configuration
from triaxis.sim.configuration import Configuration, parse_configuration
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.models import (
    board_build,
    core_build,
    detector_build,
    mesh_build,
)
from triaxis.sim.paths import DUT, VERIF, certified_sources
from triaxis.sim.slang import compiled
from triaxis.sim.verilate import MANY, QUICK, Build
from triaxis.verif.mutation.syntax import kind, read_source, span
from triaxis.verif.testbench.golden_sample import MOST_SELDOM
from triaxis.verif.testbench.rtl_package import CORE_PACKAGE, Package
from triaxis.verif.testbench.settings import BURST, RunSettings

# The tests that mutants are tried with and the pairs that each sends, the quickest to notice anything first:
# what random pairs leave are mostly widths, which corners show.
_CORE_TESTS = {
    "ExtremesTest": 2400, "RandomTest": 300, "DegenerateTest": 150, "CoplanarTest": 450,
    "PenetratingTest": 150, "SliversTest": 150, "TouchingTest": 1500, "NearMissTest": 750, "TinyTest": 150,
    "FarTest": 150, "RegressionsTest": 1, "StallsTest": 1800, "ResetsTest": 3000, "MixedTest": 6000,
}  # fmt: skip
# Of the certified core: its own first. And where it differs from the core: its files, the package.
_CERTIFIED_TESTS = {"CertificatesTest": 3000, **_CORE_TESTS}
_CERTIFIED_FILES = (CORE_PACKAGE, *(path.relative_to(DUT).as_posix() for path in certified_sources()))
_MESH_TESTS = {
    "MeshRandomTest": 1, "MeshGapsTest": 1, "MeshResetsTest": 1, "MeshStallsTest": 1, "MeshAbortTest": 1,
    "MeshLimitsTest": 1, "MeshTrialsTest": 1, "MeshClocksTest": 1,
}  # fmt: skip
# Pairs of the volume, in the narrowest model, which is the fastest, and in others.
_VOLUME, _OTHER_VOLUME = 1 << 20, 1 << 17
# In an engine that holds so many triangles a mesh; in others the pairs of about as many scenes.
_MESH_VOLUME_DEPTH = 64
_MESH_VOLUME = {
    "MeshResetsTest": 2_000_000, "MeshStallsTest": 500_000,
    "MeshRandomTest": 100_000, "MeshAbortTest": 10_000,
}  # fmt: skip

_BOARD_TESTS = {
    "BoardSmokeTest": 1, "BoardRefusalsTest": 1, "BoardFramesTest": 1, "BoardGoTest": 1,
    "BoardHoldTest": 40, "BoardResetsTest": 40, "BoardSilenceTest": 1, "BoardAbortTest": 1,
    "BoardMixedTest": 150, "BoardFullTest": 1, "BoardTrialsTest": 1,
}  # fmt: skip
_BOARD_VOLUME = 1000

_BOARD_PACKAGE = "board/triaxis_board_pkg.sv"
# A millisecond and the clocks beside it, and the top's own time.
_WATCHDOG_CLOCKS = (1, 99_999, 100_000, 100_001, 10_000_000, (1 << 32) - 1)

EXACT_CORE = VERIF / "mutation" / "exact_core"
_DATAPATH = "triaxis_datapath.sv"


def _runs(tests: Mapping[str, int], config: str, seed: int) -> tuple[RunSettings, ...]:
    """Return the runs of tests with so many pairs each, of which the golden model judges few."""
    return tuple(
        RunSettings(test, seed, config, pairs, "", agent=BURST, judged_one_in=MOST_SELDOM)
        for test, pairs in tests.items()
    )


@dataclass(frozen=True)
class Target:
    """The core in one configuration, or (``combinational``) the wrapper around it, which has no clock.

    Of a target, mutants with a build each are tried by the first ``quick_tests`` of the short tests, or all
    (None), on what compiles soonest. For what these leave, and all other tests, it is compiled at ``speed``,
    with assertions.
    """

    configuration: Configuration
    combinational: bool = False
    quick_tests: ClassVar[int | None] = None
    speed: ClassVar[str] = QUICK
    clock: ClassVar[str] = "clk_i"

    @property
    def name(self) -> str:
        """Return its name."""
        return f"detector_w{self.configuration.width}" if self.combinational else self.configuration.name

    def build(self, dut: Path) -> Build:
        """Return the build of the RTL in a folder, quickly made, without assertions."""
        made = (
            detector_build(self.configuration.width, dut)
            if self.combinational
            else core_build(self.configuration, dut)
        )
        return replace(made, speed=QUICK)

    def mutates(self, file: str) -> bool:
        """Return whether this is where mutants of that file of dut/ are looked for."""
        return file in _CERTIFIED_FILES if self.configuration.certified else file.startswith("core/")

    def tests(self, seed: int, times: int = 1) -> tuple[RunSettings, ...]:
        """Return the short tests, with so many times the pairs."""
        tests = _CERTIFIED_TESTS if self.configuration.certified else _CORE_TESTS
        return _runs({test: times * pairs for test, pairs in tests.items()}, self.configuration.name, seed)

    def volume(self, seed: int) -> tuple[RunSettings, ...]:
        """Return the long test; none of the wrapper, which has no environment."""
        if self.combinational:
            return ()
        pairs = _VOLUME if self.configuration.width == MIN_WIDTH else _OTHER_VOLUME
        test = "CertificatesTest" if self.configuration.certified else "VolumeTest"
        return _runs({test: pairs}, self.configuration.name, seed)


@dataclass(frozen=True)
class EngineTarget:
    """The mesh engine in one configuration, the core in it without mutants: that has targets of its own.

    ``exact_core``: with the checker of golden/ for the core's data path, which is quick to build.
    """

    configuration: MeshConfiguration
    exact_core: bool = False

    combinational = False
    quick_tests: ClassVar[int | None] = None
    speed: ClassVar[str] = QUICK
    clock: ClassVar[str] = "clk_i"

    @property
    def name(self) -> str:
        """Return its name, that of the configuration."""
        return f"mesh_{self.configuration.name}"

    def build(self, dut: Path) -> Build:
        """Return the build of the RTL in a folder, quickly made, without assertions."""
        made = self.made(dut)
        sources = made.sources
        if self.exact_core:
            sources = tuple(EXACT_CORE / one.name if one.name == _DATAPATH else one for one in sources)
        return replace(made, sources=sources, speed=QUICK)

    def made(self, dut: Path) -> Build:
        """Return the usual build of the RTL in a folder."""
        return mesh_build(self.configuration, dut)

    def mutates(self, file: str) -> bool:
        """Return whether this is where mutants of that file of dut/ are looked for."""
        return file.startswith("mesh/")

    def tests(self, seed: int) -> tuple[RunSettings, ...]:
        """Return the short tests."""
        return _runs(_MESH_TESTS, self.name, seed)

    def volume(self, seed: int) -> tuple[RunSettings, ...]:
        """Return the long tests."""
        depth = self.configuration.depth
        pairs = {test: full * depth**2 // _MESH_VOLUME_DEPTH**2 for test, full in _MESH_VOLUME.items()}
        return _runs(pairs, self.name, seed + 1)


@dataclass(frozen=True)
class BoardTarget(EngineTarget):
    """The board in one configuration, with the checker of golden/ for the core's data path."""

    configuration: BoardParameters  # pyright: ignore[reportIncompatibleVariableOverride]
    exact_core: bool = True
    quick_tests: ClassVar[int | None] = 1
    speed: ClassVar[str] = MANY
    clock: ClassVar[str] = "clk_100mhz_i"
    chosen: tuple[str, ...] = tuple(_BOARD_TESTS)

    @property
    def name(self) -> str:
        """Return its name, that of the configuration."""
        return self.configuration.name

    def made(self, dut: Path) -> Build:
        """Return the usual build of the RTL in a folder."""
        return board_build(self.configuration, dut)

    def mutates(self, file: str) -> bool:
        """Return whether this is where mutants of that file of dut/ are looked for."""
        return file.startswith("board/")

    def tests(self, seed: int) -> tuple[RunSettings, ...]:
        """Return the short tests."""
        return _runs({test: _BOARD_TESTS[test] for test in self.chosen}, self.name, seed)

    def volume(self, seed: int) -> tuple[RunSettings, ...]:
        """Return the long test."""
        return _runs({"BoardMixedTest": _BOARD_VOLUME}, self.name, seed + 1)


AnyTarget = Target | EngineTarget

# Narrow where possible: extremes are as likely as anything else, and a simulation is fast.
MAIN = Target(parse_configuration("w8_m8"))
# Without margins; multipliers that are split and swapped; padding above the coordinates.
PLAIN = Target(parse_configuration("w18_m0_t1"))
# Both operands of multipliers split; no edge x box axes, no gating.
WIDE = Target(parse_configuration("w32_m0_no_edge_box_ungated"))
# Narrow pieces of either operand, one beside a whole lower piece of the other; both operands split, with
# margins.
NARROW = Target(parse_configuration("w26_m3_t1"))
WRAPPER = Target(Configuration(8, 0), combinational=True)
# With certificates: with margins, and without.
CERTIFIED = Target(parse_configuration("w8_m8_certified"))
CERTIFIED_PLAIN = Target(parse_configuration("w12_m0_t1_certified"))

# The smallest: what a mutant that needs a build of its own is built as first.
SMALLEST = Target(parse_configuration("w8_m0_no_edge_box"))

# Where the top piece of a multiplier's operand fills the 25-bit port, and the 18-bit one. For what survives
# everywhere else.
FULL_PIECES = (Target(parse_configuration("w23_m17_t1")), Target(parse_configuration("w24_m24_t1")))

# Several words of lanes in a group, and of groups in a mesh.
ENGINE = EngineTarget(MeshConfiguration(8, 8, depth=64, group=8, lanes=2, cycle_bits=9))
# One triangle in a group, one lane, no margins, the core certified.
ENGINE_SINGLE = EngineTarget(
    MeshConfiguration(8, 0, depth=16, group=1, lanes=1, cycle_bits=8, certified=True)
)
# One word of lanes in a group, one of groups in a mesh; margins narrower than coordinates, no operand gating.
ENGINE_WORD = EngineTarget(MeshConfiguration(8, 3, depth=16, group=4, lanes=4, cycle_bits=8, gating=False))

# Coordinates with bits above them in their bytes, and more near pairs than displays show; the widest, where
# all poses fit, without margins.
BOARD = BoardTarget(parse_board_configuration("board_w12_m5_d128_g8_l4"))
BOARD_WIDE = BoardTarget(
    parse_board_configuration("board_w32_m0_d16_g4_l2"), chosen=("BoardSmokeTest", "BoardRefusalsTest")
)

TARGETS: tuple[AnyTarget, ...] = (
    MAIN, PLAIN, WIDE, NARROW, CERTIFIED, CERTIFIED_PLAIN, WRAPPER,
    ENGINE, ENGINE_SINGLE, ENGINE_WORD, BOARD, BOARD_WIDE,
)  # fmt: skip


def elaborated(target: AnyTarget, dut: Path = DUT) -> frozenset[tuple[str, int]]:
    """Return where the modules and generate blocks begin that a target elaborates: (file, offset).

    Only of files whose mutants are looked for there.
    """
    import pyslang.ast as ast

    # What stands in for the data path has no mutants.
    if isinstance(target, EngineTarget):
        target = replace(target, exact_core=False)
    build = target.build(dut)
    compilation = compiled(build.sources, build.dut / "core", build.top, build.parameters)
    blocks: set[tuple[str, int]] = set()

    def visit(symbol: Any) -> Any:
        name = str(symbol.kind).rpartition(".")[2]
        if name == "GenerateBlock" and symbol.isUninstantiated:
            return ast.VisitAction.Skip
        if name in ("GenerateBlock", "InstanceBody") and symbol.syntax is not None:
            start = symbol.syntax.sourceRange.start
            place = Path(compilation.sourceManager.getFileName(start)).resolve()
            blocks.add((place.relative_to(dut.resolve()).as_posix(), start.offset))
        return ast.VisitAction.Advance

    for instance in compilation.getRoot().topInstances:
        instance.visit(visit)
    # Functions and constants of the package serve every target.
    blocks.update(_packages(build))
    return frozenset(block for block in blocks if target.mutates(block[0]))


def _packages(build: Build) -> list[tuple[str, int]]:
    found: list[tuple[str, int]] = []
    for source in build.sources:
        if source.name.endswith("_pkg.sv"):
            parsed = read_source(source, build.dut)
            found += [(parsed.name, span(m)[0]) for m in parsed.modules if kind(m) == "PackageDeclaration"]
    return found


def right_package(dut: Path, file: str) -> bool:
    """Return whether a package in a folder gives what is signed off: latencies, times; True of others.

    It shows mutants that no simulation of one configuration shows: a clock more or less. True as well where
    it does not evaluate.
    """
    due: dict[str, dict[tuple[int, ...], int]] = {}
    if file == CORE_PACKAGE:
        due = {"core_latency": every_latency(), "certified_latency": every_latency(certified=True)}
    elif file == _BOARD_PACKAGE:
        due = {"watchdog_ms": {(clocks,): -(-clocks // 100_000) for clocks in _WATCHDOG_CLOCKS}}
    if not due:
        return True
    package = Package(dut, file)
    try:
        return all(
            package.call(function, *point) == value
            for function, values in due.items()
            for point, value in values.items()
        )
    except InputError:
        return True


def every_latency(certified: bool = False) -> dict[tuple[int, ...], int]:
    """Return the latency in clocks for every W, with no, some and all margin bits, as it is signed off."""
    points = [(width, margin) for width in range(MIN_WIDTH, MAX_WIDTH + 1) for margin in (0, 8, width)]
    return {point: Configuration(*point, certified=certified).latency for point in points}
