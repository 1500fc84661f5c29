"""The board: what its part offers, what a bitstream is built from."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.sim.board_parameters import TOP_TIMES, BoardParameters
from triaxis.sim.paths import board_sources, core_sources, mesh_sources

FPGA = Path(__file__).resolve().parent
VIVADO = FPGA / "vivado"
BUILD_SCRIPT = VIVADO / "build.tcl"
CONSTRAINTS = VIVADO / "nexys4ddr.xdc"

PART = "xc7a100tcsg324-1"
TOP = "nexys4ddr_top"
# The mesh engine in the top.
ENGINE_INSTANCE = "u_mesh"

# The build that is signed off for the board, and that the board's environment simulates by its name.
SIGNED_OFF = BoardParameters(depth=4096, certify=True, **TOP_TIMES)

# What is in the top twice, so that one half finds what goes wrong in the other: no synthesis may merge it.
TWICE = tuple(
    place.format(k)
    for place in (
        "g_watchdog[{}].u_watchdog",
        "g_runner[{}].u_runner",
        "g_safety[{}].u_safety",
        "u_command.g_request[{}].u_request",
        "u_mesh.g_walk[{}].u_walk",
        "u_mesh.u_store_a.g_intake[{}].u_intake",
        "u_mesh.u_store_b.g_intake[{}].u_intake",
    )
    for k in range(2)
)


@dataclass(frozen=True)
class Resources:
    """DSP blocks, look-up tables, flip-flops, and block RAMs of 36 kbit; one of 18 kbit counts as half."""

    dsps: int
    luts: int
    ffs: int
    brams: float = 0


@dataclass(frozen=True)
class Limits:
    """The most that a build may take of each; None: no limit of its own."""

    dsps: int | None = None
    luts: int | None = None
    ffs: int | None = None
    brams: float | None = None

    def exceeded(self, used: Resources) -> list[str]:
        """Return the names of the resources of which more is used."""
        bounds = vars(self)
        return [name for name, bound in bounds.items() if bound is not None and getattr(used, name) > bound]


# XC7A100T, from the 7 Series FPGAs Overview (DS180).
XC7A100T = Resources(dsps=240, luts=63_400, ffs=126_800, brams=135)

# Room for routing, and for what comes later.
BOARD_LIMITS = Limits(dsps=200, luts=XC7A100T.luts * 70 // 100, brams=XC7A100T.brams * 0.8)
WHOLE_PART = Limits(**vars(XC7A100T))


def generics(parameters: BoardParameters, build_id: int = 0) -> dict[str, str]:
    """Return the top's parameters as Verilog constants, all that were simulated; ``build_id`` has 32 bits."""
    return {
        **{name: str(value) for name, value in parameters.rtl.items()},
        "Certify": f"1'b{int(parameters.certify)}",
        "BuildId": f"32'h{build_id:08x}",
    }


@dataclass(frozen=True)
class Inputs:
    """Everything that a build reads: sources in order, include folders, parameters, simulated activity."""

    sources: tuple[Path, ...]
    include: tuple[Path, ...]
    generics: Mapping[str, str] = field(default_factory=dict)
    activity: Path | None = None


def bitstream_sources(dut: Path) -> list[Path]:
    """Return the files of the whole top in the order in which they compile.

    Raises InputError where a list of files cannot be read, or one of them is missing.
    """
    try:
        found = [*core_sources(dut), *mesh_sources(dut), *board_sources(dut)]
    except OSError as error:
        raise InputError(f"{error.filename}: cannot read the list of files: {error.strerror}") from error
    if missing := [path for path in found if not path.is_file()]:
        raise InputError(f"{missing[0]}: not there")
    return found
