"""What the monitors publish: runs of beats seen on a stream, as arrays."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from triaxis.golden.pairs import Pairs


@dataclass(frozen=True)
class PairBatch:
    """Pairs accepted by the core. ``waits``: clocks that each was offered before it was accepted."""

    pairs: Pairs
    margins: npt.NDArray[np.int64]
    tags: npt.NDArray[np.int64]
    waits: npt.NDArray[np.int64]

    def __len__(self) -> int:
        """Return the number of pairs."""
        return len(self.tags)


@dataclass(frozen=True)
class ResultBatch:
    """Results taken from the core. ``waits``: clocks that each was offered before it was taken."""

    words: npt.NDArray[np.uint16]
    tags: npt.NDArray[np.int64]
    waits: npt.NDArray[np.int64]

    def __len__(self) -> int:
        """Return the number of results."""
        return len(self.tags)


@dataclass(frozen=True)
class ResetSeen:
    """The core was reset: what it held is gone."""
