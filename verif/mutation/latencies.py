"""The latency of every build: it shows mutants of the package that no pair shows, a clock more or less."""

from pathlib import Path

from triaxis.golden.pairs import MAX_WIDTH, MIN_WIDTH
from triaxis.sim.paths import ROOT
from triaxis.verif.mutation.elaborated import core_latencies
from triaxis.verif.mutation.models import Killed

# In clocks at M = 0, from the first width that has it; one clock more with margins.
_FIRST_WIDTHS = {8: 23, 13: 24, 18: 26, 25: 28}


def latency_table(folder: Path) -> Killed | None:
    """Hold the package's latencies against the README's table, and against every width between its rows."""
    table = readme_latencies() | every_latency()
    found = core_latencies(folder, list(table))
    if found is None or found == list(table.values()):
        return None
    return Killed("LatencyTable", "README", "triaxis_pkg", "wrong latency", 0)


def every_latency() -> dict[tuple[int, int], int]:
    """Return the latency in clocks for every W without and with margins, as it is signed off."""
    clocks = {
        width: _FIRST_WIDTHS[max(first for first in _FIRST_WIDTHS if first <= width)]
        for width in range(MIN_WIDTH, MAX_WIDTH + 1)
    }
    return {(w, 0): row for w, row in clocks.items()} | {(w, w): row + 1 for w, row in clocks.items()}


def latency_section() -> str:
    """Return the text of the README's section on latency."""
    return (ROOT / "README.md").read_text().split("### Latency")[1].split("###")[0]


def readme_latencies() -> dict[tuple[int, int], int]:
    """Return the latency in clocks for (W, M), from the README's table."""
    table: dict[tuple[int, int], int] = {}
    for line in latency_section().splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if len(cells) == 4 and all(cell.isdigit() for cell in cells):
            width, none, eight, full = map(int, cells)
            table |= {(width, 0): none, (width, 8): eight, (width, width): full}
    return table
