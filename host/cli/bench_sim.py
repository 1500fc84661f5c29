"""``triaxis bench-sim``: how fast the simulations are, against the bare core."""

import argparse

from rich.console import Console
from rich.table import Table

from triaxis.bench.speed import BOUNDS, STEPS, SimSpeeds, bench_sim, write_speeds
from triaxis.host.cli.progress import progress_bar

REACHED, MISSED = 0, 1


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the command."""
    parser = commands.add_parser(
        "bench-sim",
        help="measure the speed of the simulations",
        description="Measure pairs a second of the bare core, the burst environment, the pin environment and "
        "the bulk checker, at W = 16 and M = 0. Writes build/bench/sim.json.",
        epilog="Exit codes: 0 all ratios reach their bounds, 1 one does not, 2 error.",
    )
    parser.set_defaults(run=run)


def run(_options: argparse.Namespace) -> int:
    """Measure, print, write."""
    with progress_bar("measurements", STEPS) as progress:
        speeds = bench_sim(progress)
    path = write_speeds(speeds)
    _print(speeds)
    print(f"written to {path}")
    missed = [name for name, bound in BOUNDS.items() if speeds.ratios[name] < bound]
    return MISSED if missed else REACHED


def _print(speeds: SimSpeeds) -> None:
    console = Console(width=100)
    table = Table(title="W = 16, M = 0, best of several rounds")
    table.add_column("what")
    table.add_column("pairs/s", justify="right")
    for name in speeds.__dataclass_fields__:
        table.add_row(name, f"{getattr(speeds, name):,.0f}")
    console.print(table)
    ratios = Table(title="ratios")
    for heading in ("ratio", "measured", "at least", ""):
        ratios.add_column(heading, justify="left" if heading == "ratio" else "right")
    for name, ratio in speeds.ratios.items():
        bound = BOUNDS.get(name)
        verdict = "" if bound is None else "reached" if ratio >= bound else "MISSED"
        ratios.add_row(name, f"{ratio:.2f}", "" if bound is None else f"{bound:g}", verdict)
    console.print(ratios)
