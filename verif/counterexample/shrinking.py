"""Shrinking: from a pair that fails to a small one that still fails.

Each round proposes thousands of smaller pairs, asks the predicate about many of them in one call, and
goes on with the smallest that fails, until none does. The predicate may be a screen: where answers in
a batch can disturb each other (a core that remembers the pair before), only the answer to a call with
one pair counts, and each pair that is gone on with has been confirmed by such a call.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from triaxis.golden.pairs import Pairs
from triaxis.verif.counterexample.candidates import candidates

# Takes pairs (N, 2, 3, 3) and margins (N,); says which fail, (N,).
Predicate = Callable[[Pairs, npt.NDArray[np.int64]], npt.NDArray[np.bool_]]

# Candidates of a call that are confirmed one by one before the rest is passed over.
_CONFIRMED = 12


@dataclass
class Budget:
    """What shrinking may spend: calls of the predicate, and pairs that it is asked about in all.

    ``at_once`` is how many pairs a call is about at most. Small ones come first, so few are asked
    about in vain.
    """

    calls: int = 1000
    pairs: int = 4_000_000
    at_once: int = 4096

    def spend(self, pairs: int) -> bool:
        """Pay for one call about that many pairs; return False, for good, where too little is left."""
        if pairs > self.pairs or not self.calls:
            self.calls = 0
            return False
        self.calls -= 1
        self.pairs -= pairs
        return True


def shrink(pair: Pairs, margin: int, fails: Predicate, budget: Budget | None = None) -> tuple[Pairs, int]:
    """Return a small pair (2, 3, 3) and its margin that fail, from a pair and a margin that fail.

    Deterministic where ``fails`` is. What it returns has failed in a call of its own, however small
    the budget. Raises ValueError where the pair itself does not fail.
    """
    budget = budget or Budget()
    pair = np.array(pair, np.int64)
    if not fails(pair[None], np.array([margin], np.int64))[0]:
        raise ValueError("shrink: the pair does not fail")
    while True:
        found = _smallest(pair, margin, fails, budget)
        if found is None:
            return pair, margin
        pair, margin = found


def _smallest(pair: Pairs, margin: int, fails: Predicate, budget: Budget) -> tuple[Pairs, int] | None:
    """Return the smallest candidate that fails, confirmed; None where there is none, or no budget."""
    if not budget.calls:
        return None
    pairs, margins = candidates(pair, margin)
    for start in range(0, len(pairs), budget.at_once):
        block = slice(start, start + budget.at_once)
        if not budget.spend(len(pairs[block])):
            return None
        for index in start + np.flatnonzero(fails(pairs[block], margins[block]))[:_CONFIRMED]:
            one = slice(index, index + 1)
            if not budget.spend(1):
                return None
            if fails(pairs[one], margins[one])[0]:
                return pairs[index], int(margins[index])
    return None
