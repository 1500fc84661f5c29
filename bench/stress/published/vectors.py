"""Vectors in bulk, of any numeric type: coordinates first, (3, N), so that each is contiguous."""

from typing import Any

import numpy as np
import numpy.typing as npt

# Coordinate, pair.
Vectors = npt.NDArray[Any]
# Vertex, coordinate, pair: (3, 3, N).
Triangles = npt.NDArray[Any]
# One number of each pair: (N,).
Numbers = npt.NDArray[Any]
Mask = npt.NDArray[np.bool_]


def cross(u: Vectors, v: Vectors) -> Vectors:
    """Return u x v: (3, N)."""
    w = np.empty(u.shape, u.dtype)
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        w[k] = u[i] * v[j] - u[j] * v[i]
    return w


def dot(u: Vectors, v: Vectors) -> Numbers:
    """Return the inner products: (N,)."""
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


def normal(triangle: Triangles) -> Vectors:
    """Return (V2 - V1) x (V3 - V1): (3, N)."""
    return cross(triangle[1] - triangle[0], triangle[2] - triangle[0])


def signs(values: Numbers) -> npt.NDArray[np.int8]:
    """Return -1, 0 or 1 for each number."""
    return (values > 0).astype(np.int8) - (values < 0).astype(np.int8)


def largest_component(vectors: Vectors) -> npt.NDArray[np.intp]:
    """Return the number of each vector's component of the largest size: (N,)."""
    x, y, z = np.abs(vectors)
    return np.where((x >= y) & (x >= z), 0, np.where(y >= z, 1, 2))


def component(points: npt.NDArray[Any], number: npt.NDArray[np.intp]) -> npt.NDArray[Any]:
    """Return coordinate ``number`` (N,) of points (.., 3, N): (.., N)."""
    return np.where(
        number == 0, points[..., 0, :], np.where(number == 1, points[..., 1, :], points[..., 2, :])
    )


def vertex(triangle: npt.NDArray[Any], number: npt.NDArray[np.intp]) -> npt.NDArray[Any]:
    """Return vertex ``number`` (N,), cyclically, of what has three along its first dimension: (.., N)."""
    place = number % 3
    return np.where(place == 0, triangle[0], np.where(place == 1, triangle[1], triangle[2]))
