"""The checker: a few exact inner products that prove a verdict, whoever proposed it.

A witness proves "near": two points, one in each triangle, no further apart than the margin.
An axis proves "clear": by Hoelder's inequality |c.(x - y)| <= |c|1 |x - y|inf, so if all of A lies
beyond all of B by more than margin * |c|1, every point of A is further than the margin from
every point of B. Claimed axes are proven on arrays too, whatever the right answer is: this shares nothing
with the bulk checker, so a "clear" that both it and the core got wrong is disproved here.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from triaxis.golden.axes import NUM_AXES, separates
from triaxis.golden.exact import Scalar, Triangle, Vector, dot


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
    on_a = [dot(axis, vertex) for vertex in a]
    on_b = [dot(axis, vertex) for vertex in b]
    gap = max(min(on_b) - max(on_a), min(on_a) - max(on_b))
    return gap > margin * sum(abs(component) for component in axis)


def claims_prove_clear(
    pairs: npt.NDArray[np.integer[Any]],
    margins: npt.NDArray[np.integer[Any]],
    axes: npt.NDArray[np.integer[Any]],
) -> npt.NDArray[np.bool_]:
    """Return whether the claimed axis (N,) of each pair (N, 2, 3, 3) separates it by more than its margin.

    Does on arrays what `axis_proves_clear` does, exactly for any coordinates.
    """
    proven = np.zeros(len(pairs), np.bool_)
    for number in np.flatnonzero(np.bincount(axes, minlength=NUM_AXES)).tolist():
        chosen = np.flatnonzero(axes == number)
        proven[chosen] = separates(number, pairs[chosen], margins[chosen])
    return proven
