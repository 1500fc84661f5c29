"""Pairs at the smallest step of the lattice, judged by Python's own integers and the bulk checker."""

from math import gcd
from typing import Any

import numpy as np
import pytest

from triaxis.golden.axes import axis_vector
from triaxis.golden.bulk import bulk_facts
from triaxis.golden.exact import dot
from triaxis.verif.core.stimulus.families import FAMILIES
from triaxis.verif.core.stimulus.near_miss import (
    box,
    edge_box,
    edge_box_level,
    edge_edge,
    edge_edge_level,
    face_vertex,
    face_vertex_level,
)

WIDTHS = range(8, 33)


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


def _float_separating(pairs: np.ndarray) -> np.ndarray:
    """Return whether an axis separates, as double-precision software says: the textbook's eleven axes."""
    a, b = pairs[:, 0].astype(np.float64), pairs[:, 1].astype(np.float64)
    edges_a, edges_b = np.roll(a, -1, 1) - a, np.roll(b, -1, 1) - b
    axes = [np.cross(edges_a[:, 0], edges_a[:, 1]), np.cross(edges_b[:, 0], edges_b[:, 1])]
    axes += [np.cross(edges_a[:, i], edges_b[:, j]) for i in range(3) for j in range(3)]
    apart = np.zeros(len(pairs), np.bool_)
    for c in axes:
        on_a, on_b = ((t * c[:, None]).sum(-1) for t in (a, b))
        apart |= (on_b.min(1) > on_a.max(1)) | (on_a.min(1) > on_b.max(1))
    return apart


@pytest.mark.parametrize("name", ["near-miss face", "near-miss edge"])
def test_double_precision_fails_at_24_bits(rng, name):
    stimulus = FAMILIES[name](rng, 20_000, 24, 0)
    exactly = ~bulk_facts(stimulus.pairs, 0).near
    wrong = (_float_separating(stimulus.pairs) != exactly).mean()
    assert 0.1 < wrong < 0.5
    # And not because the textbook's axes would not do: at 12 bits double precision is exact.
    small = FAMILIES[name](rng, 5000, 12, 0)
    proper = bulk_facts(small.pairs, 0)
    chosen = (proper.coplanar == 0) & (proper.rank_a == 2) & (proper.rank_b == 2)
    assert (_float_separating(small.pairs) != ~proper.near)[chosen].sum() == 0
