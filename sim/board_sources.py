"""The board's own RTL files."""

from pathlib import Path

from triaxis.verif.paths import ROOT

BOARD_RTL = ROOT / "fpga" / "rtl"


def board_sources(rtl: Path = BOARD_RTL) -> list[Path]:
    """Return the RTL files of the board, which compile after those of the mesh engine."""
    return [rtl / name for name in (rtl / "board.f").read_text(encoding="utf-8").split()]
