"""The checker: a few exact inner products that prove a verdict, whoever proposed it.

A witness proves "near": two points, one in each triangle, no further apart than the margin.
An axis proves "clear": by Hoelder's inequality |c.(x - y)| <= |c|1 |x - y|inf, so if all of A lies
beyond all of B by more than margin * |c|1, every point of A is further than the margin from
every point of B. Claimed axes are proven on arrays too, whatever the right answer is: this shares no
arithmetic with the bulk checker, so a "clear" that both it and the core got wrong is disproved here.
"""

from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from triaxis.golden.axes import NUM_AXES
from triaxis.golden.errors import InputError
from triaxis.golden.exact import Scalar, Triangle, Vector, dot
from triaxis.golden.native import native_function
from triaxis.golden.pairs import NO_AXIS, native_margins, native_pairs


def witness_proves_near(
    a: Triangle, b: Triangle, margin: Scalar, weights_a: Vector, weights_b: Vector
) -> bool:
    """Return whether the weights name a point of A and a point of B within the margin."""
    for weights in (weights_a, weights_b):
        if sum(weights) != 1 or any(weight < 0 for weight in weights):
            return False
    gaps = (
        dot(weights_a, [vertex[k] for vertex in a]) - dot(weights_b, [vertex[k] for vertex in b])
        for k in range(3)
    )
    return all(abs(gap) <= margin for gap in gaps)


def axis_proves_clear(a: Triangle, b: Triangle, margin: Scalar, axis: Sequence[Scalar]) -> bool:
    """Return whether the axis separates A and B, in either order, by more than the margin."""
    return axis_gap(a, b, axis) > margin * sum(abs(component) for component in axis)


def axis_gap(a: Triangle, b: Triangle, axis: Sequence[Scalar]) -> Scalar:
    """Return by how much A and B are apart on an axis, in either order; negative where they overlap there."""
    on_a = [dot(axis, vertex) for vertex in a]
    on_b = [dot(axis, vertex) for vertex in b]
    return max(min(on_b) - max(on_a), min(on_a) - max(on_b))


@cache
def _proven() -> Callable[..., None]:
    return native_function("certificate", "triaxis_proven", "pppip", Path(__file__).parent)


def claims_prove_clear(
    pairs: npt.NDArray[np.integer[Any]],
    margins: npt.NDArray[np.integer[Any]],
    axes: npt.NDArray[np.integer[Any]],
) -> npt.NDArray[np.bool_]:
    """Return whether the claimed axis (N,) of each pair (N, 2, 3, 3) separates it by more than its margin.

    Does in native code what `axis_proves_clear` and `triaxis.golden.axes.separates` do, exactly, for
    coordinates and margins of 32 bits; raises InputError for others. NO_AXIS proves nothing.
    """
    coordinates, limits = native_pairs(pairs), native_margins(margins, len(pairs))
    if axes.shape != limits.shape or not ((axes >= NO_AXIS) & (axes < NUM_AXES)).all():
        raise InputError(f"claims: must be axes, {NO_AXIS}..{NUM_AXES - 1}, of shape {limits.shape}")
    claims, proven = np.ascontiguousarray(axes, np.int8), np.zeros(len(limits), np.bool_)
    addresses = (array.ctypes.data for array in (coordinates, limits, claims))
    _proven()(*addresses, len(limits), proven.ctypes.data)
    return proven
