"""Pairs of real coordinates of 53 bits, as float64 has them: too fine for any grid of 32 bits.

Coordinates are whole numbers below 2^53 in size, in a unit of their own, so float64 holds them exactly, and
exact verdicts need no fractions. float32 holds them rounded, as a program in float32 would have them.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from triaxis.bench.stress.lattice_families import contacts_at
from triaxis.verif.core.stimulus.stimulus import Ints, Rng
from triaxis.verif.core.stimulus.symmetry import random_orders

Reals = npt.NDArray[np.float64]

# The size of the larger triangle, in units: sums of a few such stay below 2^53.
_SIZE = 2.0**50

# Pairs far from the origin: bits of their own size, and how far they are from their decision.
_FAR_BITS = 16
_FAR_GAP = 2.0**-18
_FAR_DIRECTION = np.array([1.0, -0.7, 0.4])


def _unit(vectors: Reals) -> Reals:
    return vectors / np.sqrt((vectors**2).sum(-1, keepdims=True))


def _frames(rng: Rng, count: int) -> tuple[Reals, Reals, Reals]:
    """Return three vectors of length 1, at right angles: (N, 3) each, in any direction."""
    first = _unit(rng.normal(size=(count, 3)))
    third = _unit(np.cross(first, rng.normal(size=(count, 3))))
    return first, np.cross(third, first), third


def _rounded(rng: Rng, *vertices: Reals) -> Ints:
    """Return pairs of these six vertices (N, 3) each, in random orders: (N, 2, 3, 3)."""
    pairs = np.rint(np.stack(vertices, 1)).astype(np.int64).reshape(-1, 2, 3, 3)
    return random_orders(rng, pairs)


def _between(rng: Rng, low: float, high: float, count: int) -> Reals:
    """Return numbers (N, 1)."""
    return rng.uniform(low, high, (count, 1))


def _sides(rng: Rng, count: int) -> npt.NDArray[Any]:
    """Return -1 or 1: (N, 1)."""
    return rng.choice([-1.0, 1.0], (count, 1))


def slivers(rng: Rng, count: int, aspect: float) -> Ints:
    """Return slivers A, and B whose edge passes A's long edge at half of A's width there, on either side.

    ``aspect``: width over length; 0: A is a segment, and B's edge passes it by 4 units.
    """
    along, across, up = _frames(rng, count)
    apex, place = _between(rng, 0.3, 0.7, count), _between(rng, 0.3, 0.7, count)
    width = _SIZE * aspect
    # Even ends, so that a place in the middle is exactly between them.
    start, end = 2 * np.rint(-_SIZE / 4 * along), 2 * np.rint(_SIZE / 4 * along)
    third = start + apex * (end - start) + width * across if aspect else (start + end) / 2
    here = np.minimum(place / apex, (1 - place) / (1 - apex)) * width if aspect else 8.0
    passing = start + place * (end - start) + _sides(rng, count) * here / 2 * across
    # B's edge goes through the plane of A; the rest of B is on the outer side of A's long edge.
    lean = _unit(up + _between(rng, -0.6, 0.6, count) * along + _between(rng, -0.6, 0.6, count) * across)
    away = _unit(
        _between(rng, -0.6, 0.6, count) * up + _between(rng, -0.6, 0.6, count) * along - 1.2 * across
    )
    above, below = _between(rng, 0.1, 0.5, count), _between(rng, 0.1, 0.5, count)
    middle = passing + _between(rng, 0.1, 0.5, count) * _SIZE * away
    return _rounded(
        rng, start, end, third, passing + above * _SIZE * lean, passing - below * _SIZE * lean, middle
    )


def of_unlike_size(rng: Rng, count: int, ratio: float) -> Ints:
    """Return a triangle and one ``ratio`` its size that pierces or misses its face by a quarter of that."""
    along, across, up = _frames(rng, count)
    corners = [
        _SIZE * (np.cos(angle) * along + np.sin(angle) * across)
        for angle in (_between(rng, turn - 0.5, turn + 0.5, count) for turn in (0.0, 2.1, 4.2))
    ]
    weights = rng.dirichlet([4.0, 4.0, 4.0], count)
    foot = sum(weights[:, k : k + 1] * corner for k, corner in enumerate(corners))
    size = _SIZE * ratio
    lowest = foot + _sides(rng, count) * size / 4 * up
    others = [
        foot
        + size * (_between(rng, 0.5, 1.0, count) * up)
        + size * (_between(rng, -1.0, 1.0, count) * along + _between(rng, -1.0, 1.0, count) * across)
        for _ in range(2)
    ]
    return _rounded(rng, *corners, lowest, *others)


def far_away(rng: Rng, count: int, distance: float) -> Ints:
    """Return pairs that miss or pass by 2^-18 of their range, ``distance`` times it from the origin."""
    span = float(1 << _FAR_BITS)
    offset = np.rint(distance * span * _FAR_DIRECTION).astype(np.int64)
    return contacts_at(rng, count, _FAR_BITS, _FAR_GAP * span) + offset
