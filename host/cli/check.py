"""``triaxis check``: do two STL meshes come within a clearance of each other?"""

import argparse
from fractions import Fraction
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.golden.pairs import check_width
from triaxis.host.cli import DONE, NO
from triaxis.host.cli.arguments import number
from triaxis.host.enclosure import NOT_ASKED, Enclosure, State, enclosure
from triaxis.host.meshcheck import MeshPair, exact_distance, prepare
from triaxis.host.pose import AXES, Pose, Turn
from triaxis.host.scene_engines import ENGINES, RTL, SceneRun, scene_engine
from triaxis.host.scene_report import enclosure_entry, grid_entry, milliseconds, run_entry, write_report
from triaxis.host.stl import read_stl

_LISTED = 10


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.description = (
        "Decide whether any facet of A comes within the clearance (Chebyshev distance) of any facet of B, or "
        "a part of one of them is inside the other. The margin covers the rounding to the grid, so a pair "
        "within the clearance is never missed; a false alarm is less than four steps of the resolution, plus "
        "twice what reading and turning rounded, beyond it."
    )
    parser.add_argument("a", type=Path, metavar="A.stl", help="binary or ASCII STL")
    parser.add_argument("b", type=Path, metavar="B.stl", help="the same, in the same unit and frame")
    parser.add_argument(
        "--resolution", type=number, default=Fraction(1, 1000), metavar="R",
        help="one step of the grid, in the files' unit (0.001)",
    )  # fmt: skip
    parser.add_argument(
        "--clearance", type=number, default=Fraction(1, 2), metavar="C",
        help="wanted clearance, in the files' unit (0.5); 0 is touching",
    )  # fmt: skip
    parser.add_argument(
        "--width", type=int, metavar="W",
        help="coordinate bits of the core, 8..32 (the smallest of 16, 24, 32 that holds the meshes)",
    )  # fmt: skip
    parser.add_argument(
        "--move", nargs=3, type=number, default=(Fraction(0),) * 3, metavar=("X", "Y", "Z"),
        help="move A, after --rotate (0 0 0)",
    )  # fmt: skip
    parser.add_argument(
        "--rotate", nargs=2, action="append", default=[], metavar=("AXIS", "DEGREES"),
        help="turn A about axis x, y or z of its frame, right-handed; again for further turns, in this order",
    )  # fmt: skip
    parser.add_argument(
        "--engine", choices=ENGINES, default=RTL,
        help="who decides: the simulated mesh engine, the bulk checker, the golden model (rtl)",
    )  # fmt: skip
    add_surfaces_only(parser)
    parser.add_argument("--json", type=Path, metavar="FILE", help="write a report")
    parser.set_defaults(run=run)


def add_surfaces_only(parser: argparse.ArgumentParser) -> None:
    """Add the option to leave insides alone."""
    parser.add_argument(
        "--surfaces-only", action="store_true",
        help="compare facets only: what is wholly inside the other is then clear of it; for meshes that are "
        "not closed, of which no inside can be told",
    )  # fmt: skip


def run(options: argparse.Namespace) -> int:
    """Check the meshes and print what was found."""
    if options.width is not None:
        check_width(options.width)
    if options.clearance < 0:
        raise InputError(f"clearance {float(options.clearance):g}: must not be negative")
    pose = Pose(tuple(_turn(*words) for words in options.rotate), tuple(options.move))
    meshes = prepare(
        read_stl(options.a),
        read_stl(options.b),
        (str(options.a), str(options.b)),
        options.resolution,
        options.clearance,
        options.width,
        pose,
    )
    engine = scene_engine(options.engine, meshes.a, meshes.b, meshes.grid.width)
    run = engine.run((0, 0, 0), meshes.margin)
    insides = NOT_ASKED if run.near_count or options.surfaces_only else enclosure(meshes.a, meshes.b)
    if options.json is not None:
        _write(options, pose, meshes, run, insides)
    _print(options, pose, meshes, run)
    if not run.near_count:
        print_without_near_facets(insides, f"no facets come within {float(options.clearance):g}", ("A", "B"))
        insides.refuse_undecided((options.a, options.b))
    return DONE if insides.verdict(run.near_count > 0) == "clear" else NO


