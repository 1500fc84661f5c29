"""``triaxis path``: does a tool stay clear of a workpiece all along a program of moves?"""

import argparse
from collections import Counter
from dataclasses import replace
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any

from triaxis.golden.errors import InputError
from triaxis.golden.pairs import check_width
from triaxis.host.cli import DONE, NO
from triaxis.host.cli.arguments import add_numbers
from triaxis.host.cli.check import EUCLIDEAN, add_distance, by_distance, refuse_distance
from triaxis.host.cli.engine import about, add_engine, board_of, trust_entry, width_of
from triaxis.host.cli.path_report import (
    Profile,
    path_report,
    print_effort,
    print_nearest,
    print_objects,
    print_scene,
    print_verdict,
    rule_entry,
    told_zones,
)
from triaxis.host.cli.program import add_program, add_zones, print_zones, read_moves, read_stocks, zone_widths
from triaxis.host.cli.terminal import progress_bar
from triaxis.host.engines import Progress, SceneEngine, scene_engine
from triaxis.host.link.board import Board
from triaxis.host.link.board_engine import BoardEngine
from triaxis.host.motion.clearance import clearances, euclidean_at, places
from triaxis.host.motion.contact import NOT_TRACKED, Rule, Setup, rules_of
from triaxis.host.motion.machine import Tool
from triaxis.host.motion.moves import Program
from triaxis.host.motion.path_check import Effort, bulk_engine
from triaxis.host.motion.path_scene import PathScene, Wanted
from triaxis.host.motion.rule_check import RuleCheck, check_rule, moves_within
from triaxis.host.report import write_report
from triaxis.host.stl import read_stl

# Steps of the grid in the longest segment on which a near pose ends the check, where none is asked for.
_STEPS = 4
# Where the clearance is looked at, for a picture, and for the least that is printed.
_PLACES, _FEW_PLACES = 200, 50
# In the width of a zone, at most: so margins fit 32 bits, with what rounding and a sixteenth of it take.
_STEPS_OF_ZONE = 1 << 31


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Move the tool along the program and find the first pose within the clearance (Chebyshev distance)
    of the workpiece, or prove that there is none: every real position of the path is covered, not only
    samples; being inside the other is near. The program's position is where the origin of TOOL.stl is, in
    the frame of WORK.stl. G-code as LinuxCNC has it, with arcs, drilling cycles, offsets, parameters and
    subroutines; what is not followed is refused. A rapid may be any way on which no axis turns back.
    Lengths in millimetres. A board that is asked says go at each clear pose, and stop at the end: no
    machine may take its output for the verdict on a path.
    """
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
        report = path_report(scene, options, first, replace(program, notes=notes), profile)
        report |= {"tools": [rule_entry(one) for one in checked], "zones": zones}
        if board is not None:
            report |= trust_entry(options, board.description)
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
        print_scene(one)
        if board is not None:
            print(f"board: {about(board.description)}")
        print_effort(one.result)
    if objects := [one for one in checked if one.rule.of_machine]:
        print_objects(objects)
    if profile.bounds:
        print_nearest(profile)
    print_zones(told_zones(zones), "moves", len(program.moves))
    if widths and result.verdict != "clear":
        print("note: --slow and --warn are told of a clear program alone")
    for note in notes:
        print(f"note: {note}")
    print_verdict(first, len(checked) > 1 and options.stock is not None)
    if result.verdict == "clear":
        told = result.insides.notes(rule.names)
        opened = dict.fromkeys(note for one in checked for note in one.result.insides.notes(one.rule.names))
        for note in opened:
            if note not in told:
                print(f"note: {note}")
    if result.verdict == "unknown":
        line = rule.program.moves[result.asked_at].line
        at = f" at the start of line {line}" if rule.numbers[result.asked_at] else ""
        result.insides.refuse_undecided(rule.files, not options.stock, at)
    return DONE if result.verdict == "clear" else NO


def _decisive(checked: list[RuleCheck]) -> RuleCheck:
    near = [one for one in checked if one.near_at is not None]
    if near:
        return min(near, key=RuleCheck.place_near)
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
) -> Profile:
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
    profile = Profile(found, len(chosen), effort)
    if wanted.euclidean and found:
        return replace(profile, euclidean=euclidean_at(profile.least, program, rules, wanted))
    return profile


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
