"""Matches results with the pairs that they answer, free of the simulator.

Every pair that the core accepts must come back exactly once, in order. A reset discards what the core
holds: results before it must answer a prefix of the pairs before it.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

from triaxis.verif.core.checking import DESCRIBED, Failure
from triaxis.verif.testbench.batches import PairBatch, ResultBatch


@dataclass
class _Epoch:
    """The time between two resets."""

    pairs: deque[PairBatch] = field(default_factory=deque)
    results: deque[ResultBatch] = field(default_factory=deque)
    pairs_closed: bool = False
    results_closed: bool = False


class Matcher:
    """Takes batches from both sides in any interleaving; hands on what belongs together."""

    def __init__(self, most_in_flight: int, on_matched: Callable[[PairBatch, ResultBatch], None]) -> None:
        """Start with nothing accepted and nothing returned.

        ``most_in_flight``: pairs that the core can hold. ``on_matched`` takes pairs and results, one to one.
        """
        self.accepted = 0
        self.returned = 0
        self.matched = 0
        self.discarded = 0
        self.resets = 0
        self.failed = 0
        self.failures: list[Failure] = []
        self._most_in_flight = most_in_flight
        self._on_matched = on_matched
        self._epochs: deque[_Epoch] = deque([_Epoch()])

    @property
    def outstanding(self) -> int:
        """Return how many pairs of the present epoch have not come back yet."""
        last = self._epochs[-1]
        return sum(map(len, last.pairs)) - sum(map(len, last.results))

    def feed_pairs(self, batch: PairBatch) -> None:
        """Take pairs that the core accepted."""
        self.accepted += len(batch)
        next(e for e in self._epochs if not e.pairs_closed).pairs.append(batch)
        self._advance()

    def feed_results(self, batch: ResultBatch) -> None:
        """Take results that the core returned."""
        self.returned += len(batch)
        next(e for e in self._epochs if not e.results_closed).results.append(batch)
        self._advance()

    def reset_pairs(self) -> None:
        """Take note that the input side saw a reset."""
        next(e for e in self._epochs if not e.pairs_closed).pairs_closed = True
        self._open_epoch()

    def reset_results(self) -> None:
        """Take note that the output side saw a reset."""
        next(e for e in self._epochs if not e.results_closed).results_closed = True
        self._open_epoch()

    def finish(self) -> None:
        """Close the run: what is missing or superfluous now stays so."""
        self._advance()
        for epoch in self._epochs:
            missing, extra = sum(map(len, epoch.pairs)), sum(map(len, epoch.results))
            if extra:
                self._fail(Failure(f"{extra} results that answer no pair"), extra)
            if missing:
                self._fail(Failure(f"{missing} pairs accepted and never answered"), missing)
        if not self.matched:
            self._fail(Failure("nothing was checked"))

    def _open_epoch(self) -> None:
        if self._epochs[-1].pairs_closed or self._epochs[-1].results_closed:
            self._epochs.append(_Epoch())
        self._advance()

    def _advance(self) -> None:
        while True:
            epoch = self._epochs[0]
            while epoch.pairs and epoch.results:
                self._match_front(epoch)
            if not (epoch.pairs_closed and epoch.results_closed):
                return
            extra = sum(map(len, epoch.results))
            if extra:
                self._fail(Failure(f"{extra} results before a reset that answer no pair"), extra)
            lost = sum(map(len, epoch.pairs))
            if lost > self._most_in_flight:
                most = f"{self._most_in_flight} can be in flight"
                self._fail(Failure(f"{lost} pairs unanswered at a reset; {most}"))
            self.discarded += lost
            self.resets += 1
            self._epochs.popleft()

    def _match_front(self, epoch: _Epoch) -> None:
        pairs, results = epoch.pairs.popleft(), epoch.results.popleft()
        count = min(len(pairs), len(results))
        if len(pairs) > count:
            epoch.pairs.appendleft(pairs[count:])
        if len(results) > count:
            epoch.results.appendleft(results[count:])
        self.matched += count
        self._on_matched(pairs[:count], results[:count])

    def _fail(self, failure: Failure, count: int = 1) -> None:
        self.failed += count
        if len(self.failures) < DESCRIBED:
            self.failures.append(failure)
