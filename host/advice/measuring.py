"""What a width does on the scene itself: alarms, how many of them are false, and what the engine spends.

Which facet pairs really come within a clearance is asked of the coordinates as they were read, rounded to no
grid. The bulk checker brackets the answer on the finest grid: within c - r there, certainly near; beyond c +
r, certainly not. What is between goes to the golden model, exactly.

What the mesh engine spends is counted without simulating it: docs/mesh-engine.md tells its stages. All stages
work at the same time, so a run takes at least as long as its busiest stage. It takes at most as long as if
they took turns, where a pair of groups costs the larger of its boxes and its tests.
"""

from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from math import ceil, floor

import numpy as np
import numpy.typing as npt

from triaxis.golden.bulk import bulk_verdicts
from triaxis.golden.judge import CertificateError
from triaxis.golden.scene import apart, boxes_of, boxes_of_groups
from triaxis.host.advice.wanted import AdviceScene, Wanted
from triaxis.host.advice.widths import EngineShape, WidthRow
from triaxis.host.broadphase import candidates
from triaxis.host.engines import Integers, Part, Progress, Translation, parts_of, unwatched
from triaxis.host.quantise import (
    Vector,
    around,
    box_of,
    finest_resolution,
    grid_around,
    grown,
    quantise,
    vector,
)
from triaxis.host.scene import bulk_near, distance_of, near_facets
from triaxis.host.stl import StlMesh

_WIDTH = 32

Numbers = npt.NDArray[np.int64]


class TooManyError(Exception):
    """More pairs than are worth the time."""


@dataclass(frozen=True)
class ExactNear:
    """Pairs as numbers i * facets of B + j, ascending: those that are near, and those left undecided."""

    near: Numbers
    undecided: Numbers


def exact_near(
    mesh_a: StlMesh, mesh_b: StlMesh, move: Vector, clearance: Fraction, most_pairs: int, most_judged: int
) -> ExactNear:
    """Return the pairs within the clearance, A being moved exactly.

    At most ``most_judged`` go to the golden model; the rest of what is between is undecided. Raises
    TooManyError where more than ``most_pairs`` have boxes that come so near.
    """
    # The finest grid that holds both, and the clearance as a margin.
    boxes = [box_of(mesh_a.facets, move), box_of(mesh_b.facets)]
    whole = grown(around(boxes), clearance)
    resolution = finest_resolution(whole if whole[0] != whole[1] else grown(whole, Fraction(1)), _WIDTH)
    grid = grid_around(boxes, resolution, _WIDTH)
    a = quantise(mesh_a.facets, grid.moved(move), "A")
    b = quantise(mesh_b.facets, grid, "B")
    # Two coordinates, each off by half a step.
    surely, at_most = floor(clearance / grid.resolution) - 1, ceil(clearance / grid.resolution) + 1
    count = 0
    for i, _ in candidates(a, b, at_most):
        count += len(i)
        if count > most_pairs:
            raise TooManyError
    found = [pairs for _, pairs in near_facets(a, b, at_most, bulk_near)]
    possible = np.concatenate([np.empty((0, 2), np.int64), *found])
    sure = np.zeros(len(possible), np.bool_)
    if surely >= 0 and len(possible):
        pairs = np.stack([a[possible[:, 0]], b[possible[:, 1]]], 1)
        sure = bulk_verdicts(pairs, surely)["near"].astype(np.bool_)
    doubtful = np.flatnonzero(~sure)
    for index in doubtful[:most_judged].tolist():
        i, j = possible[index].tolist()
        sure[index] = distance_of(mesh_a, i, mesh_b, j, move) <= clearance
    numbers = possible[:, 0] * len(b) + possible[:, 1]
    return ExactNear(np.sort(numbers[sure]), np.sort(numbers[doubtful[most_judged:]]))


# Clocks to start, to fill the pipelines and to end: of an empty run, of one that goes through the core, whose
# certificates take up to 22.
_LEAST_OVERHEAD, _MOST_OVERHEAD = 5, 64 + 22


@dataclass
class EngineWork:
    """Runs of a mesh against another: of all parts of them where they exceed the depth.

    ``near``: pairs as numbers i * facets of B + j, ascending. Cycles without loading.
    """

    pairs: int
    near: Numbers
    parts: int
    tested: int = 0
    group_pairs_opened: int = 0
    least_cycles: int = 0
    most_cycles: int = 0


