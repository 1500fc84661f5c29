"""Claims proven by the claimed axis alone, on arrays."""

from functools import reduce
from typing import Any

import numpy as np
import numpy.typing as npt

from triaxis.golden.axes import NUM_AXES, axis_vector
from triaxis.golden.exact import dot


def claims_prove_clear(
    pairs: npt.NDArray[np.int32], margins: npt.NDArray[np.integer], axes: npt.NDArray[np.integer]
) -> npt.NDArray[np.bool_]:
    """Return whether the claimed axis (N,) of each pair separates it by more than its margin.

    Does on arrays what `triaxis.golden.certificate.axis_proves_clear` does. Exact in 64 bits for
    coordinates below 2^19 and margins below 2^20, as is `triaxis.golden.axes.separating`.
    """
    proven = np.zeros(len(pairs), np.bool_)
    flat = pairs.reshape(-1, 18)
    for number in np.flatnonzero(np.bincount(axes, minlength=NUM_AXES)).tolist():
        chosen = np.flatnonzero(axes == number)
        # Triangle, vertex, coordinate, pair: the definitions for one pair then serve all of them.
        vertices: Any = np.ascontiguousarray(flat[chosen].T, np.int64).reshape(2, 3, 3, -1)
        axis: Any = axis_vector(number, vertices[0], vertices[1])
        projections: Any = [[dot(axis, vertex) for vertex in triangle] for triangle in vertices]
        on_a, on_b = projections
        gap = np.maximum(
            reduce(np.minimum, on_b) - reduce(np.maximum, on_a),
            reduce(np.minimum, on_a) - reduce(np.maximum, on_b),
        )
        proven[chosen] = gap > margins[chosen] * sum(np.abs(component) for component in axis)
    return proven
