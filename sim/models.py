"""The builds of each block: core, wrapper, mesh engine, board. Variants are made by `replace`."""

from dataclasses import replace
from pathlib import Path

from triaxis.sim.board_parameters import BoardParameters
from triaxis.sim.build import core_files, mesh_files, rtl_files
from triaxis.sim.configuration import CERTIFIED_TOP, CORE_TOP, Configuration
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.paths import DUT, SIM, VERIF, board_sources, mesh_sources, rtl_sources
from triaxis.sim.verilate import FAST, MANY, QUICK, Build, Form

MESH_TOP, DETECTOR_TOP, BOARD_TOP = "triaxis_mesh", "CollisionDetector", "nexys4ddr_top"
BARE_TOP = "triaxis_bare_tb"

# Sixteen of 32 bits fill the widest vectors that there are; more of them than caches hold are slower.
LANES = 16

CORE_SVA, MESH_SVA, BOARD_SVA = (VERIF / block / "sva" for block in ("core", "mesh", "board"))


def assertions(folder: Path) -> tuple[Path, ...]:
    """Return the files of a folder of assertions that compile after the RTL."""
    return tuple(sorted(folder.glob("*.sv")))


def _speed(dut: Path) -> str:
    """Return how fast a model of the RTL in a folder is to be: a changed copy runs for a moment."""
    return FAST if dut == DUT else QUICK


def core_build(configuration: Configuration, dut: Path = DUT) -> Build:
    """Return the core as a library; see core_engine.py."""
    defines = {
        "WIDTH": configuration.width,
        "MARGIN_BITS": configuration.margin_bits,
        "TAG_BITS": configuration.sent_bits,
    }
    return Build(
        configuration.name, configuration.top, configuration.parameters, tuple(rtl_sources(dut)),
        (SIM / "core_player.cpp",), tuple(core_files(dut)), defines=defines, dut=dut, speed=_speed(dut),
    )  # fmt: skip


def lockstep_build(configuration: Configuration) -> Build:
    """Return many cores in lockstep as a library; see core_engine.py."""
    build = core_build(configuration)
    return replace(build, cpp=(SIM / "lanes_player.cpp",), lanes=LANES)


def asserted(build: Build) -> Build:
    """Return a library that checks assertions: its RTL's, and the environment's of its block."""
    rules = {CORE_TOP: CORE_SVA, CERTIFIED_TOP: CORE_SVA, MESH_TOP: MESH_SVA, BOARD_TOP: BOARD_SVA}
    more = assertions(rules[build.top]) if build.top in rules else ()
    return replace(build, assertions=True, sources=(*build.sources, *more))


def detector_build(width: int, dut: Path = DUT) -> Build:
    """Return the wrapper CollisionDetector as a library; see detector.py."""
    return Build(
        f"detector_w{width}", DETECTOR_TOP, {"W": width}, tuple(rtl_sources(dut)),
        (SIM / "detector_player.cpp",), tuple(core_files(dut)), dut=dut,
    )  # fmt: skip


def mesh_build(configuration: MeshConfiguration, dut: Path = DUT) -> Build:
    """Return the mesh engine as a library, in which one sees what reaches the core; see mesh_engine.py."""
    defines = {
        "WIDTH": configuration.width,
        "MARGIN_BITS": configuration.margin_bits,
        "INDEX_BITS": configuration.index_bits,
        "CYCLE_BITS": configuration.cycle_bits,
    }
    return Build(
        f"mesh_{configuration.name}", MESH_TOP, configuration.parameters,
        (*rtl_sources(dut), *mesh_sources(dut), SIM / "mesh_public.vlt"), (SIM / "mesh_player.cpp",),
        tuple(mesh_files(dut)), defines=defines, dut=dut, speed=_speed(dut),
    )  # fmt: skip


def board_build(parameters: BoardParameters, dut: Path = DUT) -> Build:
    """Return the whole board as a library; see simulated_board.py.

    It runs for millions of clocks on a changed copy, too.
    """
    defines = {
        "CLOCKS_PER_THREE_BITS": parameters.clocks_per_three_bits,
        "DIGIT_CLOCKS": parameters.digit_clocks,
    }
    return Build(
        parameters.name, BOARD_TOP, parameters.rtl,
        (*rtl_sources(dut), *mesh_sources(dut), *board_sources(dut)), (SIM / "board_player.cpp",),
        tuple(rtl_files(dut)), defines=defines, dut=dut, speed=FAST if dut == DUT else MANY,
    )  # fmt: skip


def _pins(name: str, top: str, parameters: dict[str, int], sources: tuple[Path, ...], dut: Path) -> Build:
    """Return a program for cocotb. It is not the bottleneck under Python: compiled quickly."""
    from cocotb_tools.config import share_dir

    main = share_dir / "lib" / "verilator" / "verilator.cpp"
    return Build(
        name, top, parameters, sources, (main,), tuple(core_files(dut)), dut=dut, form=Form.PINS,
        assertions=True, speed=QUICK,
    )  # fmt: skip


def pin_build(configuration: Configuration, dut: Path = DUT) -> Build:
    """Return the core with its pins and its assertions as a program for cocotb."""
    sources = (CORE_SVA / "public.vlt", *rtl_sources(dut), *assertions(CORE_SVA))
    return _pins(configuration.name, configuration.top, configuration.parameters, sources, dut)


def mesh_pin_build(configuration: MeshConfiguration, dut: Path = DUT) -> Build:
    """Return the mesh engine with its pins and its assertions as a program for cocotb."""
    sources = (
        MESH_SVA / "public.vlt", *rtl_sources(dut), *mesh_sources(dut), *assertions(MESH_SVA),
    )  # fmt: skip
    return _pins(f"mesh_{configuration.name}", MESH_TOP, configuration.parameters, sources, dut)


def board_pin_build(parameters: BoardParameters, dut: Path = DUT) -> Build:
    """Return the whole board with its pins and its assertions as a program for cocotb."""
    sources = (
        BOARD_SVA / "public.vlt", *rtl_sources(dut), *mesh_sources(dut), *board_sources(dut),
        *assertions(BOARD_SVA),
    )  # fmt: skip
    return _pins(parameters.name, BOARD_TOP, parameters.rtl, sources, dut)


def bare_build() -> Build:
    """Return a program for cocotb with nothing in it: what is under test stands beside it, as a library."""
    return _pins("bare", BARE_TOP, {}, (SIM / "bare_tb.vlt", SIM / f"{BARE_TOP}.sv"), DUT)
