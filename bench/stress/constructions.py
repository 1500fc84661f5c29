"""Pairs as far from their decision as the knob of a family says: up to the smallest steps there are.

On a grid of 24 bits float32 holds every coordinate exactly, so what a method gets wrong there is its
arithmetic alone. Distances from a plane go in steps of g / |c|, far below the grid's: see
verif/core/stimulus/lattice.py. Triangles, segments and points on a small grid are hard for a method's logic
instead: differences, products and determinants are exact in float32 too.

Real coordinates of 53 bits, as float64 has them, are too fine for any grid of 32 bits: whole numbers below
2^53 in size, in a unit of their own, so float64 holds them exactly, and exact verdicts need no fractions.
float32 holds them rounded, as a program in float32 would have them.
"""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from triaxis.golden.bulk import bulk_facts
from triaxis.verif.core.stimulus.contact import Contact, placed
from triaxis.verif.core.stimulus.flat import of_rank
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
    around,
    chance,
    collected,
    divided,
    joined,
    largest_extents,
    largest_span,
    up_to,
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


def contacts(construction: Construction, rng: Rng, count: int, width: int) -> Stimulus:
    """Return contacts of proper triangles, in any orientation and place."""

    def make(asked: int) -> Stimulus:
        made = placed(rng, construction(rng, asked, width), width, 0)
        facts = bulk_facts(made.pairs, 0)
        return made[(facts.rank_a == 2) & (facts.rank_b == 2)]

    return collected(count, make)


def _of_all(constructions: list[tuple[Construction, int]], rng: Rng, count: int, width: int) -> Ints:
    """Return contacts of all constructions by their shares."""
    counts = divided(count, [share for _, share in constructions])
    parts = [contacts(made, rng, n, width) for (made, _), n in zip(constructions, counts, strict=True)]
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


def gaps(rng: Rng, count: int, gap: float) -> Ints:
    """Return pairs that miss or pass each other by ``gap`` times a quarter of the range."""
    return contacts_at(rng, count, WIDTH, gap * 2.0 ** (WIDTH - 2))


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


# Sizes of triangles, and so that pairs that meet stay within -15..15.
_SMALL = 5
# Pairs drawn at a time: near and clear ones are chosen from them, half each.
_DRAWN = 6


def _of_ranks(rng: Rng, count: int, *ranks: int) -> Ints:
    """Return pairs of these ranks whose vertices meet or nearly meet, in half of the pairs."""
    # Segments are made of twelfths of their size.
    sizes = (12 if rank == 1 else _SMALL for rank in ranks)
    drawn = zip(ranks, sizes, strict=True)
    a, b = (of_rank(rng, np.full(count, rank), np.full(count, size)) for rank, size in drawn)
    rows, vertex = np.arange(count), up_to(rng, 2, (2, count))
    meet = a[rows, vertex[0]] - b[rows, vertex[1]]
    b += np.where(chance(rng, count, 2)[:, None], meet, around(rng, 1, (count, 3)))[:, None]
    return np.stack([a, b], 1)


def degenerate(rng: Rng, count: int, rank_a: int, rank_b: int) -> Ints:
    """Return pairs (N, 2, 3, 3) of these ranks (0 point, 1 segment, 2 triangle), half of them near."""

    def make(near: bool, asked: int) -> Stimulus:
        pairs = _of_ranks(rng, _DRAWN * asked, rank_a, rank_b)
        facts = bulk_facts(pairs, 0)
        # Clear pairs that are close: one step decides, as where they touch.
        chosen = (facts.rank_a == rank_a) & (facts.rank_b == rank_b) & (facts.near == near)
        chosen &= bulk_facts(pairs, 1).near
        kept = pairs[chosen][:asked].astype(np.int32)
        return Stimulus(kept, np.zeros(len(kept), np.uint32))

    half = count // 2
    parts = [collected(half, lambda n: make(True, n)), collected(count - half, lambda n: make(False, n))]
    return np.concatenate([part.pairs for part in parts]).astype(np.int64)


Reals = npt.NDArray[np.float64]

# The size of the larger triangle, in units: sums of a few such stay below 2^53.
_SIZE = 2.0**50

# Pairs far from the origin: bits of their own size, and how far they are from their decision.
_FAR_BITS = 16
_FAR_GAP = 2.0**-18
_FAR_DIRECTION = np.array([1.0, -0.7, 0.4])


