"""Pairs at the smallest step of the lattice, judged by Python's own integers and the bulk checker."""

from math import gcd
from typing import Any

import pytest

from triaxis.golden.axes import axis_vector
from triaxis.golden.exact import dot
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
