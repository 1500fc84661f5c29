"""The facts of a pair from their definitions, slowly: Python's integers, and the linear program."""

import math
from itertools import permutations
from typing import Any

import numpy as np

from triaxis.golden.axes import NUM_AXES, axis_vector
from triaxis.golden.exact import coplanar, dot, triangle_rank
from triaxis.golden.judge import judge

Triangle = list[list[int]]


def _order(triangle: Triangle) -> int:
    orders = permutations(range(3))
    return next(n for n, order in enumerate(orders) if [triangle[v] for v in order] == sorted(triangle))


def _is_part(a: Triangle, b: Triangle) -> bool:
    return all(judge([vertex] * 3, b, 0).near for vertex in a)


def _bits(projections: list[int], extreme: int) -> int:
    return sum(1 << v for v, projection in enumerate(projections) if projection == extreme)


def _examine(facts: dict[str, int], number: int, a: Triangle, b: Triangle, margin: int) -> None:
    axis: list[Any] = axis_vector(number, a, b)
    on_a: list[Any] = [dot(axis, vertex) for vertex in a]
    on_b: list[Any] = [dot(axis, vertex) for vertex in b]
    up, down = min(on_b) - max(on_a), min(on_a) - max(on_b)
    reach = margin * sum(map(abs, axis))
    bit, step = 1 << number, math.gcd(*axis)
    facts["above"] |= bit * (up > reach)
    facts["below"] |= bit * (down > reach)
    facts["upper"] |= bit * (up >= down)
    facts["lower"] |= bit * (down >= up)
    if step == 0:
        return
    if len({*on_a, *on_b}) == 1:
        facts["flat"] |= bit
        return
    excess = max(up, down) - reach
    facts["clear_step"] |= bit * (excess == step)
    facts["near_step"] |= bit * (excess == -step)
    if excess == 0:
        facts["level"] |= bit
        facts["support_a"] &= _bits(on_a, max(on_a) if up > down else min(on_a))
        facts["support_b"] &= _bits(on_b, min(on_b) if up > down else max(on_b))


def _kind(facts: dict[str, int]) -> int:
    """Return the digits of the kind put together, each with how many bits it has."""
    separating = facts["above"] | facts["below"]
    # The lowest bit's number, and 1; 0 where there is none.
    claim = (separating & -separating).bit_length()
    digits = (
        (facts["rank_a"], 2),
        (facts["rank_b"], 2),
        (facts["level"] != 0, 1),
        (facts["clear_step"] & separating != 0, 1),
        (facts["near_step"] != 0, 1),
        (facts["flat"] != 0, 1),
        (facts["support_a"].bit_count(), 2),
        (facts["support_b"].bit_count(), 2),
    )
    for digit, bits in digits:
        claim = claim << bits | digit
    return claim


def slow_facts(a: Triangle, b: Triangle, margin: int) -> dict[str, int]:
    """Return the fields of Facts of one pair."""
    sides = ("above", "below", "upper", "lower")
    facts = dict.fromkeys((*sides, "level", "clear_step", "near_step", "flat"), 0)
    facts |= {"support_a": 7, "support_b": 7}
    for number in range(NUM_AXES):
        _examine(facts, number, a, b, margin)
    coordinates = np.array([a, b])
    facts |= {
        "rank_a": triangle_rank(a),
        "rank_b": triangle_rank(b),
        "order_a": _order(a),
        "order_b": _order(b),
        "coplanar": int(coplanar(a, b)),
        "a_in_b": int(_is_part(a, b)),
        "b_in_a": int(_is_part(b, a)),
        "low": int(coordinates.min()),
        "high": int(coordinates.max()),
        "extent": int(np.ptp(coordinates, (0, 1)).max()),
    }
    return facts | {"kind": _kind(facts)}
