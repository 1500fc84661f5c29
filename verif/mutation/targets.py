"""The models in which mutants are looked for: chosen so that every generate branch is in one of them."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from triaxis.sim.build import core_files, mesh_files
from triaxis.sim.configuration import Configuration, parse_configuration
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.paths import VERIF, mesh_sources, rtl_sources

_SVA = VERIF / "core" / "sva"
EXACT_CORE = VERIF / "mutation" / "exact_core"
_DATAPATH = "triaxis_datapath.sv"


@dataclass(frozen=True)
class Target:
    """A top module in one configuration. ``latency``: in clocks; 0 for the wrapper, which has none."""

    name: str
    top: str
    configuration: Configuration
    latency: int

    @property
    def combinational(self) -> bool:
        """Return whether this is the wrapper, which has no clock."""
        return self.top == "CollisionDetector"

    @property
    def assertions(self) -> list[Path]:
        """Return the files of verif/core/sva/ that go with it."""
        return [] if self.combinational else sorted(_SVA.glob("*.sv"))

    @property
    def harness(self) -> str:
        """Return the file of the harness."""
        return "detector.cpp" if self.combinational else "core.cpp"

    @property
    def defines(self) -> tuple[str, ...]:
        """Return what the harness must be told."""
        return (f"-DMARGIN_BITS={self.configuration.margin_bits}",)

    @property
    def parameters(self) -> Mapping[str, int]:
        """Return the parameters of the top module."""
        return {"W": self.configuration.width} if self.combinational else self.configuration.parameters

    def sources(self, dut: Path) -> list[Path]:
        """Return the files of ``dut`` in the order in which they compile."""
        return rtl_sources(dut)

    def depends_on(self, dut: Path) -> list[Path]:
        """Return the files of ``dut`` that a build depends on."""
        return core_files(dut)

    def mutates(self, file: str) -> bool:
        """Return whether this is where mutants of that file of dut/ are looked for."""
        return file.startswith("core/")


@dataclass(frozen=True)
class EngineTarget:
    """The mesh engine in one configuration, the core in it without mutants: that has targets of its own.

    ``exact_core``: with the checker of golden/ for the core's data path, which is quick to build.
    """

    configuration: MeshConfiguration
    exact_core: bool = False

    top = "triaxis_mesh"
    harness = "engine.cpp"
    combinational = False

    @property
    def name(self) -> str:
        """Return its name, that of the configuration."""
        return f"mesh_{self.configuration.name}"

    @property
    def assertions(self) -> list[Path]:
        """Return the files of verif/core/sva/ that go with it."""
        return sorted((VERIF / "mesh" / "sva").glob("*.sv"))

    @property
    def defines(self) -> tuple[str, ...]:
        """Return what the harness must be told."""
        made = self.configuration
        return (
            f"-DWIDTH={made.width}",
            f"-DMARGIN_BITS={made.margin_bits}",
            f"-DINDEX_BITS={made.index_bits}",
            f"-DCYCLE_BITS={made.cycle_bits}",
        )

    @property
    def parameters(self) -> Mapping[str, int]:
        """Return the parameters of the top module."""
        return self.configuration.parameters

    def sources(self, dut: Path) -> list[Path]:
        """Return the files of ``dut`` in the order in which they compile."""
        core = rtl_sources(dut)
        if self.exact_core:
            core = [EXACT_CORE / path.name if path.name == _DATAPATH else path for path in core]
        return [*core, *mesh_sources(dut)]

    def depends_on(self, dut: Path) -> list[Path]:
        """Return the files of ``dut`` that a build depends on."""
        return mesh_files(dut)

    def mutates(self, file: str) -> bool:
        """Return whether this is where mutants of that file of dut/ are looked for."""
        return file.startswith("mesh/")


AnyTarget = Target | EngineTarget


def _core(name: str) -> Target:
    configuration = parse_configuration(name)
    return Target(name, "triaxis_core", configuration, configuration.latency)


# Narrow where possible: extremes are as likely as anything else, and a simulation is fast.
MAIN = _core("w8_m8")
# Without margins; multipliers that are split and swapped; padding above the coordinates.
PLAIN = _core("w18_m0_t1")
# Both operands of multipliers split; no edge x box axes, no gating.
WIDE = _core("w32_m0_no_edge_box_ungated")
WRAPPER = Target("detector_w8", "CollisionDetector", Configuration(8, 0), 0)

# The smallest: what a mutant that needs a build of its own is built as first.
SMALLEST = _core("w8_m0_no_edge_box")

# Where the top piece of a multiplier's operand fills the 25-bit port, and the 18-bit one. For what survives
# everywhere else.
FULL_PIECES = (_core("w23_m17_t1"), _core("w24_m24_t1"))

# Several words of lanes in a group, and of groups in a mesh.
ENGINE = EngineTarget(MeshConfiguration(8, 8, depth=64, group=8, lanes=2, cycle_bits=9))
# One triangle in a group, one lane, no margins.
ENGINE_SINGLE = EngineTarget(MeshConfiguration(8, 0, depth=16, group=1, lanes=1, cycle_bits=8))
# One word of lanes in a group, one of groups in a mesh; margins narrower than coordinates, no operand gating.
ENGINE_WORD = EngineTarget(MeshConfiguration(8, 3, depth=16, group=4, lanes=4, cycle_bits=8, gating=False))

TARGETS: tuple[AnyTarget, ...] = (MAIN, PLAIN, WIDE, WRAPPER, ENGINE, ENGINE_SINGLE, ENGINE_WORD)
