"""``triaxis bench skipping``: what is told of the measurement."""

import argparse
from collections.abc import Iterator
from dataclasses import asdict
from functools import partial, reduce
from operator import add
from typing import Any

from rich.table import Table

from triaxis.bench import harness
from triaxis.bench.harness import Findings, report
from triaxis.bench.mesh_cycles import CLOCK_MHZ, CONFIGURATION, real_meshes
from triaxis.bench.skipping.plot import figure_of
from triaxis.bench.skipping.run import LEAST_RATIO, SceneRow, SkippingResult, run_skipping
from triaxis.bench.skipping.scenes import SURFACES, skipping_scenes
from triaxis.bench.skipping.software import BOXES, MOST_COMPARED, SIZES, Growth, Saved
from triaxis.host.cli.arguments import add_seed
from triaxis.host.cli.terminal import progress_bar, table


def add_skipping(parser: argparse.ArgumentParser) -> None:
    """Count the facet pairs that each stage of the mesh engine skips, its cycles, and the time of the
    bulk checker with and without the broad phase; ask FCL and trimesh about the same meshes, where they
    are installed; measure the broad phase from 10^3 to 10^6 facets. Scenes of real meshes are left out
    where their folder ($TRIAXIS_DATA, or ../shared/data) is absent. Writes build/bench/skipping.json and
    a picture of it.
    """
    add_seed(parser)
    parser.set_defaults(
        run=lambda options: report(harness.FOLDER / "skipping.json", partial(_measured, options.seed))
    )


def _measured(seed: int) -> Findings:
    data = real_meshes()
    steps = len(skipping_scenes(data)) + len(SURFACES) * len(SIZES)
    with progress_bar("scenes and sizes", steps) as progress:
        return findings(run_skipping(seed, data, progress))


def findings(result: SkippingResult) -> Findings:
    """Return what is told of a result."""
    hardware, software = result.totals
    pairs, cycles, loading = hardware.cycles_without_skipping, hardware.cycles, hardware.cycles_to_load
    exponents = ", ".join(
        f"{growth.surfaces.name} {growth.compared_exponent:.2f}" for growth in result.growth
    )
    content = {
        "seed": result.seed,
        "real_meshes": result.real_meshes,
        "engine": CONFIGURATION.name,
        "clock_mhz": CLOCK_MHZ,
        "times": "seconds of processor time, one thread, least of several rounds",
        "bounds": {"least_pairs_a_cycle": LEAST_RATIO, "most_comparison_exponent": MOST_COMPARED},
        "totals": {
            "pairs": pairs,
            "cycles": cycles,
            "cycles_to_load": loading,
            "seconds_all_pairs": software.seconds_all_pairs,
            "seconds_behind_boxes": software.seconds_behind_boxes,
        },
        "packages": [asdict(package) for package in result.packages],
        "scenes": [_scene(row) for row in result.scenes],
        "growth": [_growth(growth) for growth in result.growth],
    }
    return Findings(
        f"triaxis bench skipping --seed {result.seed}",
        f"{pairs:,} facet pairs in {cycles:,} cycles ({pairs / cycles:.0f} a cycle), and {loading:,} to load "
        f"them ({pairs / (cycles + loading):.0f} a cycle of both); bulk checker "
        f"{software.seconds_all_pairs:.2f} s alone, {software.seconds_behind_boxes:.3f} s behind the broad "
        f"phase; comparisons grow with exponents {exponents}",
        result.problems,
        content,
        [_stage_table(result), _package_table(result), *_growth_tables(result)],
        {"skipping": lambda: figure_of(result)},
        [f"absent: {each.name}: {each.why_absent}" for each in result.packages if each.version is None],
    )


def _scene(row: SceneRow) -> dict[str, Any]:
    return {
        "name": row.scene.name,
        "real": row.scene.real,
        "meetings": [[len(a), len(b)] for a, b in row.scene.meetings],
        "pairs": row.scene.pairs,
        "at_margins": [
            {"margin": margin, **asdict(at), "tested": at.pairs_by_stage.tested}
            for margin, at in row.at.items()
        ],
        "packages_at_margin_0": [asdict(run) for run in row.peers],
    }


