"""The broad phase against trying all pairs: nothing lost, nothing more, in order."""

import numpy as np
import pytest

from triaxis.golden.scene import apart, boxes_of
from triaxis.host import broadphase
from triaxis.host.broadphase import FacetTrees, Poses, candidates


def found(a, b, margin):
    blocks = [np.stack(block, 1) for block in candidates(a, b, margin)]
    assert all(len(block) for block in blocks)
    return np.concatenate([np.empty((0, 2), np.int64), *blocks])


def assert_same(a, b, margin):
    np.testing.assert_array_equal(found(a, b, margin), np.argwhere(~apart(boxes_of(a), boxes_of(b), margin)))


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
    assert len(found(a, b, 9)) > 0 == len(found(a, b, 8))
    assert_same(a, b, 9)


def test_blocks_are_bounded(rng, monkeypatch):
    """No block is larger than allowed, unless it is that of a single facet of A."""
    monkeypatch.setattr(broadphase, "_BLOCK", 100)
    monkeypatch.setattr(broadphase, "_FACETS", 64)
    a, b = (
        np.concatenate([spread(rng, 500), KINDS["identical"](rng, 90)]),
        np.tile(spread(rng, 300), (3, 1, 1)),
    )
    for i, _ in candidates(a, b, 5):
        assert len(i) <= 100 or i[0] == i[-1]
    assert_same(a, b, 5)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("most", [1, 30, 1 << 12])
def test_some_are_all_where_that_is_said(rng, monkeypatch, kind, most):
    """At several poses at once: a part of what is there, or all of it."""
    monkeypatch.setattr(broadphase, "_FACETS", 32)
    a, b = KINDS[kind](rng, 45), spread(rng, 70)
    poses = Poses(rng.integers(-200, 200, (9, 3)), rng.integers(0, 60, 9))
    (pose, i, j), complete = FacetTrees(a, b).some(poses, most)
    # A tree each for the first and the last facets of A.
    assert np.bincount(pose, minlength=9).max() <= 2 * most and complete.all() >= (most > 45 * 70)
    for number in range(9):
        got = set(zip(i[pose == number].tolist(), j[pose == number].tolist(), strict=True))
        wanted = {tuple(pair) for pair in found(a + poses.moves[number], b, poses.margins[number]).tolist()}
        assert len(got) == (pose == number).sum() and got <= wanted
        assert got == wanted or not complete[number]
