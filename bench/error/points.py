"""The core on a workload: each part on the finest grid of its width, in collision mode and in no-miss mode.

Rounding to the grid moves a triangle by at most r/2 in the Chebyshev distance, r the resolution, so the
distance of two by at most r. The core answers near(Aq, Bq, m) exactly for the rounded triangles, hence

    dist(A, B) <= (m - 1) r   implies near,   and   near implies   dist(A, B) <= (m + 1) r.

Collision mode, m = 0, errs on both sides within r of touching. No-miss mode takes m of `margin_for` at
clearance 0, which is 1: it misses nothing, and each false alarm is within 2 r (docs/theory.md, section 6).

Verdicts are those of the bulk checker, with which the RTL was signed off; a sample runs through the Verilated
core.
"""

from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import numpy.typing as npt

from triaxis.bench.error.truth import Truth
from triaxis.bench.error.workloads import Part, Workload, part_grid
from triaxis.golden.bulk import bulk_verdicts
from triaxis.golden.pairs import Pairs
from triaxis.host.quantise import Grid, margin_for, quantise
from triaxis.sim.configuration import Configuration
from triaxis.sim.core_engine import RtlEngine

Mask = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class Errors:
    """How many of ``pairs`` collide in truth, how many of those were missed, how many others were alarms."""

    pairs: int
    colliding: int
    missed: int
    false_alarms: int

    @property
    def missed_share(self) -> float:
        """Return the share of the colliding pairs that was missed; 0 where none collides."""
        return self.missed / self.colliding if self.colliding else 0.0

    @property
    def false_alarm_share(self) -> float:
        """Return the share of the clear pairs that was called near; 0 where none is clear."""
        clear = self.pairs - self.colliding
        return self.false_alarms / clear if clear else 0.0


def count_errors(verdicts: Mask, truth: Truth) -> Errors:
    """Return the errors of verdicts (N,), true: near, on whether pairs collide, touching included."""
    colliding = truth.near()
    return Errors(
        len(truth),
        int(colliding.sum()),
        int((colliding & ~verdicts).sum()),
        int((verdicts & ~colliding).sum()),
    )


WIDTHS = (8, 10, 12, 14, 16, 20, 24, 32)
COLLISION, NO_MISS = "collision", "no-miss"
MODES = (COLLISION, NO_MISS)

# One pair a clock of the board's 100 MHz.
CLOCK_NS = 10.0
# Pairs of a workload that run through the Verilated core.
SAMPLE = 2000


@dataclass(frozen=True)
class OnGrid:
    """A workload rounded to the grids of its parts, at one width: (N, 2, 3, 3).

    ``resolutions`` (parts,), in mm; ``margins`` (parts,): those of no-miss mode; ``part`` (N,): whose pair it
    is; ``unchanged``: no coordinate moved.
    """

    pairs: Pairs
    resolutions: tuple[Fraction, ...]
    margins: tuple[int, ...]
    part: npt.NDArray[np.int64]
    unchanged: bool


@dataclass(frozen=True)
class CorePoint:
    """What the core makes of a workload in one mode.

    ``beyond_band``: false alarms whose exact distance exceeds (m + 1) r; ``farthest``: the largest distance
    of a false alarm, in resolutions. ``sampled``: pairs that ran through the RTL, of which ``rtl_differs``
    have another verdict or axis there. ``unchanged``: rounding moved nothing, so errors are the core's own.
    """

    width: int
    mode: str
    errors: Errors
    resolutions_mm: tuple[float, ...]
    margin: int
    beyond_band: int
    farthest: float
    sampled: int
    rtl_differs: int
    cycles_per_pair: float
    unchanged: bool


def configuration(width: int, mode: str) -> Configuration:
    """Return the core's build: without margins for collision mode, with one margin bit for no-miss mode."""
    return Configuration(width, 0 if mode == COLLISION else 1)


def spread_rows(count: int, most: int) -> npt.NDArray[np.int64]:
    """Return which of so many pairs are chosen, evenly spread: all where there are no more than wanted."""
    return np.unique(np.linspace(0, count - 1, min(count, most)).astype(np.int64))


def on_grid(workload: Workload, width: int) -> OnGrid:
    """Return a workload on the finest grids that hold its parts."""
    grids = [part_grid(part.a, part.b, width) for part in workload.parts]
    pairs = [
        np.stack(
            [quantise(x, grid, f"{part.source}, {name}") for name, x in (("A", part.a), ("B", part.b))], 1
        )
        for part, grid in zip(workload.parts, grids, strict=True)
    ]
    return OnGrid(
        np.concatenate(pairs),
        tuple(grid.resolution for grid in grids),
        tuple(margin_for(Fraction(0), grid) for grid in grids),
        np.repeat(np.arange(len(grids)), [len(part) for part in workload.parts]),
        all(map(_unchanged, workload.parts, pairs, grids)),
    )


def _unchanged(part: Part, pairs: Pairs, grid: Grid) -> bool:
    """Return whether all integers stand exactly where the floats were.

    The resolution is a power of two, and an integer of at most 33 bits times that is a float64: no rounding.
    """
    places = [int(offset / grid.resolution) for offset in grid.offset]
    real = (pairs + np.array(places)).astype(np.float64) * float(grid.resolution)
    return bool((real == np.stack([part.a, part.b], 1).astype(np.float64)).all())


def margins_of(rounded: OnGrid, mode: str) -> npt.NDArray[np.int64]:
    """Return the margin of each pair in a mode, in resolutions: (N,)."""
    return np.array(rounded.margins, np.int64)[rounded.part] * (mode == NO_MISS)


def core_point(rounded: OnGrid, truth: Truth, width: int, mode: str) -> CorePoint:
    """Return the core's errors on a workload in one mode, with what was compared with the RTL."""
    margins = margins_of(rounded, mode)
    near: Mask = bulk_verdicts(rounded.pairs, margins)["near"]
    # In resolutions, exactly.
    alarms = [
        (truth.distances[i] / rounded.resolutions[rounded.part[i]], int(margins[i]))
        for i in np.flatnonzero(near & ~truth.near()).tolist()
    ]
    differs, sampled, cycles = _through_rtl(rounded, margins, configuration(width, mode))
    return CorePoint(
        width,
        mode,
        count_errors(near, truth),
        tuple(float(resolution) for resolution in rounded.resolutions),
        int(margins.max(initial=0)),
        sum(distance > margin + 1 for distance, margin in alarms),
        float(max((distance for distance, _ in alarms), default=0)),
        sampled,
        differs,
        cycles,
        rounded.unchanged,
    )


def _through_rtl(
    rounded: OnGrid, margins: npt.NDArray[np.int64], build: Configuration
) -> tuple[int, int, float]:
    """Return how many of a sample the Verilated core answers differently, its size, and cycles a pair.

    The cycles are those of the second half of the sample, after the first: what a pair costs in the stream.
    """
    engine = RtlEngine(build)
    chosen = spread_rows(len(rounded.pairs), SAMPLE)
    pairs, asked = rounded.pairs[chosen], margins[chosen]
    exact, said = bulk_verdicts(pairs, asked), engine.verdicts(pairs, asked)
    differs = (exact["near"] != said["near"]) | (exact["axis"] != said["axis"])
    half = len(chosen) // 2
    whole_cycles, half_cycles = (engine.words(pairs[:n], asked[:n])[1] for n in (len(chosen), half))
    return int(differs.sum()), len(chosen), (whole_cycles - half_cycles) / (len(chosen) - half)
