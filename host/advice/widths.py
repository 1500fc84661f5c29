"""What each width means for a scene: resolution, margin, band of false alarms, DSP blocks, the whole board.

Look-up tables, flip-flops and block RAM are known only from synthesis, which takes minutes: it is done on
demand, and its figures are kept for these very sources.
"""

import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from fractions import Fraction
from pathlib import Path

from triaxis.fpga.board_build import TOP, WHOLE_PART, XC7A100T, Resources, bitstream_sources
from triaxis.fpga.resources import BUILDS, SYNTHESIS, synthesise
from triaxis.golden.outputs import write_whole
from triaxis.golden.pairs import MAX_WIDTH, MIN_WIDTH
from triaxis.host.advice.wanted import AdviceScene, Wanted
from triaxis.host.quantise import Grid, Steps, false_alarm_band, finest_resolution, grid_around, margin_for
from triaxis.sim.build import content_hash
from triaxis.sim.paths import BUILD, DUT
from triaxis.sim.programs import yosys_version

WIDTHS = range(MIN_WIDTH, MAX_WIDTH + 1)


@dataclass(frozen=True)
class EngineShape:
    """Sizes of the engine; see `MeshConfiguration`."""

    depth: int
    group: int
    lanes: int


# Blocks of the board's top at (width, margin bits, shape).
CountBlocks = Callable[[int, int, EngineShape], int]


@dataclass(frozen=True)
class Board:
    """How the board is built: DSP blocks that it may take, triangles, groups, lanes and margin bits.

    ``lanes``, ``margin_bits``: None for what suits each width.
    """

    dsps: int
    depth: int
    group: int
    lanes: int | None = None
    margin_bits: int | None = None

    def shape(self, width: int) -> EngineShape:
        """Return the engine's sizes at a width."""
        return EngineShape(self.depth, self.group, self.lanes or lanes_of_builds(width))


def lanes_of_builds(width: int) -> int:
    """Return the lanes of the board's own build with the next width that is no smaller, or of the widest."""
    boards = sorted(
        (build.parameters["W"], build.parameters["Lanes"]) for build in BUILDS if build.top == TOP
    )
    return next((lanes for wide, lanes in boards if wide >= width), boards[-1][1])


@dataclass(frozen=True)
class WidthRow:
    """A width on the finest grid that holds volume and clearance. ``margin`` in steps.

    ``band``: how far beyond the clearance a false alarm can be, in the files' unit; ``margin_bits``: as
    many as the margin needs, or as the board has. ``problems``: why it will not do, one sentence each.
    ``resources``: what the whole board takes, where it was synthesised.
    """

    width: int
    grid: Grid
    shape: EngineShape
    margin: int
    margin_bits: int
    band: Fraction
    dsps: int | None = None
    problems: tuple[str, ...] = ()
    resources: Resources | None = None

    @property
    def meets(self) -> bool:
        """Return whether nothing speaks against it."""
        return not self.problems


def width_row(
    scene: AdviceScene, wanted: Wanted, width: int, steps: Steps, board: Board, count_blocks: CountBlocks
) -> WidthRow:
    """Return what a width means."""
    # Of the volume, and of the clearance as a margin: one of all ones, without the step for rounding and the
    # half one of the position.
    largest = (1 << width) - 2 - Fraction(int(scene.travels), 2)
    least = (wanted.clearance + scene.rounding) / largest
    room = int(scene.travels)
    resolution = finest_resolution(scene.volume, width, wanted.unit, steps, room, least)
    grid, shape = grid_around([scene.volume], resolution, width), board.shape(width)
    reading = scene.reading(resolution)
    margin = margin_for(wanted.clearance, grid, reading)
    bits = board.margin_bits if board.margin_bits is not None else margin.bit_length()
    band = false_alarm_band(wanted.clearance, resolution, margin, reading)
    problems: list[str] = []
    dsps: int | None = None
    if band > wanted.band:
        problems.append(f"its band is {length(band, wanted)}")
    if margin >= 1 << bits or bits > width:
        problems.append(f"its margin of {margin:,} steps does not fit M = {bits}")
    else:
        dsps = count_blocks(width, bits, shape)
        if dsps > board.dsps:
            problems.append(f"it takes {dsps} DSP blocks of {board.dsps}")
    return WidthRow(width, grid, shape, margin, bits, band, dsps, tuple(problems))


def length(value: Fraction, wanted: Wanted) -> str:
    """Return a length in the unit of the files as millimetres, to four digits."""
    return f"{float(value * wanted.unit):.4g} mm"


_NAMES = {"luts": "look-up tables", "ffs": "flip-flops", "brams": "block RAMs"}
_FOLDER = BUILD / "fpga" / "advised"


def _parameters(row: WidthRow) -> Mapping[str, int]:
    sizes = {"Depth": row.shape.depth, "Group": row.shape.group, "Lanes": row.shape.lanes}
    return {"W": row.width, "M": row.margin_bits, **sizes}


def _kept(row: WidthRow) -> Path:
    values = [f"{name}={value}" for name, value in _parameters(row).items()]
    files = [*bitstream_sources(DUT), *sorted((DUT / "core").glob("*.svh")), SYNTHESIS]
    key = content_hash(files, TOP, *values)
    return _FOLDER / f"{key[:24]}.json"


def known_resources(row: WidthRow) -> Resources | None:
    """Return what an earlier synthesis of this very build found; None where there was none."""
    try:
        return Resources(**json.loads(_kept(row).read_text(encoding="utf-8"))["used"])
    except (OSError, ValueError, KeyError, TypeError):
        return None


def synthesised_resources(row: WidthRow) -> Resources:
    """Return what the whole board takes, synthesised where that is not known; minutes.

    Raises InputError where the synthesiser is missing or fails.
    """
    known = known_resources(row)
    if known is not None:
        return known
    kept = _kept(row)
    made = synthesise(bitstream_sources(DUT), DUT / "core", TOP, _parameters(row), kept.with_suffix(""))
    content = {"tool": yosys_version(), "parameters": _parameters(row), "used": asdict(made.used)}
    write_whole(kept, json.dumps(content, indent=2) + "\n")
    return made.used


def with_resources(row: WidthRow, used: Resources | None) -> WidthRow:
    """Return the row with what its board takes, which is a problem where the part has less."""
    if used is None:
        return row
    exceeded = [name for name in WHOLE_PART.exceeded(used) if name != "dsps"]
    problems = [
        f"it takes {vars(used)[name]:,g} {_NAMES[name]} of {vars(XC7A100T)[name]:,g}" for name in exceeded
    ]
    return replace(row, resources=used, problems=(*row.problems, *problems))


def resources_reason(used: Resources | None) -> str:
    """Return what is known besides DSP blocks as a part of a sentence."""
    if used is None:
        return "look-up tables and block RAM were not synthesised: --synthesise does, in minutes"
    shares = (f"{vars(used)[key]:,g} of {vars(XC7A100T)[key]:,g} {name}" for key, name in _NAMES.items())
    return f"{', '.join(shares)}, synthesised, before routing"
