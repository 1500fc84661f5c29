"""Where things are: in a checkout, or in what was installed of one."""

from pathlib import Path

from triaxis.golden.outputs import build_folder

ROOT = Path(__file__).resolve().parents[1]
DUT = ROOT / "dut"
SIM = ROOT / "sim"
VERIF = ROOT / "verif"
BUILD = build_folder()


def rtl_sources(dut: Path = DUT) -> list[Path]:
    """Return the RTL files of the core in the order in which they compile."""
    return listed(dut / "core" / "triaxis.f")


def core_sources(dut: Path = DUT) -> list[Path]:
    """Return those that a design of today takes: all but the wrapper of the replaced one."""
    return [source for source in rtl_sources(dut) if source.name != "CollisionDetector.sv"]


def certified_sources() -> list[Path]:
    """Return those of the core's RTL files that the certified core alone elaborates."""
    names = ("reach", "apart", "certifier", "certified_core")
    return [DUT / "core" / f"triaxis_{name}.sv" for name in names]


def mesh_sources(dut: Path = DUT) -> list[Path]:
    """Return the RTL files of the mesh engine, which compile after those of the core."""
    return listed(dut / "mesh" / "triaxis_mesh.f")


def board_sources(dut: Path = DUT) -> list[Path]:
    """Return the RTL files of the board and its top, which compile after those of the mesh engine."""
    return listed(dut / "board" / "triaxis_board.f")


def listed(listing: Path) -> list[Path]:
    """Return the files that a list of files names, in its order."""
    return [listing.parent / name for name in listing.read_text(encoding="utf-8").split()]
