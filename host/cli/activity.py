"""``triaxis activity``: how much operand gating saves, by counted toggles; the activity for power reports."""

import argparse
import time

from rich.console import Console
from rich.table import Table

from triaxis.bench.activity.measuring import BOUND, SAIF, SAIF_SCENE, Row, measure, trace_scene, write_result
from triaxis.bench.activity.streams import streams
from triaxis.host.cli.progress import progress_bar

WITHIN, BEYOND = 0, 1


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the command."""
    parser = commands.add_parser(
        "activity",
        help="count the toggles of all multipliers with and without operand gating",
        description="Send the same pairs, one in a hundred undecided by its boxes, through the core with and "
        "without operand gating. Writes build/fpga/activity.json, and build/fpga/activity.saif, the activity "
        "of the mesh engine on a scene, for power reports.",
        epilog=f"Exit codes: 0 gating leaves at most {100 * BOUND:g} % of the toggles, 1 more, 2 error.",
    )
    parser.add_argument("--seed", type=int, default=1, help="seed of the random pairs (1)")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Measure, print, write."""
    start = time.perf_counter()
    wanted = streams(options.seed)
    with progress_bar("activity", len(wanted) + 1) as progress:
        rows = measure(wanted, progress=progress)
        engine = trace_scene(SAIF_SCENE)
        progress(1)
    path = write_result(rows, engine, options.seed, time.perf_counter() - start)
    _print(rows)
    print(f"written to {path} and {SAIF.name}")
    return WITHIN if all(row.within_bound for row in rows) else BEYOND


def _print(rows: list[Row]) -> None:
    table = Table(title=f"toggles of all {rows[0].gated.multipliers} multipliers, W = 16, M = 16")
    for heading in ("pairs", "undecided", "ungated", "gated", "share", "at most"):
        table.add_column(heading, justify="left" if heading == "pairs" else "right")
    for row in rows:
        table.add_row(
            f"{row.pairs:,}: {row.name}",
            f"{100 * row.undecided / row.pairs:.2f} %",
            f"{row.ungated.total:,}",
            f"{row.gated.total:,}",
            f"{100 * row.ratio:.2f} %",
            f"{100 * BOUND:g} %" if row.within_bound else f"{100 * BOUND:g} % EXCEEDED",
        )
    Console(width=110).print(table)
