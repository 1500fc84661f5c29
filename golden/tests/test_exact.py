from fractions import Fraction
from itertools import permutations

import pytest

from triaxis.golden.exact import coplanar, rank, triangle_rank

TRIANGLE = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
SEGMENT = [[0, 0, 0], [3, 6, 9], [1, 2, 3]]
POINT = [[5, -5, 5]] * 3


@pytest.mark.parametrize(("triangle", "expected"), [(TRIANGLE, 2), (SEGMENT, 1), (POINT, 0)])
def test_triangle_rank_in_every_order(triangle, expected):
    assert {triangle_rank(order) for order in permutations(triangle)} == {expected}


def test_rank_is_exact_where_floating_point_is_not():
    big = 10**30
    assert rank([[big, 1, 0], [big * 3, 3, 0]]) == 1
    assert rank([[big, 1, 0], [big * 3, 4, 0]]) == 2
    assert rank([[Fraction(1, 3), 0, 0], [0, Fraction(1, 10**20), 0], [0, 0, 1]]) == 3


def test_coplanar():
    assert coplanar(TRIANGLE, [[7, 7, 0], [9, 0, 0], [1, 1, 0]])
    assert not coplanar(TRIANGLE, [[7, 7, 0], [9, 0, 0], [1, 1, 1]])
    assert coplanar(SEGMENT, POINT)
    # Two skew segments are degenerate triangles in no common plane.
    assert not coplanar([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 1], [0, 0, 1], [0, 2, 1]])