def _unit(vectors: Reals) -> Reals:
    return vectors / np.sqrt((vectors**2).sum(-1, keepdims=True))


def _frames(rng: Rng, count: int) -> tuple[Reals, Reals, Reals]:
    """Return three vectors of length 1, at right angles: (N, 3) each, in any direction."""
    first = _unit(rng.normal(size=(count, 3)))
    third = _unit(np.cross(first, rng.normal(size=(count, 3))))
    return first, np.cross(third, first), third


def _rounded(rng: Rng, *vertices: Reals) -> Ints:
    """Return pairs of these six vertices (N, 3) each, in random orders: (N, 2, 3, 3)."""
    pairs = np.rint(np.stack(vertices, 1)).astype(np.int64).reshape(-1, 2, 3, 3)
    return random_orders(rng, pairs)


def _between(rng: Rng, low: float, high: float, count: int) -> Reals:
    """Return numbers (N, 1)."""
    return rng.uniform(low, high, (count, 1))


def _sides(rng: Rng, count: int) -> npt.NDArray[Any]:
    """Return -1 or 1: (N, 1)."""
    return rng.choice([-1.0, 1.0], (count, 1))


def slivers(rng: Rng, count: int, aspect: float) -> Ints:
    """Return slivers A, and B whose edge passes A's long edge at half of A's width there, on either side.

    ``aspect``: width over length; 0: A is a segment, and B's edge passes it by 4 units.
    """
    along, across, up = _frames(rng, count)
    apex, place = _between(rng, 0.3, 0.7, count), _between(rng, 0.3, 0.7, count)
    width = _SIZE * aspect
    # Even ends, so that a place in the middle is exactly between them.
    start, end = 2 * np.rint(-_SIZE / 4 * along), 2 * np.rint(_SIZE / 4 * along)
    third = start + apex * (end - start) + width * across if aspect else (start + end) / 2
    here = np.minimum(place / apex, (1 - place) / (1 - apex)) * width if aspect else 8.0
    passing = start + place * (end - start) + _sides(rng, count) * here / 2 * across
    # B's edge goes through the plane of A; the rest of B is on the outer side of A's long edge.
    lean = _unit(up + _between(rng, -0.6, 0.6, count) * along + _between(rng, -0.6, 0.6, count) * across)
    away = _unit(
        _between(rng, -0.6, 0.6, count) * up + _between(rng, -0.6, 0.6, count) * along - 1.2 * across
    )
    above, below = _between(rng, 0.1, 0.5, count), _between(rng, 0.1, 0.5, count)
    middle = passing + _between(rng, 0.1, 0.5, count) * _SIZE * away
    return _rounded(
        rng, start, end, third, passing + above * _SIZE * lean, passing - below * _SIZE * lean, middle
    )


def of_unlike_size(rng: Rng, count: int, ratio: float) -> Ints:
    """Return a triangle and one ``ratio`` its size that pierces or misses its face by a quarter of that."""
    along, across, up = _frames(rng, count)
    corners = [
        _SIZE * (np.cos(angle) * along + np.sin(angle) * across)
        for angle in (_between(rng, turn - 0.5, turn + 0.5, count) for turn in (0.0, 2.1, 4.2))
    ]
    weights = rng.dirichlet([4.0, 4.0, 4.0], count)
    foot = sum(weights[:, k : k + 1] * corner for k, corner in enumerate(corners))
    size = _SIZE * ratio
    lowest = foot + _sides(rng, count) * size / 4 * up
    others = [
        foot
        + size * (_between(rng, 0.5, 1.0, count) * up)
        + size * (_between(rng, -1.0, 1.0, count) * along + _between(rng, -1.0, 1.0, count) * across)
        for _ in range(2)
    ]
    return _rounded(rng, *corners, lowest, *others)


def far_away(rng: Rng, count: int, distance: float) -> Ints:
    """Return pairs that miss or pass by 2^-18 of their range, ``distance`` times it from the origin."""
    span = float(1 << _FAR_BITS)
    offset = np.rint(distance * span * _FAR_DIRECTION).astype(np.int64)
    return contacts_at(rng, count, _FAR_BITS, _FAR_GAP * span) + offset
