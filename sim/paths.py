"""Where things are in the checkout."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
DUT = ROOT / "dut"
VERIF = ROOT / "verif"
BUILD = ROOT / "build"


def rtl_sources() -> list[Path]:
    """Return the RTL files of the core in the order in which they compile."""
    return [DUT / name for name in (DUT / "triaxis.f").read_text().split()]


def mesh_sources(dut: Path = DUT) -> list[Path]:
    """Return the RTL files of the mesh engine, which compile after those of the core."""
    folder = dut / "mesh"
    return [folder / name for name in (folder / "triaxis_mesh.f").read_text().split()]
