"""The separating-axis test of S. Gottschalk, M. C. Lin and D. Manocha, "OBBTree", 1996, for two triangles.

Two normals and nine products of edges decide pairs in general position, and the six normals of the edges
within their planes decide coplanar ones. All seventeen are always asked, so there is no branch. Coordinates
are taken relative to a vertex of A first, which costs nothing and rounds less.
"""

from collections.abc import Iterator

import numpy as np

from triaxis.bench.stress.published.vectors import Mask, Triangles, Vectors, cross, dot, normal


def _axes(edges_a: Triangles, edges_b: Triangles, normal_a: Vectors, normal_b: Vectors) -> Iterator[Vectors]:
    yield normal_a
    yield normal_b
    for edge_a in edges_a:
        for edge_b in edges_b:
            yield cross(edge_a, edge_b)
    for edge in edges_a:
        yield cross(normal_a, edge)
    for edge in edges_b:
        yield cross(normal_b, edge)


def separating_axes(a: Triangles, b: Triangles) -> Mask:
    """Return which pairs no axis separates: (N,)."""
    p, q, r, s, t = a[1] - a[0], a[2] - a[0], *(b - a[0])
    edges_a = np.stack([p, q - p, a[0] - a[2]])
    edges_b = np.stack([b[1] - b[0], b[2] - b[1], b[0] - b[2]])
    separated = np.zeros(a.shape[2], np.bool_)
    for axis in _axes(edges_a, edges_b, normal(a), normal(b)):
        on_p, on_q = dot(axis, p), dot(axis, q)
        on_r, on_s, on_t = dot(axis, r), dot(axis, s), dot(axis, t)
        # The first vertex of A is at 0.
        high_a, low_a = np.maximum(np.maximum(on_p, on_q), 0), np.minimum(np.minimum(on_p, on_q), 0)
        high_b = np.maximum(np.maximum(on_r, on_s), on_t)
        low_b = np.minimum(np.minimum(on_r, on_s), on_t)
        separated |= (low_b > high_a) | (low_a > high_b)
    return ~separated
