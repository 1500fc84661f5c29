"""``triaxis check``: do two STL meshes come within a clearance of each other?"""

import argparse
from fractions import Fraction
from pathlib import Path
from typing import Any

from triaxis.golden.errors import InputError
from triaxis.golden.pairs import check_width
from triaxis.host.cli import DONE, NO
from triaxis.host.cli.arguments import add_numbers, number
from triaxis.host.cli.engine import (
    BOARD,
    about,
    add_engine,
    board_of,
    certificates,
    hold,
    output_of,
    trust_entry,
    width_of,
)
from triaxis.host.cli.terminal import progress_bar
from triaxis.host.enclosure import NOT_ASKED, Enclosure, State, enclosure
from triaxis.host.engines import BULK, STILL, Integers, SceneEngine, SceneRun, scene_engine
from triaxis.host.euclidean import EuclideanEngine, euclidean_distance, within_in_files
from triaxis.host.least import least_distance
from triaxis.host.link.board import Board
from triaxis.host.link.board_engine import BoardEngine
from triaxis.host.link.messages import Mode, Status
from triaxis.host.quantise import NOWHERE, check_clearance
from triaxis.host.report import counts_entry, enclosure_entry, grid_entry, milliseconds, write_report
from triaxis.host.scene import AUTOMATIC_WIDTHS, AXES, MeshPair, Pose, Turn, distance_of, prepare
from triaxis.host.shells import solid_of
from triaxis.host.stl import read_stl

