"""What the measurement of skipping leaves behind: build/bench/skipping.json and its picture."""

from dataclasses import asdict
from pathlib import Path
from typing import Any

from triaxis.bench.mesh_cycles import CLOCK_MHZ, CONFIGURATION
from triaxis.bench.skipping.asking import PeerRun
from triaxis.bench.skipping.growth import MOST_COMPARED, MOST_SECONDS, Growth, Point
from triaxis.bench.skipping.plot import figure_of
from triaxis.bench.skipping.run import LEAST_RATIO, AtMargin, SceneRow, SkippingResult
from triaxis.host.saved_figure import write_figures
from triaxis.sim.evidence import write_evidence
from triaxis.sim.paths import BUILD

RESULT = BUILD / "bench" / "skipping.json"


def write_result(result: SkippingResult) -> list[Path]:
    """Write the result and its picture, each whole or not at all; return the files."""
    pictures = write_figures(figure_of(result), RESULT)
    return [write_evidence(RESULT, content(result)), *pictures]


def summary(result: SkippingResult) -> str:
    """Return what was found, in a line."""
    pairs, cycles, software = result.totals
    exponents = ", ".join(
        f"{growth.surfaces.name} {growth.compared_exponent:.2f}" for growth in result.growth
    )
    return (
        f"{pairs:,} facet pairs in {cycles:,} cycles ({pairs / cycles:.0f} a cycle); bulk checker "
        f"{software.without:.2f} s alone, {software.with_skipping:.3f} s behind the broad phase; comparisons "
        f"grow with exponents {exponents}"
    )


def content(result: SkippingResult) -> dict[str, Any]:
    """Return what the file says, without the stamp."""
    pairs, cycles, software = result.totals
    return {
        **asdict(result.provenance),
        "command": f"triaxis bench skipping --seed {result.seed}",
        "passed": not result.problems,
        "problems": result.problems,
        "summary": summary(result),
        "seconds": round(result.seconds, 1),
        "seed": result.seed,
        "real_meshes": result.real_meshes,
        "engine": CONFIGURATION.name,
        "clock_mhz": CLOCK_MHZ,
        "times": "seconds of processor time, one thread, least of several rounds",
        "bounds": {
            "least_pairs_a_cycle": LEAST_RATIO,
            "most_comparison_exponent": MOST_COMPARED,
            "most_seconds_exponent": MOST_SECONDS,
        },
        "totals": {
            "pairs": pairs,
            "cycles": cycles,
            "seconds_all_pairs": software.without,
            "seconds_behind_boxes": software.with_skipping,
        },
        "packages": [asdict(package) for package in result.packages],
        "scenes": [_scene(row) for row in result.scenes],
        "growth": [_growth(growth) for growth in result.growth],
    }


def _scene(row: SceneRow) -> dict[str, Any]:
    return {
        "name": row.scene.name,
        "real": row.scene.real,
        "meetings": [[len(a), len(b)] for a, b in row.scene.meetings],
        "pairs": row.scene.pairs,
        "at_margins": [_at_margin(at) for at in row.at],
        "packages_at_margin_0": [_peer(run) for run in row.peers],
    }


def _at_margin(at: AtMargin) -> dict[str, Any]:
    return {
        "margin": at.margin,
        "pairs_by_stage": asdict(at.stages),
        "tested": at.stages.tested,
        "hardware": {
            "cycles": at.cycles,
            "cycles_without_skipping": at.cycles_without,
            "clocks_of_work": asdict(at.clocks),
            "right": at.engine_right,
        },
        "software": {
            "seconds_behind_boxes": at.software.with_skipping,
            "seconds_all_pairs": at.software.without,
            "boxes_compared": at.software.boxes,
            "pairs_tested": at.software.tested,
            "right": at.software_right,
        },
    }


def _peer(run: PeerRun) -> dict[str, Any]:
    return {
        "name": run.name,
        "build_seconds": run.build_seconds,
        "ask_seconds": run.ask_seconds,
        "volumes_compared": run.volumes,
        "triangles_compared": run.triangles,
        "finds": "pairs of boxes" if run.boxes_only else "colliding facets",
        "found": run.found,
        "missed": run.missed,
        "extra": run.extra,
    }


def _growth(growth: Growth) -> dict[str, Any]:
    return {
        "surfaces": growth.surfaces.name,
        "about": growth.surfaces.about,
        "comparison_exponent": growth.compared_exponent,
        "seconds_exponent": growth.seconds_exponent,
        "points": [_point(point) for point in growth.points],
    }


def _point(point: Point) -> dict[str, Any]:
    return {
        "facets": point.facets,
        "seconds_broad_phase": point.seconds,
        "seconds_with_verdicts": point.decided_seconds,
        "boxes_compared": point.boxes,
        "pairs_left": point.left,
        "near": point.near,
        "same_as_all_pairs": point.same,
        "packages": [_peer(run) for run in point.peers],
    }
