"""How many pairs of triangles pairs of groups have: what the counters of a mesh engine must add up to."""

from collections.abc import Sequence

import numpy as np


def group_pair_sizes(count_a: int, count_b: int, group: int) -> list[tuple[int, int]]:
    """Return how many pairs a pair of groups has, and how many of those there are: the largest first.

    All groups but the last of a mesh are full.
    """
    (full_a, rest_a), (full_b, rest_b) = divmod(count_a, group), divmod(count_b, group)
    some_a, some_b = int(rest_a > 0), int(rest_b > 0)
    return [
        (group * group, full_a * full_b),
        *sorted([(group * rest_b, full_a * some_b), (rest_a * group, some_a * full_b)], reverse=True),
        (rest_a * rest_b, some_a * some_b),
    ]


def most_pairs(groups: int, sizes: Sequence[tuple[int, int]]) -> int:
    """Return how many pairs so many pairs of groups have at most; ``sizes``: of `group_pair_sizes`."""
    pairs = 0
    for size, count in sizes:
        taken = min(groups, count)
        pairs += taken * size
        groups -= taken
    return pairs


def have_pairs(groups: int, pairs: int, sizes: Sequence[tuple[int, int]]) -> bool:
    """Return whether so many pairs of groups can have exactly so many pairs; ``sizes``: likewise.

    Between the least and the most not all is possible, so that one pair left out mostly shows.
    """
    (full, of_full), (long, of_long), (short, of_short), (corner, of_corner) = sizes
    for corners in range(of_corner + 1):
        # Of the short ones any number; how many of the others there are then, two equations say.
        shorts = np.arange(min(of_short, groups - corners) + 1)
        left = groups - corners - shorts
        missing = full * left - (pairs - corners * corner - shorts * short)
        longs = missing // (full - long)
        whole = longs * (full - long) == missing
        if (whole & (longs >= 0) & (longs <= np.minimum(of_long, left)) & (left - longs <= of_full)).any():
            return True
    return False
