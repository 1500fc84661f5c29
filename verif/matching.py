"""The heart of the scoreboard, free of the simulator: matches results with pairs and judges them.

Every pair that the core accepts must come back exactly once, in order, with its own tag and with the
verdict of the golden model. A reset discards what the core holds: results before it must answer a
prefix of the pairs before it.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from triaxis.golden.axes import BOX_AXES, axis_name, axis_vector
from triaxis.golden.certificate import axis_proves_clear
from triaxis.golden.judge import judge_pairs
from triaxis.golden.pairs import NO_AXIS, Pairs, Verdicts
from triaxis.verif.batches import PairBatch, ResultBatch
from triaxis.verif.configuration import Configuration
from triaxis.verif.result import decode, encode

# Axes of a core without the edge x box axes: they come last.
AXES_WITHOUT_EDGE_BOX = 14

# Depth of the core's result queue, the same for every W and M (see triaxis_core).
MOST_IN_FLIGHT = 32

# Failures described in full; beyond that they are only counted.
_DESCRIBED = 10


@dataclass(frozen=True)
class CheckedBatch:
    """Pairs that were checked, with what was expected and how they travelled."""

    pairs: Pairs
    margins: npt.NDArray[np.int64]
    expected: Verdicts
    waits_in: npt.NDArray[np.int64]
    waits_out: npt.NDArray[np.int64]


@dataclass(frozen=True)
class Failure:
    """One thing that went wrong; ``pair`` and ``margin`` where it is about a pair."""

    message: str
    pair: Pairs | None = None
    margin: int = 0


@dataclass
class _Epoch:
    """The time between two resets."""

    pairs: deque[PairBatch] = field(default_factory=deque)
    results: deque[ResultBatch] = field(default_factory=deque)
    pairs_closed: bool = False
    results_closed: bool = False


def expected_verdicts(pairs: Pairs, margins: npt.NDArray[np.int64], configuration: Configuration) -> Verdicts:
    """Return what a core in that configuration must answer: the golden verdict, and its contract.

    With operand gating the flags of a pair that a box axis decides read 0. Without the edge x box
    axes a pair that only they separate is near; it is coplanar (DESIGN, section 4).
    """
    verdicts = judge_pairs(pairs, margins)
    if configuration.gating:
        boxed = (verdicts["axis"] >= 0) & (verdicts["axis"] < BOX_AXES)
        for flag in ("coplanar", "degenerate_a", "degenerate_b"):
            verdicts[flag] &= ~boxed
    if not configuration.edge_box:
        blind = verdicts["axis"] >= AXES_WITHOUT_EDGE_BOX
        verdicts["near"] |= blind
        verdicts["axis"][blind] = NO_AXIS
    return verdicts


class Matcher:
    """Takes batches from both sides in any interleaving; calls ``on_checked`` for what it checked."""

    def __init__(
        self,
        configuration: Configuration,
        on_checked: Callable[[CheckedBatch], None] = lambda _: None,
    ) -> None:
        """Start with nothing accepted and nothing returned."""
        self.configuration = configuration
        self.accepted = 0
        self.returned = 0
        self.checked = 0
        self.clear_claims = 0
        self.discarded = 0
        self.resets = 0
        self.failed = 0
        self.failures: list[Failure] = []
        self._on_checked = on_checked
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
        if not self.checked:
            self._fail(Failure("nothing was checked"))

    def _open_epoch(self) -> None:
        if self._epochs[-1].pairs_closed or self._epochs[-1].results_closed:
            self._epochs.append(_Epoch())
        self._advance()

    def _advance(self) -> None:
        while True:
            epoch = self._epochs[0]
            while epoch.pairs and epoch.results:
                self._check_front(epoch)
            if not (epoch.pairs_closed and epoch.results_closed):
                return
            extra = sum(map(len, epoch.results))
            if extra:
                self._fail(Failure(f"{extra} results before a reset that answer no pair"), extra)
            lost = sum(map(len, epoch.pairs))
            if lost > MOST_IN_FLIGHT:
                self._fail(Failure(f"{lost} pairs unanswered at a reset; {MOST_IN_FLIGHT} can be in flight"))
            self.discarded += lost
            self.resets += 1
            self._epochs.popleft()

    def _check_front(self, epoch: _Epoch) -> None:
        pairs, results = epoch.pairs.popleft(), epoch.results.popleft()
        count = min(len(pairs), len(results))
        if len(pairs) > count:
            epoch.pairs.appendleft(
                PairBatch(
                    pairs.pairs[count:],
                    pairs.margins[count:],
                    pairs.tags[count:],
                    pairs.waits[count:],
                )
            )
        if len(results) > count:
            epoch.results.appendleft(
                ResultBatch(results.words[count:], results.tags[count:], results.waits[count:])
            )
        self._check(
            PairBatch(pairs.pairs[:count], pairs.margins[:count], pairs.tags[:count], pairs.waits[:count]),
            ResultBatch(results.words[:count], results.tags[:count], results.waits[:count]),
        )

    def _check(self, pairs: PairBatch, results: ResultBatch) -> None:
        expected = expected_verdicts(pairs.pairs, pairs.margins, self.configuration)
        wrong_tag = pairs.tags != results.tags
        wrong_word = encode(expected) != results.words
        for i in np.flatnonzero(wrong_tag | wrong_word):
            if wrong_tag[i]:
                message = f"tag {results.tags[i]} where {pairs.tags[i]} was due"
            else:
                got = decode(results.words[i : i + 1])[0]
                message = f"core says {got} ({results.words[i]:#06x}), golden model {expected[i]}"
            self._fail(Failure(message, pairs.pairs[i], int(pairs.margins[i])))
        self._recheck_claims(pairs, results)
        self.checked += len(pairs)
        self._on_checked(CheckedBatch(pairs.pairs, pairs.margins, expected, pairs.waits, results.waits))

    def _recheck_claims(self, pairs: PairBatch, results: ResultBatch) -> None:
        """Prove every "clear" from the claimed axis alone, whatever the golden model said."""
        verdicts = decode(results.words)
        for i in np.flatnonzero(~verdicts["near"]):
            a, b = pairs.pairs[i].tolist()
            number, margin = int(verdicts["axis"][i]), int(pairs.margins[i])
            self.clear_claims += 1
            if not axis_proves_clear(a, b, margin, axis_vector(number, a, b)):
                message = f"claimed axis {number} ({axis_name(number)}) does not separate"
                self._fail(Failure(message, pairs.pairs[i], margin))

    def _fail(self, failure: Failure, count: int = 1) -> None:
        self.failed += count
        if len(self.failures) < _DESCRIBED:
            self.failures.append(failure)
