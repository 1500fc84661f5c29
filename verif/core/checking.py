"""Checks answers, pair by pair, free of the simulator.

Every answer is compared with the bulk checker and every claimed axis is checked to separate; a sample is
judged by the golden model too, which shares nothing with the bulk checker.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from triaxis.coverage.core_sample import CoreSample
from triaxis.golden.axes import axis_name
from triaxis.golden.bulk import bulk_facts
from triaxis.golden.certificate import claims_prove_clear
from triaxis.golden.facts import Facts
from triaxis.golden.judge import CertificateError, judge_pairs
from triaxis.golden.pairs import NO_AXIS
from triaxis.sim.configuration import Configuration
from triaxis.sim.result import claimed_axes, decode
from triaxis.verif.core.expectation import expected_words, tried_words
from triaxis.verif.core.items import Integers, PairBatch, ResultBatch
from triaxis.verif.testbench.failures import DESCRIBED, Blame, report_failure
from triaxis.verif.testbench.golden_sample import EVERYTHING, GoldenSample, Share

# Pairs that came before a failing one, kept with it: a fault may need them. More than any latency.
_CONTEXT = 64


@dataclass(frozen=True)
class Failure:
    """One thing that went wrong; ``pair`` (2, 3, 3) and ``margin`` where it is about a pair.

    ``context`` (K, 2, 3, 3) and ``context_margins`` (K,): the pairs that were accepted just before it.
    """

    message: str
    pair: Integers | None = None
    margin: int = 0
    context: Integers = field(default_factory=lambda: np.zeros((0, 2, 3, 3), np.int64))
    context_margins: Integers = field(default_factory=lambda: np.zeros(0, np.int64))
    blame: Blame = Blame.DESIGN
    # At which the result left the core.
    clock: int | None = None

    def record(self) -> dict[str, Any]:
        """Return it as it stands among the counts of a run."""
        return {
            "blame": self.blame,
            "message": self.message,
            "of_pair": self.pair is not None,
            "clock": self.clock,
        }


class Checker:
    """Checks matched batches, in order; calls ``on_checked`` for each."""

    def __init__(
        self,
        configuration: Configuration,
        share: Share = EVERYTHING,
        seed: int = 0,
        on_checked: Callable[[CoreSample], None] = lambda _: None,
    ) -> None:
        """Start with nothing checked."""
        self.configuration = configuration
        self.checked = 0
        self.clear_claims = 0
        self.judged = 0
        # Claims, NO_AXIS among them, of which the golden model has judged a pair.
        self.judged_axes: set[int] = set()
        # Pairs that failed, however often; and those of the batch that is being checked, by their places.
        self.failed = 0
        self._failing: set[int] = set()
        self._clocks: Integers = np.zeros(0, np.int64)
        self._attempts = np.zeros(0, np.uint8)
        self.failures: list[Failure] = []
        # Pairs up to and including the first that failed; None: none did.
        self.until_failure: int | None = None
        self.sample = GoldenSample(share, seed)
        self._on_checked = on_checked
        self._before: tuple[Integers, Integers] | None = None

    def check(self, pairs: PairBatch, results: ResultBatch) -> None:
        """Check results against the pairs that they answer, one to one."""
        facts = bulk_facts(pairs.pairs, pairs.margins)
        self._failing, self._clocks = set(), results.clocks
        tags, self._attempts = self._tags(pairs)
        self._compare(pairs, tags, results, facts)
        self._recheck_claims(pairs, results)
        self._judge(pairs, facts)
        self.failed += len(self._failing)
        self.checked += len(pairs)
        self._before = self._until(pairs, len(pairs))
        self._on_checked(
            CoreSample(
                facts,
                pairs.margins,
                results.words,
                pairs.waits,
                results.waits,
                results.clocks,
                self._attempts,
            )
        )

    def _tags(self, pairs: PairBatch) -> tuple[Integers, npt.NDArray[np.uint8]]:
        """Return the tags that results are to have, and what pairs try."""
        if not self.configuration.certified:
            return pairs.tags, np.zeros(len(pairs), np.uint8)
        shift = self.configuration.tag_bits
        return pairs.tags & ((1 << shift) - 1), (pairs.tags >> shift).astype(np.uint8)

    def _compare(self, pairs: PairBatch, tags: Integers, results: ResultBatch, facts: Facts) -> None:
        expected = expected_words(facts, self.configuration)
        attempts = self._attempts
        if attempts.any():
            expected = tried_words(expected, facts, attempts, self.configuration)
        wrong_tag = tags != results.tags
        for i in np.flatnonzero(wrong_tag | (expected != results.words)).tolist():
            if len(self.failures) >= DESCRIBED:
                message = ""
            elif wrong_tag[i]:
                message = f"tag {results.tags[i]} where {tags[i]} was due"
            else:
                got, due = decode(np.array([results.words[i], expected[i]]))
                tried = f", trying {attempts[i]:#04x}" if attempts[i] else ""
                message = f"core says {got} ({results.words[i]:#06x}), exact answer {due}{tried}"
            self._fail(message, pairs, i)

    def _recheck_claims(self, pairs: PairBatch, results: ResultBatch) -> None:
        """Prove every "clear" from the claimed axis, whatever the right answer is."""
        axes = claimed_axes(results.words)
        clear = axes != NO_AXIS
        self.clear_claims += int(clear.sum())
        wrong = clear & ~claims_prove_clear(pairs.pairs, pairs.margins, axes)
        for i in np.flatnonzero(wrong).tolist():
            number = int(axes[i])
            self._fail(f"claimed axis {number} ({axis_name(number)}) does not separate", pairs, i)

    def _judge(self, pairs: PairBatch, facts: Facts) -> None:
        chosen = self.sample.choose(facts)
        if not len(chosen):
            return
        some, margins = pairs.pairs[chosen].astype(np.int64), pairs.margins[chosen].astype(np.int64)
        self.judged += len(chosen)
        try:
            verdicts = judge_pairs(some, margins)
        except CertificateError as error:
            self._fail(f"golden model: {error}", pairs, int(chosen[0]), Blame.JUDGES)
            return
        self.judged_axes |= set(verdicts["axis"].tolist())
        for i in chosen[verdicts != facts[chosen].verdicts].tolist():
            self._fail("bulk checker and golden model disagree", pairs, i, Blame.JUDGES)

    def _fail(self, message: str, pairs: PairBatch, i: int, blame: Blame = Blame.DESIGN) -> None:
        # Each batch is gone through several times.
        self._failing.add(i)
        until = self.checked + i + 1
        self.until_failure = min(self.until_failure or until, until)
        report_failure(message, until)
        if len(self.failures) >= DESCRIBED:
            return
        context, margins = self._until(pairs, i)
        clock = int(self._clocks[i])
        numbered = f"result {until} at clock {clock}: {message}"
        if self._attempts[i]:
            # It is no failure of the pair alone: the run itself repeats it.
            pair = f"margin {pairs.margins[i]}, {pairs.pairs[i].tolist()}"
            self.failures.append(Failure(f"{numbered}: {pair}", blame=blame, clock=clock))
            return
        self.failures.append(
            Failure(numbered, pairs.pairs[i], int(pairs.margins[i]), context, margins, blame, clock)
        )

    def _until(self, pairs: PairBatch, i: int) -> tuple[Integers, Integers]:
        """Return the last pairs and margins before pair ``i`` of a batch, also of the batch before it."""
        start = max(0, i - _CONTEXT)
        here = pairs[start:i]
        if start or self._before is None:
            return here.pairs.copy(), here.margins.copy()
        left = slice(max(0, len(self._before[1]) - (_CONTEXT - i)), None)
        return (
            np.concatenate([self._before[0][left], here.pairs]),
            np.concatenate([self._before[1][left], here.margins]),
        )
