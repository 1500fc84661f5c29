import numpy as np
import pytest

from triaxis.golden.axes import separating
from triaxis.golden.exact import coplanar, triangle_rank
from triaxis.golden.pairs import check_pairs
from triaxis.verif.scenes import mesh_pairs
from triaxis.verif.sequences.families import FAMILIES, all_orders, mixed_pairs, random_margins, shuffled
from triaxis.verif.sequences.seed_vectors import seed_vectors


@pytest.mark.parametrize("name", FAMILIES)
@pytest.mark.parametrize("width", [8, 16, 32])
def test_in_range_and_of_both_verdicts(rng, name, width):
    pairs = FAMILIES[name](rng, 400, width)
    assert pairs.shape == (400, 2, 3, 3)
    check_pairs(pairs, width)
    near = ~separating(pairs, np.zeros(400, np.int64)).any(1)
    # Far pairs are there to be clear.
    assert near.any() or name == "far"
    assert not near.all()


def test_same_seed_same_pairs():
    first, second = (mixed_pairs(np.random.default_rng(5), 100, 16) for _ in range(2))
    assert (first == second).all()


def test_degenerate_pairs_are_of_every_combination(rng):
    ranks = {(triangle_rank(a), triangle_rank(b)) for a, b in FAMILIES["degenerate"](rng, 900, 16).tolist()}
    assert ranks == {(i, j) for i in range(3) for j in range(3)}


def test_coplanar_pairs_are(rng):
    pairs = FAMILIES["coplanar"](rng, 400, 16).tolist()
    flat = [coplanar(a, b) for a, b in pairs]
    assert 200 < sum(flat) < 400
    tilted = [
        True
        for (a, b), c in zip(pairs, flat, strict=True)
        if c and all(len({v[k] for v in a + b}) > 1 for k in range(3))
    ]
    assert len(tilted) > 80


def test_orders(rng):
    pairs = rng.integers(0, 1000, (2, 2, 3, 3))
    orders = all_orders(pairs)
    assert orders.shape == (144, 2, 3, 3)
    assert len({order.tobytes() for order in orders}) == 144
    vertices = {
        tuple(map(tuple, p.reshape(6, 3).tolist())) for p in np.sort(orders.reshape(-1, 6, 3), axis=1)
    }
    assert len(vertices) == 2
    again = shuffled(rng, np.repeat(pairs[:1], 500, 0))
    assert {o.tobytes() for o in again} <= {o.tobytes() for o in orders[:72]}


def test_margins_in_range(rng):
    pairs = mixed_pairs(rng, 500, 8)
    for largest in (0, 1, 255):
        margins = random_margins(rng, pairs, largest)
        assert margins.min() >= 0
        assert margins.max() == largest


def test_seed_vectors_and_meshes(rng):
    assert seed_vectors(16).shape == (15, 2, 3, 3)
    for width in (8, 16, 32):
        check_pairs(mesh_pairs(rng, 101, width), width)
        assert len(mesh_pairs(rng, 101, width)) == 101
