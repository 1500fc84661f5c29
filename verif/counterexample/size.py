"""What makes one counterexample smaller than another.

The order compares, one after the other: the sum of the bit lengths of the coordinates and the margin;
the largest absolute coordinate; the number of distinct coordinates; the margin; the sum of the absolute
coordinates; the number of negative ones; the coordinates themselves. The last makes it total, so that
shrinking is deterministic; nothing in it ever grows without bound, so that shrinking ends.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from triaxis.golden.pairs import Pairs


def bit_lengths(values: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """Return the bit length of each absolute value, which must be below 2^53."""
    # frexp is exact there: 2^(e-1) <= value < 2^e.
    return np.frexp(np.abs(values).astype(np.float64))[1].astype(np.int64)


def sizes(pairs: Pairs, margins: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """Return the sizes of pairs (N, 2, 3, 3) at margins (N,): rows (N, K), to be compared from the left."""
    flat = pairs.reshape(-1, 18)
    absolute = np.abs(flat)
    ordered = np.sort(flat, axis=1)
    summary = [
        bit_lengths(flat).sum(1) + bit_lengths(margins),
        absolute.max(1),
        1 + (np.diff(ordered, axis=1) != 0).sum(1),
        margins,
        absolute.sum(1),
        (flat < 0).sum(1),
    ]
    return np.column_stack([*summary, flat])


def smallest_first(keys: npt.NDArray[Any]) -> npt.NDArray[np.intp]:
    """Return the order that sorts rows of sizes (N, K)."""
    return np.lexsort(keys.T[::-1])


def smaller(keys: npt.NDArray[np.int64], than: npt.NDArray[np.int64]) -> npt.NDArray[np.bool_]:
    """Return which rows of sizes (N, K) are strictly smaller than the one row (K,)."""
    differs = keys != than
    first = differs.argmax(1)
    rows = np.arange(len(keys))
    return differs.any(1) & (keys[rows, first] < than[first])
