"""What the instrumented cores are played with: chosen so that every bin that can be hit is hit.

Not a search for faults: thousands of pairs. The families give every verdict, flag and coincidence;
limits of the coordinates reach the highest bits; uniform coordinates give the bits between; and the
schedule fills the result queue, empties it, and resets the core with pairs in flight.
"""

import numpy as np
import numpy.typing as npt

from triaxis.golden.pairs import Pairs, coordinate_range
from triaxis.verif.configuration import Configuration
from triaxis.verif.instrumented_core import OFFER, RESET, TAKE, Stimulus
from triaxis.verif.sequences.families import mixed

# Of each of the three kinds of pairs, as many.
_KINDS = 3


def _limit_pairs(rng: np.random.Generator, count: int, width: int) -> Pairs:
    """Return pairs at corners of the coordinate box, where the core's widths are decided."""
    low, high = coordinate_range(width)
    corners = np.where(rng.integers(0, 2, (count, 2, 3, 3)) == 0, low, high)
    beside = corners + np.where(corners == low, 1, -1) * rng.integers(0, 2, (count, 2, 3, 3))
    return np.where(rng.integers(0, 2, (count, 1, 1, 1)) == 0, corners, beside)


def pairs_with_margins(
    rng: np.random.Generator, count: int, width: int, largest: int
) -> tuple[Pairs, npt.NDArray[np.int64]]:
    """Return pairs (N, 2, 3, 3) and margins (N,) of all families, at the limits, and uniform, shuffled.

    Half of the margins that are not the families' own are uniform, half are the largest.
    """
    each = -(-count // _KINDS)
    low, high = coordinate_range(width)
    families = mixed(rng, each, width, largest)
    pairs = np.concatenate(
        [
            families.pairs.astype(np.int64),
            _limit_pairs(rng, each, width),
            rng.integers(low, high + 1, (each, 2, 3, 3)),
        ]
    )
    uniform = rng.integers(0, largest + 1, 2 * each)
    others = np.where(rng.integers(0, 2, 2 * each) == 0, uniform, largest)
    margins = np.concatenate([families.margins.astype(np.int64), others])
    order = rng.permutation(len(pairs))[:count]
    return pairs[order], margins[order]


def flowing() -> npt.NDArray[np.uint8]:
    """Return a schedule without gaps, back-pressure or resets."""
    return np.array([OFFER | TAKE], np.uint8)


def disturbed(rng: np.random.Generator) -> npt.NDArray[np.uint8]:
    """Return a schedule with everything: streaming, gaps, full queues, resets in each of these."""
    phases: list[npt.NDArray[np.uint8]] = []
    for _ in range(8):
        gaps = rng.integers(0, 2, 200) * OFFER | TAKE
        stalls = rng.integers(0, 2, 200) * TAKE | OFFER
        both = rng.integers(0, 4, 200)
        streaming, full, empty = np.full(600, OFFER | TAKE), np.full(100, OFFER), np.full(100, TAKE)
        for phase in (streaming, full, gaps, empty, stalls, both):
            clocks = phase.astype(np.uint8)
            if rng.integers(0, 2):
                clocks[rng.integers(0, len(clocks))] |= RESET
            phases.append(clocks)
    return np.concatenate(phases)


def stimulus(
    rng: np.random.Generator, count: int, configuration: Configuration, steps: npt.NDArray[np.uint8]
) -> Stimulus:
    """Return ``count`` pairs with margins and tags for a core, to be played by that schedule."""
    pairs, margins = pairs_with_margins(rng, count, configuration.width, configuration.max_margin)
    return Stimulus(
        pairs,
        margins,
        rng.integers(0, 1 << configuration.tag_bits, count),
        rng.integers(0, 256, count).astype(np.uint8),
        steps,
    )
