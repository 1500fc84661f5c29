"""``triaxis bench-skipping``: what skipping saves, in hardware and software, against other broad phases."""

import argparse

from rich.console import Console
from rich.table import Table

from triaxis.bench.mesh_cycles import CLOCK_MHZ, CONFIGURATION
from triaxis.bench.skipping.asking import PeerRun
from triaxis.bench.skipping.growth import Growth
from triaxis.bench.skipping.results import summary, write_result
from triaxis.bench.skipping.run import SkippingResult, run_skipping, steps
from triaxis.golden.errors import InputError
from triaxis.host.cli.progress import progress_bar
from triaxis.host.mesh_data import mesh_data

REACHED, MISSED = 0, 1


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the command."""
    parser = commands.add_parser(
        "bench-skipping",
        help="measure what skipping saves, and compare it with other broad phases",
        description="Count the facet pairs that each stage of the mesh engine skips, its cycles, and the "
        "time of the bulk checker with and without the broad phase; ask FCL and trimesh about the same "
        "meshes, where they are installed; measure the broad phase from 10^3 to 10^6 facets. Scenes of real "
        "meshes are left out where their folder ($TRIAXIS_DATA, or ../shared/data) is absent. Writes "
        "build/bench/skipping.json and a picture of it.",
        epilog="Exit codes: 0 all answers right and all bounds reached, 1 not, 2 error.",
    )
    parser.add_argument("--seed", type=int, default=1, help="what all random choices follow from (1)")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Measure, print, write."""
    if options.seed < 0:
        raise InputError(f"--seed {options.seed}: must not be negative")
    data = mesh_data()
    if data is None:
        print("real meshes: no folder $TRIAXIS_DATA or ../shared/data: left out")
    with progress_bar("scenes and sizes", steps(data)) as progress:
        result = run_skipping(options.seed, data, progress)
    console = Console(width=170)
    for table in (_stages(result), _packages(result), *(_growth(growth, result) for growth in result.growth)):
        console.print(table)
    for package in result.packages:
        if package.version is None:
            print(f"absent: {package.name}: {package.why_absent}")
    for problem in result.problems:
        print(f"PROBLEM {problem}")
    print(f"{'FAILED' if result.problems else 'PASSED'}: {summary(result)}, {result.seconds:.0f} s")
    for path in write_result(result):
        print(f"written to {path}")
    return MISSED if result.problems else REACHED


def _table(title: str, headings: tuple[str, ...]) -> Table:
    table = Table(title=title)
    for number, heading in enumerate(headings):
        table.add_column(heading, justify="right" if number else "left")
    return table


def _stages(result: SkippingResult) -> Table:
    """Return what each stage skips, and what that saves: without margin, and with the scene's own."""
    headings = (
        "scene", "margin", "pairs", "objects", "groups", "boxes", "axes", "near", "cycles", "pairs/cycle",
        "all pairs, ms", "behind boxes, ms",
    )  # fmt: skip
    title = f"pairs skipped by each stage; {CONFIGURATION.name} at {CLOCK_MHZ} MHz; the bulk checker"
    table = _table(title, headings)
    for row in result.scenes:
        for at in row.at:
            stages = at.stages
            table.add_row(
                row.scene.name if at is row.at[0] else "",
                f"{at.margin}",
                f"{stages.pairs:,}",
                f"{stages.objects:,}",
                f"{stages.rows + stages.groups:,}",
                f"{stages.boxes:,}",
                f"{stages.tested - stages.near:,}",
                f"{stages.near:,}",
                f"{at.cycles:,}",
                f"{at.cycles_without / at.cycles:.1f}",
                f"{1000 * at.software.without:.2f}",
                f"{1000 * at.software.with_skipping:.2f}",
            )
    return table


def _packages(result: SkippingResult) -> Table:
    """Return what all packages did over all scenes without margin."""
    headings = (
        "all scenes, margin 0", "version", "volumes compared", "triangles compared", "build, ms", "ask, ms",
        "found", "missed", "extra",
    )  # fmt: skip
    table = _table("the same question: all pairs of facets that collide", headings)
    software = [row.at[0].software for row in result.scenes]
    table.add_row(
        "broad phase and bulk checker",
        "trees each time",
        f"{sum(saved.boxes for saved in software):,}",
        f"{sum(saved.tested for saved in software):,}",
        "",
        f"{1000 * sum(saved.with_skipping for saved in software):.1f}",
        f"{sum(row.at[0].stages.near for row in result.scenes):,}",
        "0",
        "0",
    )
    for package in result.packages:
        runs = [run for row in result.scenes for run in row.peers if run.name == package.name]
        if runs:
            version = f"{package.distribution} {package.version}"
            table.add_row(package.name, version, *_counts(runs))
    return table


def _counts(runs: list[PeerRun]) -> tuple[str, ...]:
    volumes = [run.volumes for run in runs if run.volumes is not None]
    triangles = [run.triangles for run in runs if run.triangles is not None]
    return (
        f"{sum(volumes):,}" if volumes else "not told",
        f"{sum(triangles):,}" if triangles else "boxes only" if runs[0].boxes_only else "not told",
        f"{1000 * sum(run.build_seconds for run in runs):.1f}",
        f"{1000 * sum(run.ask_seconds for run in runs):.1f}",
        f"{sum(run.found for run in runs):,}",
        f"{sum(run.missed for run in runs)}",
        f"{sum(run.extra for run in runs)}",
    )


def _growth(growth: Growth, result: SkippingResult) -> Table:
    present = [package.name for package in result.packages if package.version is not None]
    headings = (
        "facets",
        "boxes compared",
        "pairs left",
        "near",
        "broad phase, s",
        "with verdicts, s",
        *present,
    )
    title = (
        f"{growth.surfaces.about}: comparisons grow like facets^{growth.compared_exponent:.2f}, seconds like "
        f"facets^{growth.seconds_exponent:.2f}; packages: seconds, trees included"
    )
    table = _table(title, headings)
    for point in growth.points:
        seconds = {run.name: f"{run.seconds:.3f}" for run in point.peers}
        table.add_row(
            f"{point.facets:,}",
            f"{point.boxes:,}",
            f"{point.left:,}",
            f"{point.near:,}",
            f"{point.seconds:.3f}",
            f"{point.decided_seconds:.3f}",
            *(seconds.get(name, "not asked") for name in present),
        )
    return table
