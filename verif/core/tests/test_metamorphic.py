"""The variants of pairs are what they say, the core answers them alike, and an answer that is not is seen."""

from itertools import permutations

import numpy as np
import pytest

from triaxis.golden.pairs import coordinate_range
from triaxis.sim.configuration import Configuration
from triaxis.sim.core_engine import RtlEngine
from triaxis.sim.result import COPLANAR, DEGENERATE_A, DEGENERATE_B, NEAR
from triaxis.verif.core.metamorphic import GROUPS, MOVES, ORDERS, SYMMETRIES, answered_alike
from triaxis.verif.core.stimulus import symmetry
from triaxis.verif.core.stimulus.families import mixed


@pytest.mark.simulator
@pytest.mark.parametrize(
    "configuration", [Configuration(16, 0), Configuration(8, 8, gating=False)], ids=lambda c: c.name
)
def test_the_core_answers_variants_alike(rng, configuration):
    engine = RtlEngine(configuration)
    base = mixed(rng, 600, configuration.width, configuration.max_margin)
    for group in GROUPS:
        variants = group.make(rng, base.pairs, configuration.width)
        words = engine.words(variants, base.margins.repeat(group.size))[0]
        assert answered_alike(words, group, configuration.gating).all()
        # It would be no check if they were all of one sort.
        for flag in (NEAR, COPLANAR, DEGENERATE_A, DEGENERATE_B):
            assert 0 < (words & flag != 0).mean() < 1
        for flag in (NEAR, COPLANAR, DEGENERATE_A, DEGENERATE_B):
            wrong = words.copy()
            wrong[rng.integers(len(words))] ^= np.uint16(flag)
            assert not answered_alike(wrong, group, configuration.gating).all()


def claim(axis, flags=0):
    return axis << 8 | flags


@pytest.mark.parametrize(
    ("group", "word", "other", "good"),
    [
        # Orders renumber edges and exchange A and B; the kind of axis stays.
        (ORDERS, claim(5), claim(13), True),
        (ORDERS, claim(14), claim(31), True),
        (ORDERS, claim(3), claim(4), True),
        (ORDERS, claim(4), claim(5), False),
        (ORDERS, claim(0), claim(1), False),
        # Symmetries exchange coordinates.
        (SYMMETRIES, claim(0), claim(2), True),
        (SYMMETRIES, claim(14), claim(16), True),
        (SYMMETRIES, claim(14), claim(17), False),
        (SYMMETRIES, claim(3), claim(4), False),
        (SYMMETRIES, claim(2), claim(3), False),
        # Translations leave all as it is.
        (MOVES, claim(30), claim(31), False),
        # A near pair claims no axis; a pair that its boxes decide has no flags, where there is gating.
        (ORDERS, NEAR, NEAR | claim(1), False),
        (MOVES, NEAR, NEAR | COPLANAR, False),
        (ORDERS, claim(7), claim(7, 1 << 4), False),
    ],
)
def test_what_a_group_lets_change(group, word, other, good):
    words, at = np.full(group.size, word, np.uint16), group.size // 4
    words[at] = other
    agree = answered_alike(words, group, gating=False)
    assert agree.shape == (1, group.size)
    assert agree[0, at] == good
    assert np.delete(agree[0], at).all()


def test_flags_follow_a_and_b_and_gated_pairs_have_none():
    words = np.full(72, claim(6, DEGENERATE_A | COPLANAR), np.uint16)
    assert (answered_alike(words, ORDERS, False) == ~ORDERS.swapped).all()
    words[ORDERS.swapped] = claim(6, DEGENERATE_B | COPLANAR)
    assert answered_alike(words, ORDERS, False).all()
    for word, good in ((claim(2), True), (claim(2, COPLANAR), False), (claim(3, COPLANAR), True)):
        words = np.full(MOVES.size, word, np.uint16)
        assert answered_alike(words, MOVES, True).all() == good
        assert answered_alike(words, MOVES, False).all()


def matrices():
    """Return the symmetries as signed permutation matrices (48, 3, 3), from the two tables."""
    signs = np.where(symmetry.REFLECTED, -1, 1)
    return np.eye(3, dtype=np.int64)[symmetry.COORDINATES] * signs[:, :, None]


def test_the_symmetries_are_the_group_of_the_cube():
    group = matrices()
    assert (group[0] == np.eye(3)).all()
    assert (group @ group.transpose(0, 2, 1) == np.eye(3)).all()
    names = {matrix.tobytes() for matrix in group}
    assert len(names) == 48
    assert {product.tobytes() for product in (group[:, None] @ group[None]).reshape(-1, 3, 3)} == names


def test_orders_are_all_72(rng):
    pairs = rng.integers(-100, 100, (3, 2, 3, 3)).astype(np.int32)
    orders = symmetry.all_orders(pairs)
    assert orders.dtype == pairs.dtype
    for pair, found in zip(pairs.tolist(), orders.reshape(3, 72, 2, 3, 3).tolist(), strict=True):
        expected = [
            [list(p), list(q)]
            for first, second in (pair, pair[::-1])
            for p in permutations(first)
            for q in permutations(second)
        ]
        assert found == expected
    assert ((np.arange(72) >= 36) == symmetry.SWAPPED).all()


@pytest.mark.parametrize(
    ("random", "every"),
    [
        (symmetry.random_orders, symmetry.all_orders),
        (symmetry.random_cube_symmetries, symmetry.all_cube_symmetries),
    ],
)
def test_random_variants_are_variants_and_all_come_up(rng, random, every):
    pair = rng.integers(-100, 100, (1, 2, 3, 3)).astype(np.int32)
    # Several blocks: each variant must be that of its own pair.
    pairs = np.concatenate([pair + np.int32(1000) * i for i in range(3)]).repeat(2500, 0)
    found = random(rng, pairs)
    assert found.shape == pairs.shape
    for i in range(3):
        names = {v.tobytes() for v in every(pair + np.int32(1000) * i)}
        assert {v.tobytes() for v in found[2500 * i : 2500 * (i + 1)]} == names
    first, second = (random(np.random.default_rng(5), pairs) for _ in range(2))
    assert (first == second).all()
    assert (pairs[0] == pair[0]).all()


@pytest.mark.parametrize("kind", [np.int32, np.int64])
@pytest.mark.parametrize("width", [8, 32])
def test_variants_are_those_that_numpy_makes(rng, width, kind):
    low, high = coordinate_range(width)
    pairs = rng.integers(low, high + 1, (500, 2, 3, 3)).astype(kind)
    pairs[::5] = rng.choice(np.array([low, high], kind), (100, 2, 3, 3))
    pairs[::2] >>= 3
    rows = rng.integers(0, len(pairs), 3000)
    orders, symmetries = rng.integers(0, 72, len(rows)), rng.integers(0, 48, len(rows))
    vertices = pairs[rows].reshape(-1, 6, 3)[np.arange(len(rows))[:, None], symmetry.VERTICES[orders]]
    turned = np.take_along_axis(vertices, symmetry.COORDINATES[symmetries][:, None].astype(np.intp), 2)
    turned ^= np.where(symmetry.REFLECTED[symmetries], -1, 0)[:, None].astype(kind)
    found = symmetry.rearranged(pairs, rows, orders, symmetries)
    assert found.dtype == kind and (found.reshape(-1, 6, 3) == turned).all()
