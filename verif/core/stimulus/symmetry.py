"""Variants of pairs that must be answered alike: vertex orders, A and B swapped, symmetries of the cube,
translations.

All are isometries of the Chebyshev distance that keep coordinates in range, so they leave near and
coplanar as they are; the degenerate flags follow A and B. The claim may change.

Arrays of pairs have shape (N, 2, 3, 3) and any integer type, which the variants keep. Orders are numbered
36 s + 6 p + q: s = 1 where A and B are swapped, and then permutation p of the vertices of the first triangle
and q of those of the second, as itertools.permutations(range(3)) lists them. Symmetries are numbered
8 p + r: coordinate k of the variant is coordinate COORDINATES[8 p + r][k] of the pair, reflected where bit k
of r is set. Number 0 changes nothing in either.

A reflection takes x to -1 - x: it is about the middle of the range [-2^(W-1), 2^(W-1) - 1], so nothing
leaves it, for any W. In two's complement this is the bitwise complement.
"""

from collections.abc import Callable
from functools import cache
from itertools import permutations, product
from pathlib import Path
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from triaxis.golden.native import native_function
from triaxis.golden.pairs import coordinate_range

Integer = TypeVar("Integer", np.int32, np.int64)

_PERMUTATIONS = tuple(permutations(range(3)))

# Pairs that are moved with one drawing of random numbers.
_BLOCK = 2048

# The vertex, 0..5 for A1 .. B3, at each place of the variant: (72, 6).
VERTICES = np.array(
    [
        [3 * swap + v for v in p] + [3 * (1 - swap) + v for v in q]
        for swap, p, q in product((0, 1), _PERMUTATIONS, _PERMUTATIONS)
    ],
    np.uint8,
)
SWAPPED = VERTICES[:, 0] >= 3
NUM_ORDERS = len(VERTICES)

# The coordinate at each place of the variant, and whether it is reflected: (48, 3) each.
COORDINATES = np.repeat(np.array(_PERMUTATIONS, np.uint8), 8, 0)
REFLECTED = np.tile(np.array([[bool(r >> k & 1) for k in range(3)] for r in range(8)]), (6, 1))
NUM_SYMMETRIES = len(COORDINATES)

# What is xored onto each coordinate.
_COMPLEMENTS = np.where(REFLECTED, -1, 0).astype(np.int8)


@cache
def _native(function: str, arguments: str) -> Callable[..., None]:
    return native_function("symmetry", function, arguments, Path(__file__).parent)


def _function(name: str, arguments: str, pairs: npt.NDArray[Integer]) -> Callable[..., None]:
    """Return the native function for pairs of that type; raise ValueError where they are none."""
    if pairs.dtype not in (np.int32, np.int64) or pairs.ndim != 4 or pairs.shape[1:] != (2, 3, 3):
        raise ValueError(f"pairs: {pairs.dtype} of shape {pairs.shape}: must be int32 or int64, (N, 2, 3, 3)")
    return _native(f"triaxis_{name}_{8 * pairs.dtype.itemsize}", arguments)


def rearranged(
    pairs: npt.NDArray[Integer],
    rows: npt.NDArray[np.integer],
    orders: npt.NDArray[np.integer],
    symmetries: npt.NDArray[np.integer],
) -> npt.NDArray[Integer]:
    """Return the pairs in these rows (N,), each in the order and under the symmetry of these numbers (N,)."""
    count = len(rows)
    if not len(orders) == len(symmetries) == count:
        raise ValueError(f"{count} rows, {len(orders)} orders, {len(symmetries)} symmetries")
    for numbers, end in ((rows, len(pairs)), (orders, NUM_ORDERS), (symmetries, NUM_SYMMETRIES)):
        if count and not 0 <= numbers.min() <= numbers.max() < end:
            raise ValueError(f"numbers of rows, orders or symmetries: must be 0..{end - 1}")
    pairs, result = np.ascontiguousarray(pairs), np.empty((count, 2, 3, 3), pairs.dtype)
    given = (np.ascontiguousarray(rows, np.uint32), np.ascontiguousarray(orders, np.uint8))
    given += (np.ascontiguousarray(symmetries, np.uint8),)
    tables = (table.ctypes.data for table in (VERTICES, COORDINATES, _COMPLEMENTS))
    addresses = (array.ctypes.data for array in (pairs, *given))
    _function("rearranged", "ppppipppp", pairs)(*addresses, count, *tables, result.ctypes.data)
    return result


