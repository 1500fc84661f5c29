"""``triaxis path``: does a tool stay clear of a workpiece all along a program of moves?"""

import argparse
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

from triaxis.golden.errors import InputError
from triaxis.golden.input_file import read_input
from triaxis.golden.pairs import check_width
from triaxis.host.cli import DONE, NO
from triaxis.host.cli.arguments import add_numbers
from triaxis.host.cli.check import (
    EUCLIDEAN,
    add_distance,
    add_surfaces_only,
    by_distance,
    print_without_near_facets,
    refuse_distance,
)
from triaxis.host.cli.engine import about, add_engine, board_of, certificates, self_tested, width_of
from triaxis.host.cli.terminal import progress_bar
from triaxis.host.engines import Progress, SceneEngine, scene_engine
from triaxis.host.link.board import Board
from triaxis.host.link.board_engine import BoardEngine
from triaxis.host.motion.clearance import Clearance, clearances, lengths, places
from triaxis.host.motion.contact import NOT_TRACKED, Rule, Setup, rules_of
from triaxis.host.motion.kinematics import LINEAR, ROTARY
from triaxis.host.motion.machine import Machine, Tool
from triaxis.host.motion.machine_file import read_machine
from triaxis.host.motion.moves import Program
from triaxis.host.motion.path_check import Effort, PathResult, bulk_engine
from triaxis.host.motion.path_scene import PathScene, Wanted
from triaxis.host.motion.program import read_program
from triaxis.host.motion.rs274 import read_by_rs274
from triaxis.host.motion.rule_check import RuleCheck, check_rule, moves_within
from triaxis.host.quantise import Vector
from triaxis.host.report import counts_entry, enclosure_entry, grid_entry, milliseconds, write_report
from triaxis.host.stl import StlMesh, read_stl

_LISTED = 10
# Steps of the grid in the longest segment on which a near pose ends the check, where none is asked for.
_STEPS = 4
# Where the clearance is looked at, for a picture, and for the least that is printed.
_PLACES, _FEW_PLACES = 200, 50
# In the width of a zone, at most: so margins fit 32 bits, with what rounding and a sixteenth of it take.
_STEPS_OF_ZONE = 1 << 31
# Of a start, in millimetres.
_FARTHEST = 10**9


@dataclass(frozen=True)
class _Profile:
    """Bounds of the clearance at places of the path, how many were looked at, and what that took."""

    bounds: list[Clearance]
    places: int
    effort: Effort


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.description = (
        "Move the tool along the program and find the first pose within the clearance (Chebyshev distance) "
        "of the workpiece, or prove that there is none: every real position of the path is covered, not "
        "only samples; being inside the other is near. The program's position is where the origin of "
        "TOOL.stl is, in the frame of WORK.stl. G-code as LinuxCNC has it, with arcs, drilling cycles, "
        "offsets, parameters and subroutines; what is not followed is refused. A rapid may be any way on "
        "which no axis turns back. Lengths in millimetres. A board that is asked says go at each clear pose, "
        "and stop at the end: no machine may take its output for the verdict on a path."
    )
    add_program(parser, Fraction(1, 1000))
    step = (
        f"longest piece of path on which a near pose ends the check ({_STEPS} R); a false alarm is less than "
        "4 R + S/2 beyond the clearance"
    )
    add_numbers(parser, "--step", "S", step)
    parser.add_argument(
        "--width", type=int, metavar="W",
        help="coordinate bits of the engine, 8..32 (the smallest of 16, 24, 32 that holds everything)",
    )  # fmt: skip
    add_engine(parser)
    add_distance(parser)
    add_zones(
        parser,
        "tell on which moves of a clear program two objects come within D mm (Chebyshev), or nearly, by the "
        "bulk checker: where a machine would be slow",
        "and within which, wider, people would be told",
    )
    parser.add_argument("--picture", type=Path, metavar="FILE.png", help="draw the scene, and the clearance")
    parser.add_argument(
        "--profile", type=int, metavar="N",
        help=f"bound the clearance at N places, for report and picture ({_PLACES} with --picture, but for a "
        "machine with objects)",
    )  # fmt: skip
    parser.set_defaults(run=run)


