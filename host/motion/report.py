"""The report of a checked path, for programs."""

from typing import Any

from triaxis.host.motion.clearance import Clearance, lengths
from triaxis.host.motion.path_check import Effort, NearPose, PathResult
from triaxis.host.motion.path_scene import PathScene
from triaxis.host.scene_report import enclosure_entry, grid_entry, milliseconds


def path_report(
    scene: PathScene,
    engine: str,
    surfaces_only: bool,
    result: PathResult,
    profile: list[Clearance],
    profiling: Effort,
) -> dict[str, Any]:
    """Return everything that is known of a checked path; lengths of the path in millimetres."""
    wanted, program = scene.wanted, scene.program
    scale = wanted.scale
    return {
        "verdict": result.verdict,
        "program": {
            "file": program.path,
            "moves": len(program.moves),
            "length": float(lengths(scene).sum()),
            "notes": program.notes,
        },
        "tool_facets": len(scene.a),
        "work_facets": len(scene.b),
        "clearance": wanted.clearance,
        "step": wanted.step,
        "false_alarm_band": scene.band,
        "millimetres_per_file_unit": scale,
        "grid_in_file_units": grid_entry(scene.grid),
        "engine": engine,
        **enclosure_entry(result.insides, surfaces_only),
        "near": None if result.near is None else _near(result.near),
        "levels": result.levels,
        "effort": _effort(result.effort),
        "profile": profile,
        "profile_effort": _effort(profiling),
    }


def _near(near: NearPose) -> dict[str, Any]:
    return {
        "line": near.line,
        "move": near.move,
        "part_of_move": near.along,
        "position": near.position,
        "margin": near.margin,
        "facet_pairs": near.near_count,
        "within_clearance_for_certain": near.certain,
        "facets": near.facets,
    }


def _effort(effort: Effort) -> dict[str, Any]:
    """Return what the engine did, summed over poses; runs stopped at a near pair left pairs out."""
    return {
        "poses": effort.poses,
        "group_pairs_skipped": effort.group_pairs_skipped,
        "group_pairs_opened": effort.group_pairs_opened,
        "pairs_skipped_in_groups": effort.skipped_in_groups,
        "pairs_skipped_by_their_boxes": effort.skipped,
        "pairs_tested": effort.tested,
        "pairs_within_the_margins_asked": effort.near,
        "cycles": effort.cycles,
        "milliseconds_at_100_MHz": milliseconds(effort.cycles),
        "most_cycles_of_a_pose": effort.most_cycles,
    }