def print_without_near_facets(insides: Enclosure, surfaces: str, names: tuple[str, str]) -> None:
    """Print the verdict on A and B, so named, of which no facets are near, as ``surfaces`` says."""
    for sentence in insides.told(names)[:_LISTED]:
        print(f"NEAR: {surfaces}, but {sentence}")
    if insides.state == State.OUTSIDE:
        print(f"CLEAR: {surfaces}, and neither is inside the other")
    if insides.state == State.NOT_ASKED:
        print(f"CLEAR: {surfaces} (surfaces only: one may be inside the other)")


def _turn(axis: str, degrees: str) -> Turn:
    """Return one --rotate; raise InputError where it is none."""
    if axis.lower() not in AXES or len(axis) != 1:
        raise InputError(f"--rotate {axis:.40}: must be x, y or z, then degrees")
    try:
        return Turn(AXES.index(axis.lower()), number(degrees))
    except argparse.ArgumentTypeError as error:
        raise InputError(f"--rotate {axis} {error}") from error


def _write(
    options: argparse.Namespace, pose: Pose, meshes: MeshPair, run: SceneRun, insides: Enclosure
) -> None:
    turns = [{"axis": AXES[turn.axis], "degrees": turn.degrees} for turn in pose.turns]
    report = {
        "verdict": insides.verdict(run.near_count > 0),
        "a": {"file": options.a, "facets": len(meshes.a)},
        "b": {"file": options.b, "facets": len(meshes.b)},
        "pose": {"rotate": turns, "move": pose.move},
        "clearance": options.clearance,
        "grid": grid_entry(meshes.grid),
        "margin": meshes.margin,
        "engine": options.engine,
        **enclosure_entry(insides, options.surfaces_only),
        **run_entry(run, len(meshes.a) * len(meshes.b)),
    }
    write_report(options.json, report)


def _print(options: argparse.Namespace, pose: Pose, meshes: MeshPair, run: SceneRun) -> None:
    grid = meshes.grid
    offset = ", ".join(f"{float(x):g}" for x in grid.offset)
    print(f"A: {options.a}, {len(meshes.a)} facets; B: {options.b}, {len(meshes.b)} facets")
    if pose.turns or any(pose.move):
        turns = [f"turned by {float(turn.degrees):g} degrees about {AXES[turn.axis]}" for turn in pose.turns]
        print(f"A is {', '.join([*turns, 'moved by ' + ' '.join(f'{float(x):g}' for x in pose.move)])}")
    print(
        f"grid: {grid.width} bits, resolution {float(grid.resolution):g}, offset ({offset}), rounding at "
        f"most {float(grid.rounding_bound):g}; margin {meshes.margin} steps"
    )
    skipped = run.skipped_in_groups + run.skipped
    print(f"facet pairs: {skipped + run.tested}; skipped by boxes: {skipped}; tested: {run.tested}")
    if run.cycles is not None:
        print(
            f"group pairs skipped: {run.group_pairs_skipped}; opened: {run.group_pairs_opened}; "
            f"{run.cycles} cycles, {milliseconds(run.cycles):.3g} ms at 100 MHz"
        )
    if not run.near_count:
        return
    clearance = f"{float(options.clearance):g}"
    print(f"NEAR: {run.near_count} facet pairs come within {clearance} (or within the rounding of it)")
    kind = "exact distance" if pose.exact else "distance as turned"
    for i, j in run.near[:_LISTED].tolist():
        print(f"  facet {i} of A, facet {j} of B: {kind} {float(exact_distance(meshes, i, j)):g}")
    if run.near_count > _LISTED:
        print(f"  .. and {run.near_count - _LISTED} more")
