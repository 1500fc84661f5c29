"""Triangles, segments and points on a small grid: hard for a method's logic, not for its arithmetic.

Coordinates are so small that differences, products and determinants are exact in float32 too.
"""

import numpy as np

from triaxis.golden.bulk import bulk_facts
from triaxis.verif.core.stimulus.degenerate import of_rank
from triaxis.verif.core.stimulus.draws import around, chance, up_to
from triaxis.verif.core.stimulus.stimulus import Ints, Rng, Stimulus, collected

# Sizes of triangles, and so that pairs that meet stay within -15..15.
_SIZE = 5
# Pairs drawn at a time: near and clear ones are chosen from them, half each.
_DRAWN = 6


def _of_ranks(rng: Rng, count: int, rank_a: int, rank_b: int) -> Ints:
    """Return pairs of these ranks whose vertices meet or nearly meet, in half of the pairs."""
    size = np.full(count, _SIZE)
    a = of_rank(rng, np.full(count, rank_a), _legs(rank_a, size))
    b = of_rank(rng, np.full(count, rank_b), _legs(rank_b, size))
    rows, vertex = np.arange(count), up_to(rng, 2, (2, count))
    meet = a[rows, vertex[0]] - b[rows, vertex[1]]
    b += np.where(chance(rng, count, 2)[:, None], meet, around(rng, 1, (count, 3)))[:, None]
    return np.stack([a, b], 1)


def _legs(rank: int, size: Ints) -> Ints:
    """Return the size to ask for: segments are made of twelfths of theirs."""
    return 12 * np.ones_like(size) if rank == 1 else size


def degenerate(rng: Rng, count: int, rank_a: int, rank_b: int) -> Ints:
    """Return pairs (N, 2, 3, 3) of these ranks (0 point, 1 segment, 2 triangle), half of them near."""

    def make(near: bool, asked: int) -> Stimulus:
        pairs = _of_ranks(rng, _DRAWN * asked, rank_a, rank_b)
        facts = bulk_facts(pairs, 0)
        # Clear pairs that are close: one step decides, as where they touch.
        chosen = (facts.rank_a == rank_a) & (facts.rank_b == rank_b) & (facts.near == near)
        chosen &= bulk_facts(pairs, 1).near
        kept = pairs[chosen][:asked].astype(np.int32)
        return Stimulus(kept, np.zeros(len(kept), np.uint32))

    half = count // 2
    parts = [collected(half, lambda n: make(True, n)), collected(count - half, lambda n: make(False, n))]
    return np.concatenate([part.pairs for part in parts]).astype(np.int64)
