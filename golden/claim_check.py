"""Claims proven by the claimed axis alone, on arrays, whatever the right answer is.

This shares nothing with the bulk checker: a "clear" that both got wrong is disproved here.
"""

from functools import reduce
from typing import Any

import numpy as np
import numpy.typing as npt

from triaxis.golden.axes import NUM_AXES, axis_vector, fits_int64
from triaxis.golden.exact import dot


def claims_prove_clear(
    pairs: npt.NDArray[np.integer[Any]],
    margins: npt.NDArray[np.integer[Any]],
    axes: npt.NDArray[np.integer[Any]],
) -> npt.NDArray[np.bool_]:
    """Return whether the claimed axis (N,) of each pair (N, 2, 3, 3) separates it by more than its margin.

    Does on arrays what `triaxis.golden.certificate.axis_proves_clear` does, exactly for any coordinates:
    in 64 bits where they suffice (see `triaxis.golden.axes.fits_int64`), in Python's integers elsewhere.
    """
    kind = np.int64 if fits_int64(pairs, margins) else object
    proven = np.zeros(len(pairs), np.bool_)
    flat = pairs.reshape(-1, 18)
    for number in np.flatnonzero(np.bincount(axes, minlength=NUM_AXES)).tolist():
        chosen = np.flatnonzero(axes == number)
        # Triangle, vertex, coordinate, pair: the definitions for one pair then serve all of them.
        vertices: Any = np.ascontiguousarray(flat[chosen].T, kind).reshape(2, 3, 3, -1)
        axis: Any = axis_vector(number, vertices[0], vertices[1])
        projections: Any = [[dot(axis, vertex) for vertex in triangle] for triangle in vertices]
        on_a, on_b = projections
        gap = np.maximum(
            reduce(np.minimum, on_b) - reduce(np.maximum, on_a),
            reduce(np.minimum, on_a) - reduce(np.maximum, on_b),
        )
        proven[chosen] = gap > margins[chosen].astype(kind) * sum(np.abs(component) for component in axis)
    return proven
