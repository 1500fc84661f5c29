"""Making what fails small: first fewer pairs, then smaller ones, until neither helps.

Fewer pairs: delta debugging (A. Zeller, R. Hildebrandt, "Simplifying and Isolating Failure-Inducing
Input", IEEE Transactions on Software Engineering 28(2), 2002) over the pairs before the last. Smaller
pairs: one place in the stream after the other, the failing pair first. Each round proposes thousands of
smaller pairs, asks the predicate about many of them in one call, and goes on with the smallest that fails,
until none does. The predicate may be a screen: where answers in a batch can disturb each other (a core that
remembers the pair before), only the answer to a call with one pair counts, and each pair that is gone on with
has been confirmed by such a call.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from triaxis.golden.pairs import Pairs
from triaxis.verif.core.failing_pairs import Stream
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


# Takes N streams of K pairs each, pairs (N, K, 2, 3, 3) and margins (N, K); says which fail, (N,).
StreamPredicate = Callable[[Pairs, npt.NDArray[np.int64]], npt.NDArray[np.bool_]]


def minimise(stream: Stream, fails: StreamPredicate, budget: Budget | None = None) -> Stream:
    """Return a small stream that fails, from one that fails (ValueError otherwise).

    ``fails`` may be a screen, as for `shrink`: an answer to one stream alone counts.
    """
    budget = budget or Budget()
    if not _fails(stream, fails):
        raise ValueError("minimise: the stream does not fail")
    while True:
        before = stream
        stream = _shorter(stream, fails, budget)
        for place in reversed(range(len(stream))):
            stream = _shrunk_at(place, stream, fails, budget)
        unchanged = len(stream) == len(before) and (stream.pairs == before.pairs).all()
        if len(stream) == 1 or (unchanged and (stream.margins == before.margins).all()):
            return stream


def _fails(stream: Stream, fails: StreamPredicate) -> bool:
    return bool(fails(stream.pairs[None], stream.margins[None])[0])


def _chosen(stream: Stream, kept: list[int]) -> Stream:
    """Return the stream with only these pairs of its context."""
    rows = [*kept, len(stream) - 1]
    return Stream(stream.pairs[rows], stream.margins[rows])


def _shorter(stream: Stream, fails: StreamPredicate, budget: Budget) -> Stream:
    """Leave out pairs of the context until none can be left out: ddmin."""
    kept = list(range(len(stream) - 1))
    parts = 1
    while kept:
        for rest in _complements(kept, parts):
            if not budget.spend(1):
                return _chosen(stream, kept)
            if _fails(_chosen(stream, rest), fails):
                kept, parts = rest, max(parts - 1, 1)
                break
        else:
            if parts >= len(kept):
                break
            parts = min(2 * parts, len(kept))
    return _chosen(stream, kept)


def _complements(kept: list[int], parts: int) -> list[list[int]]:
    """Return what is left of the list without each of its ``parts`` parts, the earliest left out first."""
    edges = [len(kept) * i // parts for i in range(parts + 1)]
    return [kept[:low] + kept[high:] for low, high in pairwise(edges)]


def _shrunk_at(place: int, stream: Stream, fails: StreamPredicate, budget: Budget) -> Stream:
    """Shrink one pair of the stream, the others as they are."""

    def fails_here(pairs: Pairs, margins: npt.NDArray[np.int64]) -> npt.NDArray[np.bool_]:
        all_pairs = np.repeat(stream.pairs[None], len(pairs), 0)
        all_margins = np.repeat(stream.margins[None], len(pairs), 0)
        all_pairs[:, place], all_margins[:, place] = pairs, margins
        return fails(all_pairs, all_margins)

    pair, margin = shrink(stream.pairs[place], int(stream.margins[place]), fails_here, budget)
    pairs, margins = stream.pairs.copy(), stream.margins.copy()
    pairs[place], margins[place] = pair, margin
    return Stream(pairs, margins)
