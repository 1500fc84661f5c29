"""Families of pairs, each a function of a random generator, a count and a width: (N, 2, 3, 3).

Sizes are drawn over the whole range, from a few LSB to all of it, so that near and clear pairs both
come up at every scale.
"""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from triaxis.golden.pairs import Pairs, coordinate_range

Family = Callable[[np.random.Generator, int, int], Pairs]


def _sizes(rng: np.random.Generator, count: int, width: int, largest: float) -> npt.NDArray[np.int64]:
    """Return half-widths of local boxes, log-uniform: (N, 1, 1, 1)."""
    bits = rng.uniform(1, largest, count)
    return np.minimum(np.exp2(bits).astype(np.int64), 1 << (width - 2)).reshape(-1, 1, 1, 1)


def _place(rng: np.random.Generator, pairs: Pairs, width: int) -> Pairs:
    """Move each pair to a random place where it fits; clip what no place would hold."""
    low, high = coordinate_range(width)
    flat = pairs.reshape(-1, 6, 3)
    room_low, room_high = low - flat.min(1), high - flat.max(1)
    fits = room_low <= room_high
    shift = rng.integers(np.where(fits, room_low, 0), np.where(fits, room_high, 0) + 1)
    return np.clip(pairs + shift[:, None, None, :], low, high)


def random_pairs(rng: np.random.Generator, count: int, width: int) -> Pairs:
    """Return general pairs whose boxes mostly overlap, at all scales."""
    size = _sizes(rng, count, width, width - 1)
    pairs = rng.integers(-size, size + 1, (count, 2, 3, 3))
    apart = rng.integers(-size, size + 1, (count, 1, 1, 3)) * rng.integers(0, 2, (count, 1, 1, 1))
    pairs[:, 1:] += apart
    return _place(rng, pairs, width)


def far_pairs(rng: np.random.Generator, count: int, width: int) -> Pairs:
    """Return small triangles anywhere in the range: nearly all are decided by their boxes."""
    low, high = coordinate_range(width)
    size = _sizes(rng, count, width, width / 2)
    centre = rng.integers(low, high + 1, (count, 2, 1, 3))
    return np.clip(centre + rng.integers(-size, size + 1, (count, 2, 3, 3)), low, high)


