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

from itertools import permutations, product
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from triaxis.golden.pairs import coordinate_range

Integer = TypeVar("Integer", np.int32, np.int64)

_PERMUTATIONS = tuple(permutations(range(3)))
_VERTICES = 6
_NUMBERS = 18

# Pairs at a time: what is worked on stays in the cache.
_BLOCK = 2048

# The vertex, 0..5 for A1 .. B3, at each place of the variant: (72, 6).
VERTICES = np.array(
    [
        [3 * swap + v for v in p] + [3 * (1 - swap) + v for v in q]
        for swap, p, q in product((0, 1), _PERMUTATIONS, _PERMUTATIONS)
    ],
    np.intp,
)
SWAPPED = VERTICES[:, 0] >= 3
NUM_ORDERS = len(VERTICES)

# The coordinate at each place of the variant, and whether it is reflected: (48, 3) each.
COORDINATES = np.repeat(np.array(_PERMUTATIONS, np.intp), 8, 0)
REFLECTED = np.tile(np.array([[bool(r >> k & 1) for k in range(3)] for r in range(8)]), (6, 1))
NUM_SYMMETRIES = len(COORDINATES)

# Where each of the 18 numbers of a variant comes from, and what is xored onto it: (48, 18) each.
_PLACES = (3 * np.arange(_VERTICES)[:, None] + COORDINATES[:, None, :]).reshape(NUM_SYMMETRIES, _NUMBERS)
_COMPLEMENTS = np.tile(np.where(REFLECTED, -1, 0), (1, _VERTICES)).astype(np.int32)


def in_order(pairs: npt.NDArray[Integer], numbers: npt.NDArray[np.integer]) -> npt.NDArray[Integer]:
    """Return each pair in the order of that number, 0..71: (N, 2, 3, 3)."""
    result = np.empty((len(pairs) * _VERTICES, 3), pairs.dtype)
    vertices = np.ascontiguousarray(pairs).reshape(-1, 3)
    for start in range(0, len(pairs), _BLOCK):
        places = VERTICES.take(numbers[start : start + _BLOCK], 0)
        places += _VERTICES * np.arange(start, start + len(places))[:, None]
        rows = slice(_VERTICES * start, _VERTICES * start + places.size)
        # Clipping never happens: it spares numpy the buffer that mode "raise" fills first.
        vertices.take(places.reshape(-1), 0, result[rows], "clip")
    return result.reshape(-1, 2, 3, 3)


def under_symmetry(pairs: npt.NDArray[Integer], numbers: npt.NDArray[np.integer]) -> npt.NDArray[Integer]:
    """Return each pair under the symmetry of the cube of that number, 0..47: (N, 2, 3, 3)."""
    result = np.empty((len(pairs), _NUMBERS), pairs.dtype)
    flat = np.ascontiguousarray(pairs).reshape(-1)
    for start in range(0, len(pairs), _BLOCK):
        block = slice(start, start + _BLOCK)
        places = _PLACES.take(numbers[block], 0)
        places += _NUMBERS * np.arange(start, start + len(places))[:, None]
        flat.take(places, None, result[block], "clip")
        result[block] ^= _COMPLEMENTS.take(numbers[block], 0)
    return result.reshape(-1, 2, 3, 3)


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
    result = np.empty((len(pairs), _NUMBERS), pairs.dtype)
    flat = pairs.reshape(-1, _NUMBERS)
    for start in range(0, len(pairs), _BLOCK):
        block = slice(start, start + _BLOCK)
        # Vertex, coordinate, pair: along the pairs everything is contiguous.
        vertices = np.ascontiguousarray(flat[block].T).reshape(_VERTICES, 3, -1)
        result[block] = (vertices + _random_shifts(rng, vertices, width)).reshape(_NUMBERS, -1).T
    return result.reshape(-1, 2, 3, 3)


def _random_shifts(
    rng: np.random.Generator, vertices: npt.NDArray[Integer], width: int
) -> npt.NDArray[Integer]:
    """Return shifts (3, N) that keep vertices (6, 3, N) in range."""
    low, high = coordinate_range(width)
    lowest, highest = vertices.min(0).astype(np.int64), vertices.max(0).astype(np.int64)
    # places <= 2^32 and draw < 2^32: the product fits 64 bits, and the quotient is below places.
    places = (high - low + 1 - (highest - lowest)).astype(np.uint64)
    draw = rng.integers(0, 1 << 32, places.shape, np.uint32).astype(np.uint64)
    shifts = low - lowest + ((draw * places) >> np.uint64(32)).astype(np.int64)
    # At 32 bits a shift may wrap: the sum is in range, so it comes out right all the same.
    return shifts.astype(vertices.dtype)


def all_orders(pairs: npt.NDArray[Integer]) -> npt.NDArray[Integer]:
    """Return all 72 orders of each pair: (72 N, 2, 3, 3), order n of pair i at 72 i + n."""
    numbers = np.tile(np.arange(NUM_ORDERS, dtype=np.uint8), len(pairs))
    return in_order(np.repeat(pairs, NUM_ORDERS, 0), numbers)


def all_cube_symmetries(pairs: npt.NDArray[Integer]) -> npt.NDArray[Integer]:
    """Return each pair under all symmetries of the cube: (48 N, 2, 3, 3), number n of pair i at 48 i + n."""
    numbers = np.tile(np.arange(NUM_SYMMETRIES, dtype=np.uint8), len(pairs))
    return under_symmetry(np.repeat(pairs, NUM_SYMMETRIES, 0), numbers)
