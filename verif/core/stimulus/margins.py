"""Margins for given pairs: of every kind, and at the decision."""

from collections.abc import Iterator
from itertools import product

import numpy as np
import numpy.typing as npt

from triaxis.verif.core.stimulus.stimulus import Ints, Rng, around, chance

AnyPairs = npt.NDArray[np.int32] | npt.NDArray[np.int64]
Reals = npt.NDArray[np.float64]

# At most so many pairs at a time: what is worked on stays in the cache.
_BLOCK = 4096


def random_margins(rng: Rng, pairs: AnyPairs, largest: int) -> Ints:
    """Return margins (N,): 0, 1, 7, any size, about the distance of the boxes, and rarely the largest."""
    count = len(pairs)
    if largest == 0:
        return np.zeros(count, np.int64)
    kind = rng.integers(0, 256, count, np.uint8)
    any_size = np.exp2(rng.random(count, np.float32) * np.float32(np.log2(largest + 1))).astype(np.int64)
    margins = np.where(kind < 88, any_size >> 1, np.maximum(box_gaps(pairs), 0) + around(rng, 1, (count,)))
    small = np.array([0, 0, 0, 1, 7], np.int64)[kind % 5]
    margins = np.where((kind >= 160) & (kind < 250), small, margins)
    margins = np.where(kind >= 250, largest, margins)
    return np.clip(margins, 0, largest)


def box_gaps(pairs: AnyPairs) -> Ints:
    """Return the largest gap of the boxes of A and B along x, y and z: (N,)."""
    low = np.minimum(np.minimum(pairs[:, :, 0], pairs[:, :, 1]), pairs[:, :, 2]).astype(np.int64)
    high = np.maximum(np.maximum(pairs[:, :, 0], pairs[:, :, 1]), pairs[:, :, 2])
    gaps = np.maximum(low[:, 1] - high[:, 0], low[:, 0] - high[:, 1])
    return np.maximum(np.maximum(gaps[:, 0], gaps[:, 1]), gaps[:, 2])


def margin_at_decision(rng: Rng, pairs: AnyPairs, largest: int) -> Ints:
    """Return margins (N,) beside the distance d: floor(d), the largest that may clear, and the next above
    and below, within 0..largest. Where d is whole, all three steps of the decision come up.
    """
    if largest == 0:
        return np.zeros(len(pairs), np.int64)
    nearest = np.floor(distances(pairs) + 2.0**-10).astype(np.int64)
    return np.clip(nearest + around(rng, 1, (len(pairs),)), 0, largest)


def distances(pairs: AnyPairs) -> Reals:
    """Return the Chebyshev distances, about: (N,).

    Rounded to float64, which is good enough to choose a margin and decides nothing.
    """
    result = np.empty(len(pairs))
    for start in range(0, len(pairs), _BLOCK):
        block = slice(start, start + _BLOCK)
        result[block] = _distances(pairs[block])
    return result


def _distances(pairs: AnyPairs) -> Reals:
    """Return the largest of gap / |c|1 over the 32 axes."""
    # Coordinates first, x, y, z of six vertices, relative to A1: (3, 6, N).
    points = np.ascontiguousarray(pairs.reshape(-1, 6, 3).transpose(2, 1, 0).astype(np.float64))
    points -= points[:, :1].copy()
    best = np.maximum(box_gaps(pairs), 0).astype(np.float64)
    for c in _axes(points):
        on = c[0] * points[0] + c[1] * points[1] + c[2] * points[2]
        low_a, high_a = (
            np.minimum(np.minimum(on[0], on[1]), on[2]),
            np.maximum(np.maximum(on[0], on[1]), on[2]),
        )
        low_b, high_b = (
            np.minimum(np.minimum(on[3], on[4]), on[5]),
            np.maximum(np.maximum(on[3], on[4]), on[5]),
        )
        norm = np.maximum(np.abs(c[0]) + np.abs(c[1]) + np.abs(c[2]), 1.0)
        np.maximum(best, np.maximum(low_b - high_a, low_a - high_b) / norm, out=best)
    return best


def _axes(points: Reals) -> Iterator[Reals]:
    """Yield the axes other than those of the boxes, (3, N) each, from vertices (3, 6, N)."""
    edges = [points[:, (v + 1) % 3 + v // 3 * 3] - points[:, v] for v in range(6)]
    unit = list(np.eye(3)[..., None])
    factors = [
        (edges[0], edges[1]),
        (edges[3], edges[4]),
        *product(edges[:3], edges[3:]),
        *product(edges, unit),
    ]
    for u, v in factors:
        yield np.stack([u[k - 2] * v[k - 1] - u[k - 1] * v[k - 2] for k in range(3)])


def at_any_margin(rng: Rng, pairs: AnyPairs, largest: int) -> Ints:
    """Return margins of which a quarter are at the decision, and the others of every kind."""
    margins = random_margins(rng, pairs, largest)
    chosen = np.flatnonzero(chance(rng, len(pairs), 4))
    margins[chosen] = margin_at_decision(rng, pairs[chosen], largest)
    return margins
