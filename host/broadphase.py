"""Which facet pairs can be near at all: those whose boxes are not apart by more than the margin."""

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from triaxis.host.box_tree import BoxTree, Work, overlapping

Integers = npt.NDArray[np.int64]

# Pairs in a block, and facets of A in it: they bound the memory, whatever the meshes.
_BLOCK = 1 << 20
_FACETS = 1 << 14


def candidates(
    a: Integers, b: Integers, margin: int, work: Work | None = None
) -> Iterator[tuple[Integers, Integers]]:
    """Yield facet numbers (i of A, j of B) whose boxes come within the margin, block by block, in order.

    ``a`` and ``b`` have shape (N, 3, 3), in LSB, below 2^60 in size. Exact: all pairs but those that a box
    axis separates by more than the margin, each once, by i and then by j. A block has at most 2^20 pairs,
    or those of a single facet of A. Time grows like (N + M) log (N + M) and the number of pairs, where
    facets are spread as on surfaces; ``work`` is told what was compared.
    """
    work = Work() if work is None else work
    if not len(a) or not len(b):
        return
    boxes_a, boxes_b = _boxes(a, margin), _boxes(b, 0)
    number_a, number_b = _reaching(boxes_a, boxes_b), _reaching(boxes_b, boxes_a)
    if not len(number_a) or not len(number_b):
        return
    tree_b = BoxTree(boxes_b[number_b])
    start, step = 0, _FACETS
    while start < len(number_a):
        facets = number_a[start : start + step]
        most = _BLOCK if len(facets) > 1 else None
        found = overlapping(BoxTree(boxes_a[facets]), tree_b, most, work)
        if found is None:
            step = len(facets) // 2
            continue
        start += len(facets)
        if len(found[0]) < _BLOCK // 4:
            step = min(2 * step, _FACETS)
        if len(found[0]):
            yield _in_order(facets, number_b, *found)


def _boxes(facets: Integers, margin: int) -> Integers:
    """Return the boxes (N, 2, 3) of facets (N, 3, 3), grown by a margin on all sides."""
    return np.stack([facets.min(1) - margin, facets.max(1) + margin], 1)


def _reaching(boxes: Integers, others: Integers) -> Integers:
    """Return the numbers of boxes (N, 2, 3) that overlap the box of all the others (M, 2, 3)."""
    low, high = others[:, 0].min(0), others[:, 1].max(0)
    return np.flatnonzero(((boxes[:, 0] <= high) & (low <= boxes[:, 1])).all(1))


def _in_order(number_a: Integers, number_b: Integers, i: Integers, j: Integers) -> tuple[Integers, Integers]:
    """Return the facet numbers of pairs (K,), (K,), by the facet of A and then of B; the lists ascend."""
    # One number a pair sorts several times faster than two.
    key = np.sort(i * len(number_b) + j)
    i = key // len(number_b)
    return number_a[i], number_b[key - i * len(number_b)]
