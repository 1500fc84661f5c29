"""The exact answer for a whole scene: which pairs of two meshes are near, and which skips have a proof.

A pair may be left untested only where a box axis separates its triangles by more than the margin, or their
groups, or A's group from the whole of B. Boxes of sets contain those of their members, so each of these
implies the one before. Nothing here follows the RTL: boxes are compared by their definition, and every pair
that they leave is decided by the bulk checker.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from triaxis.golden.bulk import bulk_verdicts

Integers = npt.NDArray[np.int64]
Mask = npt.NDArray[np.bool_]

# Pairs of boxes compared at a time: bounds the memory, whatever the meshes.
_BLOCK = 1 << 20


@dataclass(frozen=True)
class SceneAnswer:
    """What is so for meshes of N and M triangles, in groups of ``group``.

    ``rows_apart`` (ceil(N/group),): A's group against the whole of B. ``groups_apart`` (.., ceil(M/group)):
    group against group. ``boxes_apart`` (N, M): triangle against triangle. ``near`` (N, M).
    """

    group: int
    rows_apart: Mask
    groups_apart: Mask
    boxes_apart: Mask
    near: Mask

    @property
    def group_pairs_skipped(self) -> int:
        """Return how many pairs of groups their boxes decide."""
        return int(self.groups_apart.sum())

    @property
    def group_pairs_opened(self) -> int:
        """Return how many pairs of groups their boxes leave."""
        return self.groups_apart.size - self.group_pairs_skipped

    @cached_property
    def pairs_skipped(self) -> int:
        """Return how many pairs within the groups left are decided by their own boxes."""
        pairs_opened = self.boxes_apart.size - int(self.in_groups_apart.sum())
        return pairs_opened - self.tested

    @cached_property
    def tested(self) -> int:
        """Return how many pairs no box decides."""
        return self.boxes_apart.size - int(self.boxes_apart.sum())

    @cached_property
    def in_groups_apart(self) -> Mask:
        """Return which pairs lie in groups that are apart: (N, M)."""
        count_a, count_b = self.boxes_apart.shape
        by_a = np.repeat(self.groups_apart, self.group, axis=0)[:count_a]
        return np.repeat(by_a, self.group, axis=1)[:, :count_b]

    @cached_property
    def to_be_tested(self) -> Integers:
        """Return the pairs that no box decides, (K, 2), in the order of the scan."""
        return in_scan_order(np.argwhere(~self.boxes_apart), self.group)

    @cached_property
    def near_pairs(self) -> Integers:
        """Return the near pairs, (K, 2), in the order of the scan."""
        return in_scan_order(np.argwhere(self.near), self.group)


def in_scan_order(pairs: Integers, group: int) -> Integers:
    """Return pairs (K, 2) in the order of the scan: groups of A, of B, then triangles of A, of B."""
    i, j = pairs[:, 0], pairs[:, 1]
    return pairs[np.lexsort((j, i, j // group, i // group))]


def boxes_of(triangles: Integers) -> Integers:
    """Return the boxes (N, 2, 3), low corner and high corner, of triangles (N, 3, 3)."""
    return np.stack([triangles.min(1), triangles.max(1)], 1)


def boxes_of_groups(boxes: Integers, group: int) -> Integers:
    """Return the boxes (ceil(N/group), 2, 3) of groups of consecutive boxes (N, 2, 3)."""
    starts = np.arange(0, len(boxes), group)
    if not len(starts):
        return np.empty((0, 2, 3), np.int64)
    return np.stack([np.minimum.reduceat(boxes[:, 0], starts), np.maximum.reduceat(boxes[:, 1], starts)], 1)


def apart(a: Integers, b: Integers, margin: int) -> Mask:
    """Return (N, M): which boxes (N, 2, 3) an axis separates from which (M, 2, 3) by more than the margin."""
    found = np.zeros((len(a), len(b)), np.bool_)
    for rows in _blocks(len(a), len(b)):
        for axis in range(3):
            found[rows] |= b[None, :, 0, axis] - a[rows, None, 1, axis] > margin
            found[rows] |= a[rows, None, 0, axis] - b[None, :, 1, axis] > margin
    return found


def scene_answer(a: Integers, b: Integers, margin: int, group: int) -> SceneAnswer:
    """Return the exact answer for triangles (N, 3, 3), moved already, and (M, 3, 3) at a margin, in LSB.

    Coordinates and margin as `bulk_verdicts` takes them.
    """
    a, b = a.astype(np.int64), b.astype(np.int64)
    boxes_a, boxes_b = boxes_of(a), boxes_of(b)
    groups_a, groups_b = boxes_of_groups(boxes_a, group), boxes_of_groups(boxes_b, group)
    whole_b = boxes_of_groups(boxes_b, max(1, len(b)))
    boxes_apart = apart(boxes_a, boxes_b, margin)
    near = np.zeros_like(boxes_apart)
    for rows in _blocks(len(a), len(b)):
        i, j = np.nonzero(~boxes_apart[rows])
        i += rows.start
        near[i, j] = bulk_verdicts(np.stack([a[i], b[j]], 1), margin)["near"]
    return SceneAnswer(
        group,
        np.asarray(apart(groups_a, whole_b, margin).all(1)),
        apart(groups_a, groups_b, margin),
        boxes_apart,
        near,
    )


def _blocks(count_a: int, count_b: int) -> Iterator[slice]:
    step = max(1, _BLOCK // max(1, count_b))
    return (slice(start, min(start + step, count_a)) for start in range(0, count_a, step))