def add_program(parser: argparse.ArgumentParser, resolution: Fraction) -> None:
    """Add a tool, a workpiece, a program, and how they are read; ``resolution``: where none is asked for."""
    tool = "binary or ASCII STL, in its own frame; or a machine file (.toml) with tools, offsets, homes"
    parser.add_argument("tool", type=Path, metavar="TOOL.stl", help=tool)
    parser.add_argument(
        "work", type=Path, metavar="WORK.stl", help="workpiece and fixture, in the program's frame"
    )
    parser.add_argument("moves", type=Path, metavar="MOVES.nc", help="the program")
    start = "where the tool is before the first move; 0 0 0 is assumed, and said, where it is not given"
    add_numbers(parser, "--start", "X Y Z", start)
    add_numbers(parser, "--clearance", "C", "wanted clearance (0.5)", Fraction(1, 2))
    add_numbers(parser, "--resolution", "R", f"one step of the grid ({float(resolution):g})", resolution)
    add_numbers(parser, "--scale", "MM", "millimetres per unit of the STL files (1)", Fraction(1))
    parser.add_argument(
        "--reader", choices=("own", "rs274"), default="own",
        help="who reads the program: our own reader, or LinuxCNC's interpreter where it is installed (own)",
    )  # fmt: skip
    parser.add_argument(
        "--block-delete", action="store_true", help="leave out lines that begin with / (they are run)"
    )
    parser.add_argument(
        "--stock", type=Path, action="append", metavar="STOCK.stl",
        help="the blank, which the cutter may touch while it feeds, and nothing else ever; once, or for each "
        "part of the program that a change of the tool ends. WORK.stl then is what nothing may touch",
    )  # fmt: skip
    add_surfaces_only(parser)
    parser.add_argument("--json", type=Path, metavar="FILE", help="write a report")


def add_zones(parser: argparse.ArgumentParser, slow: str, warn: str) -> None:
    """Add the widths of both zones."""
    add_numbers(parser, "--slow", "D", slow, None)
    add_numbers(parser, "--warn", "D", warn, None)


def zone_widths(options: argparse.Namespace) -> list[Fraction]:
    """Return how wide the zones are that are asked for, from the innermost, in millimetres.

    Raises InputError where one is not around the other, or around the clearance.
    """
    if options.warn is not None and options.slow is None:
        raise InputError("--warn: is around the zone of --slow: give that, too")
    widths = [width for width in (options.slow, options.warn) if width is not None]
    if not all(narrow < wide for narrow, wide in pairwise([options.clearance, *widths])):
        raise InputError("--clearance, --slow, --warn: each must be wider than the one before: correct them")
    return widths


def print_zones(zones: Sequence[dict[str, Any]], of: str, count: int) -> None:
    """Print how many of so many moves, or pieces, are in each zone, and their lines; of which two objects."""
    for zone in zones:
        lines = zone["lines"]
        told = f", lines {', '.join(map(str, lines[:_LISTED]))}" if lines else ""
        more = ", .." if len(lines) > _LISTED else ""
        two = f"{zone['what']} and {zone['of']} " if "what" in zone else ""
        print(f"{two}within {float(zone['within']):g} mm, or nearly: {zone[of]} of {count} {of}{told}{more}")


def read_moves(options: argparse.Namespace) -> tuple[Program, Machine, Tool | None]:
    """Return the program, the machine that it is for, and the tool where one is given by itself."""
    start = None if options.start is None else tuple(options.start)
    if start is not None and max(map(abs, start)) > _FARTHEST:
        raise InputError(f"--start: at most {_FARTHEST:g} in each coordinate: correct it")
    machine = (
        read_machine(options.tool, options.scale) if options.tool.suffix.lower() == ".toml" else Machine()
    )
    reader = read_by_rs274 if options.reader == "rs274" else read_program
    with progress_bar("lines read", read_input(options.moves).count(b"\n")) as progress:
        program = reader(options.moves, start, options.block_delete, machine, progress)
    given = Tool(0, read_stl(options.tool), str(options.tool)) if not machine.tools else None
    return program, machine, given


