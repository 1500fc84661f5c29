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

from triaxis.bench.error.truth import Truth, exact_triangle
from triaxis.bench.error.workloads import Part, Workload, part_grid
from triaxis.bench.harness import ROUNDS, best_times
from triaxis.bench.peers.peer import Peer
from triaxis.golden.bulk import bulk_claims, bulk_facts, bulk_verdicts
from triaxis.golden.certificate import claims_prove_clear
from triaxis.golden.judge import judge
from triaxis.golden.pairs import NO_AXIS, Pairs
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


# Pairs of the golden model, at some 200 microseconds each.
_JUDGED = 400
_GOLDEN_ROUNDS = 3


@dataclass(frozen=True)
class BulkPoint:
    """Nanoseconds a pair at one width and margin.

    ``clear``: pairs that it calls clear; ``unproven``: those of them whose axis does not separate them by
    `claims_prove_clear`, which shares nothing with it. ``differs``: pairs on which the two disagree.
    """

    width: int
    mode: str
    claims_ns: float
    clear: int
    unproven: int
    differs: int


def bulk_point(rounded: OnGrid, width: int, mode: str) -> BulkPoint:
    """Return the bulk checker's times on a workload, and whether its axes prove what they claim."""
    pairs = np.ascontiguousarray(rounded.pairs, np.int32)
    margins = margins_of(rounded, mode).astype(np.uint32)
    (seconds,) = best_times([lambda: bulk_claims(pairs, margins)])
    claims = bulk_claims(pairs, margins)
    clear = claims != NO_AXIS
    proven = claims_prove_clear(pairs[clear], margins[clear], claims[clear])
    differs = int((claims != bulk_facts(pairs, margins).claim).sum())
    unproven = int((~proven).sum())
    return BulkPoint(width, mode, seconds * 1e9 / len(pairs), int(clear.sum()), unproven, differs)


def golden_ns(workload: Workload) -> float:
    """Return the nanoseconds a pair that the golden model takes, certificates and their check included."""
    a, b = workload.a, workload.b
    pairs = [(exact_triangle(a[i]), exact_triangle(b[i])) for i in spread_rows(len(a), _JUDGED)]

    def work() -> None:
        for x, y in pairs:
            judge(x, y, 0)

    return best_times([work], _GOLDEN_ROUNDS)[0] * 1e9 / len(pairs)


# Pairs that are timed; all are judged.
TIMED = 4000
# A second triangle moved so far that no pair of any workload meets.
_FAR = 2.0**20


@dataclass(frozen=True)
class PeerPoint:
    """Errors, and nanoseconds a pair: of the whole run, and of calls alone.

    ``name``, ``version`` and ``call`` are the peer's. ``bulk_ns``: the bulk checker's, in collision mode on
    the finest grid, on the same pairs in the same rounds. ``noise_ns``: by how much the bests of the first
    and of the second half of the rounds differ, of the run or of the calls.
    """

    name: str
    distribution: str
    version: str
    call: str
    errors: Errors
    run_ns: float
    overhead_ns: float
    bulk_ns: float
    noise_ns: float

    @property
    def kernel_ns(self) -> float:
        """Return what is left of the run when calls are taken off."""
        return max(0.0, self.run_ns - self.overhead_ns)

    @property
    def most_kernel_ns(self) -> float | None:
        """Return what the kernel is less than, where noise hides it; None where it does not."""
        return self.kernel_ns + self.noise_ns if self.kernel_ns <= self.noise_ns else None

    @property
    def times_bulk(self) -> float:
        """Return how many times the bulk checker's time that is."""
        return self.kernel_ns / self.bulk_ns


def peer_point(peer: Peer, version: str, workload: Workload, finest: OnGrid, truth: Truth) -> PeerPoint:
    """Return a peer's errors and times on a workload; ``finest``: the same pairs on the finest grid."""
    # As most packages take them: the same numbers.
    a, b = workload.a.astype(np.float64), workload.b.astype(np.float64)
    chosen = spread_rows(len(a), TIMED)
    run = peer.load(a[chosen], b[chosen])
    # A batch has one call for all of its pairs.
    calls = peer.load(a[:1], b[:1]) if peer.batched else peer.load(a[chosen], b[chosen] + _FAR)
    pairs, margins = np.ascontiguousarray(finest.pairs[chosen], np.int32), np.zeros(len(chosen), np.uint32)
    works = [run.ask, calls.ask, lambda: bulk_claims(pairs, margins)]
    halves = np.array([best_times(works, ROUNDS // 2) for _ in range(2)]) * 1e9 / len(chosen)
    run_ns, calls_ns, bulk_ns = halves.min(0).tolist()
    return PeerPoint(
        peer.name,
        peer.distribution,
        version,
        peer.call,
        count_errors(peer.load(a, b).ask(), truth),
        run_ns,
        calls_ns,
        bulk_ns,
        float(np.ptp(halves, axis=0)[:2].max()),
    )
