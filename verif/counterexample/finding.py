"""From a pair that failed in a simulation to a small counterexample of the bare core, whole or broken."""

from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path

import numpy as np
import numpy.typing as npt

from triaxis.golden.axes import axis_name
from triaxis.golden.bulk import bulk_facts
from triaxis.golden.judge import CertificateError, judge_pairs
from triaxis.golden.pairs import Pairs
from triaxis.sim.configuration import Configuration
from triaxis.sim.core_engine import CoreError, RtlEngine
from triaxis.sim.paths import DUT
from triaxis.sim.result import AXIS_MASK, AXIS_SHIFT, COPLANAR, DEGENERATE_A, DEGENERATE_B, NEAR
from triaxis.verif.core.expectation import expected_words
from triaxis.verif.core.failing_pairs import FailingPair, Stream
from triaxis.verif.counterexample.shrinking import Budget, StreamPredicate, minimise


class Symptom(IntEnum):
    """The worst that is wrong with an answer, worst first; RIGHT: nothing is."""

    description: str

    def __new__(cls, number: int, description: str) -> "Symptom":
        """Make a number with what it means."""
        made = int.__new__(cls, number)
        made._value_, made.description = number, description
        return made

    RIGHT = 0, "is right"
    MISSED = 1, "says clear where the pair is near"
    FALSE_ALARM = 2, "says near where the pair is clear"
    CLAIM = 3, "claims another axis than the lowest-numbered one that separates"
    FLAGS = 4, "sets or misses a flag"
    OTHER_BITS = 5, "sets bits that must read 0"
    INTERFACE = 6, "hangs, or returns another pair's tag"


_FLAGS = COPLANAR | DEGENERATE_A | DEGENERATE_B


def symptoms(words: npt.NDArray[np.uint16], right: npt.NDArray[np.uint16]) -> npt.NDArray[np.uint8]:
    """Return the `Symptom` of each result word (N,), given the word that the core must answer (N,)."""
    wrong = words ^ right
    near_wrong, near = (wrong & NEAR) != 0, (right & NEAR) != 0
    return np.select(
        [
            wrong == 0,
            near_wrong & near,
            near_wrong,
            ~near & ((wrong & (AXIS_MASK << AXIS_SHIFT)) != 0),
            (wrong & _FLAGS) != 0,
        ],
        [Symptom.RIGHT, Symptom.MISSED, Symptom.FALSE_ALARM, Symptom.CLAIM, Symptom.FLAGS],
        Symptom.OTHER_BITS,
    ).astype(np.uint8)


class BareCore:
    """The core built from a folder of RTL, in one configuration; every run starts with a fresh one.

    Pairs are sent one per clock, without stalls: what only stalls or resets bring out does not fail here.
    """

    def __init__(self, configuration: Configuration, dut: Path = DUT) -> None:
        """Build it where needed."""
        self.configuration = configuration
        self._engine = RtlEngine(configuration, dut=dut)

    def answer(self, stream: Stream) -> np.uint16 | str:
        """Return a fresh core's result word for the last pair, or how the core broke its interface."""
        try:
            return self._engine.words(stream.pairs, stream.margins)[0][-1]
        except CoreError as error:
            return str(error)

    def right(self, pairs: Pairs, margins: npt.NDArray[np.int64]) -> npt.NDArray[np.uint16]:
        """Return the words that the core must answer to pairs (N, 2, 3, 3) at margins (N,)."""
        return expected_words(bulk_facts(pairs, margins), self.configuration)

    def symptoms_alone(self, pairs: Pairs, margins: npt.NDArray[np.int64]) -> npt.NDArray[np.uint8]:
        """Return the symptom of the last pair of each stream, a fresh core for each.

        Streams have pairs (N, K, 2, 3, 3) and margins (N, K).
        """
        answers = [self.answer(Stream(p, m)) for p, m in zip(pairs, margins, strict=True)]
        broken = np.array([isinstance(answer, str) for answer in answers], np.bool_)
        words = np.array([0 if isinstance(answer, str) else answer for answer in answers], np.uint16)
        found = symptoms(words, self.right(pairs[:, -1], margins[:, -1]))
        return np.where(broken, np.uint8(Symptom.INTERFACE), found)

    def symptoms_together(self, pairs: Pairs, margins: npt.NDArray[np.int64]) -> npt.NDArray[np.uint8]:
        """Do as `symptoms_alone`, but send all streams to one core: some ten times as fast.

        An answer may be disturbed by the stream before it. Where the core breaks its interface, the
        streams are halved until it does no more, or has one stream to answer for.
        """
        if len(pairs) < 2:
            return self.symptoms_alone(pairs, margins)
        length, half = pairs.shape[1], len(pairs) // 2
        try:
            words = self._engine.words(pairs.reshape(-1, 2, 3, 3), margins.reshape(-1))[0]
        except CoreError:
            halves = (slice(0, half), slice(half, None))
            return np.concatenate([self.symptoms_together(pairs[h], margins[h]) for h in halves])
        return symptoms(words[length - 1 :: length], self.right(pairs[:, -1], margins[:, -1]))

    def symptom(self, stream: Stream) -> Symptom:
        """Return the symptom of one stream."""
        return Symptom(int(self.symptoms_alone(stream.pairs[None], stream.margins[None])[0]))

    def screen(self, symptom: Symptom) -> StreamPredicate:
        """Return a fast predicate: a stream has this symptom, as far as one core for all can tell."""
        return lambda pairs, margins: self.symptoms_together(pairs, margins) == symptom

    def test(self, symptom: Symptom) -> StreamPredicate:
        """Return the exact predicate: a stream has this symptom in a fresh core."""
        return lambda pairs, margins: self.symptoms_alone(pairs, margins) == symptom


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
