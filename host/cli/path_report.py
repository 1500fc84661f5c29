"""What `path` says of a program: its report, and what it prints."""

import argparse
from dataclasses import dataclass, replace
from decimal import ROUND_CEILING, ROUND_FLOOR, Context
from fractions import Fraction
from typing import Any

from triaxis.host.cli.check import print_without_near_facets
from triaxis.host.cli.engine import certificates
from triaxis.host.cli.program import LISTED, place_words
from triaxis.host.motion.clearance import Clearance, lengths
from triaxis.host.motion.moves import Program
from triaxis.host.motion.path_check import Effort, PathResult
from triaxis.host.motion.path_scene import PathScene
from triaxis.host.motion.rule_check import RuleCheck
from triaxis.host.report import counts_entry, enclosure_entry, grid_entry, milliseconds


@dataclass(frozen=True)
class Profile:
    """Bounds of the clearance at places of the path, how many were looked at, and what that took.

    ``euclidean``: the Euclidean distance where the clearance is least, in millimetres, where it is asked for.
    """

    bounds: list[Clearance]
    places: int
    effort: Effort
    euclidean: Fraction | None = None

    @property
    def least(self) -> Clearance:
        """Return where the clearance was seen to be least."""
        return min(self.bounds, key=lambda one: one.seen)


def path_report(
    scene: PathScene, options: argparse.Namespace, checked: RuleCheck, program: Program, profile: Profile
) -> dict[str, Any]:
    """Return everything that is known of a checked path; lengths of the path in millimetres.

    What is not of the whole program is of what decides, and of each thing that was checked in `tools`.
    """
    wanted, result, near = scene.wanted, checked.result, checked.result.near
    numbers = checked.rule.numbers
    return {
        "verdict": result.verdict,
        "program": {
            "file": program.path,
            "moves": len(program.moves),
            "length": sum(move.length for move in program.moves),
            "notes": program.notes,
        },
        "tool_facets": len(scene.a),
        "work_facets": len(scene.b),
        "clearance": wanted.clearance,
        "distance": options.distance,
        "step": wanted.step,
        "false_alarm_band": checked.band,
        "millimetres_per_file_unit": wanted.scale,
        "grid_in_file_units": grid_entry(scene.grid),
        "engine": options.engine,
        **enclosure_entry(result.insides, options.surfaces_only),
        "enclosure_at": {
            "move": numbers[result.asked_at],
            "line": checked.rule.program.moves[result.asked_at].line,
        },
        "what": checked.rule.names[0],
        "of": checked.rule.names[1],
        "stock": options.stock,
        "near": None if near is None else replace(near, move=numbers[near.move]),
        "levels": result.levels,
        "effort": _effort_entry(result.effort),
        "profile": profile.bounds,
        "profile_effort": _effort_entry(profile.effort),
        "least_euclidean": profile.euclidean,
    }


def rule_entry(checked: RuleCheck) -> dict[str, Any]:
    """Return what a report says of one thing that was checked."""
    rule, result = checked.rule, checked.result
    return {
        "number": checked.tool.number,
        "name": checked.tool.name,
        "what": rule.names[0],
        "of": rule.names[1],
        "moves": len(rule.program.moves),
        "verdict": result.verdict,
        "facets": len(checked.scene.a),
        "open_edges": result.insides.open_edges,
        "levels": result.levels,
        "effort": _effort_entry(result.effort),
    }


def _effort_entry(effort: Effort) -> dict[str, Any]:
    """Return what the engine did, summed over poses; runs stopped at a near pair left pairs out."""
    return {
        "poses": effort.poses,
        **counts_entry(effort, "pairs_within_the_margins_asked"),
        "most_cycles_of_a_pose": effort.most_cycles,
    }


