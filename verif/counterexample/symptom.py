"""In what way an answer is wrong. A counterexample keeps its symptom while it shrinks."""

from enum import IntEnum

import numpy as np
import numpy.typing as npt

from triaxis.sim.result import AXIS_MASK, AXIS_SHIFT, COPLANAR, DEGENERATE_A, DEGENERATE_B, NEAR


class Symptom(IntEnum):
    """The worst that is wrong with an answer, worst first; RIGHT: nothing is."""

    RIGHT = 0
    MISSED = 1
    FALSE_ALARM = 2
    CLAIM = 3
    FLAGS = 4
    OTHER_BITS = 5
    INTERFACE = 6

    @property
    def word(self) -> str:
        """Return one word, for names."""
        return self.name.lower()

    @property
    def description(self) -> str:
        """Return what it means."""
        return _DESCRIPTIONS[self]


_DESCRIPTIONS = {
    Symptom.RIGHT: "is right",
    Symptom.MISSED: "says clear where the pair is near",
    Symptom.FALSE_ALARM: "says near where the pair is clear",
    Symptom.CLAIM: "claims another axis than the lowest-numbered one that separates",
    Symptom.FLAGS: "sets or misses a flag",
    Symptom.OTHER_BITS: "sets bits that must read 0",
    Symptom.INTERFACE: "hangs, or returns another pair's tag",
}
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
