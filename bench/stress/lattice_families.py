"""Pairs on a grid of so many bits, as far from their decision as the knob says: up to the smallest steps.

On 24 bits float32 holds every coordinate exactly, so what a method gets wrong there is its arithmetic alone.
Distances from a plane go in steps of g / |c|, far below the grid's: see verif/core/stimulus/lattice.py.
All triangles are proper ones.
"""

from collections.abc import Callable
from functools import partial

import numpy as np

from triaxis.golden.bulk import bulk_facts
from triaxis.verif.core.stimulus.contact import Contact, placed
from triaxis.verif.core.stimulus.draws import around, chance, up_to
from triaxis.verif.core.stimulus.lattice import Step, plane_step, raised
from triaxis.verif.core.stimulus.near_miss import (
    edge_edge,
    edge_edge_level,
    edges_above,
    face_vertex,
    face_vertex_level,
    vertex_above,
)
from triaxis.verif.core.stimulus.stimulus import (
    Ints,
    Rng,
    Stimulus,
    collected,
    divided,
    joined,
    largest_extents,
    largest_span,
)
from triaxis.verif.core.stimulus.symmetry import random_cube_symmetries, random_orders, random_translations

# Bits of the grid of tilts and gaps.
WIDTH = 24
# The largest multiple of a step that is asked for: `raised` takes products with g below 2^61.
_LARGEST_MULTIPLE = 2.0**61

Construction = Callable[[Rng, int, int], Contact]


def _multiples(step: Step, distance: float) -> Ints:
    """Return how many steps make up a distance from the plane, in LSB: (N,), at least 1."""
    g = np.maximum(step.g, 1)
    length = np.sqrt((step.c.astype(np.float64) ** 2).sum(1))
    return np.rint(np.clip(distance * length / g, 1, _LARGEST_MULTIPLE)).astype(np.int64)


def _faces_at(distance: float, rng: Rng, count: int, width: int) -> Contact:
    """Return faces that a vertex misses, or pierces, by a distance: some share of ``count``."""
    a = up_to(rng, 1 << (width - 2), (count, 3, 3))
    u, v = a[:, 1] - a[:, 0], a[:, 2] - a[:, 0]
    step = plane_step(u, v)
    return vertex_above(rng, a, raised(u, v, step, _multiples(step, distance)))


def _edges_at(distance: float, rng: Rng, count: int, width: int) -> Contact:
    """Return edges that pass, or cross, each other at a distance: some share of ``count``."""
    e, f = np.moveaxis(around(rng, 1 << (width - 3), (count, 2, 3)), 1, 0)
    step = plane_step(e, f)
    return edges_above(rng, e, f, raised(e, f, step, _multiples(step, distance)))


def _full_size(construction: Construction, rng: Rng, count: int, width: int) -> Contact:
    """Return those contacts of a construction that extend over at least a quarter of the range."""
    contact = construction(rng, count, width)
    return contact[largest_extents(contact.pairs.reshape(-1, 6, 3)) > largest_span(width) // 4]


def _of_all(constructions: list[tuple[Construction, int]], rng: Rng, count: int, width: int) -> Ints:
    """Return contacts of all constructions by their shares, in any order, orientation and place."""

    def make(construction: Construction, asked: int) -> Stimulus:
        made = placed(rng, construction(rng, asked, width), width, 0)
        facts = bulk_facts(made.pairs, 0)
        return made[(facts.rank_a == 2) & (facts.rank_b == 2)]

    counts = divided(count, [share for _, share in constructions])
    parts = [collected(n, partial(make, made)) for (made, _), n in zip(constructions, counts, strict=True)]
    return joined(parts).pairs.astype(np.int64)


_TOUCHING: list[tuple[Construction, int]] = [
    (partial(_full_size, face_vertex_level), 1),
    (partial(_full_size, edge_edge_level), 1),
]
_ONE_STEP: list[tuple[Construction, int]] = [
    (partial(_full_size, face_vertex), 2),
    (partial(_full_size, edge_edge), 2),
]


def contacts_at(rng: Rng, count: int, width: int, gap: float) -> Ints:
    """Return pairs that miss or pass each other by ``gap`` LSB, half each: (N, 2, 3, 3); 0: that touch.

    Half of them are a vertex over a face, half two edges, of a quarter of the range in size.
    """
    if gap == 0:
        return _of_all(_TOUCHING, rng, count, width)
    return _of_all([(partial(_faces_at, gap), 1), (partial(_edges_at, gap), 1)], rng, count, width)


def near_misses(rng: Rng, count: int, width: int) -> Ints:
    """Return pairs that miss by the smallest step, touch, or pass by the smallest step: a third each.

    All extend over at least a quarter of the range: smaller ones are those of a smaller width.
    """
    return _of_all(_ONE_STEP + _TOUCHING, rng, count, width)


def _tilted(distance: float, rng: Rng, asked: int) -> Stimulus:
    """Return pairs of which B's vertices are at most ``distance`` LSB off A's plane, on either side."""
    u, v = np.moveaxis(around(rng, 1 << (WIDTH - 3), (asked, 2, 3)), 1, 0)
    step = plane_step(u, v)
    most = _multiples(step, distance)
    vertices, found = [], step.found
    for _ in range(3):
        share = 1 - rng.random(asked)
        multiple = np.maximum((share * most).astype(np.int64), 1) * np.where(chance(rng, asked, 2), 1, -1)
        place = raised(u, v, step, multiple)
        shift = up_to(rng, 1, (2, asked, 1))
        vertices.append(place.x - shift[0] * u - shift[1] * v)
        found = found & place.found
    pairs = np.stack([np.zeros_like(u), u, v, *vertices], 1).reshape(-1, 2, 3, 3)
    pairs = pairs[found & (largest_extents(pairs.reshape(-1, 6, 3)) <= largest_span(WIDTH))]
    return Stimulus(pairs.astype(np.int32), np.zeros(len(pairs), np.uint32))


def _coplanar(rng: Rng, asked: int) -> Stimulus:
    """Return triangles in one tilted plane, on the lattice of two vectors in it."""
    basis = around(rng, 1 << (WIDTH // 2 - 2), (asked, 1, 2, 3))
    pairs = around(rng, 1 << (WIDTH // 2 - 2), (asked, 2, 3, 2)) @ basis
    return Stimulus(pairs.astype(np.int32), np.zeros(asked, np.uint32))


def nearly_coplanar(rng: Rng, count: int, tilt: float) -> Ints:
    """Return triangles over each other whose planes are tilted by about ``tilt`` (radians); 0: coplanar."""
    size = float(1 << (WIDTH - 3))
    made = collected(count, partial(_tilted, tilt * size, rng) if tilt else partial(_coplanar, rng))
    anywhere = random_translations(rng, made.pairs, WIDTH)
    return random_cube_symmetries(rng, random_orders(rng, anywhere)).astype(np.int64)
