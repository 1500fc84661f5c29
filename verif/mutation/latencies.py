"""The latency of every build: it shows mutants of the package that no pair shows, a clock more or less."""

from pathlib import Path

from triaxis.golden.pairs import MAX_WIDTH, MIN_WIDTH
from triaxis.sim.configuration import Configuration
from triaxis.verif.mutation.elaborated import core_latencies
from triaxis.verif.mutation.models import Killed


def latency_table(folder: Path) -> Killed | None:
    """Hold the package's latencies against the documented ones, at every width."""
    table = every_latency()
    found = core_latencies(folder, list(table))
    if found is None or found == list(table.values()):
        return None
    return Killed("LatencyTable", "every width", "triaxis_pkg", "wrong latency", 0)


def every_latency() -> dict[tuple[int, int], int]:
    """Return the documented latency in clocks for every (W, M) with M = 0, 8 and W."""
    widths = range(MIN_WIDTH, MAX_WIDTH + 1)
    return {(w, m): Configuration(w, m).latency for w in widths for m in (0, 8, w)}
