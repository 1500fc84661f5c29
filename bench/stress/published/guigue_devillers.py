"""P. Guigue and O. Devillers, "Fast and robust triangle-triangle overlap test using orientation predicates",
Journal of Graphics Tools 8(1), 2003.

Everything is the sign of a determinant of differences. Let p be the vertex of each triangle that is alone on
the upper side of the other's plane. On the line common to both planes, A reaches from edge p q to edge p r,
and so does B; which ends come first is the orientation of two edges, one of each.
"""

import numpy as np
import numpy.typing as npt

from triaxis.bench.stress.published.lone_vertex import all_on_one_side, lone_vertex
from triaxis.bench.stress.published.planar import overlap_by_turns, seen_flat
from triaxis.bench.stress.published.vectors import (
    Mask,
    Numbers,
    Triangles,
    Vectors,
    cross,
    dot,
    normal,
    signs,
    vertex,
)


def _heights(triangle: Triangles, plane: Triangles) -> Numbers:
    """Return the orientation of each vertex with respect to the plane of another triangle: (3, N)."""
    up = cross(plane[0] - plane[2], plane[1] - plane[2])
    return np.stack([dot(point - plane[2], up) for point in triangle])


def _orientation(a: Vectors, b: Vectors, c: Vectors, d: Vectors) -> Numbers:
    """Return det(a - d, b - d, c - d): (N,)."""
    return dot(a - d, cross(b - d, c - d))


def _from_lone(
    triangle: Triangles, lone: npt.NDArray[np.intp], turned: Mask
) -> tuple[Vectors, Vectors, Vectors]:
    """Return the vertices from the lone one on, the other way round where ``turned``: (3, N) each."""
    step = np.where(turned, 2, 1)
    return vertex(triangle, lone), vertex(triangle, lone + step), vertex(triangle, lone + 2 * step)


def guigue_devillers(a: Triangles, b: Triangles) -> Mask:
    """Return which pairs the test takes for touching or overlapping: (N,)."""
    signs_a, signs_b = signs(_heights(a, b)), signs(_heights(b, a))
    apart = all_on_one_side(signs_a) | all_on_one_side(signs_b)
    coplanar = ~signs_a.any(0) | ~signs_b.any(0)
    (lone_a, side_a), (lone_b, side_b) = lone_vertex(signs_a), lone_vertex(signs_b)
    # Exchanging q and r of one turns its plane over, and so brings p of the other to the upper side.
    p1, q1, r1 = _from_lone(a, lone_a, side_b < 0)
    p2, q2, r2 = _from_lone(b, lone_b, side_a < 0)
    first_before, last_before = _orientation(q2, p2, p1, q1) > 0, _orientation(r2, p2, r1, p1) > 0
    near = ~(apart | first_before | last_before)
    flat = np.flatnonzero(coplanar & ~apart)
    if len(flat):
        along = normal(a[..., flat])
        near[flat] = overlap_by_turns(seen_flat(a[..., flat], along), seen_flat(b[..., flat], along))
    return near
