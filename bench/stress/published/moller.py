"""T. Moller, "A fast triangle-triangle intersection test", Journal of Graphics Tools 2(2), 1997.

Each triangle against the other's plane, as an equation N.x + d = 0; then the intervals in which the line
common to both planes meets the two triangles, seen along the coordinate axis closest to that line.
"""

import numpy as np

from triaxis.bench.stress.published.lone_vertex import all_on_one_side, lone_vertex
from triaxis.bench.stress.published.planar import overlap_by_edges, seen_flat
from triaxis.bench.stress.published.vectors import (
    Mask,
    Numbers,
    Triangles,
    component,
    cross,
    dot,
    largest_component,
    normal,
    signs,
    vertex,
)


def _interval(places: Numbers, heights: Numbers) -> tuple[Numbers, Numbers]:
    """Return where the two edges from the lone vertex cross the plane, in order: (N,) each.

    places, heights: of the vertices (3, N), along the line and above the plane.
    """
    lone, side = lone_vertex(signs(heights))
    place, height = vertex(places, lone), vertex(heights, lone)
    ends = []
    for other in (lone + 1, lone + 2):
        drop = np.where(side == 0, 1, height - vertex(heights, other))
        ends.append(place + (vertex(places, other) - place) * height / drop)
    return np.minimum(*ends), np.maximum(*ends)


def moller(a: Triangles, b: Triangles) -> Mask:
    """Return which pairs the test takes for touching or overlapping: (N,)."""
    normal_a, normal_b = normal(a), normal(b)
    shift_a, shift_b = -dot(normal_a, a[0]), -dot(normal_b, b[0])
    heights_a = np.stack([dot(normal_b, point) + shift_b for point in a])
    heights_b = np.stack([dot(normal_a, point) + shift_a for point in b])
    signs_a, signs_b = signs(heights_a), signs(heights_b)
    apart = all_on_one_side(signs_a) | all_on_one_side(signs_b)
    coplanar = ~signs_a.any(0) | ~signs_b.any(0)
    along = largest_component(cross(normal_a, normal_b))
    low_a, high_a = _interval(component(a, along), heights_a)
    low_b, high_b = _interval(component(b, along), heights_b)
    near = ~apart & (low_a <= high_b) & (low_b <= high_a)
    flat = np.flatnonzero(coplanar & ~apart)
    if len(flat):
        seen = [seen_flat(triangle[..., flat], normal_a[:, flat]) for triangle in (a, b)]
        near[flat] = overlap_by_edges(*seen)
    return near
