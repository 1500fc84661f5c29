"""The 32 axes by number, from their definition (docs/theory.md, section 2), and claims made with them.

0..2 box x, y, z; 3 normal of A; 4 normal of B; 5+3i+j edge i of A x edge j of B; 14+3i+k edge i of
A x coordinate k; 23+3j+k edge j of B x coordinate k. Edge i runs from vertex i to the next.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from triaxis.golden.exact import Scalar, Triangle, difference
from triaxis.golden.pairs import NO_AXIS, Pairs

NUM_AXES = 32
BOX_AXES = 3

# Below this width every number in `separating` fits 64 bits: axes are at most 2 L^2 in a component,
# a projection at most 3 * 2 L^2 * L/2 = 3 L^3, a gap twice that, and margin * |axis|1 at most
# L * 4 L^2; 6 L^3 < 2^63 holds for L < 2^20.
_INT64_WIDTH = 20
_BLOCK = 1 << 14


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


def _cross_arrays(x: npt.NDArray[Any], y: npt.NDArray[Any]) -> npt.NDArray[Any]:
    return np.stack(
        [
            x[..., 1] * y[..., 2] - x[..., 2] * y[..., 1],
            x[..., 2] * y[..., 0] - x[..., 0] * y[..., 2],
            x[..., 0] * y[..., 1] - x[..., 1] * y[..., 0],
        ],
        -1,
    )


def _separating_block(pairs: npt.NDArray[Any], margins: npt.NDArray[Any]) -> npt.NDArray[np.bool_]:
    a, b = pairs[:, 0], pairs[:, 1]
    edges_a, edges_b = np.roll(a, -1, 1) - a, np.roll(b, -1, 1) - b
    unit = np.eye(3, dtype=np.int64).astype(pairs.dtype)
    axes = np.concatenate(
        [
            np.broadcast_to(unit, (len(pairs), 3, 3)),
            _cross_arrays(edges_a[:, 0], edges_a[:, 1])[:, None],
            _cross_arrays(edges_b[:, 0], edges_b[:, 1])[:, None],
            _cross_arrays(edges_a[:, :, None], edges_b[:, None, :]).reshape(-1, 9, 3),
            _cross_arrays(edges_a[:, :, None], unit[None, None]).reshape(-1, 9, 3),
            _cross_arrays(edges_b[:, :, None], unit[None, None]).reshape(-1, 9, 3),
        ],
        1,
    )
    on_a = (axes[:, :, None, :] * a[:, None, :, :]).sum(-1)
    on_b = (axes[:, :, None, :] * b[:, None, :, :]).sum(-1)
    gap = np.maximum(on_b.min(-1) - on_a.max(-1), on_a.min(-1) - on_b.max(-1))
    return (gap > margins[:, None] * np.abs(axes).sum(-1)).astype(np.bool_)


def fits_int64(pairs: npt.NDArray[np.integer[Any]], margins: npt.NDArray[np.integer[Any]]) -> bool:
    """Return whether 64-bit integers provably hold every number of an axis test on these pairs."""
    limit = 1 << (_INT64_WIDTH - 1)
    return len(pairs) == 0 or bool(
        -limit <= pairs.min() and pairs.max() < limit and margins.max() < 2 * limit
    )


def separating(pairs: Pairs, margins: npt.NDArray[np.int64]) -> npt.NDArray[np.bool_]:
    """Return, for pairs (N, 2, 3, 3) and margins (N,), which of the 32 axes separate: (N, 32).

    Exact for any coordinates: 64-bit integers where they provably suffice, Python's own otherwise.
    """
    dtype = np.dtype(np.int64) if fits_int64(pairs, margins) else np.dtype(object)
    result = np.empty((len(pairs), NUM_AXES), np.bool_)
    for start in range(0, len(pairs), _BLOCK):
        block = slice(start, start + _BLOCK)
        result[block] = _separating_block(pairs[block].astype(dtype), margins[block].astype(dtype))
    return result


def claims(pairs: Pairs, margins: npt.NDArray[np.int64]) -> npt.NDArray[np.int16]:
    """Return the lowest-numbered separating axis of each pair, NO_AXIS where none separates."""
    separates = separating(pairs, margins)
    return np.where(separates.any(1), separates.argmax(1), NO_AXIS).astype(np.int16)
