"""The widths of the package triaxis_pkg, proved by enumerating the corners of the coordinate box.

Every quantity is affine in each single coordinate, so over a box it is largest at a corner. With
coordinates 0 and 1 in place of the limits it scales with powers of L = 2^W - 1.
"""

import re
from itertools import product

import numpy as np
import pytest

from triaxis.sim.paths import DUT

CORNERS = np.array(list(product((0, 1), repeat=18)), np.int8).reshape(-1, 6, 3)


def cross(x, y):
    return np.stack(
        [
            x[..., 1] * y[..., 2] - x[..., 2] * y[..., 1],
            x[..., 2] * y[..., 0] - x[..., 0] * y[..., 2],
            x[..., 0] * y[..., 1] - x[..., 1] * y[..., 0],
        ],
        -1,
    )


def dot(x, y):
    return (x * y).sum(-1, dtype=x.dtype)


def edge(v, triangle, i):
    return v[:, 3 * triangle + (i + 1) % 3] - v[:, 3 * triangle + i]


def cross_products(v):
    """Return the cross products from a common vertex: (N, n)."""
    p, q, *r = (v[:, i] - v[:, 0] for i in range(1, 6))
    common = [cross(p, q), *(cross(r[j], r[(j + 1) % 3]) for j in range(3))]
    common += [c for j in range(3) for c in (cross(p, r[j]), cross(r[j], q))]
    normal_b = cross(edge(v, 1, 0), edge(v, 1, 1))
    return np.concatenate([*common, normal_b], -1)


def planar_orientations(v):
    """Return 2D orientations of a vertex against an edge of the other triangle: (N, n)."""
    return np.concatenate(
        [
            cross(edge(v, t, i), v[:, 3 * (1 - t) + j] - v[:, 3 * t + i])
            for t in (0, 1)
            for i in range(3)
            for j in range(3)
        ],
        -1,
    )


def triple_products(v):
    """Return the ten triple products and the nine orientations of an edge with an edge: (N, n)."""
    p, q, *r = (v[:, i] - v[:, 0] for i in range(1, 6))
    f = [cross(r[j], r[(j + 1) % 3]) for j in range(3)]
    ten = [dot(cross(p, q), x) for x in r] + [dot(x, y) for x in (p, q) for y in f] + [dot(r[0], f[1])]
    edges = [
        dot(v[:, 3 + j] - v[:, i], cross(edge(v, 0, i), edge(v, 1, j))) for i in range(3) for j in range(3)
    ]
    return np.stack(ten + edges, -1)


def projection_differences(v):
    """Return all differences of a vertex of B and one of A on the eleven 3D axes, and in A or B."""
    axes = [cross(edge(v, 0, 0), edge(v, 0, 1)), cross(edge(v, 1, 0), edge(v, 1, 1))]
    axes += [cross(edge(v, 0, i), edge(v, 1, j)) for i in range(3) for j in range(3)]
    pairs = [(x, y) for x in range(6) for y in range(x)]
    return np.stack([dot(axis, v[:, x] - v[:, y]) for axis in axes for x, y in pairs], -1)


def edge_edge(v):
    """Return the edge x edge axes: (N, 27)."""
    return np.concatenate([cross(edge(v, 0, i), edge(v, 1, j)) for i in range(3) for j in range(3)], -1)


@pytest.mark.parametrize(
    ("quantity", "bound"),
    [
        (cross_products, 1),
        (planar_orientations, 1),
        (edge_edge, 2),
        (triple_products, 2),
        (projection_differences, 4),
    ],
)
def test_bound_at_the_corners(quantity, bound):
    largest = max(int(np.abs(quantity(part)).max()) for part in np.array_split(CORNERS, 16))
    assert largest == bound


def test_sum_of_absolutes_at_the_corners():
    axes = edge_edge(CORNERS).reshape(len(CORNERS), 9, 3)
    assert int(np.abs(axes).sum(-1).max()) == 4
    normals = cross(edge(CORNERS, 0, 0), edge(CORNERS, 0, 1))
    assert int(np.abs(normals).sum(-1).max()) <= 4


@pytest.mark.parametrize(
    "quantity", [cross_products, planar_orientations, edge_edge, triple_products, projection_differences]
)
def test_affine_in_each_coordinate(rng, quantity):
    v = rng.integers(-9, 10, (40, 6, 3))
    for vertex, coordinate in product(range(6), range(3)):
        step = np.zeros((6, 3), np.int64)
        step[vertex, coordinate] = 1
        assert (quantity(v + step) + quantity(v - step) == 2 * quantity(v)).all()


def rtl_width(name, width):
    """Return a width function of the RTL package, evaluated."""
    text = (DUT / "core" / "triaxis_pkg.sv").read_text()
    match = re.search(rf"function automatic int unsigned {name}\(int unsigned w\);\s*return (.*?);", text)
    assert match, name
    return eval(match[1], {}, {"w": width})


@pytest.mark.parametrize("width", range(8, 33))
def test_the_rtl_widths_hold_the_bounds(width):
    big = (1 << width) - 1

    def fits(value, bits):
        return value < 1 << (bits - 1)

    assert fits(big, rtl_width("diff_width", width))
    assert fits(big**2, rtl_width("cross_width", width))
    assert fits(2 * big**2, rtl_width("axis_width", width))
    assert fits(2 * big**3, rtl_width("det_width", width))
    assert fits(4 * big**3, rtl_width("span_width", width))
    # With margins: 3 L^3 of A's own extent, or 4 L^3 of a point, against a threshold of 4 L^3.
    assert fits(7 * big**3, rtl_width("span_width", width) + 1)
    assert fits(3 * big**2, rtl_width("cross_width", width) + 2)
    # The sums of absolutes in triaxis_threshold.
    assert 4 * big**2 < 1 << rtl_width("axis_width", width)
    assert 2 * big < 1 << rtl_width("diff_width", width)
    # No bit is wasted on the numbers that cost multipliers.
    assert not fits(big, rtl_width("diff_width", width) - 1)
    assert not fits(big**2, rtl_width("cross_width", width) - 1)
    assert not fits(2 * big**3, rtl_width("det_width", width) - 1)
