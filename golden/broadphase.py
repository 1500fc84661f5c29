"""Which facet pairs can be near at all: those whose boxes are not apart by more than the margin."""

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

# Candidate pairs examined at a time: bounds the memory, whatever the meshes.
_BLOCK = 1 << 20


def candidates(
    a: npt.NDArray[np.int64], b: npt.NDArray[np.int64], margin: int
) -> Iterator[tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]]:
    """Yield facet numbers (i of A, j of B) whose boxes come within the margin, block by block.

    ``a`` and ``b`` have shape (N, 3, 3). Exact: a pair left out is separated by a box axis. B is
    sorted along x; for each facet of A the facets of B that begin early enough are a prefix, and
    those that begin no earlier than A's start less the widest facet of B are a suffix.
    """
    low_a, high_a = a.min(1) - margin, a.max(1) + margin
    order = np.argsort(b[:, :, 0].min(1), kind="stable")
    low_b, high_b = b.min(1)[order], b.max(1)[order]
    widest = int((high_b[:, 0] - low_b[:, 0]).max(initial=0))
    first = np.searchsorted(low_b[:, 0], low_a[:, 0] - widest, "left")
    last = np.searchsorted(low_b[:, 0], high_a[:, 0], "right")
    counts = last - first
    start = 0
    while start < len(a):
        stop = start + max(1, int(np.searchsorted(np.cumsum(counts[start:]), _BLOCK, "right")))
        count = counts[start:stop]
        i = np.repeat(np.arange(start, stop), count)
        within = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
        j = np.repeat(first[start:stop], count) + within
        overlap = ((low_a[i] <= high_b[j]) & (low_b[j] <= high_a[i])).all(1)
        if overlap.any():
            yield i[overlap], order[j[overlap]]
        start = stop
