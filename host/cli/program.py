"""A program of moves on the command line: how it is asked for, read and told of, by `path` and `watch`."""

import argparse
from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from typing import Any

from triaxis.golden.errors import InputError
from triaxis.golden.input_file import read_input
from triaxis.host.cli.arguments import add_numbers
from triaxis.host.cli.check import add_surfaces_only
from triaxis.host.cli.terminal import progress_bar
from triaxis.host.motion.kinematics import LINEAR, ROTARY
from triaxis.host.motion.machine import Machine, Tool
from triaxis.host.motion.machine_file import read_machine
from triaxis.host.motion.moves import Program
from triaxis.host.motion.program import read_program
from triaxis.host.motion.rs274 import read_by_rs274
from triaxis.host.quantise import Vector
from triaxis.host.stl import StlMesh, read_stl

# Of lines, facets and sentences, how many are printed.
LISTED = 10
# Of a start, in millimetres.
_FARTHEST = 10**9


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


def print_zones(zones: Sequence[dict[str, Any]], of: str, count: int) -> None:
    """Print how many of so many moves, or pieces, are in each zone, and their lines; of which two objects."""
    for zone in zones:
        lines = zone["lines"]
        told = f", lines {', '.join(map(str, lines[:LISTED]))}" if lines else ""
        more = ", .." if len(lines) > LISTED else ""
        two = f"{zone['what']} and {zone['of']} " if "what" in zone else ""
        print(f"{two}within {float(zone['within']):g} mm, or nearly: {zone[of]} of {count} {of}{told}{more}")


def place_words(position: Vector, angles: Vector) -> str:
    """Return the words of a position, to the tenth of a micrometre."""
    place = " ".join(f"{axis}{float(c):.4f}" for axis, c in zip(LINEAR, position, strict=True))
    return place + "".join(f" {axis}{float(c):.4f}" for axis, c in zip(ROTARY, angles, strict=True) if c)