def engine_work(
    a: list[Part], b: list[Part], translation: Integers, margin: int, shape: EngineShape,
    allow: Progress = unwatched,
) -> EngineWork:  # fmt: skip
    """Run A, moved, against B. ``allow`` is told of pairs before they are decided, and may refuse them."""
    count_a, count_b = (sum(len(part.numbers) for part in parts) for parts in (a, b))
    work = EngineWork(count_a * count_b, np.empty(0, np.int64), len(a) * len(b))
    found = [work.near]
    for part_a, part_b in product(a, b):
        near = _run(part_a.facets + translation, part_b.facets, margin, shape, allow, work)
        found.append(part_a.numbers[near[:, 0]] * count_b + part_b.numbers[near[:, 1]])
    work.near = np.sort(np.concatenate(found))
    return work


def _run(
    a: Integers, b: Integers, margin: int, shape: EngineShape, allow: Progress, work: EngineWork
) -> Numbers:
    """Add a run's work, and return its near pairs (K, 2)."""
    near = [np.empty((0, 2), np.int64)]
    boxes_a, boxes_b = boxes_of(a), boxes_of(b)
    groups_a, groups_b = (boxes_of_groups(boxes, shape.group) for boxes in (boxes_a, boxes_b))
    whole_a, whole_b = (boxes_of_groups(boxes, len(boxes)) for boxes in (boxes_a, boxes_b))
    rows = len(groups_a)
    work.least_cycles += _LEAST_OVERHEAD
    work.most_cycles += rows + _MOST_OVERHEAD
    if apart(whole_a, whole_b, margin).all():
        work.least_cycles += rows
        return near[0]
    words = int((~apart(groups_a, whole_b, margin)).sum()) * -(-len(groups_b) // shape.lanes)
    open_pairs = ~apart(groups_a, groups_b, margin)
    tested_in = np.zeros(open_pairs.shape, np.int64)
    for i, j in candidates(a, b, margin):
        allow(len(i))
        np.add.at(tested_in, (i // shape.group, j // shape.group), 1)
        verdicts = bulk_verdicts(np.stack([a[i], b[j]], 1), margin)["near"].astype(np.bool_)
        near.append(np.stack([i[verdicts], j[verdicts]], 1))
    boxes = shape.group * shape.group // shape.lanes
    opened, tested = int(open_pairs.sum()), int(tested_in.sum())
    work.group_pairs_opened += opened
    work.tested += tested
    # Of a last group that is not full what is there takes a clock: its facets of A, its words of B.
    facets, in_last = (np.minimum(shape.group, len(of) - np.arange(0, len(of), shape.group)) for of in (a, b))
    least_boxes = int(facets @ open_pairs @ -(-in_last // shape.lanes))
    work.least_cycles += max(rows, words, least_boxes, tested)
    work.most_cycles += words + int(np.maximum(boxes, tested_in)[open_pairs].sum())
    return np.concatenate(near)


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


def positions_of(scene: AdviceScene, wanted: Wanted, count: int, progress: Progress) -> list[Position]:
    """Return positions of the travel with what is true there; ``progress`` is told of each."""
    found: list[Position] = []
    judged = _MOST_JUDGED // max(1, count * len(scene.others))
    for offset in scene.positions(count):
        move = vector(m + t for m, t in zip(scene.move, offset, strict=True))
        try:
            truth = tuple(
                exact_near(scene.moving.mesh, b.mesh, move, wanted.clearance, _MOST_PAIRS, judged)
                for b in scene.others
            )
        except TooManyError:
            truth = None
        found.append(Position(offset, truth))
        progress(1)
    return found


def measure(scene: AdviceScene, row: WidthRow, positions: list[Position]) -> Measured | None:
    """Return what a width does at the positions; None where that is too much.

    Raises CertificateError where a pair within the clearance gives no alarm: the margin rules that out.
    """
    if any(position.truth is None for position in positions):
        return None
    left = _MOST_PAIRS

    def allow(pairs: int) -> None:
        nonlocal left
        left -= pairs
        if left < 0:
            raise TooManyError

    numbers = range(len(scene.meshes))
    a, *others = (parts_of(integers(scene, row, k), row.shape.depth, row.shape.group) for k in numbers)
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
    return vector(round(t / row.grid.resolution) for t in offset)


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