def told_zones(zones: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return what is worth telling of zones: of each the objects that are in it, or any where none are."""
    told = list[dict[str, Any]]()
    for width in sorted({zone["within"] for zone in zones}):
        every = [zone for zone in zones if zone["within"] == width]
        told += [zone for zone in every if zone["moves"]] or [{"within": width, "moves": 0, "lines": []}]
    return told


def print_scene(checked: RuleCheck) -> None:
    """Print what was checked along which path, on which grid."""
    scene, rule = checked.scene, checked.rule
    program, wanted, grid = rule.program, scene.wanted, scene.grid
    what, of = (name.removeprefix("the ") for name in rule.names)
    print(f"{what}: {rule.files[0]}, {len(scene.a)} facets; {of}: {rule.files[1]}, {len(scene.b)} facets")
    print(f"path: {program.path}, {len(program.moves)} moves, {lengths(program).sum():.6g} mm")
    print(
        f"grid: {grid.width} bits, resolution {float(wanted.resolution):.12g} mm; clearance "
        f"{float(wanted.clearance):.12g} mm, false alarms less than {float(checked.band):g} mm beyond it"
    )


def print_objects(checked: list[RuleCheck]) -> None:
    """Print what was done for each two objects of a machine."""
    effort = Effort()
    for one in checked:
        effort.join(one.result.effort)
    proven = sum(level.by_boxes + level.by_pose for one in checked for level in one.result.levels)
    clear = sum(one.result.verdict == "clear" for one in checked)
    print(
        f"objects of the machine: {len(checked)} pairs, {clear} of them clear; segments proven clear: "
        f"{proven}; poses asked: {effort.poses}{certificates(effort)}"
    )


def print_effort(result: PathResult) -> None:
    """Print how much of the path was shown clear by what, and what the engine did."""
    effort, levels = result.effort, result.levels
    by_boxes, by_pose = (sum(getattr(level, name) for level in levels) for name in ("by_boxes", "by_pose"))
    print(
        f"segments proven clear: {by_boxes} by the objects' boxes, {by_pose} by a pose each; levels: "
        f"{len(levels)}; poses asked: {effort.poses}"
    )
    print(
        f"facet pairs of all poses: skipped by boxes: {effort.skipped_in_groups + effort.skipped}; tested: "
        f"{effort.tested}{certificates(effort)}"
    )
    if effort.cycles is not None and effort.most_cycles is not None:
        print(
            f"{effort.cycles} cycles, {milliseconds(effort.cycles):.4g} ms at 100 MHz; at most "
            f"{effort.most_cycles} for a pose"
        )


def print_nearest(profile: Profile) -> None:
    """Print the least clearance of all places; nothing is said of what is between them."""
    least = profile.least
    proven = min(one.proven for one in profile.bounds)
    place = place_words(least.position, least.angles)
    print(
        f"clearance at {profile.places} places: least in line {least.line} at {place}: {least.what} and "
        f"{least.of}, {_bound(proven, ROUND_FLOOR)} to {_bound(least.seen, ROUND_CEILING)} mm (Chebyshev)"
        + (f", there {float(profile.euclidean):.4g} mm (Euclid)" if profile.euclidean is not None else "")
    )


def _bound(value: float, rounding: str) -> str:
    """Return a bound to four digits, which is one as well."""
    return f"{Context(4, rounding).create_decimal_from_float(value).normalize():f}"


def print_verdict(checked: RuleCheck, several: bool) -> None:
    """Print it; ``several``: things were checked, of which this one decides."""
    result, names, scene = checked.result, checked.rule.names, checked.scene
    clearance = f"{float(scene.wanted.clearance):.12g} mm{' by Euclid' * scene.wanted.euclidean}"
    near = result.near
    later = checked.rule.numbers[result.asked_at] > 0
    start = (
        f"at the start of line {checked.rule.program.moves[result.asked_at].line}"
        if later
        else "at the start"
    )
    if near is None:
        inside = result.verdict == "near" and later
        where = start if inside else "for each of these" if several else "anywhere on the path"
        print_without_near_facets(result.insides, f"no facets come within {clearance} {where}", names)
        return
    for sentence in result.insides.told(names)[:LISTED]:
        print(f"NEAR: {start} {sentence}")
    place = place_words(near.position, near.angles)
    print(f"NEAR: line {near.line}: at {place} {names[0]} comes within {clearance} of {names[1]}")
    if not near.within_clearance_for_certain:
        print("  (or within the band beyond it: no facets judged are within it at this very position)")
    if checked.rule.of_machine and not any(one.by_boxes + one.by_pose for one in result.levels):
        print("  (from the start on: if they are meant to touch, name one in may_touch of the other)")
    for found in near.facets[:LISTED]:
        print(
            f"  facet {found.tool_facet} of {names[0]}, facet {found.work_facet} of {names[1]}: exact "
            f"distance {float(found.distance):g}"
        )
    if near.facet_pairs > LISTED:
        print(f"  .. and {near.facet_pairs - LISTED} more")
