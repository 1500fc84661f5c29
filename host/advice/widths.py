"""What each width means for a scene: resolution, margin, band of false alarms, DSP blocks."""

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

from triaxis.fpga.board_build import TOP, Resources
from triaxis.fpga.resources import BUILDS
from triaxis.golden.errors import InputError
from triaxis.golden.pairs import MAX_WIDTH, MIN_WIDTH
from triaxis.host.advice.engine_work import EngineShape
from triaxis.host.advice.scene import AdviceScene, Wanted
from triaxis.host.grid_choice import Steps, false_alarm_band, finest_resolution
from triaxis.host.quantise import Grid, grid_around, margin_for

WIDTHS = range(MIN_WIDTH, MAX_WIDTH + 1)

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
    """A width on its finest grid. ``margin`` in steps; None where the width cannot hold it, and what follows.

    ``band``: how far beyond the clearance a false alarm can be, in the files' unit; ``margin_bits``: as
    many as the margin needs, or as the board has. ``problems``: why it will not do, one sentence each.
    ``resources``: what the whole board takes, where it was synthesised.
    """

    width: int
    grid: Grid
    shape: EngineShape
    margin: int | None = None
    margin_bits: int | None = None
    band: Fraction | None = None
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
    resolution = finest_resolution(scene.volume, width, wanted.unit, steps, room=int(scene.travels))
    grid, shape = grid_around([scene.volume], resolution, width), board.shape(width)
    reading = scene.reading(resolution)
    try:
        margin = margin_for(wanted.clearance, grid, reading)
    except InputError:
        needed = length(wanted.clearance, wanted)
        problem = f"the clearance, {needed}, is more than {width} bits of {length(resolution, wanted)} hold"
        return WidthRow(width, grid, shape, problems=(problem,))
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
