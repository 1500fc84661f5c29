"""Pairs that touch, penetrate or hold each other, by construction; and contacts at any margin.

Let A and B be on either side of a plane with normal c, from A to B, with a gap in the direction of c (0,
touching; or a step more or less). Moving B by m * sign(c), a corner of the cube [-m, m]^3, adds m * |c|1 to
that gap. So the excess at margin m is the gap at margin 0, and a pair that touches comes to a distance
of exactly m. Where a component of c is 0, B may go anywhere in -m..m.

Pairs that touch are made for every pair of features (vertex, edge, face), of small integer coordinates
(a, b, c) about a point that both features hold inside; A lies in c <= 0, B in c >= 0. A random integer basis
then takes them into space: it keeps what touches what.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations_with_replacement

import numpy as np
import numpy.typing as npt

from triaxis.verif.core.stimulus.lattice import cross, side
from triaxis.verif.core.stimulus.stimulus import (
    Ints,
    Mask,
    Pairs32,
    Rng,
    Stimulus,
    around,
    bounds,
    chance,
    chosen_rows,
    largest_extents,
    largest_span,
    sizes,
    up_to,
)
from triaxis.verif.core.stimulus.symmetry import random_cube_symmetries, random_orders, random_translations


@dataclass(frozen=True)
class Contact:
    """Pairs (N, 2, 3, 3) somewhere in space, and sign(c) (N, 3), -1, 0 or 1, from A to B."""

    pairs: Ints
    away: Ints

    def __getitem__(self, chosen: slice | Mask | npt.NDArray[np.integer]) -> "Contact":
        """Return the chosen contacts."""
        return Contact(chosen_rows(self.pairs, chosen), chosen_rows(self.away, chosen))


def _log_uniform(rng: Rng, limit: Ints) -> Ints:
    """Return integers in 1..limit at every scale, 0 where the limit is 0."""
    drawn = np.exp2(rng.random(len(limit)) * np.log2(limit + 1.0)).astype(np.int64)
    return np.minimum(drawn, limit)


def placed(rng: Rng, contact: Contact, width: int, largest_margin: int, least_margin: int = 0) -> Stimulus:
    """Return what fits the width, at margins in least..largest, in any order, orientation and place."""
    room = np.minimum(largest_span(width) - largest_extents(contact.pairs.reshape(-1, 6, 3)), largest_margin)
    fits = np.flatnonzero(room >= least_margin)
    contact, room = contact[fits], room[fits]
    count = len(room)
    margin = np.where(chance(rng, count, 8), room, _log_uniform(rng, room))
    if least_margin == 0:
        margin[chance(rng, count, 4)] = 0
    # Every second pair stays where it is instead: in the plane of A, if it was there.
    free = around(rng, (margin >> 1)[:, None] * chance(rng, count, 2)[:, None], (count, 3))
    shift = np.where(contact.away == 0, free, margin[:, None] * contact.away)
    pairs = contact.pairs
    pairs[:, 1] += shift[:, None]
    small = random_translations(rng, pairs, width).astype(np.int32)
    return Stimulus(random_cube_symmetries(rng, random_orders(rng, small)), margin.astype(np.uint32))


def one_step(rng: Rng, contact: Contact) -> Contact:
    """Return the contacts with B moved by one unit along one coordinate: a third nearer, a third farther."""
    count = len(contact.away)
    rows, coordinate = np.arange(count), up_to(rng, 2, (count,))
    step = around(rng, 1, (count,)) * contact.away[rows, coordinate]
    pairs = contact.pairs.copy()
    pairs[rows, 1, :, coordinate] += step[:, None]
    return Contact(pairs, contact.away)


# Triangles (N, 3, 3) within -size..size in c >= 0, given size (N,), at least LEAST: the feature holds 0.
Feature = Callable[[Rng, Ints], Ints]

LEAST = 8


def _above(rng: Rng, size: Ints) -> Ints:
    """Return points (N, 3) with c > 0."""
    point = around(rng, size[:, None], (len(size), 3))
    point[:, 2] = 1 + up_to(rng, size - 1, (len(size),))
    return point


def _in_plane(rng: Rng, size: Ints) -> Ints:
    """Return points (N, 3) with c = 0, never 0."""
    point = around(rng, size[:, None], (len(size), 3))
    point[:, 2] = 0
    point[(point[:, 0] | point[:, 1]) == 0, 0] = 1
    return point


def vertex(rng: Rng, size: Ints) -> Ints:
    """Return triangles with a vertex at 0; one in 8 each is a segment, or a point."""
    kind = up_to(rng, 7, (len(size), 1))
    second, third = _above(rng, size), _above(rng, size)
    second = np.where(kind == 0, 0, second)
    third = np.where(kind == 0, 0, np.where(kind == 1, second, third))
    return np.stack([np.zeros_like(second), second, third], 1)


def edge(rng: Rng, size: Ints) -> Ints:
    """Return triangles with 0 inside an edge; one in 8 is a segment."""
    direction = _in_plane(rng, size // 4)
    before, after = 1 + up_to(rng, 2, (2, len(size), 1))
    third = np.where(chance(rng, len(size), 8)[:, None], after * direction, _above(rng, size))
    return np.stack([-before * direction, after * direction, third], 1)


def face(rng: Rng, size: Ints) -> Ints:
    """Return triangles with 0 inside the face."""
    u, v = _in_plane(rng, size // 4), _in_plane(rng, size // 4)
    # Never parallel: where they are, v is u turned by a right angle.
    parallel = u[:, 0] * v[:, 1] == u[:, 1] * v[:, 0]
    v[parallel, 0], v[parallel, 1] = -u[parallel, 1], u[parallel, 0]
    weights = 1 + up_to(rng, 1, (3, len(size), 1))
    return np.stack([weights[0] * u, weights[0] * v, -(weights[1] * u + weights[2] * v)], 1)


FEATURES: dict[str, Feature] = {"vertex": vertex, "edge": edge, "face": face}
# Features of the two, in either order: placing swaps A and B.
FEATURE_PAIRS = tuple(combinations_with_replacement(FEATURES, 2))


def in_space(rng: Rng, small: Ints, room: int) -> tuple[Ints, Ints, Mask]:
    """Return images of pairs (N, 2, 3, 3) in a random integer basis, sign(n), and where the basis is one.

    n is normal to the image of the plane c = 0, on the side of c > 0.
    """
    low, high = bounds(small.reshape(-1, 18, 1))
    largest = np.maximum(np.maximum(-low, high)[:, 0], 1)
    size = np.maximum(room // (3 * largest), 1)
    size = np.where(chance(rng, len(size), 4), np.minimum(size, 3), size)
    basis = around(rng, size[:, None, None], (len(small), 3, 3))
    normal = cross(basis[:, 0], basis[:, 1])
    up = side(normal, basis[:, 2])
    return small @ basis[:, None], np.sign(normal) * up[:, None], up != 0


def coefficient_sizes(rng: Rng, count: int, width: int) -> Ints:
    """Return sizes (N,) for coordinates about the point of contact; the basis takes the rest of the range."""
    return sizes(rng, count, LEAST, max(LEAST, 1 << (2 * width // 3)))


def touching(feature_a: str, feature_b: str) -> Callable[[Rng, int, int], Contact]:
    """Return the construction of pairs that touch at a point inside these features, and in no larger ones
    except where the features overlap: edge-face in a segment, face-face in an area.
    """

    def make(rng: Rng, count: int, width: int) -> Contact:
        size = coefficient_sizes(rng, count, width)
        a, b = FEATURES[feature_a](rng, size), FEATURES[feature_b](rng, size)
        small = np.stack([-a, b], 1)
        pairs, away, proper = in_space(rng, small, largest_span(width) // 2)
        if (feature_a, feature_b) == ("edge", "edge"):
            along, across = small[:, 0, 1] - small[:, 0, 0], small[:, 1, 1] - small[:, 1, 0]
            proper &= along[:, 0] * across[:, 1] != along[:, 1] * across[:, 0]
        return Contact(pairs, away)[proper]

    return make


def sharing_edge(rng: Rng, count: int, width: int) -> Contact:
    """Return pairs that touch along edges: the same edge, or two on one line that overlap."""
    size = coefficient_sizes(rng, count, width)
    a, b = edge(rng, size), edge(rng, size)
    same = chance(rng, count, 2)[:, None]
    line = a[:, 1] - a[:, 0]
    # B's edge on A's line: A's own, or from inside A's edge to beyond its end.
    b[:, 0] = np.where(same, -a[:, 0], 0)
    b[:, 1] = np.where(same, -a[:, 1], -line)
    b[:, 2] = _above(rng, size)
    pairs, away, proper = in_space(rng, np.stack([-a, b], 1), largest_span(width) // 2)
    return Contact(pairs, away)[proper]


def _inside(rng: Rng, triangle: Ints) -> Ints:
    """Return points (N, 3), 4 times a point inside each triangle (N, 3, 3)."""
    more = np.eye(3, dtype=np.int64)[up_to(rng, 2, (len(triangle),))]
    return ((1 + more)[..., None] * triangle).sum(1)


def penetrating_pairs(rng: Rng, count: int, width: int) -> Pairs32:
    """Return A with a vertex above the plane of B, and an edge or two from there through B's face."""
    # Nothing below is larger than 5 * size, or 7 * size from 16 on: 8 * 5 * 3 fits 8 bits about 0.
    size = np.maximum(coefficient_sizes(rng, count, width) // 8, 8)
    b = face(rng, size // 2)
    apex = around(rng, size[:, None], (count, 3))
    apex[:, 2] = 1 + up_to(rng, size - 1, (count,))
    points = np.stack([_inside(rng, b), _inside(rng, b)], 1)
    # From the apex through each point, and as far again, or twice as far.
    times = 1 + up_to(rng, np.minimum(size // 16, 1)[:, None, None], (count, 2, 1))
    beyond = points + (points - apex[:, None]) * times
    # Or the second edge goes anywhere: it mostly misses B, which then passes through A in turn.
    anywhere = around(rng, 2 * size[:, None], (count, 3))
    beyond[:, 1] = np.where(chance(rng, count, 2)[:, None], anywhere, beyond[:, 1])
    a = np.concatenate([apex[:, None], beyond], 1)
    pairs, _, _ = in_space(rng, np.stack([a, 4 * b], 1), largest_span(width) // 2)
    return random_orders(rng, random_translations(rng, pairs, width).astype(np.int32))


def _weights(rng: Rng, total: Ints, least: Ints) -> Ints:
    """Return barycentric weights (N, 3 points, 3 vertices), each at least ``least``, with that total."""
    count = len(total)
    rest = (total - 3 * least)[:, None]
    cuts = np.sort(up_to(rng, rest[..., None], (count, 3, 2)), -1)
    first, second = cuts[..., 0], cuts[..., 1]
    return np.stack([first, second - first, rest - second], -1) + least[:, None, None]


def contained_pairs(rng: Rng, count: int, width: int) -> Pairs32:
    """Return a triangle, a segment or a point that is a part of another triangle.

    In turn: strictly inside; touching edges from inside; with vertices at vertices; identical. One in 4 is
    moved off by one step.
    """
    most = largest_span(width)
    total = sizes(rng, count, 3, max(3, most // 16))
    outer = around(rng, ((most - 2) // 2 // total).reshape(-1, 1, 1), (count, 3, 3))
    kind = np.arange(count) % 4
    weights = _weights(rng, total, np.where(kind == 0, 1, 0))
    rows, place = np.arange(count), up_to(rng, 2, (3, count))
    # On an edge: one vertex of the outer triangle has no part in that point; at a vertex: all of it.
    weights = np.where((kind == 1)[:, None, None], _without(weights, place.T), weights)
    corners = np.eye(3, dtype=np.int64)[place[0]] * total[:, None]
    weights[:, 0] = np.where((kind == 2)[:, None], corners, weights[:, 0])
    same = np.eye(3, dtype=np.int64) * total[:, None, None]
    weights = np.where((kind == 3)[:, None, None], same, weights)
    inner = weights @ outer
    # Lower ranks: vertices that coincide.
    inner[:, 2] = np.where((chance(rng, count, 6) & (kind < 3))[:, None], inner[:, 1], inner[:, 2])
    inner[:, 1:] = np.where((chance(rng, count, 12) & (kind < 3))[:, None, None], inner[:, :1], inner[:, 1:])
    off = chance(rng, count, 4)
    inner[rows, :, place[1]] += np.where(off, around(rng, 1, (count,)), 0)[:, None]
    pairs = np.stack([inner, outer * total[:, None, None]], 1)
    return random_orders(rng, random_translations(rng, pairs, width).astype(np.int32))


def _without(weights: Ints, vertex: Ints) -> Ints:
    """Return the weights with those of one vertex (N, 3) of each point given to the next vertex."""
    chosen = vertex[..., None]
    given = np.take_along_axis(weights, chosen, -1)
    moved = weights.copy()
    np.put_along_axis(moved, chosen, 0, -1)
    following = (chosen + 1) % 3
    np.put_along_axis(moved, following, np.take_along_axis(weights, following, -1) + given, -1)
    return moved
