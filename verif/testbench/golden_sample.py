"""Which pairs of a run the golden model judges as well.

The bulk checker checks every pair; the linear program is too slow for that. It gets a random share,
and pairs of kinds of situation that it has not judged in this run: which axis decides, at which step of the
decision, between triangles of which ranks, touching with which features. A few at a time, in random order:
no run gets through all kinds; each counts how many it met and how many it judged.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from triaxis.golden.facts import KIND_BITS, Facts

# The smallest share: one in so many.
MOST_SELDOM = 1 << 16


@dataclass(frozen=True)
class Share:
    """How much the golden model judges: one pair in ``one_in`` at random (1: all), and of kinds that are
    new at most ``at_a_time`` in a batch.
    """

    one_in: int
    at_a_time: int = 8


EVERYTHING = Share(1)


class GoldenSample:
    """Chooses pairs, batch by batch; remembers which kinds it has seen."""

    def __init__(self, share: Share, seed: int) -> None:
        """Start with no kind seen."""
        self._share = share
        self._rng = np.random.default_rng([seed, *b"golden"])
        self._met = np.zeros(1 << KIND_BITS, np.bool_)
        self._chosen = np.zeros(1 << KIND_BITS, np.bool_)
        self._first = np.full(1 << KIND_BITS, -1, np.int32)

    @property
    def kinds_met(self) -> int:
        """Return how many kinds came up; 0 where everything is judged."""
        return int(self._met.sum())

    @property
    def kinds_chosen(self) -> int:
        """Return of how many kinds a pair was chosen; 0 where everything is judged."""
        return int(self._chosen.sum())

    def choose(self, facts: Facts) -> npt.NDArray[np.intp]:
        """Return the indices of the pairs to judge, ascending."""
        if self._share.one_in == 1:
            return np.arange(len(facts))
        code = facts.kind
        self._met[code] = True
        wanted = np.flatnonzero(~self._chosen[code])
        # The first of each kind in this batch: of assignments to one place the last holds.
        self._first[code[wanted[::-1]]] = wanted[::-1]
        new = self._first[np.flatnonzero(self._first >= 0)]
        self._first[code[new]] = -1
        # At random, so that none waits for ever behind others.
        new = self._rng.permutation(new)[: self._share.at_a_time]
        self._chosen[code[new]] = True
        random = np.flatnonzero(self._rng.integers(0, self._share.one_in, len(facts), np.uint16) == 0)
        return np.union1d(new, random)
