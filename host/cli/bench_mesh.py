"""``triaxis bench-mesh``: what whole scenes cost the mesh engine."""

import argparse

from rich.console import Console
from rich.table import Table

from triaxis.bench.mesh_cycles import CLOCK_MHZ, CONFIGURATION, Row, bench_mesh, cases, write_rows
from triaxis.host.cli.progress import progress_bar
from triaxis.verif.signoff.scene_checks import mesh_data

REACHED, MISSED = 0, 1


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the command."""
    parser = commands.add_parser(
        "bench-mesh",
        help="measure what whole scenes cost the mesh engine",
        description="Count the cycles of the simulated mesh engine in the worst case, on close scenes and on "
        "objects apart, against their bounds; compare every scene with the bulk checker. Scenes of real "
        "meshes are left out where their folder ($TRIAXIS_DATA, or ../shared/data) is absent. Writes "
        "build/bench/mesh.json.",
        epilog="Exit codes: 0 all bounds reached and all scenes right, 1 not, 2 error.",
    )
    parser.set_defaults(run=run)


def run(_options: argparse.Namespace) -> int:
    """Measure, print, write."""
    data = mesh_data()
    if data is None:
        print("real meshes: no folder $TRIAXIS_DATA or ../shared/data: left out")
    chosen = cases(data)
    with progress_bar("scenes", len(chosen)) as progress:
        rows = bench_mesh(chosen, progress)
    path = write_rows(rows, data is not None)
    _print(rows)
    print(f"written to {path}")
    return REACHED if all(row.passed for row in rows) else MISSED


def _print(rows: list[Row]) -> None:
    table = Table(title=f"triaxis_mesh {CONFIGURATION.name}, at {CLOCK_MHZ} MHz")
    headings = ("scene", "facets", "pairs", "tested", "near", "cycles", "ms", "pairs/cycle", "bound", "")
    for heading in headings:
        table.add_column(heading, justify="left" if heading == "scene" else "right")
    for row in rows:
        table.add_row(
            row.name,
            f"{row.facets_a} x {row.facets_b}",
            f"{row.pairs:,}",
            f"{row.run.tested:,}",
            f"{row.run.near_count:,}",
            f"{row.cycles:,}",
            f"{row.cycles / CLOCK_MHZ / 1000:.3f}",
            f"{row.pairs / row.cycles:.1f}",
            str(row.bound),
            "WRONG" if not row.right else "reached" if row.passed else "MISSED",
        )
    Console(width=160).print(table)
