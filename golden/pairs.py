"""Pairs of triangles and verdicts on them, as arrays and files.

Pairs have shape (N, 2, 3, 3): pair; A then B; vertex; coordinate. A file of pairs is a NumPy
``.npy`` file of that shape with an integer type. A file of verdicts is a ``.npy`` file of shape
(N,) with the type `VERDICT`.
"""

import io
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from triaxis.golden.errors import InputError
from triaxis.golden.input_file import read_array
from triaxis.golden.outputs import write_whole

MIN_WIDTH = 8
MAX_WIDTH = 32
NO_AXIS = -1

VERDICT = np.dtype(
    [
        ("near", np.bool_),
        ("axis", np.int16),
        ("coplanar", np.bool_),
        ("degenerate_a", np.bool_),
        ("degenerate_b", np.bool_),
    ]
)

_LARGEST_NATIVE_MARGIN = (1 << MAX_WIDTH) - 1

Pairs = npt.NDArray[np.int64]
Verdicts = npt.NDArray[np.void]


def coordinate_range(width: int) -> tuple[int, int]:
    """Return the smallest and the largest coordinate of ``width`` signed bits."""
    return -(1 << (width - 1)), (1 << (width - 1)) - 1


def check_width(width: int) -> None:
    """Raise InputError unless the core can be built with this many coordinate bits."""
    if not MIN_WIDTH <= width <= MAX_WIDTH:
        raise InputError(f"width {width}: must be {MIN_WIDTH}..{MAX_WIDTH} bits")


def check_margin(margin: int, width: int) -> None:
    """Raise InputError unless the margin (LSB) fits the core.

    2^width - 1 is the largest distance of two points in range, so nothing beyond it is ever needed.
    """
    limit = (1 << width) - 1
    if not 0 <= margin <= limit:
        raise InputError(f"margin {margin}: must be 0..{limit} for width {width}")


def check_pairs(array: npt.NDArray[Any], width: int, name: str = "pairs") -> Pairs:
    """Return the pairs as int64, or raise InputError naming the first element that is wrong."""
    if array.ndim != 4 or array.shape[1:] != (2, 3, 3):
        raise InputError(f"{name}: shape {array.shape}: must be (N, 2, 3, 3)")
    if array.dtype.kind not in "iu":
        raise InputError(
            f"{name}: type {array.dtype}: must be an integer type; quantise real coordinates first"
        )
    low, high = coordinate_range(width)
    wrong = (array < low) | (array > high)
    if wrong.any():
        index = tuple(int(i) for i in np.argwhere(wrong)[0])
        raise InputError(
            f"{name}: pair {index[0]}, triangle {'AB'[index[1]]}, vertex {index[2]}, coordinate "
            f"{'xyz'[index[3]]}: {array[index]} is outside {low}..{high} (width {width})"
        )
    return array.astype(np.int64)


def native_pairs(pairs: npt.NDArray[Any]) -> npt.NDArray[np.int32]:
    """Return the pairs as the native code wants them, not copied where they are that already."""
    if pairs.dtype != np.int32 or pairs.ndim != 4 or pairs.shape[1:] != (2, 3, 3):
        pairs = check_pairs(pairs, MAX_WIDTH)
    return np.ascontiguousarray(pairs, np.int32)


def native_margins(margins: npt.NDArray[Any] | int, count: int) -> npt.NDArray[np.uint32]:
    """Return the margins as the native code wants them, not copied where they are that already."""
    array = np.asarray(margins)
    if array.dtype.kind not in "iu" or array.shape not in ((), (count,)):
        raise InputError(
            f"margins: {array.dtype} of shape {array.shape}: must be integers of shape ({count},), one "
            "for each pair, or a single one"
        )
    if array.dtype != np.uint32:
        wrong = (array < 0) | (array > _LARGEST_NATIVE_MARGIN)
        if wrong.any():
            index = int(np.argmax(wrong))
            raise InputError(
                f"margins: number {index}: {array.flat[index]}: must be 0..{_LARGEST_NATIVE_MARGIN}"
            )
    return np.ascontiguousarray(np.broadcast_to(array, count), np.uint32)


def read_pairs(path: Path, width: int) -> Pairs:
    """Read a file of pairs; raise InputError where it is not one, or out of range for ``width``."""
    return check_pairs(read_array(path), width, str(path))


def write_verdicts(path: Path, verdicts: Verdicts) -> None:
    """Write verdicts as a .npy file, whole or not at all."""
    content = io.BytesIO()
    np.save(content, verdicts)
    write_whole(path, content.getvalue())
