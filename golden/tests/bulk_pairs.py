"""Pairs and margins that are hard on the bulk checker: coincidences at every scale, and the limits."""

import numpy as np
import numpy.typing as npt

from triaxis.golden.pairs import Pairs, coordinate_range

# Grids this small are nothing but coincidences: touching, level, one step away, flat, degenerate.
_TINY = 3


def _tiny(rng: np.random.Generator, count: int) -> Pairs:
    return rng.integers(-_TINY, _TINY + 1, (count, 2, 3, 3))


def _sheared(rng: np.random.Generator, pairs: Pairs, limit: int) -> Pairs:
    """Return the pairs after unimodular maps that fill the range: what was level, flat or one step away
    at margin 0 on a normal or on an edge x edge axis still is.
    """
    rows = np.arange(len(pairs))
    for _ in range(8):
        to, by = rng.permuted(np.tile(np.arange(3), (len(pairs), 1)), axis=1).T[:2]
        room = limit // np.maximum(abs(pairs).max((1, 2, 3)), 1)
        factor = rng.integers(-room, room + 1) // rng.integers(1, 50, len(pairs))
        moved = pairs.copy()
        moved[rows, :, :, to] += factor[:, None, None] * pairs[rows, :, :, by]
        fits = abs(moved).max((1, 2, 3)) <= limit
        pairs = np.where(fits[:, None, None, None], moved, pairs)
    return pairs


def _degenerate(rng: np.random.Generator, pairs: Pairs) -> Pairs:
    """Return the pairs with vertices replaced by others, of the same triangle or of the other one."""
    count = len(pairs)
    rows, pairs = np.arange(count), pairs.copy()
    for _ in range(4):
        to, (vertex, other) = rng.integers(0, 2, count), rng.integers(0, 3, (2, count))
        by = np.where(rng.integers(0, 4, count) == 0, 1 - to, to)
        pairs[rows, to, vertex] = pairs[rows, by, other]
    return pairs


def _inside(rng: np.random.Generator, pairs: Pairs) -> Pairs:
    """Return pairs in which B is a part of A, touching its border or not."""
    weights = np.array([[6, 0, 0], [0, 6, 0], [0, 0, 6], [3, 3, 0], [2, 2, 2], [0, 1, 5], [4, 1, 1]])
    a = pairs[:, 0] // 6 * 6
    chosen = weights[rng.integers(0, len(weights), (len(pairs), 3))]
    return np.stack([a, chosen @ a // 6], 1)


def awkward_pairs(rng: np.random.Generator, count: int, width: int) -> Pairs:
    """Return about ``count`` pairs (N, 2, 3, 3) of all kinds, in random order."""
    low, high = coordinate_range(width)
    each = -(-count // 8)
    size = np.exp2(rng.uniform(1, width - 1, (each, 1, 1, 1))).astype(np.int64)
    general = rng.integers(-size, size, (each, 2, 3, 3))
    corners = rng.choice(np.array([low, low + 1, 0, high - 1, high]), (each, 2, 3, 3))
    limits = rng.choice(np.array([low, high]), (each, 2, 3, 3))
    sheared = _sheared(rng, _tiny(rng, each), high)
    scaled = _tiny(rng, each) * rng.integers(1, high // _TINY + 1, (each, 1, 1, 1))
    inside = _inside(rng, np.where(rng.integers(0, 2, (each, 1, 1, 1)) == 0, general, scaled))
    kinds = [general, corners, limits, sheared, scaled, inside, _tiny(rng, each)]
    kinds.append(_degenerate(rng, rng.permutation(np.concatenate(kinds))[:each]))
    pairs = rng.permutation(np.concatenate(kinds))
    swap = rng.integers(0, 2, len(pairs)) == 0
    return np.where(swap[:, None, None, None], pairs[:, ::-1], pairs)


def awkward_margins(rng: np.random.Generator, pairs: Pairs, width: int) -> npt.NDArray[np.int64]:
    """Return margins (N,): 0, tiny, the distance of the boxes and one beside, any, the largest."""
    largest = (1 << width) - 1
    low, high = pairs.min(2), pairs.max(2)
    gap = np.maximum(low[:, 1] - high[:, 0], low[:, 0] - high[:, 1]).max(1).clip(0)
    count = len(pairs)
    kinds = [
        np.zeros(count, np.int64),
        np.zeros(count, np.int64),
        rng.integers(0, 4, count),
        gap,
        gap + rng.integers(-1, 2, count),
        gap // 2,
        np.exp2(rng.uniform(0, width, count)).astype(np.int64),
        np.full(count, largest),
    ]
    return np.choose(rng.integers(0, len(kinds), count), kinds).clip(0, largest)


_WIDTHS = (8, 16, 17, 20, 24, 25, 26, 27, 30, 32)


def hard_pairs(rng: np.random.Generator, count: int) -> tuple[Pairs, npt.NDArray[np.int64]]:
    """Return pairs of all widths in random order, so that neighbours need different arithmetic; margins."""
    pairs = [awkward_pairs(rng, count, width) for width in _WIDTHS]
    margins = [awkward_margins(rng, p, width) for p, width in zip(pairs, _WIDTHS, strict=True)]
    order = rng.permutation(sum(map(len, pairs)))
    return np.concatenate(pairs)[order], np.concatenate(margins)[order]
