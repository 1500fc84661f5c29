"""What a bitstream of the board is built from: part, top module, sources, parameters."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from triaxis.golden.errors import InputError

FPGA = Path(__file__).resolve().parent
TOP_RTL = FPGA / "nexys4ddr_top.sv"
VIVADO = FPGA / "vivado"
BUILD_SCRIPT = VIVADO / "build.tcl"
CONSTRAINTS = VIVADO / "nexys4ddr.xdc"

PART = "xc7a100tcsg324-1"
TOP = "nexys4ddr_top"
# The mesh engine in the top.
ENGINE_INSTANCE = "u_mesh"

# The drop-in wrapper is no part of the board.
_ELSEWHERE = "CollisionDetector.sv"


@dataclass(frozen=True)
class BoardParameters:
    """Parameters of the top; see its header. The default is the build that is signed off for the board."""

    width: int = 16
    margin_bits: int = 16
    depth: int = 4096
    group: int = 8
    lanes: int = 8

    def generics(self, build_id: int = 0) -> dict[str, str]:
        """Return the top's parameters as Verilog constants; ``build_id`` has 32 bits."""
        return {
            "W": str(self.width),
            "M": str(self.margin_bits),
            "Depth": str(self.depth),
            "Group": str(self.group),
            "Lanes": str(self.lanes),
            "BuildId": f"32'h{build_id:08x}",
        }


@dataclass(frozen=True)
class Inputs:
    """Everything that a build reads: sources in order, include folders, parameters, simulated activity."""

    sources: tuple[Path, ...]
    include: tuple[Path, ...]
    generics: Mapping[str, str] = field(default_factory=dict)
    activity: Path | None = None


def board_sources(dut: Path) -> list[Path]:
    """Return the files of the whole top in the order in which they compile.

    Raises InputError where a list of files is missing or empty.
    """
    return [
        *_listed(dut / "core" / "triaxis.f"),
        *_listed(dut / "mesh" / "triaxis_mesh.f"),
        *_listed(dut / "board" / "triaxis_board.f"),
        TOP_RTL,
    ]


def _listed(listing: Path) -> list[Path]:
    try:
        names: Iterable[str] = listing.read_text(encoding="utf-8").split()
    except OSError as error:
        raise InputError(f"{listing}: cannot read the list of files: {error.strerror}") from error
    found = [listing.parent / name for name in names if name != _ELSEWHERE]
    missing = [path for path in found if not path.is_file()]
    if missing or not found:
        raise InputError(f"{listing}: {missing[0] if missing else 'no file'}: not there")
    return found
