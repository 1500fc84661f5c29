"""Pairs that touch exactly, by construction, in every pair of features: vertex, edge, face.

Triangles are made of small integer coordinates (a, b, c) about a point that both features hold inside; A
lies in c <= 0, B in c >= 0. A random integer basis then takes them into space: it keeps what touches what.
"""

from collections.abc import Callable
from itertools import combinations_with_replacement

import numpy as np

from triaxis.verif.core.stimulus.contact import Contact
from triaxis.verif.core.stimulus.draws import around, chance, sizes, up_to
from triaxis.verif.core.stimulus.lattice import cross, side
from triaxis.verif.core.stimulus.stimulus import Ints, Mask, Rng, bounds, largest_span

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
