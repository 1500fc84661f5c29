"""Stimulus as arrays: pairs with the margins at which they are asked; random integers to make them of.

Whatever the width, coordinates are int32 and margins uint32, contiguous, as native code takes them. Integers
are drawn in bulk, cheaper than by Generator.integers where bounds differ from row to row; that needs a bit
generator of 64 bits, as numpy.random.default_rng has.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from triaxis.golden.pairs import coordinate_range

Integer = TypeVar("Integer", np.int32, np.int64)
Number = TypeVar("Number", bound=np.integer)

Rng = np.random.Generator
Ints = npt.NDArray[np.int64]
Pairs32 = npt.NDArray[np.int32]
Mask = npt.NDArray[np.bool_]
Margins32 = npt.NDArray[np.uint32]

# Rounds after which a construction that keeps too little is taken to be wrong.
_ROUNDS = 60


def chosen_rows(
    array: npt.NDArray[Number], chosen: slice | Mask | npt.NDArray[np.integer]
) -> npt.NDArray[Number]:
    """Return array[chosen], several times as fast."""
    if isinstance(chosen, slice):
        return array[chosen]
    return array.take(np.flatnonzero(chosen) if chosen.dtype == np.bool_ else chosen, 0)


@dataclass(frozen=True)
class Stimulus:
    """Pairs (N, 2, 3, 3) at margins (N,)."""

    pairs: Pairs32
    margins: Margins32

    def __len__(self) -> int:
        """Return the number of pairs."""
        return len(self.margins)

    def __getitem__(self, chosen: slice | Mask | npt.NDArray[np.integer]) -> "Stimulus":
        """Return the chosen pairs with their margins."""
        return Stimulus(chosen_rows(self.pairs, chosen), chosen_rows(self.margins, chosen))


# From a generator, a count, a width (8..32 bits) and the largest margin: that many pairs with margins.
# The same state of the generator gives the same stimulus.
Family = Callable[[Rng, int, int, int], Stimulus]

# The same without margins: from a generator, a count and a width, pairs.
PairFamily = Callable[[Rng, int, int], Pairs32]


def divided(count: int, shares: Sequence[int]) -> list[int]:
    """Return whole numbers in proportion to the shares, as nearly as can be, with that sum."""
    total, before = sum(shares), 0
    parts: list[int] = []
    for share in shares:
        parts.append(count * (before + share) // total - count * before // total)
        before += share
    return parts


def joined(parts: Sequence[Stimulus]) -> Stimulus:
    """Return the parts one after another."""
    return Stimulus(np.concatenate([p.pairs for p in parts]), np.concatenate([p.margins for p in parts]))


def collected(count: int, make: Callable[[int], Stimulus]) -> Stimulus:
    """Return ``count`` pairs from a construction that, asked for n, keeps some share of n."""
    parts: list[Stimulus] = []
    have, asked, ask = 0, 0, count + 8
    for _ in range(_ROUNDS):
        parts.append(make(ask))
        have, asked = have + len(parts[-1]), asked + ask
        if have >= count:
            return joined(parts)[:count]
        # What the yield so far calls for, and a little more.
        ask = min((count - have) * (asked + 8) // (have + 1) + 32, 4 * count + 64)
    raise RuntimeError(f"{have} of {asked} pairs kept: the construction does not fit this width")


def bounds(points: npt.NDArray[Integer]) -> tuple[npt.NDArray[Integer], npt.NDArray[Integer]]:
    """Return the smallest and largest coordinates of the points (N, P, 3): (N, 3) each."""
    low, high = points[:, 0], points[:, 0]
    # Faster than min(1) and max(1) for few points.
    for number in range(1, points.shape[1]):
        low = np.minimum(low, points[:, number])
        high = np.maximum(high, points[:, number])
    return low, high


def largest_extents(points: Ints) -> Ints:
    """Return the largest of the extents in x, y and z of the points (N, P, 3): (N,)."""
    low, high = bounds(points)
    extents = high - low
    return np.maximum(np.maximum(extents[:, 0], extents[:, 1]), extents[:, 2])


def largest_span(width: int) -> int:
    """Return the largest extent of what is in range."""
    low, high = coordinate_range(width)
    return high - low


def words(rng: Rng, shape: Sequence[int]) -> npt.NDArray[np.int32]:
    """Return 32 random bits each."""
    count = int(np.prod(shape))
    raw = np.asarray(rng.bit_generator.random_raw(-(-count // 2)), np.uint64)
    return raw.view(np.int32)[:count].reshape(shape)


def of_bits(rng: Rng, bits: npt.NDArray[np.integer], shape: Sequence[int]) -> npt.NDArray[np.int32]:
    """Return integers of so many signed bits, 1..32; ``bits`` is broadcast over ``shape``."""
    drawn = words(rng, shape)
    drawn >>= (32 - bits).astype(np.int32)
    return drawn


def up_to(rng: Rng, limit: Ints | int, shape: Sequence[int]) -> Ints:
    """Return integers in 0..limit, for limits below 2^32, broadcast over ``shape``."""
    drawn = words(rng, shape).view(np.uint32).astype(np.uint64)
    # At most (2^32 - 1) * 2^32: no overflow.
    drawn *= np.asarray(limit + 1).astype(np.uint64)
    drawn >>= np.uint64(32)
    return drawn.view(np.int64)


def around(rng: Rng, limit: Ints | int, shape: Sequence[int]) -> Ints:
    """Return integers in -limit..limit, for limits below 2^31."""
    return up_to(rng, 2 * limit, shape) - limit


def sizes(rng: Rng, count: int, least: int, most: int) -> Ints:
    """Return sizes (N,) in least..most: every scale, the large ones more often."""
    ratio = np.log2((most + 1) / least)
    # The exponent is 1 - u^2: half of the sizes lie in the upper quarter of the scales.
    bits = (1 - rng.random(count) ** 2) * ratio
    return np.minimum((least * np.exp2(bits)).astype(np.int64), most)


def chance(rng: Rng, count: int, of: int) -> npt.NDArray[np.bool_]:
    """Return true (N,) for one in ``of``, at random."""
    return rng.integers(0, of, count, np.uint8) == 0
