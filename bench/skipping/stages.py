"""What each stage of the mesh engine skips, counted by the golden model in facet pairs.

The stages are those of docs/mesh-engine.md. The first splits in two: objects whose boxes are apart as a
whole, and groups of A that are apart from the whole of B. The last splits by the axis that decides, as
numbered in docs/theory.md, section 2. A pair counts where it is skipped first.
"""

from dataclasses import dataclass, fields
from itertools import product
from typing import Any, Self, cast

import numpy as np

from triaxis.golden.bulk import bulk_verdicts
from triaxis.golden.pairs import NO_AXIS
from triaxis.golden.scene import SceneAnswer, scene_answer
from triaxis.host.engines import Integers
from triaxis.host.scene import in_order
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.mesh_engine import spatial_order

# The first axes of their kinds behind the three box axes; see `triaxis.golden.axes`.
_NORMALS, _EDGES, _EDGE_BOXES = 3, 5, 14


class Summed:
    """Figures of a pair of meshes, which can be added field by field.

    What holds must hold of both; what is not known of one is not known of the sum; names stay.
    """

    def __add__(self, other: Self) -> Self:
        """Return the sums."""
        names = [field.name for field in fields(cast(Any, self))]
        return type(self)(*(_sum(getattr(self, name), getattr(other, name)) for name in names))


def _sum(one: Any, other: Any) -> Any:
    if one is None or other is None:
        return None
    if isinstance(one, bool):
        return one and other
    return one if isinstance(one, str) else one + other


@dataclass(frozen=True)
class Stages(Summed):
    """How many facet pairs each stage skips, and how many are near: together all of them."""

    objects: int = 0
    rows: int = 0
    groups: int = 0
    boxes: int = 0
    normals: int = 0
    edges: int = 0
    edge_boxes: int = 0
    near: int = 0

    @property
    def before_boxes(self) -> int:
        """Return how many pairs are skipped with their objects or groups, whose own boxes nobody compares."""
        return self.objects + self.rows + self.groups

    @property
    def tested(self) -> int:
        """Return how many pairs no box decides: the core is asked about them."""
        return self.normals + self.edges + self.edge_boxes + self.near

    @property
    def pairs(self) -> int:
        """Return the number of all pairs."""
        return self.before_boxes + self.boxes + self.tested


@dataclass(frozen=True)
class Clocks(Summed):
    """How many clocks each part of the engine has work for; all are at work at the same time."""

    rows: int = 0
    words: int = 0
    boxes: int = 0
    core: int = 0


@dataclass(frozen=True)
class StageAnswer:
    """What skipping does to a pair of solids. ``near`` (K, 2): (facet of A, of B), by number."""

    stages: Stages
    clocks: Clocks
    near: Integers


def stage_answer(a: Integers, b: Integers, margin: int, engine: MeshConfiguration) -> StageAnswer:
    """Return what is skipped of facets (N, 3, 3) and (M, 3, 3), loaded as the engine is, at a margin in LSB.

    Meshes beyond its depth are loaded in parts; a part is an object of its own.
    """
    stages, clocks, near = Stages(), Clocks(), [np.empty((0, 2), np.int64)]
    for in_a, in_b in product(_parts(a, engine), _parts(b, engine)):
        answer = scene_answer(a[in_a], b[in_b], margin, engine.group)
        i, j = answer.to_be_tested.T
        verdicts = bulk_verdicts(np.stack([a[in_a[i]], b[in_b[j]]], 1), margin)
        stages += _stages(answer, verdicts["axis"])
        clocks += _clocks(answer, engine)
        i, j = answer.near_pairs.T
        near.append(np.stack([in_a[i], in_b[j]], 1))
    return StageAnswer(stages, clocks, in_order(np.concatenate(near)))


def _parts(facets: Integers, engine: MeshConfiguration) -> list[Integers]:
    """Return the numbers of the facets that the engine holds at a time, in the order of loading."""
    order = spatial_order(facets, engine.group)
    return [order[start : start + engine.depth] for start in range(0, len(order), engine.depth)]


def _stages(answer: SceneAnswer, axis: Integers) -> Stages:
    """Return the counts; ``axis`` (T,) decides the pairs that are tested."""
    count_a, count_b = answer.boxes_apart.shape
    apart_a = np.repeat(answer.rows_apart, answer.group)[:count_a]
    in_rows = int(apart_a.sum()) * count_b
    objects = in_rows if answer.rows_apart.all() else 0
    return Stages(
        objects,
        in_rows - objects,
        int(answer.in_groups_apart.sum()) - in_rows,
        answer.pairs_skipped,
        int(((axis >= _NORMALS) & (axis < _EDGES)).sum()),
        int(((axis >= _EDGES) & (axis < _EDGE_BOXES)).sum()),
        int((axis >= _EDGE_BOXES).sum()),
        int((axis == NO_AXIS).sum()),
    )


def _clocks(answer: SceneAnswer, engine: MeshConfiguration) -> Clocks:
    rows, groups_b = answer.groups_apart.shape
    overlapping_rows = rows - int(answer.rows_apart.sum())
    return Clocks(
        rows,
        overlapping_rows * -(-groups_b // engine.lanes),
        answer.group_pairs_opened * engine.group * engine.group // engine.lanes,
        answer.tested,
    )
