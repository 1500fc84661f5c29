"""The variants are what they say: all of them, isometries, in range, and harmless to the verdict."""

from itertools import permutations

import numpy as np
import pytest

from triaxis.verif.core.stimulus import symmetry


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
