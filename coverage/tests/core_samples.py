"""Samples of pairs as a faultless core would answer them."""

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from triaxis.coverage.core_sample import CoreSample, axes_of
from triaxis.golden.bulk import bulk_facts
from triaxis.golden.facts import Facts
from triaxis.golden.pairs import Pairs
from triaxis.sim.configuration import Configuration

_BATCH = 1 << 16


def true_words(facts: Facts, build: Configuration) -> npt.NDArray[np.uint16]:
    """Return the result words that docs/interface.md asks of a core."""
    axes = np.uint32((1 << axes_of(build)) - 1)
    separating = facts.separating & axes
    near = separating == 0
    lowest = np.array([0 if m == 0 else (m & -m).bit_length() - 1 for m in separating.tolist()], np.uint16)
    flags = facts.coplanar + 2 * (facts.rank_a < 2) + 4 * (facts.rank_b < 2)
    if build.gating:
        flags = np.where(separating & np.uint32(7) == 0, flags, 0)
    return near.astype(np.uint16) | (flags << 1).astype(np.uint16) | lowest << np.uint16(8)


def samples(
    rng: np.random.Generator, build: Configuration, pairs: Pairs, margins: npt.NDArray[np.integer]
) -> Iterator[CoreSample]:
    """Yield samples of the pairs, with waits at random: in the first of them none."""
    for start in range(0, len(pairs), _BATCH):
        part = slice(start, start + _BATCH)
        facts = bulk_facts(pairs[part], margins[part])
        share = 0.0 if start == 0 else rng.choice([0.001, 0.05, 0.5])
        waits = rng.integers(0, 12, (2, len(facts)), np.uint8)
        waits *= (rng.random((2, len(facts))) < share).astype(np.uint8)
        words, none = true_words(facts, build), np.zeros(len(facts), np.uint8)
        clocks = start + np.arange(len(facts))
        yield CoreSample(facts, margins[part].astype(np.int64), words, waits[0], waits[1], clocks, none)
