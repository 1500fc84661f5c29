"""What a width does on the scene itself: alarms, how many of them are false, and what the engine spends."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from triaxis.golden.judge import CertificateError
from triaxis.host.advice.engine_work import EngineWork, LoadedMesh, engine_work
from triaxis.host.advice.exact_near import ExactNear, TooManyError, exact_near
from triaxis.host.advice.scene import AdviceScene, Wanted
from triaxis.host.advice.widths import WidthRow
from triaxis.host.quantise import Vector, quantise
from triaxis.host.scene_engines import Integers, Translation

# Pairs of a width, over all positions, beyond which it is not measured; pairs that the golden model is given.
_MOST_PAIRS = 6_000_000
_MOST_JUDGED = 20_000


@dataclass(frozen=True)
class Position:
    """An offset of the first mesh, and what is true there of each other mesh; None: too much to find."""

    offset: Vector
    truth: tuple[ExactNear, ...] | None


@dataclass(frozen=True)
class Measured:
    """Sums over all positions and meshes, but cycles: those of the position that takes most.

    ``undecided`` alarms may be false or not: the golden model was not asked. ``parts``: runs at a position.
    """

    positions: int
    pairs: int
    tested: int
    alarms: int
    false_alarms: int
    undecided: int
    positions_near: int
    positions_near_falsely: int
    least_cycles: int
    most_cycles: int
    parts: int

    @property
    def false_share(self) -> float:
        """Return false alarms among the pairs that no box decides."""
        return self.false_alarms / max(1, self.tested)


def positions_of(
    scene: AdviceScene, wanted: Wanted, count: int, progress: Callable[[int], None]
) -> list[Position]:
    """Return positions of the travel with what is true there; ``progress`` is told of each."""
    found: list[Position] = []
    judged = _MOST_JUDGED // max(1, count * len(scene.others))
    for offset in scene.positions(count):
        x, y, z = (m + t for m, t in zip(scene.move, offset, strict=True))
        try:
            truth = tuple(
                exact_near(scene.moving.mesh, b.mesh, (x, y, z), wanted.clearance, _MOST_PAIRS, judged)
                for b in scene.others
            )
        except TooManyError:
            truth = None
        found.append(Position(offset, truth))
        progress(1)
    return found


def measure(scene: AdviceScene, row: WidthRow, positions: list[Position]) -> Measured | None:
    """Return what a width does at the positions; None where that is too much, or it cannot hold the margin.

    Raises CertificateError where a pair within the clearance gives no alarm: the margin rules that out.
    """
    if row.margin is None or any(position.truth is None for position in positions):
        return None
    left = _MOST_PAIRS

    def allow(pairs: int) -> None:
        nonlocal left
        left -= pairs
        if left < 0:
            raise TooManyError

    a = LoadedMesh(integers(scene, row, 0), row.shape)
    others = [LoadedMesh(integers(scene, row, number), row.shape) for number in range(1, len(scene.meshes))]
    totals = np.zeros(8, np.int64)
    least, most = [0], [0]
    parts = 0
    try:
        for position in positions:
            move = np.array(translation(row, position.offset))
            works = [engine_work(a, b, move, row.margin, row.shape, allow) for b in others]
            totals += _compared(works, position.truth or ())
            least.append(sum(work.least_cycles for work in works))
            most.append(sum(work.most_cycles for work in works))
            parts = sum(work.parts for work in works)
    except TooManyError:
        return None
    pairs, tested, alarms, false, undecided, missed, near, falsely = totals.tolist()
    if missed:
        raise CertificateError(f"W = {row.width}, margin {row.margin}: {missed} near pairs give no alarm")
    return Measured(
        len(positions), pairs, tested, alarms, false, undecided, near, falsely, max(least), max(most), parts
    )


def integers(scene: AdviceScene, row: WidthRow, number: int) -> Integers:
    """Return a mesh on the row's grid, the first one where it stands without any offset: (N, 3, 3)."""
    named = scene.meshes[number]
    grid = row.grid if number else row.grid.moved(scene.move)
    return quantise(named.mesh.facets, grid, named.name)


def translation(row: WidthRow, offset: Vector) -> Translation:
    """Return an offset in steps of the row's grid, rounded."""
    x, y, z = (round(t / row.grid.resolution) for t in offset)
    return x, y, z


def _compared(works: list[EngineWork], truths: tuple[ExactNear, ...]) -> Integers:
    """Return the counts of one position, in the order in which `measure` takes them."""
    totals = np.zeros(8, np.int64)
    truly_near, doubtful = False, False
    for work, truth in zip(works, truths, strict=True):
        undecided = np.intersect1d(work.near, truth.undecided, assume_unique=True)
        wrong = np.setdiff1d(np.setdiff1d(work.near, truth.near, assume_unique=True), undecided)
        missed = np.setdiff1d(truth.near, work.near, assume_unique=True)
        counts = work.pairs, work.tested, len(work.near), len(wrong), len(undecided), len(missed)
        totals[:6] += counts
        truly_near |= len(truth.near) > 0
        doubtful |= len(undecided) > 0
    near = bool(totals[2])
    totals[6:] = near, near and not truly_near and not doubtful
    return totals
