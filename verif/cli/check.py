"""``triaxis check``: do two STL meshes come within a clearance of each other?"""

import argparse
from decimal import Decimal, InvalidOperation
from fractions import Fraction
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.golden.judge import judge_in_parallel
from triaxis.golden.pairs import check_width
from triaxis.golden.stl import read_stl
from triaxis.verif.cli.progress import progress_bar
from triaxis.verif.engine import RtlEngine, configuration_for
from triaxis.verif.meshcheck import (
    MeshPair,
    MeshResult,
    check_meshes,
    exact_distance,
    one_box_holds_the_other,
    prepare,
)

CLEAR, NEAR = 0, 1
_LISTED = 10
_DIGITS = 60


def _number(text: str) -> Fraction:
    """Parse a decimal number exactly."""
    try:
        number = Decimal(text)
    except InvalidOperation as error:
        raise argparse.ArgumentTypeError(f"{text:.40}: not a finite decimal number") from error
    if not number.is_finite():
        raise argparse.ArgumentTypeError(f"{text:.40}: not a finite decimal number")
    # Keeps the exact fraction, and everything computed from it, of a reasonable size.
    if abs(number.adjusted()) > _DIGITS or len(number.as_tuple().digits) > _DIGITS:
        raise argparse.ArgumentTypeError(f"{text:.40}: beyond {_DIGITS} digits")
    return Fraction(number)


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the command."""
    parser = commands.add_parser(
        "check",
        help="decide whether two STL meshes come within a clearance",
        description="Decide whether any facet of A comes within the clearance (Chebyshev distance) of any "
        "facet of B. Surfaces only: a mesh wholly inside the other touches none of its facets. The "
        "margin covers the rounding to the grid, so a pair within the clearance is never missed; "
        "a false alarm is less than four steps of the resolution beyond it.",
        epilog="Exit codes: 0 clear, 1 near, 2 error.",
    )
    parser.add_argument("a", type=Path, metavar="A.stl", help="binary or ASCII STL")
    parser.add_argument("b", type=Path, metavar="B.stl", help="the same, in the same unit and frame")
    parser.add_argument(
        "--resolution", type=_number, default=Fraction(1, 1000), metavar="R",
        help="one step of the grid, in the files' unit (0.001)",
    )  # fmt: skip
    parser.add_argument(
        "--clearance", type=_number, default=Fraction(1, 2), metavar="C",
        help="wanted clearance, in the files' unit (0.5); 0 is touching",
    )  # fmt: skip
    parser.add_argument(
        "--width", type=int, metavar="W",
        help="coordinate bits of the core, 8..32 (the smallest of 16, 24, 32 that holds the meshes)",
    )  # fmt: skip
    parser.add_argument("--engine", choices=("rtl", "golden"), default="rtl", help="who decides (rtl)")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Check the meshes and print what was found."""
    if options.width is not None:
        check_width(options.width)
    if options.clearance < 0:
        raise InputError(f"clearance {float(options.clearance):g}: must not be negative")
    meshes = prepare(
        read_stl(options.a),
        read_stl(options.b),
        (str(options.a), str(options.b)),
        options.resolution,
        options.clearance,
        options.width,
    )
    if options.engine == "rtl":
        decide = RtlEngine(configuration_for(meshes.grid.width, meshes.margin)).verdicts
    else:
        decide = judge_in_parallel
    with progress_bar("facets of A", len(meshes.a)) as progress:
        result = check_meshes(meshes, decide, _LISTED, progress)
    _print(options, meshes, result)
    return NEAR if result.near_count else CLEAR


def _print(options: argparse.Namespace, meshes: MeshPair, result: MeshResult) -> None:
    grid = meshes.grid
    offset = ", ".join(f"{float(x):g}" for x in grid.offset)
    print(f"A: {options.a}, {len(meshes.a)} facets; B: {options.b}, {len(meshes.b)} facets")
    print(
        f"grid: {grid.width} bits, resolution {float(grid.resolution):g}, offset ({offset}), rounding at "
        f"most {float(grid.rounding_bound):g}; margin {meshes.margin} steps"
    )
    print(f"facet pairs: {result.pairs}; skipped by boxes: {result.skipped}; tested: {result.tested}")
    clearance = f"{float(options.clearance):g}"
    if not result.near_count:
        print(f"CLEAR: no facets come within {clearance}")
        if one_box_holds_the_other(meshes):
            print("note: one mesh's box holds the other's; only surfaces are compared, not insides")
        return
    print(f"NEAR: {result.near_count} facet pairs come within {clearance} (or within the rounding of it)")
    for i, j in result.near:
        distance = float(exact_distance(meshes, i, j))
        print(f"  facet {i} of A, facet {j} of B: exact distance {distance:g}")
    if result.near_count > len(result.near):
        print(f"  .. and {result.near_count - len(result.near)} more")
