"""From a pair that failed in a simulation to a small counterexample of the bare core."""

from dataclasses import dataclass

import numpy as np

from triaxis.golden.axes import axis_name
from triaxis.golden.bulk import bulk_facts
from triaxis.golden.judge import CertificateError, judge_pairs
from triaxis.sim.configuration import Configuration
from triaxis.sim.result import AXIS_MASK, AXIS_SHIFT, COPLANAR, DEGENERATE_A, DEGENERATE_B, NEAR
from triaxis.verif.core.stream import Stream
from triaxis.verif.counterexample.bare_core import BareCore
from triaxis.verif.counterexample.failing import FailingPair
from triaxis.verif.counterexample.minimising import minimise
from triaxis.verif.counterexample.shrinking import Budget
from triaxis.verif.counterexample.symptom import Symptom

# A fresh core for each stream takes 0.1 to 1 ms: some seconds at most.
_ALONE = {"pairs": 20_000, "at_once": 256}


@dataclass(frozen=True, eq=False)
class Counterexample:
    """A stream whose last pair the core gets wrong.

    ``answer`` is its result word, or says how it broke its interface; ``right`` is the word that it had
    to answer.
    """

    configuration: Configuration
    stream: Stream
    symptom: Symptom
    answer: np.uint16 | str
    right: np.uint16

    @property
    def core_said(self) -> str:
        """Return what the core answered, in words."""
        return self.answer if isinstance(self.answer, str) else describe(self.answer)

    @property
    def right_answer(self) -> str:
        """Return what it had to answer, in words."""
        return describe(self.right)

    @property
    def claim(self) -> int | None:
        """Return the axis that the core claims, None where it claims none."""
        if isinstance(self.answer, str) or self.answer & NEAR:
            return None
        return int(self.answer) >> AXIS_SHIFT & AXIS_MASK


def describe(word: np.uint16) -> str:
    """Return a result word in words: ``near, coplanar (0x0003)``, ``clear by axis 4 (normal B) ..``"""
    axis = int(word) >> AXIS_SHIFT & AXIS_MASK
    said = ["near" if word & NEAR else f"clear by axis {axis} ({axis_name(axis)})"]
    flags = {COPLANAR: "coplanar", DEGENERATE_A: "A degenerate", DEGENERATE_B: "B degenerate"}
    said += [text for flag, text in flags.items() if word & flag]
    return f"{', '.join(said)} ({word:#06x})"


def failing_stream(core: BareCore, failing: FailingPair) -> Stream | None:
    """Return a stream that fails on the bare core: the pair alone, or after its context; None if neither."""
    streams = [failing.stream]
    if failing.context is not None:
        streams.append(failing.stream.preceded_by(failing.context))
    return next((s for s in streams if core.symptom(s) != Symptom.RIGHT), None)


def find(core: BareCore, failing: FailingPair) -> Counterexample | None:
    """Return a small counterexample with the failing pair's symptom; None where it does not fail.

    The symptom is that of the last pair of the stream; what else the core gets wrong does not count.
    Raises CertificateError where the bulk checker and the golden model disagree on the result.
    """
    stream = failing_stream(core, failing)
    if stream is None:
        return None
    symptom = core.symptom(stream)
    stream = minimise(stream, core.screen(symptom))
    # What failed only in the company of other candidates, or stayed hidden in it, is seen here.
    stream = minimise(stream, core.test(symptom), Budget(**_ALONE))
    _check_by_linear_program(stream)
    right = core.right(stream.pairs[-1:], stream.margins[-1:])[0]
    return Counterexample(core.configuration, stream, symptom, core.answer(stream), right)


def _check_by_linear_program(stream: Stream) -> None:
    """Let the golden model judge the last pair too: shrinking asked the bulk checker alone."""
    pairs, margins = stream.pairs[-1:], stream.margins[-1:]
    if (judge_pairs(pairs, margins) != bulk_facts(pairs, margins).verdicts).any():
        raise CertificateError(f"bulk checker and golden model disagree on {stream.describe()}")