def _growth(growth: Growth) -> dict[str, Any]:
    return {
        "surfaces": growth.surfaces.name,
        "about": growth.surfaces.about,
        "comparison_exponent": growth.compared_exponent,
        "seconds_exponent": growth.seconds_exponent,
        "points": [asdict(point) for point in growth.points],
    }


def _stage_table(result: SkippingResult) -> Table:
    """Return what each stage skips, and what that saves: without margin, and with the scene's own."""
    headings = (
        "scene", "margin", "pairs", "objects", "groups", "boxes", "axes", "near", "cycles", "to load",
        "pairs/cycle", "all pairs, ms", "behind boxes, ms",
    )  # fmt: skip
    title = f"pairs skipped by each stage; {CONFIGURATION.name} at {CLOCK_MHZ} MHz; the bulk checker"
    rows = table(title, headings)
    for row in result.scenes:
        for margin, at in row.at.items():
            by, hardware = at.pairs_by_stage, at.hardware
            counts = (
                by.pairs, by.objects, by.rows + by.groups, by.boxes, by.tested - by.near, by.near,
                hardware.cycles, hardware.cycles_to_load,
            )  # fmt: skip
            rows.add_row(
                "" if margin else row.scene.name,
                f"{margin}",
                *(f"{count:,}" for count in counts),
                f"{hardware.cycles_without_skipping / hardware.cycles:.1f}",
                f"{1000 * at.software.seconds_all_pairs:.2f}",
                f"{1000 * at.software.seconds_behind_boxes:.2f}",
            )
    return rows


def _package_table(result: SkippingResult) -> Table:
    """Return what all packages did over all scenes without margin."""
    headings = (
        "all scenes, margin 0", "version", "volumes compared", "triangles compared", "build, ms", "ask, ms",
        "found", "missed", "extra",
    )  # fmt: skip
    rows = table("the same question: all pairs of facets that collide", headings)
    ours = sum((row.plain.software for row in result.scenes), Saved())
    found = sum(row.plain.pairs_by_stage.near for row in result.scenes)
    rows.add_row(
        "broad phase and bulk checker", "trees each time", f"{ours.boxes_compared:,}",
        f"{ours.pairs_tested:,}", "", f"{1000 * ours.seconds_behind_boxes:.1f}", f"{found:,}", "0", "0",
    )  # fmt: skip
    # The packages were asked in one order about all scenes.
    for runs in zip(*(row.peers for row in result.scenes), strict=True):
        whole = reduce(add, runs)
        package = next(each for each in result.packages if each.name == whole.name)
        triangles = "boxes only" if whole.finds == BOXES else _count(whole.triangles_compared)
        rows.add_row(
            whole.name, f"{package.distribution} {package.version}", _count(whole.volumes_compared),
            triangles, f"{1000 * whole.build_seconds:.1f}", f"{1000 * whole.ask_seconds:.1f}",
            f"{whole.found:,}", f"{whole.missed}", f"{whole.extra}",
        )  # fmt: skip
    return rows


def _count(count: int | None) -> str:
    return "not told" if count is None else f"{count:,}"


def _growth_tables(result: SkippingResult) -> Iterator[Table]:
    names = [package.name for package in result.packages if package.version is not None]
    ours = ("facets", "boxes compared", "pairs left", "near", "broad phase, s", "with verdicts, s")
    for growth in result.growth:
        title = (
            f"{growth.surfaces.about}: comparisons grow like facets^{growth.compared_exponent:.2f}, seconds "
            f"like facets^{growth.seconds_exponent:.2f}; packages: seconds, trees included"
        )
        rows = table(title, (*ours, *names))
        for point in growth.points:
            seconds = {run.name: f"{run.seconds:.3f}" for run in point.packages}
            counts = (point.facets, point.boxes_compared, point.pairs_left, point.near)
            rows.add_row(
                *(f"{count:,}" for count in counts),
                f"{point.seconds_broad_phase:.3f}",
                f"{point.seconds_with_verdicts:.3f}",
                *(seconds.get(name, "not asked") for name in names),
            )
        yield rows
