"""What skipping saves in software: the bulk checker on all facet pairs, and behind the broad phase."""

from dataclasses import dataclass

import numpy as np

from triaxis.bench.skipping.clocked import clocked
from triaxis.golden.bulk import bulk_facts
from triaxis.host.box_tree import Work
from triaxis.host.broadphase import candidates
from triaxis.host.meshcheck import in_order
from triaxis.host.scene_engines import Integers

# Pairs decided at a time, such that they stay in the processor's cache.
_AT_ONCE = 1 << 14


@dataclass(frozen=True)
class Found:
    """All near pairs of two meshes, (K, 2): (facet of A, of B), in order; what it took to find them.

    ``boxes``: comparisons of two boxes; ``tested``: pairs that were decided by the bulk checker.
    """

    near: Integers
    boxes: int
    tested: int


def all_pairs(a: Integers, b: Integers, margin: int) -> Found:
    """Decide all pairs of facets (N, 3, 3) and (M, 3, 3), coordinates and margin in LSB."""
    near = [np.empty((0, 2), np.int64)]
    facets_b = np.arange(len(b))
    step = max(1, _AT_ONCE // max(1, len(b)))
    for start in range(0, len(a), step):
        i = np.repeat(np.arange(start, min(start + step, len(a))), len(b))
        near.append(_near(a, b, i, np.tile(facets_b, len(i) // len(b)), margin))
    return Found(np.concatenate(near), 0, len(a) * len(b))


def behind_boxes(a: Integers, b: Integers, margin: int) -> Found:
    """Decide the pairs that the broad phase leaves; the near ones are the same."""
    work, tested, near = Work(), 0, [np.empty((0, 2), np.int64)]
    for i, j in candidates(a, b, margin, work):
        tested += len(i)
        for start in range(0, len(i), _AT_ONCE):
            chosen = slice(start, start + _AT_ONCE)
            near.append(_near(a, b, i[chosen], j[chosen], margin))
    return Found(np.concatenate(near), work.compared, tested)


def _near(a: Integers, b: Integers, i: Integers, j: Integers, margin: int) -> Integers:
    """Return which pairs (i, j) are near, (K, 2)."""
    near = bulk_facts(np.stack([a[i], b[j]], 1).astype(np.int32), margin).near
    return np.stack([i[near], j[near]], 1)


@dataclass(frozen=True)
class Saved:
    """Seconds of processor time with and without skipping, of pairs of solids, and what was done with it.

    ``same``: both found the same near pairs.
    """

    with_skipping: float = 0.0
    without: float = 0.0
    boxes: int = 0
    tested: int = 0
    same: bool = True

    def __add__(self, other: "Saved") -> "Saved":
        """Return the sums."""
        return Saved(
            self.with_skipping + other.with_skipping,
            self.without + other.without,
            self.boxes + other.boxes,
            self.tested + other.tested,
            self.same and other.same,
        )


def saved(a: Integers, b: Integers, margin: int) -> tuple[Saved, Integers]:
    """Measure both in one run; return also the near pairs (K, 2) behind the broad phase."""
    skipped, seconds = clocked(lambda: behind_boxes(a, b, margin))
    complete, all_seconds = clocked(lambda: all_pairs(a, b, margin))
    near = in_order(skipped.near)
    same = np.array_equal(near, in_order(complete.near))
    return Saved(seconds, all_seconds, skipped.boxes, skipped.tested, same), near
