"""Making a stream small: first fewer pairs, then smaller ones, until neither helps.

Fewer pairs: delta debugging (A. Zeller, R. Hildebrandt, "Simplifying and Isolating Failure-Inducing
Input", IEEE Transactions on Software Engineering 28(2), 2002) over the pairs before the last. Smaller
pairs: `shrink`, one place in the stream after the other, the failing pair first.
"""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from triaxis.golden.pairs import Pairs
from triaxis.verif.core.stream import Stream
from triaxis.verif.counterexample.shrinking import Budget, shrink

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