def in_order(pairs: npt.NDArray[Integer], numbers: npt.NDArray[np.integer]) -> npt.NDArray[Integer]:
    """Return each pair in the order of that number, 0..71: (N, 2, 3, 3)."""
    return rearranged(pairs, np.arange(len(pairs)), numbers, np.zeros(len(pairs), np.uint8))


def under_symmetry(pairs: npt.NDArray[Integer], numbers: npt.NDArray[np.integer]) -> npt.NDArray[Integer]:
    """Return each pair under the symmetry of the cube of that number, 0..47: (N, 2, 3, 3)."""
    return rearranged(pairs, np.arange(len(pairs)), np.zeros(len(pairs), np.uint8), numbers)


def random_variants(
    rng: np.random.Generator, pairs: npt.NDArray[Integer], rows: npt.NDArray[np.integer]
) -> npt.NDArray[Integer]:
    """Return the pairs in these rows (N,), each in a random order and under a random symmetry."""
    orders = rng.integers(0, NUM_ORDERS, len(rows), np.uint8)
    return rearranged(pairs, rows, orders, rng.integers(0, NUM_SYMMETRIES, len(rows), np.uint8))


def random_orders(rng: np.random.Generator, pairs: npt.NDArray[Integer]) -> npt.NDArray[Integer]:
    """Return each pair in one of its 72 orders."""
    return in_order(pairs, rng.integers(0, NUM_ORDERS, len(pairs), np.uint8))


def random_cube_symmetries(rng: np.random.Generator, pairs: npt.NDArray[Integer]) -> npt.NDArray[Integer]:
    """Return each pair under one of the 48 symmetries of the cube."""
    return under_symmetry(pairs, rng.integers(0, NUM_SYMMETRIES, len(pairs), np.uint8))


def random_translations(
    rng: np.random.Generator, pairs: npt.NDArray[Integer], width: int
) -> npt.NDArray[Integer]:
    """Return each pair moved to a place where it is in range of ``width`` bits, any with about equal odds."""
    pairs, result = np.ascontiguousarray(pairs), np.empty(pairs.shape, pairs.dtype)
    place = _function("placed", "ppiiip", pairs)
    for start in range(0, len(pairs), _BLOCK):
        block = pairs[start : start + _BLOCK]
        draws = rng.integers(0, 1 << 32, (3, len(block)), np.uint32)
        moved = result[start : start + _BLOCK]
        place(block.ctypes.data, draws.ctypes.data, len(block), *coordinate_range(width), moved.ctypes.data)
    return result


def centred(pairs: npt.NDArray[np.int32]) -> npt.NDArray[np.int32]:
    """Return the pairs moved so that zero is in their middle: small pairs get small numbers."""
    pairs, result = np.ascontiguousarray(pairs), np.empty(pairs.shape, pairs.dtype)
    _function("centred", "pip", pairs)(pairs.ctypes.data, len(pairs), result.ctypes.data)
    return result


def all_orders(pairs: npt.NDArray[Integer]) -> npt.NDArray[Integer]:
    """Return all 72 orders of each pair: (72 N, 2, 3, 3), order n of pair i at 72 i + n."""
    numbers = np.tile(np.arange(NUM_ORDERS, dtype=np.uint8), len(pairs))
    return in_order(np.repeat(pairs, NUM_ORDERS, 0), numbers)


def all_cube_symmetries(pairs: npt.NDArray[Integer]) -> npt.NDArray[Integer]:
    """Return each pair under all symmetries of the cube: (48 N, 2, 3, 3), number n of pair i at 48 i + n."""
    numbers = np.tile(np.arange(NUM_SYMMETRIES, dtype=np.uint8), len(pairs))
    return under_symmetry(np.repeat(pairs, NUM_SYMMETRIES, 0), numbers)