_LISTED = 10
# How much finer a grid is tried where facets touch on one.
_FINER = 8
CHEBYSHEV, EUCLIDEAN = "chebyshev", "euclidean"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Decide whether any facet of A comes within the clearance (Chebyshev distance) of any facet of B, or
    a part of one of them is inside the other. The margin covers the rounding to the grid, so a pair
    within the clearance is never missed; a false alarm is less than three steps of the resolution, plus
    twice what reading and turning rounded, beyond it.
    """
    add_meshes(parser, Fraction(1, 1000))
    parser.add_argument(
        "--width", type=int, metavar="W",
        help="coordinate bits of the core, 8..32 (the smallest of 16, 24, 32 that holds the meshes)",
    )  # fmt: skip
    parser.add_argument(
        "--rotate", nargs=2, action="append", default=[], metavar=("AXIS", "DEGREES"),
        help="turn A about axis x, y or z of its frame, right-handed, before it is moved; again for further "
        "turns, in this order",
    )  # fmt: skip
    add_distance(parser)
    add_engine(parser)
    parser.set_defaults(run=run, mode=Mode.ALL, hold=False)


def add_meshes(parser: argparse.ArgumentParser, resolution: Fraction) -> None:
    """Add what every check of two meshes is told, with the resolution where none is asked for."""
    parser.add_argument("a", type=Path, metavar="A.stl", help="binary or ASCII STL")
    parser.add_argument("b", type=Path, metavar="B.stl", help="the same, in the same unit and frame")
    step = f"one step of the grid, in the files' unit ({float(resolution):g})"
    add_numbers(parser, "--resolution", "R", step, resolution)
    wanted = "wanted clearance, in the files' unit (0.5); 0 is touching"
    add_numbers(parser, "--clearance", "C", wanted, Fraction(1, 2))
    add_numbers(parser, "--move", "X Y Z", "move A (0 0 0)", NOWHERE)
    add_surfaces_only(parser)
    parser.add_argument("--json", type=Path, metavar="FILE", help="write a report")


def add_surfaces_only(parser: argparse.ArgumentParser) -> None:
    """Add the option to leave insides alone."""
    parser.add_argument(
        "--surfaces-only", action="store_true",
        help="compare facets only: what is wholly inside the other is then clear of it; for meshes that are "
        "not closed, of which no inside can be told",
    )  # fmt: skip


def add_distance(parser: argparse.ArgumentParser) -> None:
    """Add the option to look at what is near again."""
    parser.add_argument(
        "--distance", choices=(CHEBYSHEV, EUCLIDEAN), default=CHEBYSHEV,
        help="euclidean: what is near in Chebyshev's distance alone is clear; not on a board, which knows "
        f"that one only ({CHEBYSHEV})",
    )  # fmt: skip


def refuse_distance(options: argparse.Namespace) -> None:
    """Raise InputError where a board is to decide by a distance that it does not know."""
    if options.distance == EUCLIDEAN and options.engine == BOARD:
        raise InputError("--distance euclidean: a board knows Chebyshev's alone: give another --engine")


def by_distance(options: argparse.Namespace, a: Integers, b: Integers, engine: SceneEngine) -> SceneEngine:
    """Return the engine that decides by the distance that is wanted, from one that has A and B loaded."""
    if options.distance == CHEBYSHEV:
        return engine
    return EuclideanEngine(engine, a, b, options.clearance / options.resolution)


def run(options: argparse.Namespace) -> int:
    """Check the meshes and print what was found; ``mode`` and ``hold`` are for the board alone."""
    if options.width is not None:
        check_width(options.width)
    check_clearance(options.clearance)
    refuse_distance(options)
    pose = Pose(tuple(_turn(*words) for words in options.rotate), tuple(options.move))
    mesh_a, mesh_b = read_stl(options.a), read_stl(options.b)
    names = (str(options.a), str(options.b))
    with board_of(options) as board:
        width = width_of(options, board)
        meshes = prepare(mesh_a, mesh_b, names, options.resolution, options.clearance, width, pose)
        if board is not None:
            return _by_board(options, board, meshes)
        engine = scene_engine(options.engine, meshes.a, meshes.b, meshes.grid.width)
        run = by_distance(options, meshes.a, meshes.b, engine).run(STILL, meshes.margin)
        told_apart = meshes
        if options.distance == EUCLIDEAN and not (meshes.mesh_a.rounding or meshes.mesh_b.rounding):
            # What the grid rounded need not count: the files' own coordinates are exact.
            where = meshes.mesh_a, meshes.mesh_b, meshes.pose.move
            by_grid = run.near_count
            run.near = within_in_files(*where, run.near, options.clearance)
            run.near_count = len(run.near)
            if by_grid and not run.near_count and not options.surfaces_only:
                told_apart = _on_finer_grid(meshes, names, options.resolution)
        asked = not run.near_count and not options.surfaces_only
        insides = enclosure(solid_of(told_apart.a), solid_of(told_apart.b)) if asked else NOT_ASKED
        return _tell(options, meshes, run, insides)


def _on_finer_grid(meshes: MeshPair, names: tuple[str, str], resolution: Fraction) -> MeshPair:
    """Return meshes that do not touch on a grid on which they do not either: there insides can be told.

    Raises InputError where no grid is fine enough and large enough.
    """
    # A is turned already.
    pose = Pose(move=meshes.pose.move)
    while True:
        resolution /= _FINER
        try:
            finer = prepare(meshes.mesh_a, meshes.mesh_b, names, resolution, Fraction(0), None, pose)
        except InputError as error:
            raise InputError(
                f"{names[0]} and {names[1]}: so close, and so large, that on no grid of "
                f"{AUTOMATIC_WIDTHS[-1]} bits it can be told whether one is inside the other: verdict "
                "unknown; compare surfaces only, with --surfaces-only"
            ) from error
        engine = scene_engine(BULK, finer.a, finer.b, finer.grid.width)
        if not engine.run(STILL, finer.margin, stop_at_first=True).near_count:
            return finer


def _by_board(options: argparse.Namespace, board: Board, meshes: MeshPair) -> int:
    insides = NOT_ASKED if options.surfaces_only else _insides(meshes)
    if insides.state in (State.INSIDE, State.UNDECIDED):
        # A clear run would make the board say go, of itself and at once.
        return _tell(options, meshes, None, insides, board, output="stop; the board was not asked to run")
    with progress_bar("facets loaded", len(meshes.a) + len(meshes.b)) as progress:
        engine = BoardEngine(board, meshes.a, meshes.b, options.mode, progress)
        run = engine.run(STILL, meshes.margin)
    if not run.near_count and insides.state != State.OUTSIDE and not options.surfaces_only:
        raise InputError("the board finds no near facets where this program does: verdict unknown")
    output = output_of(board, engine.status, options.hold)
    code = _tell(options, meshes, run, insides, board, engine.status, output)
    if options.hold and code == DONE:
        # What the report said is then no longer so.
        hold(
            board, engine.status, lambda: options.json and write_report(options.json, {"verdict": "unknown"})
        )
    return code


def _insides(meshes: MeshPair) -> Enclosure:
    """Return what is known of insides before the board runs; near facets leave nothing to ask."""
    found = enclosure(solid_of(meshes.a), solid_of(meshes.b))
    if found.state == State.OUTSIDE:
        return found
    engine = scene_engine(BULK, meshes.a, meshes.b, meshes.grid.width)
    return NOT_ASKED if engine.run(STILL, meshes.margin, stop_at_first=True).near_count else found


def _turn(axis: str, degrees: str) -> Turn:
    if axis.lower() not in AXES or len(axis) != 1:
        raise InputError(f"--rotate {axis:.40}: must be x, y or z, then degrees")
    try:
        return Turn(AXES.index(axis.lower()), number(degrees))
    except argparse.ArgumentTypeError as error:
        raise InputError(f"--rotate {axis} {error}") from error


def _tell(
    options: argparse.Namespace, meshes: MeshPair, run: SceneRun | None, insides: Enclosure,
    board: Board | None = None, status: Status | None = None, output: str = "",
) -> int:  # fmt: skip
    """Write the report, print, return the exit code; ``run``: None where the board was not asked.

    Raises InputError where it is undecided whether one is inside the other.
    """
    near = run is not None and run.near_count > 0
    # A board that says go is not kept waiting.
    least = least_distance(meshes, options.distance == EUCLIDEAN) if board is None else None
    if options.json is not None:
        report = _report(options, meshes, run, insides, board, status)
        write_report(options.json, {**report, "least_distance": least})
    _print_scene(options, meshes)
    if board is not None:
        print(f"board: {about(board.description)}")
    if run is not None:
        _print_run(options, meshes, run)
    if not near:
        print_without_near_facets(
            insides, f"no facets come within {float(options.clearance):.12g}", ("A", "B")
        )
    if least is not None:
        about_least = "" if least.exact else "about "
        print(
            f"least distance of facets: {about_least}{least.distance:g}, facet {least.a} of A, "
            f"facet {least.b} of B"
        )
    if output:
        print(f"output: {output}")
    if not near:
        insides.refuse_undecided((options.a, options.b))
    return DONE if insides.verdict(near) == "clear" else NO


def _report(
    options: argparse.Namespace, meshes: MeshPair, run: SceneRun | None, insides: Enclosure,
    board: Board | None, status: Status | None,
) -> dict[str, Any]:  # fmt: skip
    turns = [{"axis": AXES[turn.axis], "degrees": turn.degrees} for turn in meshes.pose.turns]
    report = {
        "verdict": insides.verdict(run is not None and run.near_count > 0),
        "a": {"file": options.a, "facets": len(meshes.a)},
        "b": {"file": options.b, "facets": len(meshes.b)},
        "pose": {"rotate": turns, "move": meshes.pose.move},
        "clearance": options.clearance,
        "grid": grid_entry(meshes.grid),
        "margin": meshes.margin,
        "engine": options.engine,
        "distance": options.distance,
        **enclosure_entry(insides, options.surfaces_only),
    }
    if board is not None:
        report |= {
            **trust_entry(options, board.description),
            "mode": options.mode.name.lower(),
            "board": board.description,
        }
    if status is not None:
        report["status"] = status
    if run is not None:
        pairs = len(meshes.a) * len(meshes.b)
        report |= {"facet_pairs": pairs, **counts_entry(run, "pairs_near"), "near": run.near}
    return report


def _print_scene(options: argparse.Namespace, meshes: MeshPair) -> None:
    grid, pose = meshes.grid, meshes.pose
    offset = ", ".join(f"{float(x):g}" for x in grid.offset)
    print(f"A: {options.a}, {len(meshes.a)} facets; B: {options.b}, {len(meshes.b)} facets")
    if pose.turns or any(pose.move):
        turns = [f"turned by {float(turn.degrees):g} degrees about {AXES[turn.axis]}" for turn in pose.turns]
        print(f"A is {', '.join([*turns, 'moved by ' + ' '.join(f'{float(x):g}' for x in pose.move)])}")
    print(
        f"grid: {grid.width} bits, resolution {float(grid.resolution):.12g}, offset ({offset}), rounding at "
        f"most {float(grid.rounding_bound):g}; margin {meshes.margin} steps"
    )


def _print_run(options: argparse.Namespace, meshes: MeshPair, run: SceneRun) -> None:
    pairs, skipped = len(meshes.a) * len(meshes.b), run.skipped_in_groups + run.skipped
    print(f"facet pairs: {pairs}; skipped by boxes: {skipped}; tested: {run.tested}{certificates(run)}")
    if run.cycles is not None:
        print(
            f"group pairs skipped: {run.group_pairs_skipped}; opened: {run.group_pairs_opened}; "
            f"{run.cycles} cycles, {milliseconds(run.cycles):.3g} ms at 100 MHz"
        )
    if not run.near_count:
        return
    count = "at least 1" if options.mode == Mode.FIRST else run.near_count
    clearance = f"{float(options.clearance):.12g}"
    print(f"NEAR: {count} facet pairs come within {clearance} (or within the rounding of it)")
    kind = "exact distance" if meshes.pose.exact else "distance as turned"
    of = euclidean_distance if options.distance == EUCLIDEAN else distance_of
    for i, j in run.near[:_LISTED].tolist():
        distance = of(meshes.mesh_a, i, meshes.mesh_b, j, meshes.pose.move)
        print(f"  facet {i} of A, facet {j} of B: {kind} {float(distance):g}")
    if len(run.near) > _LISTED:
        print(f"  .. and {len(run.near) - _LISTED} more")


def print_without_near_facets(insides: Enclosure, surfaces: str, names: tuple[str, str]) -> None:
    """Print the verdict on A and B, so named, of which no facets are near, as ``surfaces`` says."""
    for sentence in insides.told(names)[:_LISTED]:
        print(f"NEAR: {surfaces}, but {sentence}")
    if insides.state == State.OUTSIDE:
        print(f"CLEAR: {surfaces}, and neither is inside the other")
    if insides.state == State.NOT_ASKED:
        print(f"CLEAR: {surfaces} (surfaces only: one may be inside the other)")
    # Where that is why the verdict is unknown, it is told so.
    for note in insides.notes(names) if insides.state != State.UNDECIDED else ():
        print(f"note: {note}")