def run(options: argparse.Namespace) -> int:
    """Check the path and print what was found."""
    refuse_distance(options)
    if options.width is not None:
        check_width(options.width)
    if options.profile is not None and options.profile < 2:
        raise InputError(f"profile {options.profile}: must be at least 2 places")
    widths = zone_widths(options)
    if widths and widths[-1] + (options.step or 0) > (widest := _STEPS_OF_ZONE * options.resolution):
        raise InputError(
            f"--slow, --warn: at most {float(widest):g} mm at this resolution, with --step: correct them"
        )
    program, machine, given = read_moves(options)
    whole_machine = bool(machine.objects or machine.rotary)
    work = read_stl(options.work), options.work
    operations: list[tuple[Setup, list[Rule]]] = []
    parts = program.stretches
    tools = [given or machine.tools[part.moves[0].tool] for part in parts]
    for tool, part, stock in zip(tools, parts, read_stocks(options, len(parts)), strict=True):
        first = sum(len(before.moves) for before in parts[: len(operations)])
        setup = Setup(tool, work, stock, machine, options.scale)
        operations.append((setup, rules_of(setup, part, first)))
    checked: list[RuleCheck] = []
    total = sum(len(rule.numbers) for _, rules in operations for rule in rules)
    setup = operations[0][0]
    with board_of(options) as board, progress_bar("moves", total) as progress:
        for setup, rules in operations:
            checked += _operation(options, board, setup.tool, rules, progress)
            if any(one.result.verdict != "clear" for one in checked):
                break
    # What decides: the first that is near, or unknown, or the last.
    first = _decisive(checked)
    rule, scene, result = first.rule, first.scene, first.result
    profile = _profile(options, program, checked, first)
    zones = _zones(program, checked, widths) if result.verdict == "clear" else []
    notes = (*program.notes, *((NOT_TRACKED,) if options.stock else ()))
    if options.json is not None:
        report = _report(scene, options, first, replace(program, notes=notes), profile)
        report |= {"tools": [_entry(one) for one in checked], "zones": zones}
        if board is not None:
            report |= self_tested(options)
        write_report(options.json, report)
    if options.picture is not None:
        # Matplotlib loads for a picture alone.
        from triaxis.host.motion.picture import draw_machine, draw_path

        if whole_machine:
            draw_machine(
                options.picture, setup, program, first, profile.bounds if options.profile else [], widths
            )
        else:
            draw_path(options.picture, program, first, profile.bounds, widths)
    for one in (one for one in checked if not one.rule.of_machine):
        _print_scene(one)
        if board is not None:
            print(f"board: {about(board.description)}")
        _print_effort(one.result)
    if objects := [one for one in checked if one.rule.of_machine]:
        _print_objects(objects)
    if profile.bounds:
        _print_nearest(profile)
    print_zones(_told(zones), "moves", len(program.moves))
    if widths and result.verdict != "clear":
        print("note: --slow and --warn are told of a clear program alone")
    for note in notes:
        print(f"note: {note}")
    _print_verdict(first, len(checked) > 1 and options.stock is not None)
    if result.verdict == "unknown":
        line = rule.program.moves[result.asked_at].line
        at = f" at the start of line {line}" if rule.numbers[result.asked_at] else ""
        result.insides.refuse_undecided(rule.files, not options.stock, at)
    return DONE if result.verdict == "clear" else NO


def read_stocks(options: argparse.Namespace, count: int) -> list[tuple[StlMesh, Path] | None]:
    """Return the stock of each of so many parts of the program with one tool."""
    files: list[Path] = options.stock or []
    if files and options.surfaces_only:
        raise InputError("--surfaces-only: with --stock rapids may begin within it: leave one of them out")
    if len(files) not in (0, 1, count):
        raise InputError(
            f"--stock: {len(files)} files; parts of the program with one tool, in which it moves: {count}: "
            "give one for all, or one for each"
        )
    stocks = [(read_stl(file), file) for file in files]
    return [stocks[k % len(stocks)] if stocks else None for k in range(count)]


def _decisive(checked: list[RuleCheck]) -> RuleCheck:
    near = [one for one in checked if one.near_at is not None]
    if near:
        return min(near, key=lambda one: one.near_at or 0)
    return next((one for one in checked if one.result.verdict == "unknown"), checked[-1])


def _operation(
    options: argparse.Namespace, board: Board | None, tool: Tool, rules: list[Rule], progress: Progress
) -> list[RuleCheck]:
    """Check what must hold with one tool, each thing as far as the first move that is near by another."""
    checked: list[RuleCheck] = []
    for rule in rules:
        ends = [one.near_at for one in checked if one.near_at is not None]
        part = rule.until(min(ends)) if ends else rule
        if part is not None:
            found = check_rule(
                tool, part, _wanted(options, board), partial(_engine, options, board), progress,
                options.surfaces_only, board is not None,
            )  # fmt: skip
            checked.append(found)
    return checked


def _wanted(options: argparse.Namespace, board: Board | None) -> Wanted:
    step = _STEPS * options.resolution if options.step is None else options.step
    return Wanted(
        options.clearance, options.resolution, step, options.scale, width_of(options, board),
        options.distance == EUCLIDEAN, board.description.margin_bits if board else None,
    )  # fmt: skip


def _engine(options: argparse.Namespace, board: Board | None, scene: PathScene) -> SceneEngine:
    if board is not None:
        return BoardEngine(board, scene.a, scene.b)
    engine = scene_engine(options.engine, scene.a, scene.b, scene.grid.width)
    return by_distance(options, scene.a, scene.b, engine)


def _profile(
    options: argparse.Namespace, program: Program, checked: list[RuleCheck], first: RuleCheck
) -> _Profile:
    """Return the least clearance of all that must keep one, at places of the path, in Chebyshev's distance.

    Not all was looked at after a move where something is near, but where there is one thing alone.
    """
    pictured = options.picture is not None and not any(one.rule.meeting for one in checked)
    asked = options.profile or (_PLACES if pictured else 0)
    count = asked or (_FEW_PLACES if first.result.verdict == "clear" else 0)
    effort, rules = Effort(), [one.rule for one in checked]
    chosen = places(program, count) if count else []
    if len(checked) > 1 and first.near_at is not None:
        chosen = [place for place in chosen if place.move <= first.near_at]
    known = Counter(number for rule in rules for number in rule.numbers)
    with progress_bar("places", sum(known[place.move] for place in chosen)) as progress:
        wanted = first.scene.wanted
        found = clearances(program, rules, wanted, bulk_engine, chosen, effort, not asked, progress)
    return _Profile(found, len(chosen), effort)


