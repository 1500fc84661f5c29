"""Random integers in bulk, cheaper than Generator.integers where bounds differ from row to row.

They need a bit generator of 64 bits, as numpy.random.default_rng has.
"""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from triaxis.verif.core.stimulus.stimulus import Ints, Rng


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