def _of_rank(
    rng: np.random.Generator, rank: npt.NDArray[np.int64], size: npt.NDArray[np.int64]
) -> npt.NDArray[np.int64]:
    """Return triangles (N, 3, 3) of rank at most ``rank``: 0 points, 1 segments with collinear
    vertices in any order, 2 triangles.
    """
    count = len(rank)
    size = size.reshape(-1, 1, 1)
    triangle = rng.integers(-size, size + 1, (count, 3, 3))
    origin = triangle[:, :1]
    steps = rng.integers(-3, 4, (count, 3, 1))
    direction = rng.integers(-np.maximum(size // 3, 1), np.maximum(size // 3, 1) + 1, (count, 1, 3))
    segment = origin + steps * direction
    choice = rank.reshape(-1, 1, 1)
    return np.where(choice == 0, origin, np.where(choice == 1, segment, triangle))


def degenerate_pairs(rng: np.random.Generator, count: int, width: int) -> Pairs:
    """Return every combination of point, segment and triangle; half of them share a vertex."""
    combination = np.arange(count) % 9
    size = _sizes(rng, count, width, width - 2)
    a = _of_rank(rng, combination // 3, size)
    b = _of_rank(rng, combination % 3, size)
    rows = np.arange(count)
    meet = a[rows, rng.integers(0, 3, count)] - b[rows, rng.integers(0, 3, count)]
    b += np.where(rng.integers(0, 2, count)[:, None] == 0, meet, 0)[:, None]
    return _place(rng, np.stack([a, b], 1), width)


def coplanar_pairs(rng: np.random.Generator, count: int, width: int) -> Pairs:
    """Return pairs in one plane: half axis-aligned, half tilted; some moved off by one step."""
    size = _sizes(rng, count, width, width - 3)
    aligned = rng.integers(-size, size + 1, (count, 2, 3, 3))
    rows = np.arange(count)
    aligned[rows, :, :, rng.integers(0, 3, count)] = 0

    # A tilted plane: integer combinations of two short vectors. |combination| <= 2 * 3 * step.
    step = np.maximum(size // 6, 1)
    basis = rng.integers(-3, 4, (count, 1, 2, 3))
    weights = rng.integers(-step, step + 1, (count, 2, 3, 2))
    tilted = weights @ basis
    pairs = np.where((rows % 2 == 0).reshape(-1, 1, 1, 1), aligned, tilted)

    off = (rng.integers(0, 4, count) == 0).reshape(-1, 1, 1)
    pairs[:, 1] += np.where(off, rng.integers(-1, 2, (count, 1, 3)), 0)
    return _place(rng, pairs, width)


def extreme_pairs(rng: np.random.Generator, count: int, width: int) -> Pairs:
    """Return pairs with coordinates at and beside the limits, zero and the powers of two."""
    low, high = coordinate_range(width)
    values = np.array([low, low + 1, -1, 0, 1, high - 1, high, low // 2, high // 2, 1 - high])
    corners = values[rng.integers(0, len(values), (count, 2, 3, 3))]
    limits = np.where(rng.integers(0, 2, (count, 2, 3, 3)) == 0, low, high)
    return np.where((np.arange(count) % 2 == 0).reshape(-1, 1, 1, 1), corners, limits)


def touching_pairs(rng: np.random.Generator, count: int, width: int) -> Pairs:
    """Return pairs that share a feature, or miss it by one step: vertex, edge, or a point of an edge
    or face given by halves and thirds.
    """
    size = _sizes(rng, count, width, width - 5) * 6
    a = rng.integers(-size[:, 0] // 6, size[:, 0] // 6 + 1, (count, 3, 3)) * 6
    b = rng.integers(-size[:, 0], size[:, 0] + 1, (count, 3, 3))
    weights = np.array([[6, 0, 0], [3, 3, 0], [2, 4, 0], [2, 2, 2], [1, 2, 3], [4, 1, 1]], np.int64)[
        rng.integers(0, 6, count)
    ]
    point = (weights[:, :, None] * a).sum(1) // 6
    b[:, 0] = point
    shared_edge = rng.integers(0, 4, count) == 0
    b[shared_edge, 0] = a[shared_edge, 0]
    b[shared_edge, 1] = a[shared_edge, 1]
    miss = rng.integers(0, 3, count) == 0
    b[miss, 0] += rng.integers(-1, 2, (int(miss.sum()), 3))
    return _place(rng, np.stack([a, b], 1), width)


def tiny_pairs(rng: np.random.Generator, count: int, width: int) -> Pairs:
    """Return pairs on a grid of a few steps, around zero: nothing but coincidences."""
    size = rng.integers(1, 5, (count, 1, 1, 1))
    return rng.integers(-size, size + 1, (count, 2, 3, 3))


FAMILIES: dict[str, Family] = {
    "random": random_pairs,
    "far": far_pairs,
    "degenerate": degenerate_pairs,
    "coplanar": coplanar_pairs,
    "extremes": extreme_pairs,
    "tiny": tiny_pairs,
    "touching": touching_pairs,
}


def mixed_pairs(rng: np.random.Generator, count: int, width: int) -> Pairs:
    """Return pairs of all families in random order, in random vertex orders, A and B swapped or not."""
    each = -(-count // len(FAMILIES))
    pairs = np.concatenate([family(rng, each, width) for family in FAMILIES.values()])
    return shuffled(rng, rng.permutation(pairs)[:count])


def shuffled(rng: np.random.Generator, pairs: Pairs) -> Pairs:
    """Return the pairs in random vertex orders, with A and B swapped or not."""
    order = rng.permuted(np.broadcast_to(np.arange(3), (len(pairs), 2, 3)), axis=2)
    pairs = np.take_along_axis(pairs, order[..., None], axis=2)
    swap = rng.integers(0, 2, len(pairs)) == 1
    return np.where(swap.reshape(-1, 1, 1, 1), pairs[:, ::-1], pairs)


def all_orders(pairs: Pairs) -> Pairs:
    """Return all 72 orders of each pair, 6 x 6 vertex orders and A, B swapped: (72 N, 2, 3, 3)."""
    orders = np.array([[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]])
    variants = [
        np.stack([pairs[:, i][:, x], pairs[:, 1 - i][:, y]], 1)
        for i in (0, 1)
        for x in orders
        for y in orders
    ]
    return np.stack(variants, 1).reshape(-1, 2, 3, 3)


def random_margins(rng: np.random.Generator, pairs: Pairs, largest: int) -> npt.NDArray[np.int64]:
    """Return margins (N,): 0, 1, 7, any size, the largest, and about the distance of the boxes."""
    count = len(pairs)
    low, high = pairs.min(2), pairs.max(2)
    gap = np.maximum(low[:, 1] - high[:, 0], low[:, 0] - high[:, 1]).max(1)
    beside = np.maximum(gap, 0) + rng.integers(-1, 2, count)
    any_size = np.exp2(rng.uniform(0, np.log2(largest + 1), count)).astype(np.int64)
    choices = np.stack(
        [
            np.zeros(count),
            np.ones(count),
            np.full(count, 7),
            any_size,
            np.full(count, largest),
            beside,
        ]
    ).astype(np.int64)
    # The largest margin makes everything near: rare.
    kind = rng.choice(len(choices), count, p=[0.25, 0.15, 0.15, 0.2, 0.02, 0.23])
    return np.clip(choices[kind, np.arange(count)], 0, largest)