def _zones(program: Program, checked: list[RuleCheck], widths: list[Fraction]) -> list[dict[str, Any]]:
    """Return which moves are in each zone, of each two that must stay clear of each other."""
    found = dict[tuple[str, str], list[set[int]]]()
    total = sum(len(one.rule.numbers) for one in checked) if widths else 0
    with progress_bar("moves, zones", total) as progress:
        for one in checked if widths else ():
            # With each tool anew.
            zones = found.setdefault(one.rule.names, [set[int]() for _ in widths])
            within = moves_within(one.rule, one.scene.wanted, widths, progress)
            for zone, moves in zip(zones, within, strict=True):
                zone |= moves
    return [
        {
            "within": width,
            "what": what,
            "of": of,
            "moves": len(zones[number]),
            "lines": sorted({program.moves[move].line for move in zones[number]}),
        }
        for (what, of), zones in found.items()
        for number, width in enumerate(widths)
    ]


def _told(zones: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return what is worth telling of zones: of each the objects that are in it, or any where none are."""
    told = list[dict[str, Any]]()
    for width in sorted({zone["within"] for zone in zones}):
        every = [zone for zone in zones if zone["within"] == width]
        told += [zone for zone in every if zone["moves"]] or [{"within": width, "moves": 0, "lines": []}]
    return told


def _report(
    scene: PathScene, options: argparse.Namespace, checked: RuleCheck, program: Program, profile: _Profile
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
    }


def _entry(checked: RuleCheck) -> dict[str, Any]:
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


def _print_scene(checked: RuleCheck) -> None:
    scene, rule = checked.scene, checked.rule
    program, wanted, grid = rule.program, scene.wanted, scene.grid
    what, of = (name.removeprefix("the ") for name in rule.names)
    print(f"{what}: {rule.files[0]}, {len(scene.a)} facets; {of}: {rule.files[1]}, {len(scene.b)} facets")
    print(f"path: {program.path}, {len(program.moves)} moves, {lengths(program).sum():.6g} mm")
    print(
        f"grid: {grid.width} bits, resolution {float(wanted.resolution):g} mm; clearance "
        f"{float(wanted.clearance):g} mm, false alarms less than {float(checked.band):g} mm beyond it"
    )


def _print_objects(checked: list[RuleCheck]) -> None:
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


def _print_effort(result: PathResult) -> None:
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


def _print_nearest(profile: _Profile) -> None:
    """Print the least clearance of all places; nothing is said of what is between them."""
    least = min(profile.bounds, key=lambda one: one.seen)
    proven = min(one.proven for one in profile.bounds)
    place = place_words(least.position, least.angles)
    print(
        f"clearance at {profile.places} places: least in line {least.line} at {place}: {least.what} and "
        f"{least.of}, {proven:.4g} to {least.seen:.4g} mm (Chebyshev)"
    )


def place_words(position: Vector, angles: Vector) -> str:
    """Return the words of a position, to the tenth of a micrometre."""
    place = " ".join(f"{axis}{float(c):.4f}" for axis, c in zip(LINEAR, position, strict=True))
    return place + "".join(f" {axis}{float(c):.4f}" for axis, c in zip(ROTARY, angles, strict=True) if c)


def _print_verdict(checked: RuleCheck, several: bool) -> None:
    """Print it; ``several``: things were checked, of which this one decides."""
    result, names, scene = checked.result, checked.rule.names, checked.scene
    clearance = f"{float(scene.wanted.clearance):g} mm{' by Euclid' * scene.wanted.euclidean}"
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
    for sentence in result.insides.told(names)[:_LISTED]:
        print(f"NEAR: {start} {sentence}")
    place = place_words(near.position, near.angles)
    print(f"NEAR: line {near.line}: at {place} {names[0]} comes within {clearance} of {names[1]}")
    if not near.within_clearance_for_certain:
        print("  (or within the band beyond it: no facets judged are within it at this very position)")
    if checked.rule.of_machine and not any(one.by_boxes + one.by_pose for one in result.levels):
        print("  (from the start on: if they are meant to touch, name one in may_touch of the other)")
    for found in near.facets[:_LISTED]:
        print(
            f"  facet {found.tool_facet} of {names[0]}, facet {found.work_facet} of {names[1]}: exact "
            f"distance {float(found.distance):g}"
        )
    if near.facet_pairs > _LISTED:
        print(f"  .. and {near.facet_pairs - _LISTED} more")
