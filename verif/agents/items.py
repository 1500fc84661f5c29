"""The sequence item: a burst of pairs with the pace at which they are offered."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from pyuvm import uvm_sequence_item

from triaxis.golden.pairs import Pairs


@dataclass(frozen=True)
class Pace:
    """Cycles on and off, alternating, drawn anew each time from 1..on and 0..off at random.

    ``off`` = 0: never a pause.
    """

    on: int = 1
    off: int = 0


FULL_SPEED = Pace()


class BurstItem(uvm_sequence_item):
    """Pairs (N, 2, 3, 3) at margins (N,), offered at a pace."""

    def __init__(
        self,
        pairs: Pairs,
        margins: npt.NDArray[np.int64],
        pace: Pace = FULL_SPEED,
        name: str = "burst",
    ) -> None:
        """Hold the arrays; the driver gives the tags."""
        super().__init__(name)
        self.pairs = pairs
        self.margins = margins
        self.pace = pace
