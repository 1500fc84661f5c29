"""RTL with one place of it broken, for tests that must see it."""

import shutil
from pathlib import Path

from triaxis.sim.paths import DUT


def broken_rtl(folder: Path, *changes: tuple[str, str, str]) -> Path:
    """Return a copy of the RTL in which of each file the first text is the second; its builds are kept."""
    copy = folder / "dut"
    shutil.copytree(DUT, copy)
    for file, right, wrong in changes:
        text = (copy / file).read_text()
        assert text.count(right) == 1, "the RTL has changed: adapt the fault"
        (copy / file).write_text(text.replace(right, wrong))
    return copy
