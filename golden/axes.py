"""The 32 axes by number, from their definition (docs/theory.md, section 2), and which separate a pair.

0..2 box x, y, z; 3 normal of A; 4 normal of B; 5+3i+j edge i of A x edge j of B; 14+3i+k edge i of
A x coordinate k; 23+3j+k edge j of B x coordinate k. Edge i runs from vertex i to the next.
"""

from functools import reduce
from typing import Any

import numpy as np
import numpy.typing as npt

from triaxis.golden.exact import Scalar, Triangle, difference, dot
from triaxis.golden.pairs import NO_AXIS, Pairs

NUM_AXES = 32
BOX_AXES = 3

# Below this width every number in `separates` fits 64 bits: axes are at most 2 L^2 in a component,
# a projection at most 3 * 2 L^2 * L/2 = 3 L^3, a gap twice that, and margin * |axis|1 at most
# L * 4 L^2; 6 L^3 < 2^63 holds for L < 2^20.
_INT64_WIDTH = 20


def axis_name(number: int) -> str:
    """Return a short name for people: ``box x``, ``normal A``, ``A edge 0 x B edge 2``, .."""
    if number < 3:
        return f"box {'xyz'[number]}"
    if number < 5:
        return f"normal {'AB'[number - 3]}"
    if number < 14:
        return f"A edge {(number - 5) // 3} x B edge {(number - 5) % 3}"
    triangle, index = divmod(number - 14, 9)
    return f"{'AB'[triangle]} edge {index // 3} x {'xyz'[index % 3]}"


def _cross(x: list[Scalar], y: list[Scalar]) -> list[Scalar]:
    return [
        x[1] * y[2] - x[2] * y[1],
        x[2] * y[0] - x[0] * y[2],
        x[0] * y[1] - x[1] * y[0],
    ]


def axis_vector(number: int, a: Triangle, b: Triangle) -> list[Scalar]:
    """Return axis ``number`` (0..31) of the pair, exactly."""
    edges_a = [difference(a[(i + 1) % 3], a[i]) for i in range(3)]
    edges_b = [difference(b[(j + 1) % 3], b[j]) for j in range(3)]
    unit: list[list[Scalar]] = [[int(i == k) for i in range(3)] for k in range(3)]
    if number < 3:
        return unit[number]
    if number < 5:
        edges = edges_a if number == 3 else edges_b
        return _cross(edges[0], edges[1])
    if number < 14:
        i, j = divmod(number - 5, 3)
        return _cross(edges_a[i], edges_b[j])
    triangle, index = divmod(number - 14, 9)
    edges = edges_b if triangle else edges_a
    return _cross(edges[index // 3], unit[index % 3])


def fits_int64(pairs: npt.NDArray[np.integer[Any]], margins: npt.NDArray[np.integer[Any]]) -> bool:
    """Return whether 64-bit integers provably hold every number of an axis test on these pairs."""
    limit = 1 << (_INT64_WIDTH - 1)
    return len(pairs) == 0 or bool(
        -limit <= pairs.min() and pairs.max() < limit and margins.max() < 2 * limit
    )


def separates(
    number: int, pairs: npt.NDArray[np.integer[Any]], margins: npt.NDArray[np.integer[Any]]
) -> npt.NDArray[np.bool_]:
    """Return which of pairs (N, 2, 3, 3) axis ``number`` separates by more than their margins (N,).

    Exact for any coordinates: 64-bit integers where they provably suffice, Python's own otherwise.
    """
    kind = np.int64 if fits_int64(pairs, margins) else object
    # Triangle, vertex, coordinate, pair: the definitions for one pair then serve all of them.
    vertices: Any = np.ascontiguousarray(pairs.reshape(-1, 18).T, kind).reshape(2, 3, 3, -1)
    axis: Any = axis_vector(number, vertices[0], vertices[1])
    projections: Any = [[dot(axis, vertex) for vertex in triangle] for triangle in vertices]
    on_a, on_b = projections
    gap = np.maximum(
        reduce(np.minimum, on_b) - reduce(np.maximum, on_a),
        reduce(np.minimum, on_a) - reduce(np.maximum, on_b),
    )
    return (gap > margins.astype(kind) * sum(np.abs(component) for component in axis)).astype(np.bool_)


def separating(pairs: Pairs, margins: npt.NDArray[np.int64]) -> npt.NDArray[np.bool_]:
    """Return, for pairs (N, 2, 3, 3) and margins (N,), which of the 32 axes separate: (N, 32)."""
    return np.stack([separates(number, pairs, margins) for number in range(NUM_AXES)], 1)


def first_separating(pairs: Pairs, margins: npt.NDArray[np.int64]) -> npt.NDArray[np.int16]:
    """Return the lowest-numbered separating axis of each pair, NO_AXIS where none separates."""
    found = separating(pairs, margins)
    return np.where(found.any(1), found.argmax(1), NO_AXIS).astype(np.int16)
