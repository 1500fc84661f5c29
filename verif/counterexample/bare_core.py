"""The bare core, whole or broken, as a predicate on streams."""

from pathlib import Path

import numpy as np
import numpy.typing as npt

from triaxis.golden.bulk import bulk_facts
from triaxis.golden.pairs import Pairs
from triaxis.sim.configuration import Configuration
from triaxis.sim.core_engine import CoreError, RtlEngine
from triaxis.sim.paths import DUT
from triaxis.verif.core.expectation import expected_words
from triaxis.verif.core.stream import Stream
from triaxis.verif.counterexample.minimising import StreamPredicate
from triaxis.verif.counterexample.symptom import Symptom, symptoms


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
