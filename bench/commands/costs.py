"""``triaxis bench sim``, ``mesh``, ``skipping``, ``fpga activity``: what simulation, engine and core cost."""

import argparse
import time
from pathlib import Path

from rich.console import Console
from rich.table import Table

from triaxis.bench.activity.measuring import BOUND, SAIF, SAIF_SCENE, measure, trace_scene
from triaxis.bench.activity.measuring import Row as GatingRow
from triaxis.bench.activity.measuring import write_numbers as write_activity
from triaxis.bench.activity.streams import streams
from triaxis.bench.mesh_cycles import CLOCK_MHZ, CONFIGURATION, Row, bench_mesh, cases, write_rows
from triaxis.bench.skipping.growth import Growth
from triaxis.bench.skipping.plot import draw
from triaxis.bench.skipping.run import SkippingResult, run_skipping, steps, summary, write_numbers
from triaxis.bench.skipping.software import BOXES, PeerRun
from triaxis.bench.speed import BOUNDS, STEPS, SimSpeeds, bench_sim, write_speeds
from triaxis.host.cli import DONE, NO
from triaxis.host.cli.arguments import add_seed
from triaxis.host.cli.terminal import print_list, progress_bar, table
from triaxis.host.scenes import mesh_data


def add_sim(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``bench sim``."""
    parser.description = (
        "Measure pairs a second of the bare core, the burst environment, the pin environment and the bulk "
        "checker, at W = 16 and M = 0. Writes build/bench/sim.json."
    )
    parser.set_defaults(run=_sim)


def _sim(_options: argparse.Namespace) -> int:
    started = time.monotonic()
    with progress_bar("measurements", STEPS) as progress:
        speeds = bench_sim(progress)
    path = write_speeds(speeds, time.monotonic() - started)
    _print_speeds(speeds)
    print(f"written to {path}")
    missed = [name for name, bound in BOUNDS.items() if speeds.ratios[name] < bound]
    return NO if missed else DONE


def _print_speeds(speeds: SimSpeeds) -> None:
    console = Console(width=100)
    rates = table("W = 16, M = 0, best of several rounds", ("what", "pairs/s"))
    for name in speeds.__dataclass_fields__:
        rates.add_row(name, f"{getattr(speeds, name):,.0f}")
    console.print(rates)
    ratios = table("ratios", ("ratio", "measured", "at least", ""))
    for name, ratio in speeds.ratios.items():
        bound = BOUNDS.get(name)
        verdict = "" if bound is None else "reached" if ratio >= bound else "MISSED"
        ratios.add_row(name, f"{ratio:.2f}", "" if bound is None else f"{bound:g}", verdict)
    console.print(ratios)


def _data() -> Path | None:
    """Return the folder of real meshes, or say that there is none."""
    data = mesh_data()
    if data is None:
        print("real meshes: no folder $TRIAXIS_DATA or ../shared/data: left out")
    return data


def add_mesh(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``bench mesh``."""
    parser.description = (
        "Count the cycles of the simulated mesh engine in the worst case, on close scenes and on objects "
        "apart, against their bounds; compare every scene with the bulk checker. Scenes of real meshes are "
        "left out where their folder ($TRIAXIS_DATA, or ../shared/data) is absent. Writes "
        "build/bench/mesh.json."
    )
    parser.set_defaults(run=_mesh)


def _mesh(_options: argparse.Namespace) -> int:
    started, data = time.monotonic(), _data()
    chosen = cases(data)
    with progress_bar("scenes", len(chosen)) as progress:
        rows = bench_mesh(chosen, progress)
    path = write_rows(rows, data is not None, time.monotonic() - started)
    _print_scenes(rows)
    print(f"written to {path}")
    return DONE if all(row.passed for row in rows) else NO


def _print_scenes(rows: list[Row]) -> None:
    headings = ("scene", "facets", "pairs", "tested", "near", "cycles", "ms", "pairs/cycle", "bound", "")
    scenes = table(f"triaxis_mesh {CONFIGURATION.name}, at {CLOCK_MHZ} MHz", headings)
    for row in rows:
        scenes.add_row(
            row.name,
            f"{row.facets_a} x {row.facets_b}",
            f"{row.pairs:,}",
            f"{row.run.tested:,}",
            f"{row.run.near_count:,}",
            f"{row.cycles:,}",
            f"{row.cycles / CLOCK_MHZ / 1000:.3f}",
            f"{row.pairs / row.cycles:.1f}",
            str(row.bound),
            row.verdict,
        )
    Console(width=160).print(scenes)


def add_skipping(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``bench skipping``."""
    parser.description = (
        "Count the facet pairs that each stage of the mesh engine skips, its cycles, and the time of the "
        "bulk checker with and without the broad phase; ask FCL and trimesh about the same meshes, where "
        "they are installed; measure the broad phase from 10^3 to 10^6 facets. Scenes of real meshes are "
        "left out where their folder ($TRIAXIS_DATA, or ../shared/data) is absent. Writes "
        "build/bench/skipping.json and a picture of it."
    )
    add_seed(parser)
    parser.set_defaults(run=_skipping)


def _skipping(options: argparse.Namespace) -> int:
    data = _data()
    with progress_bar("scenes and sizes", steps(data)) as progress:
        result = run_skipping(options.seed, data, progress)
    console = Console(width=170)
    for shown in (_stages(result), _packages(result), *(_growth(growth, result) for growth in result.growth)):
        console.print(shown)
    for package in result.packages:
        if package.version is None:
            print(f"absent: {package.name}: {package.why_absent}")
    print_list("PROBLEM", result.problems)
    print(f"{'FAILED' if result.problems else 'PASSED'}: {summary(result)}, {result.seconds:.0f} s")
    for path in (write_numbers(result), *draw(result)):
        print(f"written to {path}")
    return NO if result.problems else DONE


def _stages(result: SkippingResult) -> Table:
    """Return what each stage skips, and what that saves: without margin, and with the scene's own."""
    headings = (
        "scene", "margin", "pairs", "objects", "groups", "boxes", "axes", "near", "cycles", "pairs/cycle",
        "all pairs, ms", "behind boxes, ms",
    )  # fmt: skip
    title = f"pairs skipped by each stage; {CONFIGURATION.name} at {CLOCK_MHZ} MHz; the bulk checker"
    rows = table(title, headings)
    for row in result.scenes:
        for at in row.at:
            stages, hardware = at.pairs_by_stage, at.hardware
            rows.add_row(
                row.scene.name if at is row.at[0] else "",
                f"{at.margin}",
                f"{stages.pairs:,}",
                f"{stages.objects:,}",
                f"{stages.rows + stages.groups:,}",
                f"{stages.boxes:,}",
                f"{stages.tested - stages.near:,}",
                f"{stages.near:,}",
                f"{hardware.cycles:,}",
                f"{hardware.cycles_without_skipping / hardware.cycles:.1f}",
                f"{1000 * at.software.seconds_all_pairs:.2f}",
                f"{1000 * at.software.seconds_behind_boxes:.2f}",
            )
    return rows


def _packages(result: SkippingResult) -> Table:
    """Return what all packages did over all scenes without margin."""
    headings = (
        "all scenes, margin 0", "version", "volumes compared", "triangles compared", "build, ms", "ask, ms",
        "found", "missed", "extra",
    )  # fmt: skip
    rows = table("the same question: all pairs of facets that collide", headings)
    software = [row.at[0].software for row in result.scenes]
    rows.add_row(
        "broad phase and bulk checker",
        "trees each time",
        f"{sum(saved.boxes_compared for saved in software):,}",
        f"{sum(saved.pairs_tested for saved in software):,}",
        "",
        f"{1000 * sum(saved.seconds_behind_boxes for saved in software):.1f}",
        f"{sum(row.at[0].pairs_by_stage.near for row in result.scenes):,}",
        "0",
        "0",
    )
    for package in result.packages:
        runs = [run for row in result.scenes for run in row.peers if run.name == package.name]
        if runs:
            version = f"{package.distribution} {package.version}"
            rows.add_row(package.name, version, *_counts(runs))
    return rows


def _counts(runs: list[PeerRun]) -> tuple[str, ...]:
    volumes = [run.volumes_compared for run in runs if run.volumes_compared is not None]
    triangles = [run.triangles_compared for run in runs if run.triangles_compared is not None]
    return (
        f"{sum(volumes):,}" if volumes else "not told",
        f"{sum(triangles):,}" if triangles else "boxes only" if runs[0].finds == BOXES else "not told",
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
    rows = table(title, headings)
    for point in growth.points:
        seconds = {run.name: f"{run.seconds:.3f}" for run in point.packages}
        rows.add_row(
            f"{point.facets:,}",
            f"{point.boxes_compared:,}",
            f"{point.pairs_left:,}",
            f"{point.near:,}",
            f"{point.seconds_broad_phase:.3f}",
            f"{point.seconds_with_verdicts:.3f}",
            *(seconds.get(name, "not asked") for name in present),
        )
    return rows


def add_activity(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``fpga activity``."""
    parser.description = (
        "Send the same pairs, one in a hundred undecided by its boxes, through the core with and without "
        f"operand gating, which must leave at most {100 * BOUND:g} % of the toggles. Writes "
        "build/fpga/activity.json, and build/fpga/activity.saif, the activity of the mesh engine on a "
        "scene, for power reports."
    )
    add_seed(parser, "seed of the random pairs")
    parser.set_defaults(run=_activity)


def _activity(options: argparse.Namespace) -> int:
    start = time.perf_counter()
    wanted = streams(options.seed)
    with progress_bar("activity", len(wanted) + 1) as progress:
        rows = measure(wanted, progress=progress)
        engine = trace_scene(SAIF_SCENE)
        progress(1)
    path = write_activity(rows, engine, options.seed, time.perf_counter() - start)
    _print_toggles(rows)
    print(f"written to {path} and {SAIF.name}")
    return DONE if all(row.within_bound for row in rows) else NO


def _print_toggles(rows: list[GatingRow]) -> None:
    title = f"toggles of all {rows[0].gated.multipliers} multipliers, W = 16, M = 16"
    toggles = table(title, ("pairs", "undecided", "ungated", "gated", "share", "at most"))
    for row in rows:
        toggles.add_row(
            f"{row.pairs:,}: {row.name}",
            f"{100 * row.undecided / row.pairs:.2f} %",
            f"{row.ungated.total:,}",
            f"{row.gated.total:,}",
            f"{100 * row.ratio:.2f} %",
            f"{100 * BOUND:g} %" if row.within_bound else f"{100 * BOUND:g} % EXCEEDED",
        )
    Console(width=110).print(toggles)
