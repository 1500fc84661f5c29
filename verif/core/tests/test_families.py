from itertools import product

import numpy as np
import pytest

from triaxis.golden.bulk import bulk_facts
from triaxis.golden.exact import coplanar, triangle_rank
from triaxis.golden.facts import Facts
from triaxis.golden.pairs import check_pairs, coordinate_range
from triaxis.host.scenes import mesh_pairs
from triaxis.verif.core.stimulus import mixture as mixtures
from triaxis.verif.core.stimulus.coplanar import coplanar_near_miss, coplanar_pairs
from triaxis.verif.core.stimulus.families import FAMILIES, mixed, mixed_pairs, mixture
from triaxis.verif.core.stimulus.penetrating import penetrating_pairs
from triaxis.verif.core.stimulus.seed_vectors import seed_vectors
from triaxis.verif.core.stimulus.slivers import sliver_pairs
from triaxis.verif.core.stimulus.stimulus import Stimulus, collected, divided

WIDTHS = range(8, 33)


def facts_of(stimulus: Stimulus) -> Facts:
    return bulk_facts(stimulus.pairs, stimulus.margins)


@pytest.mark.parametrize("name", FAMILIES)
def test_in_range_at_every_width(rng, name):
    for width, count in product(WIDTHS, (0, 1, 50)):
        largest = int(rng.choice([0, 1, (1 << width // 2) - 1, (1 << width) - 1]))
        # Anything that NumPy notices, such as an overflow in float64, is an error here.
        with np.errstate(all="raise"):
            stimulus = FAMILIES[name](rng, count, width, largest)
        assert stimulus.pairs.shape == (count, 2, 3, 3)
        assert stimulus.margins.shape == (count,)
        assert (stimulus.pairs.dtype, stimulus.margins.dtype) == (np.int32, np.uint32)
        assert stimulus.pairs.flags.c_contiguous
        check_pairs(stimulus.pairs, width)
        assert count == 0 or stimulus.margins.max() <= largest


@pytest.mark.parametrize("name", FAMILIES)
@pytest.mark.parametrize("width", [8, 16, 32])
def test_both_verdicts_and_large_numbers(rng, name, width):
    for largest in (0, (1 << width) - 1):
        stimulus = FAMILIES[name](rng, 1500, width, largest)
        facts = facts_of(stimulus)
        # Far pairs without a margin are there to be clear, some others to be near.
        assert facts.near.any() or (name, largest) == ("far", 0)
        assert facts.near.all() == (name in ("shared", "penetrating"))
        small = name in ("tiny", "near-miss small")
        size = (facts.high.astype(np.int64) - facts.low).max()
        assert small or size > (1 << width) * 3 // 4
        assert largest == 0 or len(np.unique(stimulus.margins)) > 20


def test_same_seed_same_stimulus():
    for name, family in FAMILIES.items():
        first, second, third = (family(np.random.default_rng(s), 100, 16, 255) for s in (5, 5, 6))
        assert (first.pairs == second.pairs).all(), name
        assert (first.margins == second.margins).all(), name
        assert (first.pairs != third.pairs).any(), name


def test_degenerate_pairs_are_of_every_combination(rng):
    pairs = FAMILIES["degenerate"](rng, 1800, 16, 0).pairs
    ranks = [(triangle_rank(a), triangle_rank(b)) for a, b in pairs.tolist()]
    for i, j in product(range(3), repeat=2):
        assert ranks.count((i, j)) > 80
    facts = bulk_facts(pairs, 0)
    assert (facts.near & (facts.level != 0)).mean() > 0.2


def test_coplanar_pairs_are(rng):
    pairs = coplanar_pairs(rng, 600, 16).tolist()
    flat = [coplanar(a, b) for a, b in pairs]
    assert 360 < sum(flat) < 560
    tilted = [all(len({v[k] for v in a + b}) > 1 for k in range(3)) for a, b in pairs]
    assert sum(t and c for t, c in zip(tilted, flat, strict=True)) > 120
    aligned = [any(len({v[k] for v in a + b}) == 1 for k in range(3)) for a, b in pairs]
    assert sum(aligned) > 200
    # Off the plane by one step: not coplanar, but nearly.
    assert 600 - sum(flat) > 40


def test_coplanar_near_misses_are_close(rng):
    contact = coplanar_near_miss(rng, 3000, 16)
    assert len(contact.pairs) > 700
    facts = bulk_facts(contact.pairs, 0)
    assert facts.coplanar.all()
    # A third touches, and the others are apart or overlap by little.
    assert (facts.near & (facts.level != 0)).mean() > 0.2
    assert 0.2 < 1 - facts.near.mean() < 0.5
    distance = (bulk_facts(contact.pairs, 255).near).mean()
    assert distance > 0.95


def test_contained_pairs_are(rng):
    pairs = FAMILIES["contained"](rng, 4000, 16, 0).pairs
    facts = bulk_facts(pairs, 0)
    inside = (facts.a_in_b | facts.b_in_a) != 0
    assert 0.7 < inside.mean() < 0.9
    assert (facts.a_in_b & facts.b_in_a).mean() > 0.15
    assert (facts.a_in_b[inside] != 0).mean() > 0.4
    # A part of lower rank, in a triangle.
    ranks = np.stack([facts.rank_a, facts.rank_b])[:, inside]
    assert ((ranks.max(0) == 2) & (ranks.min(0) == 1)).mean() > 0.05
    assert ((ranks.max(0) == 2) & (ranks.min(0) == 0)).mean() > 0.02


def _crossings(edges_of: np.ndarray, face_of: np.ndarray) -> np.ndarray:
    """Return how many edges of one triangle pass inside the face of the other: 64-bit numbers suffice."""
    normal = np.cross(face_of[:, 1] - face_of[:, 0], face_of[:, 2] - face_of[:, 0])
    height = ((edges_of - face_of[:, :1]) * normal[:, None]).sum(-1)
    count = np.zeros(len(face_of), int)
    for i in range(3):
        p, q = edges_of[:, i], edges_of[:, (i + 1) % 3]
        apart = height[:, i] * height[:, (i + 1) % 3] < 0
        turns = [
            np.sign((np.cross(face_of[:, j] - p, face_of[:, (j + 1) % 3] - p) * (q - p)).sum(-1))
            for j in range(3)
        ]
        count += apart & (np.abs(sum(turns)) == 3)
    return count


def test_penetrating_pairs_are(rng):
    pairs = penetrating_pairs(rng, 4000, 12).astype(np.int64)
    crossings = np.stack([_crossings(pairs[:, 0], pairs[:, 1]), _crossings(pairs[:, 1], pairs[:, 0])], 1)
    # Two edges of one triangle, or one of each.
    assert (crossings.max(1) == 2).mean() > 0.4
    assert ((crossings == 1).all(1)).mean() > 0.1
    assert (crossings.sum(1) > 0).mean() > 0.95
    assert bulk_facts(pairs, 0).near.all()


def test_slivers_are_as_thin_as_can_be(rng):
    triangles = sliver_pairs(rng, 4000, 24).astype(np.int64).reshape(-1, 3, 3)
    p, q = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    area = np.abs(np.cross(p, q)).max(1)
    longest = np.abs(np.stack([p, q, q - p])).max((0, 2))
    # The height is area / length. One in 8 is a triangle of any shape.
    assert ((area > 0) & (area <= 4 * longest)).mean() > 0.6
    # The smallest area that there is, on a long edge: an aspect of about the length squared.
    assert ((area == 1) & (longest > 1 << 16)).mean() > 0.08


def test_extremes_reach_the_limits(rng):
    low, high = coordinate_range(32)
    facts = bulk_facts(FAMILIES["extremes"](rng, 8000, 32, 0).pairs, 0)
    assert ((facts.low == low) & (facts.high == high)).mean() > 0.7
    # On a line along a coordinate axis, where a box axis can be the only one.
    alone = np.isin(facts.separating, np.array([1, 2, 4], np.uint32))
    assert alone.sum() > 10


def test_mixed_is_of_all_families(rng, monkeypatch):
    def marked(number):
        def family(rng, count, width, largest_margin):
            return Stimulus(np.full((count, 2, 3, 3), number, np.int32), np.full(count, number, np.uint32))

        return family

    families = [marked(n) for n in range(7)]
    monkeypatch.setattr(mixtures, "random_cube_symmetries", lambda rng, pairs: pairs)
    for count in (1, 100, 5000):
        stimulus = mixtures.mixed_once(rng, families, count, 16, 0)
        assert len(stimulus) == count
        assert set(stimulus.margins) == set(range(7)) or count == 1
        # Margins stay with their pairs, where these are neither moved nor centred.
        half = count // 2
        assert (stimulus.pairs[:half, 0, 0, 0] == stimulus.margins[:half]).all()
    supply = mixtures.Mixture(rng, families, 16, 0)
    shares = np.bincount(supply.burst(70_000).margins, minlength=7) / 10_000
    assert (np.abs(shares - 1) < 0.1).all()


def test_mixture_renews_its_pool_at_the_rate_of_its_use(rng):
    made: list[int] = []

    def family(rng, count, width, largest_margin):
        made.append(count)
        number = len(made)
        return Stimulus(np.full((count, 2, 3, 3), number, np.int32), np.full(count, number, np.uint32))

    supply = mixtures.Mixture(rng, [family] * 4, 16, 0)
    assert len(made) == 4
    seen = [supply.burst(65_536).margins for _ in range(30)]
    assert sum(made) == pytest.approx(4 * made[0] + 30 * 65_536 / mixtures.TIMES, abs=made[0])
    uses = np.bincount(np.concatenate(seen))[5:-4] / made[0]
    assert uses.mean() == pytest.approx(mixtures.TIMES, rel=0.15)


def test_mixture_is_deterministic_and_never_repeats_itself():
    one, two = (mixture(np.random.default_rng(4), 16, 255) for _ in range(2))
    bursts = [(one.burst(5000), two.burst(5000)) for _ in range(3)]
    for a, b in bursts:
        assert (a.pairs == b.pairs).all()
        assert (a.margins == b.margins).all()
    every = np.concatenate([a.pairs for a, _ in bursts]).reshape(-1, 18)
    assert len(np.unique(every, axis=0)) > 0.97 * len(every)


def test_variants_are_answered_alike(rng):
    for width in (8, 16, 32):
        base = mixed(rng, 4000, width, (1 << width) - 1)
        again = mixtures.varied(rng, base, width)
        check_pairs(again.pairs, width)
        assert (again.pairs != base.pairs).any((1, 2, 3)).mean() > 0.95
        first, second = facts_of(base), facts_of(again)
        assert (first.near == second.near).all()
        assert (first.coplanar == second.coplanar).all()
        assert (np.bitwise_count(first.level) == np.bitwise_count(second.level)).all()


def test_centred_pairs_are_around_zero(rng):
    low, high = coordinate_range(32)
    pairs = np.concatenate(
        [mixed(rng, 3000, 32, 0).pairs, rng.choice(np.array([low, high], np.int32), (200, 2, 3, 3))]
    )
    moved = mixtures.centred(pairs).astype(np.int64).reshape(-1, 6, 3)
    assert (np.isin(moved.max(1) + moved.min(1), [-1, 0])).all()
    assert (
        moved - moved[:, :1]
        == (pairs.astype(np.int64).reshape(-1, 6, 3) - pairs.reshape(-1, 6, 3)[:, :1].astype(np.int64))
    ).all()


def test_pairs_without_margins(rng):
    pairs = mixed_pairs(rng, 300, 16)
    check_pairs(pairs, 16)
    assert pairs.dtype == np.int64
    assert 0.2 < bulk_facts(pairs, 0).near.mean() < 0.95


def test_counts_are_divided_and_collected():
    for count, shares in product((0, 1, 7, 100), ([1], [1, 2, 3], [1] * 30)):
        parts = divided(count, shares)
        assert sum(parts) == count
        assert all(abs(p - count * s / sum(shares)) < 1 for p, s in zip(parts, shares, strict=True))

    def nothing(count):
        return Stimulus(np.empty((0, 2, 3, 3), np.int32), np.empty(0, np.uint32))

    with pytest.raises(RuntimeError, match="0 of"):
        collected(5, nothing)


def test_seed_vectors_and_meshes(rng):
    assert seed_vectors(16).shape == (15, 2, 3, 3)
    for width in (8, 16, 32):
        check_pairs(mesh_pairs(rng, 101, width), width)
        assert len(mesh_pairs(rng, 101, width)) == 101
