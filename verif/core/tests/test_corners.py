"""Pairs at corners reach the bounds of the projections, and none lies beyond them."""

import numpy as np
import pytest

from triaxis.golden.pairs import coordinate_range
from triaxis.verif.core.stimulus.corners import (
    ORIENTATION,
    SPAN,
    all_corners,
    at_corners,
    largest_pairs,
    orientations,
    spans,
)


def test_no_corner_lies_beyond_the_bounds():
    corners = all_corners()
    assert max(np.abs(orientations(corners, v)).max() for v in range(3)) == ORIENTATION
    assert max(np.abs(spans(corners, i, j, (j + 2) % 3)).max() for i in range(3) for j in range(3)) == SPAN


@pytest.mark.parametrize("width", [8, 16])
def test_largest_pairs_reach_both_bounds_with_both_signs(rng, width):
    low, high = coordinate_range(width)
    pairs = largest_pairs(rng, 4000, width).astype(np.int64)
    assert pairs.min() == low
    assert pairs.max() == high
    cube = (high - low) ** 3
    found = [orientations(pairs, vertex) for vertex in range(3)]
    assert np.max(found) == ORIENTATION * cube
    assert np.min(found) == -ORIENTATION * cube
    found = [spans(pairs, i, j, (j + 2) % 3) for i in range(3) for j in range(3)]
    assert np.max(found) == SPAN * cube
    assert np.min(found) == -SPAN * cube


def test_half_of_the_margins_hide_nothing(rng):
    stimulus = at_corners(rng, 2001, 16, 65535)
    assert len(stimulus) == 2001
    assert (stimulus.margins[::2] == 0).all()
    assert (stimulus.margins[1::2] > 0).any()
