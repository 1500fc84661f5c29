"""Stimulus is what it says: in range, repeatable; contacts touch, near misses miss by a step."""

from itertools import product
from math import gcd
from typing import Any

import numpy as np
import pytest

from triaxis.golden.axes import axis_vector
from triaxis.golden.bulk import bulk_facts
from triaxis.golden.exact import dot
from triaxis.golden.facts import Facts
from triaxis.golden.pairs import check_pairs
from triaxis.verif.core.stimulus.families import FAMILIES, TOUCHING, mixture
from triaxis.verif.core.stimulus.near_miss import (
    box,
    edge_box,
    edge_box_level,
    edge_edge,
    edge_edge_level,
    face_vertex,
    face_vertex_level,
    family_of,
)
from triaxis.verif.core.stimulus.stimulus import Stimulus

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


def test_a_seed_gives_the_same_stimulus_and_another_one_others():
    for name, family in {**FAMILIES, "mixture": mixture}.items():
        if family is mixture:
            first, second, third = (mixture(np.random.default_rng(s), 16, 255).burst(5000) for s in (4, 4, 5))
            assert len(np.unique(first.pairs.reshape(-1, 18), axis=0)) > 0.97 * len(first)
        else:
            first, second, third = (family(np.random.default_rng(s), 100, 16, 255) for s in (5, 5, 6))
        assert (first.pairs == second.pairs).all(), name
        assert (first.margins == second.margins).all(), name
        assert (first.pairs != third.pairs).any(), name


# How many vertices of the two span what touches, and whether any axis is at the margin at all: triangles that
# overlap in one plane touch in all of both.
SUPPORTS = {
    "vertex-vertex": (1, 1),
    "vertex-edge": (1, 2),
    "vertex-face": (1, 3),
    "edge-edge": (2, 2),
    "edge-face": (2, 3),
    "face-face": (3, 3),
    "shared edge": (2, 2),
}


@pytest.mark.parametrize("width", [8, 13, 16, 24, 32])
@pytest.mark.parametrize("name", TOUCHING)
def test_features_touch_and_no_more(rng, name, width):
    stimulus = family_of([(TOUCHING[name], 1)])(rng, 2000, width, 0)
    facts = facts_of(stimulus)
    assert facts.near.all()
    proper = (facts.rank_a == 2) & (facts.rank_b == 2)
    assert proper.mean() > 0.4
    supports = np.sort(np.bitwise_count(np.stack([facts.support_a, facts.support_b], 1)), 1)
    assert (supports[proper] == SUPPORTS[name]).all()
    touching = proper & (facts.level != 0)
    assert (touching == proper).all() if name != "face-face" else facts.coplanar.all()


def _gap(c, a, b):
    """Return the gap on c, B above A."""
    return min(dot(c, v) for v in b) - max(dot(c, v) for v in a)


# The construction, the axis on which it is close, and the gaps in steps that come up.
CONSTRUCTIONS = {
    "face, vertex": (face_vertex, 3, {-1, 1}),
    "face, vertex level": (face_vertex_level, 3, {0}),
    "edge, edge": (edge_edge, 5, {-1, 1}),
    "edge, edge level": (edge_edge_level, 5, {0}),
    "edge, vertex": (lambda *a: edge_box(*a, flat=False), 16, {-1, 1}),
    "edge, vertex level": (lambda *a: edge_box_level(*a, flat=False), 16, {0}),
    "edge, vertex flat": (lambda *a: edge_box(*a, flat=True), 16, {-1, 1}),
    "edge, vertex flat level": (lambda *a: edge_box_level(*a, flat=True), 16, {0}),
    "vertex, vertex": (lambda *a: box(*a, flat=False), 0, {-1, 0, 1}),
    "vertex, vertex flat": (lambda *a: box(*a, flat=True), 0, {-1, 0, 1}),
}


@pytest.mark.parametrize("name", CONSTRUCTIONS)
def test_gaps_are_the_smallest_steps(rng, name):
    make, axis, steps = CONSTRUCTIONS[name]
    for width in WIDTHS:
        contact = make(rng, 60, width)
        seen = set()
        for (a, b), away in zip(contact.pairs.tolist(), contact.away.tolist(), strict=True):
            c: list[Any] = axis_vector(axis, a, b)
            if dot(c, away) < 0:
                c = [-x for x in c]
            # The direction in which B moves away is that of the axis, component by component.
            assert away == [(x > 0) - (x < 0) for x in c]
            step, rest = divmod(_gap(c, a, b), gcd(*c))
            assert rest == 0
            seen.add(step)
        # Both signs, from a number of contacts of which chance gives one sign alone hardly ever.
        assert seen == steps if len(contact.pairs) > 14 else seen <= steps
        assert len(contact.pairs) > 5
