"""The broad phase against trying all pairs: nothing lost, nothing more, in order."""

import numpy as np
import pytest

from triaxis.golden.errors import InputError
from triaxis.golden.scene import apart, boxes_of
from triaxis.host.broadphase import FacetTrees, Work, all_candidates, in_order


def assert_same(a, b, margin):
    wanted = np.argwhere(~apart(boxes_of(a), boxes_of(b), margin))
    np.testing.assert_array_equal(all_candidates(a, b, margin), wanted)


def spread(rng, count, place=300, size=40):
    return rng.integers(-place, place, (count, 1, 3)) + rng.integers(-size, size + 1, (count, 3, 3))


def huge_among_small(rng, count):
    facets = spread(rng, count, 300, 3)
    facets[:: max(1, count // 4)] *= 100
    return facets


def clustered(rng, count):
    """All within a few steps of each other, but for one far away: more bits than one key of the order."""
    facets = spread(rng, count, 3, 1)
    facets[0] += (1 << 31) - 8
    return facets


ENDS = [-(1 << 31), -(1 << 31) + 1, 0, (1 << 31) - 1]
KINDS = {
    "spread": spread,
    "points": lambda rng, count: np.repeat(rng.integers(-6, 6, (count, 1, 3)), 3, 1),
    "segments": lambda rng, count: spread(rng, count, 20, 8)[:, [0, 1, 1]],
    "identical": lambda rng, count: np.repeat(spread(rng, 1), count, 0),
    "huge among small": huge_among_small,
    "needles": lambda rng, count: (
        spread(rng, count, 300, 1) + rng.integers(-400, 401, (count, 3, 1)) * [0, 0, 1]
    ),
    "clustered": clustered,
    "in one plane": lambda rng, count: spread(rng, count) * [1, 1, 0] + [0, 0, 7],
    "at the ends": lambda rng, count: rng.choice(ENDS, (count, 3, 3)),
    # Of few values, so that boxes touch, coincide and vanish.
    "large steps": lambda rng, count: rng.integers(-4, 5, (count, 3, 3)) * (1 << 29),
}


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_against_every_kind(rng, kind):
    for other in KINDS.values():
        a, b = KINDS[kind](rng, 37), other(rng, 70)
        for margin in (0, 50, 1 << 16, 1 << 29, (1 << 32) - 1):
            assert_same(a, b, margin)
        assert_same(b, a, 1)
    for sizes in ((0, 5), (5, 0), (1, 1), (1, 300), (4, 4), (5, 17), (64, 65)):
        a, b = (KINDS[kind](rng, max(size, 1))[:size] for size in sizes)
        assert_same(a, b, 3)


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("side", [-1, 1])
def test_the_margin_ends_at_a_step(axis, side):
    """Boxes at a distance of the margin are within it, one step further they are not: on all six sides."""
    rng = np.random.default_rng(3)
    a = rng.integers(-20, 21, (40, 3, 3))
    a[0] = [[-20, -20, -20], [20, 20, 20], [0, 0, 0]]
    b = a.copy()
    b[:, :, axis] += side * (40 + 9)
    assert len(all_candidates(a, b, 9)) > 0 == len(all_candidates(a, b, 8))
    assert_same(a, b, 9)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("most", [1, 30])
def test_trees_serve_all_poses_in_blocks_of_any_size(rng, kind, most):
    """Each pair once, in full blocks but for the last; searches that are left, or go on beside others."""
    a, b = KINDS[kind](rng, 45), spread(rng, 70)
    trees = FacetTrees(a, b)
    next(trees.candidates(a[0, 0] * 0, 1 << 32), None)
    for move, margin in zip(rng.integers(-200, 200, (9, 3)), rng.integers(0, 60, 9).tolist(), strict=True):
        work = Work()
        blocks = [np.stack(block, 1) for block in trees.candidates(move, margin, work, most)]
        assert {len(block) for block in blocks[:-1]} <= {most} and all(map(len, blocks))
        wanted = all_candidates(a + move, b, margin)
        np.testing.assert_array_equal(in_order(np.concatenate([wanted[:0], *blocks])), wanted)
        assert work.compared >= len(wanted)


def test_what_overlaps_by_most_comes_first():
    """Cubes in a row, and one like them that is moved along: it meets that in whose place it is."""
    row = np.array([[[20 * k] * 3, [20 * k + 9] * 3, [20 * k + 9] * 3] for k in range(64)])
    trees = FacetTrees(row[:1], row)
    for place in (0, 17, 40, 63):
        move = np.full(3, 20 * place)
        (i, j), *_ = trees.candidates(move, 0)
        assert (i.tolist(), j.tolist()) == ([0], [place])
        # Within 500 there are 25 on either side.
        (_, j), *_ = trees.candidates(move, 500, block=1)
        assert abs(int(j[0]) - place) <= 2


def test_what_is_beyond_32_bits_is_refused_where_it_is_decided():
    a, none = np.zeros((1, 3, 3), np.int64), np.empty((0, 2), np.int64)
    far = np.array([0, (1 << 31) - 1, 0])
    near, decided = FacetTrees(a, a + far).first_near(far, 0, none)
    assert (near.tolist(), decided) == ([[0, 0]], 1)
    for move, margin in ((far + 1, 1 << 31), (-far - 2, (1 << 32) - 1), (far, 1 << 32)):
        with pytest.raises(InputError, match="32 bits are the most"):
            FacetTrees(a, a).first_near(move, margin, none)
        assert len(FacetTrees(a, a).first_near(move, margin >> 2, none)[0]) == 0
    for empty in ((a[:0], a), (a, a[:0])):
        assert (
            FacetTrees(*empty).first_near(far, 0, none)[1]
            == 0
            == len([*FacetTrees(*empty).candidates(far, 9)])
        )
