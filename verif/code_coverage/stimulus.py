"""What cores with coverage counters are played with: chosen so that every bin that can be hit is hit.

Not a search for faults: thousands of pairs. The families give every flag and coincidence, and every
claim often enough to pass through each place of the result queue; corners of the coordinate box reach
the highest bits; uniform coordinates give the bits between; and the schedule fills the result queue,
empties it, and resets the core with pairs in flight.
"""

import numpy as np
import numpy.typing as npt

from triaxis.golden.axes import NUM_AXES
from triaxis.golden.bulk import bulk_facts
from triaxis.golden.pairs import NO_AXIS, Pairs, coordinate_range
from triaxis.sim.configuration import Configuration
from triaxis.sim.core_engine import Sent, Steps, core_words
from triaxis.verif.core.stimulus.families import mixed
from triaxis.verif.core.stimulus.general import corner_pairs, diagonal_pairs

# Of each of the four kinds of pairs, as many.
_KINDS = 4
# Pairs drawn for one that is kept where every claim must come up equally often.
_DRAWN_PER_CLAIM = 8
# Of the pairs at corners, those with the largest projection of all.
_LONGEST_SHARE = 4

_Margins = npt.NDArray[np.int64]


def _claim_pairs(rng: np.random.Generator, count: int, width: int, largest: int) -> tuple[Pairs, _Margins]:
    """Return pairs and margins of all families with every claim, and none, about equally often."""
    drawn = mixed(rng, _DRAWN_PER_CLAIM * count, width, largest)
    claim = bulk_facts(drawn.pairs, drawn.margins).claim
    by_claim = [np.flatnonzero(claim == axis) for axis in range(NO_AXIS, NUM_AXES)]
    chosen = rng.integers(0, len(by_claim), count)
    # A claim that did not come up leaves its place to any pair.
    places = [by_claim[kind] if len(by_claim[kind]) else np.arange(len(claim)) for kind in chosen]
    picked = np.array([rng.choice(place) for place in places], np.intp)
    return drawn.pairs[picked].astype(np.int64), drawn.margins[picked].astype(np.int64)


def pairs_with_margins(
    rng: np.random.Generator, count: int, width: int, largest: int
) -> tuple[Pairs, _Margins]:
    """Return pairs (N, 2, 3, 3) and margins (N,): of all families, at corners, uniform, shuffled.

    Half of the margins that are not the families' own are uniform, half are the largest.
    """
    each = -(-count // _KINDS)
    longest = each // _LONGEST_SHARE
    low, high = coordinate_range(width)
    families = mixed(rng, each, width, largest)
    claimed, claimed_margins = _claim_pairs(rng, each, width, largest)
    pairs = np.concatenate(
        [
            families.pairs.astype(np.int64),
            claimed,
            diagonal_pairs(rng, longest, width),
            corner_pairs(rng, each - longest, width),
            rng.integers(low, high + 1, (each, 2, 3, 3)),
        ]
    )
    uniform = rng.integers(0, largest + 1, 2 * each)
    others = np.where(rng.integers(0, 2, 2 * each) == 0, uniform, largest)
    margins = np.concatenate([families.margins.astype(np.int64), claimed_margins, others])
    order = rng.permutation(len(pairs))[:count]
    return pairs[order], margins[order]


def stimulus(
    rng: np.random.Generator, count: int, configuration: Configuration, steps: Steps
) -> tuple[Sent, Pairs, _Margins]:
    """Return ``count`` pairs with margins for a core as they are sent by that schedule, and themselves."""
    pairs, margins = pairs_with_margins(rng, count, configuration.width, configuration.max_margin)
    tags = rng.integers(0, 1 << configuration.tag_bits, count)
    padding = rng.integers(0, 256, count).astype(np.uint8)
    return core_words(pairs, margins, tags, configuration, steps, padding), pairs, margins
