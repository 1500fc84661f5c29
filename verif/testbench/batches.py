"""What the monitors publish: runs of beats seen on a stream, as arrays."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

Integers = npt.NDArray[np.integer[Any]]


@dataclass(frozen=True)
class PairBatch:
    """Pairs (N, 2, 3, 3) accepted by the core, at margins (N,).

    ``waits``: clocks that each was offered before it was accepted.
    """

    pairs: Integers
    margins: Integers
    tags: Integers
    waits: Integers

    def __len__(self) -> int:
        """Return the number of pairs."""
        return len(self.tags)

    def __getitem__(self, part: slice) -> "PairBatch":
        """Return a part."""
        return PairBatch(self.pairs[part], self.margins[part], self.tags[part], self.waits[part])


@dataclass(frozen=True)
class ResultBatch:
    """Results taken from the core. ``waits``: clocks that each was offered before it was taken."""

    words: npt.NDArray[np.uint16]
    tags: Integers
    waits: Integers

    def __len__(self) -> int:
        """Return the number of results."""
        return len(self.tags)

    def __getitem__(self, part: slice) -> "ResultBatch":
        """Return a part."""
        return ResultBatch(self.words[part], self.tags[part], self.waits[part])


@dataclass(frozen=True)
class ResetSeen:
    """The core was reset: what it held is gone."""
