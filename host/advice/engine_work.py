"""What a scene costs the mesh engine, counted without simulating it: docs/mesh-engine.md tells its stages.

All stages work at the same time, so a run takes at least as long as its busiest stage. It takes at most as
long as if they took turns, where a pair of groups costs the larger of its boxes and its tests.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product

import numpy as np
import numpy.typing as npt

from triaxis.golden.bulk import bulk_verdicts
from triaxis.golden.scene import apart, boxes_of, boxes_of_groups
from triaxis.host.broadphase import candidates
from triaxis.host.scene_engines import Integers
from triaxis.host.spatial_order import spatial_order

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


@dataclass(frozen=True)
class _Part:
    """What the engine holds at a time: facets (N, 3, 3), their numbers in the file (N,), the boxes of their
    groups (ceil(N / group), 2, 3) and of all of them (1, 2, 3)."""

    facets: Integers
    numbers: Integers
    groups: Integers
    whole: Integers

    def moved(self, translation: Integers) -> "_Part":
        """Return the part after a translation (3,)."""
        return _Part(
            self.facets + translation, self.numbers, self.groups + translation, self.whole + translation
        )


class LoadedMesh:
    """Facets (N, 3, 3) on the grid, in the parts and the order in which the engine is given them."""

    def __init__(self, facets: Integers, shape: EngineShape) -> None:
        """Put them in order."""
        order = spatial_order(facets, shape.group)
        self.count = len(facets)
        self.parts = [
            _part(facets, order[start : start + shape.depth], shape)
            for start in range(0, len(order), shape.depth)
        ]


def _part(facets: Integers, numbers: Integers, shape: EngineShape) -> _Part:
    held = facets[numbers]
    boxes = boxes_of(held)
    return _Part(held, numbers, boxes_of_groups(boxes, shape.group), boxes_of_groups(boxes, len(boxes)))


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
    for part_a, part_b in product([part.moved(translation) for part in a.parts], b.parts):
        part = _part_work(part_a, part_b, margin, shape, allow)
        near.append(part_a.numbers[part.near[:, 0]] * b.count + part_b.numbers[part.near[:, 1]])
        tested += part.tested
        opened += part.opened
        least += part.least + _LEAST_OVERHEAD
        most += part.most + _MOST_OVERHEAD
    parts = len(a.parts) * len(b.parts)
    return EngineWork(a.count * b.count, tested, opened, np.sort(np.concatenate(near)), least, most, parts)


@dataclass(frozen=True)
class _PartWork:
    tested: int
    opened: int
    near: npt.NDArray[np.int64]
    least: int
    most: int


def _part_work(
    a: _Part, b: _Part, margin: int, shape: EngineShape, allow: Callable[[int], None]
) -> _PartWork:
    rows = len(a.groups)
    if apart(a.whole, b.whole, margin).all():
        return _PartWork(0, 0, np.empty((0, 2), np.int64), rows, rows)
    overlapping = ~apart(a.groups, b.whole, margin)[:, 0]
    words = int(overlapping.sum()) * -(-len(b.groups) // shape.lanes)
    open_pairs = ~apart(a.groups, b.groups, margin)
    tested_in = np.zeros(open_pairs.shape, np.int64)
    near: list[npt.NDArray[np.int64]] = [np.empty((0, 2), np.int64)]
    for i, j in candidates(a.facets, b.facets, margin):
        allow(len(i))
        np.add.at(tested_in, (i // shape.group, j // shape.group), 1)
        verdicts = bulk_verdicts(np.stack([a.facets[i], b.facets[j]], 1), margin)["near"].astype(np.bool_)
        near.append(np.stack([i[verdicts], j[verdicts]], 1))
    boxes = shape.group * shape.group // shape.lanes
    opened, tested = int(open_pairs.sum()), int(tested_in.sum())
    within = int(np.maximum(boxes, tested_in)[open_pairs].sum())
    return _PartWork(
        tested,
        opened,
        np.concatenate(near),
        max(rows, words, boxes * opened, tested),
        rows + words + within,
    )
