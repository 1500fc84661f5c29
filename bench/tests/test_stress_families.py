"""The families of the stress test: each knob does what its label says."""

import numpy as np
import pytest

from triaxis.bench.stress.constructions import (
    WIDTH,
    contacts_at,
    degenerate,
    far_away,
    near_misses,
    nearly_coplanar,
    of_unlike_size,
    slivers,
)
from triaxis.bench.stress.families import FAMILIES
from triaxis.golden.axes import axis_vector
from triaxis.golden.bulk import bulk_facts
from triaxis.golden.exact import dot
from triaxis.golden.judge import judge


def lengths(vectors):
    return np.sqrt((vectors.astype(float) ** 2).sum(-1))


def longest_edges(triangles):
    return lengths(triangles - np.roll(triangles, 1, 1)).max(1)


def widths(triangles):
    """Return the smallest heights of triangles (N, 3, 3), from their exact areas."""
    areas = [
        float(sum(x * x for x in axis_vector(3, t, t))) ** 0.5 for t in triangles.astype(object).tolist()
    ]
    return np.array(areas) / longest_edges(triangles)


@pytest.mark.parametrize("family", FAMILIES, ids=lambda family: family.name)
def test_every_setting_makes_pairs(rng, family):
    for setting in family.settings:
        state = rng.bit_generator.state
        pairs = setting.make(rng, 41)
        assert pairs.shape == (41, 2, 3, 3) and pairs.dtype == np.int64
        assert np.abs(pairs).max() < 1 << 53
        rng.bit_generator.state = state
        assert (setting.make(rng, 41) == pairs).all()
        near = np.mean([judge(a, b, 0).near for a, b in pairs.tolist()])
        assert near == 1 if (family.name, setting.label) == ("gap", "0") else 0.1 < near < 0.9, setting.label


@pytest.mark.parametrize("gap", [4.0, 2.0**-20])
def test_contacts_are_as_far_apart_as_said(rng, gap):
    pairs = contacts_at(rng, 40, WIDTH, gap)
    assert 0.2 < bulk_facts(pairs, 0).near.mean() < 0.8
    for a, b in pairs.tolist():
        found = judge(a, b, 0)
        # Of two planes a distance apart, the Chebyshev distance is at least 1 / sqrt(3) of that.
        assert found.near or 0.57 * gap < found.distance < 1.01 * gap


def test_near_misses_are_one_step_away_or_touch(rng):
    facts = bulk_facts(near_misses(rng, 900, 16), 0)
    touching, apart = facts.near & (facts.level != 0), ~facts.near
    assert (facts.clear_step[apart] != 0).all()
    assert 0.25 < touching.mean() < 0.42 and 0.2 < apart.mean() < 0.45
    assert (facts.near_step[facts.near & ~touching] != 0).all()
    assert ((facts.rank_a == 2) & (facts.rank_b == 2)).all()


@pytest.mark.parametrize("tilt", [2.0**-8, 2.0**-50])
def test_planes_are_tilted_as_said(rng, tilt):
    angles = []
    for a, b in nearly_coplanar(rng, 60, tilt).astype(object).tolist():
        # Exact products; the angle is small, so its sine will do.
        normals = [axis_vector(3, t, t) for t in (a, b)]
        sine = float(dot(c := _cross(*normals), c)) ** 0.5
        angles.append(sine / float(dot(normals[0], normals[0]) * dot(normals[1], normals[1])) ** 0.5)
    assert 0.1 * tilt < np.median(angles) < 10 * tilt


def _cross(x, y):
    return [x[k - 2] * y[k - 1] - x[k - 1] * y[k - 2] for k in range(3)]


@pytest.mark.parametrize("exponent", [4, 24, 46])
def test_slivers_are_as_thin_as_said(rng, exponent):
    pairs = slivers(rng, 40, 2.0**-exponent)
    ratios = np.stack([widths(pairs[:, k]) / longest_edges(pairs[:, k]) for k in (0, 1)], 1).min(1)
    # Rounding to whole units of 2^-50 of the length.
    assert (np.abs(ratios * 2.0**exponent - 1) < 2.0 ** (exponent - 47)).all()


def test_slivers_of_no_width_are_segments(rng):
    pairs = slivers(rng, 40, 0.0)
    assert (np.minimum(widths(pairs[:, 0]), widths(pairs[:, 1])) == 0).all()


@pytest.mark.parametrize("exponent", [4, 24, 44])
def test_sizes_are_in_the_ratio_said(rng, exponent):
    pairs = of_unlike_size(rng, 40, 2.0**-exponent)
    a, b = longest_edges(pairs[:, 0]), longest_edges(pairs[:, 1])
    ratios = np.minimum(a, b) / np.maximum(a, b)
    assert (np.abs(np.log2(ratios) + exponent) < 3).all()


def test_far_pairs_are_the_same_pairs_moved(rng):
    state = rng.bit_generator.state
    here = far_away(rng, 30, 0.0)
    rng.bit_generator.state = state
    there = far_away(rng, 30, 2.0**36)
    moved = (there - here).reshape(-1, 3)
    assert (moved == moved[0]).all() and np.abs(moved[0]).max() == 1 << 52


def test_degenerate_pairs_have_their_ranks(rng):
    for rank_a, rank_b in ((2, 2), (2, 1), (2, 0), (1, 1), (1, 0), (0, 0)):
        pairs = degenerate(rng, 101, rank_a, rank_b)
        facts = bulk_facts(pairs, 0)
        assert (facts.rank_a == rank_a).all() and (facts.rank_b == rank_b).all()
        assert facts.near.sum() == 50 and bulk_facts(pairs, 1).near.all()
        assert np.abs(pairs).max() <= 31
