"""The latency of every build: it shows mutants of the package that no pair shows, a clock more or less."""

from pathlib import Path

from triaxis.golden.pairs import MAX_WIDTH, MIN_WIDTH
from triaxis.sim.configuration import Configuration
from triaxis.sim.paths import ROOT
from triaxis.verif.mutation.elaborated import core_latencies
from triaxis.verif.mutation.models import Killed


def latency_table(folder: Path) -> Killed | None:
    """Hold the package's latencies against the README's table, and against every width between its rows."""
    table = readme_latencies() | every_latency()
    found = core_latencies(folder, list(table))
    if found is None or found == list(table.values()):
        return None
    return Killed("LatencyTable", "README", "triaxis_pkg", "wrong latency", 0)


def every_latency() -> dict[tuple[int, int], int]:
    """Return the latency in clocks for every W without and with margins, as it is signed off."""
    points = [(width, margin) for width in range(MIN_WIDTH, MAX_WIDTH + 1) for margin in (0, width)]
    return {point: Configuration(*point).latency for point in points}


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
