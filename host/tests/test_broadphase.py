"""The broad phase against trying all pairs: nothing lost, nothing more, in order, and in near-linear time."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from triaxis.golden.scene import apart, boxes_of
from triaxis.host import broadphase
from triaxis.host.broadphase import Work, candidates

REPEATABLE = settings(deadline=None, derandomize=True, database=None)


def by_trying_all(a, b, margin):
    return np.argwhere(~apart(boxes_of(a), boxes_of(b), margin))


def found(a, b, margin):
    blocks = [np.stack(block, 1) for block in candidates(a, b, margin)]
    assert all(len(block) for block in blocks)
    return np.concatenate([np.empty((0, 2), np.int64), *blocks])


def assert_same(a, b, margin):
    np.testing.assert_array_equal(found(a, b, margin), by_trying_all(a, b, margin))


def spread(rng, count, place=300, size=40):
    return rng.integers(-place, place, (count, 1, 3)) + rng.integers(-size, size + 1, (count, 3, 3))


def points(rng, count):
    return np.repeat(rng.integers(-6, 6, (count, 1, 3)), 3, 1)


def segments(rng, count):
    return spread(rng, count, 20, 8)[:, [0, 1, 1]]


def identical(rng, count):
    return np.repeat(spread(rng, 1), count, 0)


def huge_among_small(rng, count):
    facets = spread(rng, count, 300, 3)
    facets[:: max(1, count // 4)] *= 100
    return facets


def needles(rng, count):
    return spread(rng, count, 300, 1) + rng.integers(-400, 401, (count, 3, 1)) * np.array([0, 0, 1])


def clustered(rng, count):
    """All within a few steps of each other, but for one far away: more bits than one key of the order."""
    facets = spread(rng, count, 3, 1)
    facets[0] += (1 << 31) - 8
    return facets


def in_one_plane(rng, count):
    return spread(rng, count) * np.array([1, 1, 0]) + np.array([0, 0, 7])


def at_the_ends(rng, count):
    return rng.choice([-(1 << 31), -(1 << 31) + 1, 0, (1 << 31) - 1], (count, 3, 3))


KINDS = [spread, points, segments, identical, huge_among_small, needles, clustered, in_one_plane, at_the_ends]


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_against_every_kind(rng, kind):
    for other in KINDS:
        a, b = kind(rng, 37), other(rng, 70)
        for margin in (0, 50, 1 << 16, (1 << 32) - 1):
            assert_same(a, b, margin)
        assert_same(b, a, 1)


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("side", [-1, 1])
def test_the_margin_ends_at_a_step(axis, side):
    """Boxes at a distance of the margin are within it, one step further they are not: on all six sides."""
    rng = np.random.default_rng(3)
    a = rng.integers(-20, 21, (40, 3, 3))
    a[0] = [[-20, -20, -20], [20, 20, 20], [0, 0, 0]]
    b = a.copy()
    b[:, :, axis] += side * (40 + 9)
    assert len(found(a, b, 9)) > 0
    assert_same(a, b, 9)
    assert len(found(a, b, 8)) == 0


@REPEATABLE
@given(st.data())
def test_small_numbers_of_any_kind(data):
    """Coordinates at all scales, of few values, so that boxes touch, coincide and vanish."""
    scale = data.draw(st.sampled_from([1, 5, 1000, (1 << 29)]))
    coordinates = st.integers(-4, 4).map(lambda x: x * scale)

    def mesh(name):
        numbers = data.draw(st.lists(st.lists(coordinates, min_size=9, max_size=9), max_size=12), label=name)
        return np.array(numbers, np.int64).reshape(-1, 3, 3)

    a, b = mesh("a"), mesh("b")
    assert_same(a, b, data.draw(st.integers(0, 3)) * data.draw(st.sampled_from([1, scale])))


def test_blocks_are_bounded(rng, monkeypatch):
    """No block is larger than allowed, unless it is that of a single facet of A."""
    monkeypatch.setattr(broadphase, "_BLOCK", 100)
    monkeypatch.setattr(broadphase, "_FACETS", 64)
    a, b = np.concatenate([spread(rng, 500), identical(rng, 90)]), np.concatenate([spread(rng, 300)] * 3)
    for i, _ in candidates(a, b, 5):
        assert len(i) <= 100 or i[0] == i[-1]
    assert_same(a, b, 5)


def rough_surface(rng, side):
    """Return a surface of 2 side^2 facets over a square, with a roughness as large as its facets."""
    x, y = np.meshgrid(np.arange(side + 1), np.arange(side + 1), indexing="ij")
    vertex = 16 * np.stack([x, y, np.zeros_like(x)], -1) + rng.integers(-8, 9, (side + 1, side + 1, 3))
    corners = vertex[:-1, :-1], vertex[1:, :-1], vertex[1:, 1:], vertex[:-1, 1:]
    quads = [np.stack([corners[0], corners[k], corners[k + 1]], 2) for k in (1, 2)]
    return np.concatenate([quad.reshape(-1, 3, 3) for quad in quads])


def test_comparisons_grow_like_the_facets(rng):
    for shuffled in (False, True):
        compared = []
        for side in (32, 128):
            a, b = rough_surface(rng, side), rough_surface(rng, side) + np.array([5, 5, 12])
            if shuffled:
                a, b = rng.permutation(a), rng.permutation(b)
            work = Work()
            assert sum(len(i) for i, _ in candidates(a, b, 0, work)) > len(a)
            compared.append(work.compared)
        # The exponent, over 16 times the facets.
        assert np.log(compared[1] / compared[0]) / np.log(16) < 1.1
