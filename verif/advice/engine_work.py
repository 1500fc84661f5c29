"""What a scene costs the mesh engine, counted without simulating it: docs/mesh-engine.md tells its stages.

All stages work at the same time, so a run takes at least as long as its busiest stage. It takes at most as
long as if they took turns, where a pair of groups costs the larger of its boxes and its tests.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
import numpy.typing as npt

from triaxis.golden.broadphase import candidates
from triaxis.golden.bulk import bulk_verdicts
from triaxis.golden.scene import apart, boxes_of, boxes_of_groups
from triaxis.golden.spatial_order import spatial_order
from triaxis.verif.scene_engines import Integers

# Clocks to start, to fill the pipelines and to end: of an empty run, of one that goes through the core.
_LEAST_OVERHEAD, _MOST_OVERHEAD = 5, 64


@dataclass(frozen=True)
class EngineShape:
    """Sizes of the engine; see `MeshConfiguration`."""

    depth: int
    group: int
    lanes: int


@dataclass(frozen=True)
class EngineWork:
    """One run of a mesh against another, or of all parts of them where they exceed the depth.

    ``near``: pairs as numbers i * facets of B + j, ascending. Cycles without loading.
    """

    pairs: int
    tested: int
    group_pairs_opened: int
    near: npt.NDArray[np.int64]
    least_cycles: int
    most_cycles: int
    parts: int


class LoadedMesh:
    """Facets (N, 3, 3) on the grid, in the parts and the order in which the engine is given them."""

    def __init__(self, facets: Integers, shape: EngineShape) -> None:
        """Put them in order."""
        order = spatial_order(facets, shape.group)
        starts = range(0, len(order), shape.depth)
        self.count = len(facets)
        self.numbers = [order[start : start + shape.depth] for start in starts]
        self.parts = [facets[numbers] for numbers in self.numbers]

    def moved(self, translation: Integers) -> Iterator[Integers]:
        """Yield the parts after a translation (3,)."""
        return (part + translation for part in self.parts)


def engine_work(
    a: LoadedMesh,
    b: LoadedMesh,
    translation: Integers,
    margin: int,
    shape: EngineShape,
    allow: Callable[[int], None] = lambda _: None,
) -> EngineWork:
    """Run A, moved, against B. ``allow`` is told of pairs before they are decided, and may refuse them."""
    near: list[npt.NDArray[np.int64]] = [np.empty(0, np.int64)]
    tested = opened = least = most = 0
    parts_a = list(a.moved(translation))
    for m, n in product(range(len(parts_a)), range(len(b.parts))):
        part = _part_work(parts_a[m], b.parts[n], margin, shape, allow)
        i, j = a.numbers[m][part.near[:, 0]], b.numbers[n][part.near[:, 1]]
        near.append(i * b.count + j)
        tested += part.tested
        opened += part.opened
        least += part.least + _LEAST_OVERHEAD
        most += part.most + _MOST_OVERHEAD
    parts = len(parts_a) * len(b.parts)
    return EngineWork(a.count * b.count, tested, opened, np.sort(np.concatenate(near)), least, most, parts)


@dataclass(frozen=True)
class _PartWork:
    tested: int
    opened: int
    near: npt.NDArray[np.int64]
    least: int
    most: int


def _part_work(
    a: Integers, b: Integers, margin: int, shape: EngineShape, allow: Callable[[int], None]
) -> _PartWork:
    boxes_a, boxes_b = boxes_of(a), boxes_of(b)
    groups_a, groups_b = boxes_of_groups(boxes_a, shape.group), boxes_of_groups(boxes_b, shape.group)
    rows = ~apart(groups_a, boxes_of_groups(boxes_b, len(b)), margin)[:, 0]
    words = int(rows.sum()) * -(-len(groups_b) // shape.lanes)
    open_pairs = ~apart(groups_a, groups_b, margin)
    tested_in = np.zeros(open_pairs.shape, np.int64)
    near: list[npt.NDArray[np.int64]] = [np.empty((0, 2), np.int64)]
    for i, j in candidates(a, b, margin):
        allow(len(i))
        np.add.at(tested_in, (i // shape.group, j // shape.group), 1)
        verdicts = bulk_verdicts(np.stack([a[i], b[j]], 1), margin)["near"].astype(np.bool_)
        near.append(np.stack([i[verdicts], j[verdicts]], 1))
    boxes = shape.group * shape.group // shape.lanes
    opened, tested = int(open_pairs.sum()), int(tested_in.sum())
    within = int(np.maximum(boxes, tested_in)[open_pairs].sum())
    return _PartWork(
        tested,
        opened,
        np.concatenate(near),
        max(len(groups_a), words, boxes * opened, tested),
        len(groups_a) + words + within,
    )
