"""The sequences: what a test sends to the input agent."""

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt
from pyuvm import uvm_sequence

from triaxis.golden.pairs import Pairs
from triaxis.verif.agents.items import FULL_SPEED, BurstItem, Pace
from triaxis.verif.sequences.families import Family, random_margins
from triaxis.verif.settings import RunSettings

# Pairs in one item.
BURST = 1024


class ArraySequence(uvm_sequence):
    """Sends given pairs at given margins."""

    def __init__(self, pairs: Pairs, margins: npt.NDArray[np.int64], pace: Pace = FULL_SPEED) -> None:
        """Hold the arrays."""
        super().__init__("array")
        self.pairs, self.margins, self.pace = pairs, margins, pace

    def bursts(self) -> Iterator[BurstItem]:
        """Cut the arrays into items."""
        for start in range(0, len(self.pairs), BURST):
            chunk = slice(start, start + BURST)
            yield BurstItem(self.pairs[chunk], self.margins[chunk], self.pace)

    async def body(self) -> None:
        """Send the items."""
        for item in self.bursts():
            await self.start_item(item)
            await self.finish_item(item)


class FamilySequence(ArraySequence):
    """Sends pairs of a family, at random margins, made burst by burst."""

    def __init__(
        self,
        family: Family,
        settings: RunSettings,
        rng: np.random.Generator,
        count: int,
        pace: Pace = FULL_SPEED,
    ) -> None:
        """Make nothing yet."""
        super().__init__(np.empty((0, 2, 3, 3), np.int64), np.empty(0, np.int64), pace)
        self.family, self.settings, self.rng, self.count = family, settings, rng, count

    def bursts(self) -> Iterator[BurstItem]:
        """Make the items as they are wanted."""
        configuration = self.settings.configuration
        for start in range(0, self.count, BURST):
            count = min(BURST, self.count - start)
            pairs = self.family(self.rng, count, configuration.width)
            margins = random_margins(self.rng, pairs, configuration.max_margin)
            yield BurstItem(pairs, margins, self.pace)
