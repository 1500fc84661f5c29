"""Pairs that reach what a core can reach, and samples of them as a faultless core would answer."""

from collections.abc import Iterator
from itertools import product

import numpy as np
import numpy.typing as npt

from triaxis.coverage.core_sample import Build, CoreSample
from triaxis.golden.bulk import bulk_facts
from triaxis.golden.facts import Facts
from triaxis.golden.pairs import Pairs, coordinate_range

Margins = npt.NDArray[np.int64]
_BATCH = 1 << 16


def all_pairs_of_unit_cube() -> Pairs:
    """Return all 2^18 ordered pairs of triangles with vertices in {0, 1}^3."""
    corners = np.array(list(product((0, 1), repeat=3)), np.int64)
    numbers = np.indices((8,) * 6, np.uint8).reshape(6, -1).T
    return corners[numbers].reshape(-1, 2, 3, 3)


def grid_pairs(rng: np.random.Generator, count: int, size: int) -> Pairs:
    """Return random pairs on {0 .. size - 1}^3."""
    return rng.integers(0, size, (count, 2, 3, 3))


def related_pairs(rng: np.random.Generator, count: int, size: int) -> Pairs:
    """Return pairs of all ranks, in common lines, in common planes and in space, some moved off by a step."""
    weights = rng.integers(-size, size + 1, (count, 2, 3, 3))
    dimension = rng.integers(1, 4, count)
    weights[dimension < 2, :, :, 1] = 0
    weights[dimension < 3, :, :, 2] = 0
    for triangle in (0, 1):
        rank = rng.integers(0, 3, count)
        weights[rank == 0, triangle] = weights[rank == 0, triangle][:, :1]
        ends = weights[rank == 1, triangle]
        steps = rng.integers(-1, 3, (len(ends), 3, 1))
        weights[rank == 1, triangle] = ends[:, :1] + steps * (ends[:, 1:2] - ends[:, :1])
    aligned = np.eye(3, dtype=np.int64)[np.argsort(rng.random((count, 3)), 1)]
    tilted = rng.integers(-1, 2, (count, 3, 3))
    basis = np.where(rng.integers(0, 2, (count, 1, 1)) == 0, aligned, tilted)
    pairs = np.einsum("ntvi,nij->ntvj", weights, basis)
    pairs[:, 1] += rng.integers(-1, 2, (count, 1, 3)) * rng.integers(0, 2, (count, 1, 1))
    return pairs


def wide_pairs(rng: np.random.Generator, count: int, width: int) -> Pairs:
    """Return pairs over the whole range, most of them of triangles smaller than that."""
    low, high = coordinate_range(width)
    whole = rng.integers(low, high + 1, (count, 2, 3, 3))
    local = whole[:, :, :1] + (whole >> rng.integers(0, width - 2, (count, 2, 1, 1)))
    return np.clip(np.where(rng.random((count, 1, 1, 1)) < 0.7, local, whole), low, high)


def pointing_pairs(rng: np.random.Generator, count: int) -> Pairs:
    """Return thin pairs that point at each other along x, 1 to 12 apart: with a margin x alone may decide."""
    pairs = rng.integers(-2, 3, (count, 2, 3, 3))
    pairs[:, 0, 1:, 0] -= rng.integers(6, 12, (count, 2))
    pairs[:, 1, 1:, 0] += rng.integers(6, 12, (count, 2))
    pairs[:, :, 0] = 0
    pairs[:, 1, :, 0] += rng.integers(1, 13, (count, 1))
    return pairs


def moved(rng: np.random.Generator, pairs: Pairs, width: int, to_limits: bool) -> Pairs:
    """Return the pairs in random places of the range, or each coordinate at a limit of it."""
    low, high = coordinate_range(width)
    flat = pairs.reshape(-1, 6, 3)
    lowest, highest = low - flat.min(1), high - flat.max(1)
    shift = rng.integers(lowest, highest + 1)
    if to_limits:
        end = rng.integers(0, 3, shift.shape)
        shift = np.where(end == 0, lowest, np.where(end == 1, highest, shift))
    return pairs + shift[:, None, None]


def distances(pairs: Pairs, largest: int) -> Margins:
    """Return the smallest margins at which pairs are near, at most ``largest``, by bisection."""
    low, high = np.zeros(len(pairs), np.int64), np.full(len(pairs), largest, np.int64)
    while (low < high).any():
        middle = (low + high) // 2
        near = bulk_facts(pairs, middle).near
        low, high = np.where(near, low, middle + 1), np.where(near, middle, high)
        low = np.minimum(low, high)
    return high


def true_words(facts: Facts, build: Build) -> npt.NDArray[np.uint16]:
    """Return the result words that docs/interface.md asks of a core."""
    axes = np.uint32((1 << build.axes) - 1)
    separating = facts.separating & axes
    near = separating == 0
    lowest = np.array([0 if m == 0 else (m & -m).bit_length() - 1 for m in separating.tolist()], np.uint16)
    flags = facts.coplanar + 2 * (facts.rank_a < 2) + 4 * (facts.rank_b < 2)
    if build.gating:
        flags = np.where(separating & np.uint32(7) == 0, flags, 0)
    return near.astype(np.uint16) | (flags << 1).astype(np.uint16) | lowest << np.uint16(8)


def samples(rng: np.random.Generator, build: Build, pairs: Pairs, margins: Margins) -> Iterator[CoreSample]:
    """Yield samples of the pairs, with waits at random: in the first of them none."""
    for start in range(0, len(pairs), _BATCH):
        part = slice(start, start + _BATCH)
        facts = bulk_facts(pairs[part], margins[part])
        share = 0.0 if start == 0 else rng.choice([0.001, 0.05, 0.5])
        waits = rng.integers(0, 12, (2, len(facts)), np.uint8)
        waits *= (rng.random((2, len(facts))) < share).astype(np.uint8)
        yield CoreSample(facts, margins[part], true_words(facts, build), waits[0], waits[1])


def margins_for(rng: np.random.Generator, build: Build, pairs: Pairs) -> Margins:
    """Return small margins, and those at which, or one below which, the pair becomes near."""
    count = len(pairs)
    if not build.margin_bits:
        return np.zeros(count, np.int64)
    exact = np.maximum(distances(pairs, build.largest_margin) - rng.integers(0, 2, count), 0)
    small = np.minimum(rng.integers(0, 4, count), build.largest_margin)
    return np.where(rng.integers(0, 4, count) == 0, small, exact)
