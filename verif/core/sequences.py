"""The sequences: what a test sends to the input agent."""

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from itertools import islice

import numpy as np

from triaxis.sim.packing import WHICH_BITS, attempts_of
from triaxis.verif.core.items import FULL_SPEED, BurstItem, Integers, Pace
from triaxis.verif.core.stimulus.stimulus import Family, Stimulus, divided, joined
from triaxis.verif.testbench.environment import WORKER, ItemsSequence
from triaxis.verif.testbench.settings import PIN, RunSettings

# Pairs in one item, for each agent. The pin agent has a Python step for each pair anyway; the burst agent
# has a fixed cost an item, and the caches of the machine set the upper end.
_BURST_PAIRS, _PIN_PAIRS = 1 << 15, 1 << 10
# Items made ahead of the one that is sent.
_AHEAD = 2


def item_pairs(settings: RunSettings) -> int:
    """Return how many pairs go into an item."""
    return _PIN_PAIRS if settings.agent == PIN else _BURST_PAIRS


class ArraySequence(ItemsSequence):
    """Sends given pairs (N, 2, 3, 3) at given margins (N,)."""

    def __init__(
        self, settings: RunSettings, pairs: Integers, margins: Integers, gaps: Pace = FULL_SPEED
    ) -> None:
        """Hold the arrays."""
        super().__init__(self.bursts())
        self.settings, self.pairs, self.margins, self.gaps = settings, pairs, margins, gaps

    def bursts(self) -> Iterator[BurstItem]:
        """Cut the arrays into items."""
        step = item_pairs(self.settings)
        for start in range(0, len(self.pairs), step):
            chunk = slice(start, start + step)
            yield BurstItem(self.pairs[chunk], self.margins[chunk], self.gaps)


class StimulusSequence(ArraySequence):
    """Sends stimulus as it is made: the next items by the worker, while the present one is sent."""

    def __init__(
        self,
        make: Callable[[int], Stimulus],
        settings: RunSettings,
        count: int,
        gaps: Pace = FULL_SPEED,
    ) -> None:
        """Make nothing yet. ``make`` gives so many pairs with their margins; it is the sequence's own."""
        super().__init__(settings, np.empty((0, 2, 3, 3), np.int32), np.empty(0, np.int64), gaps)
        self.make, self.count = make, count

    def bursts(self) -> Iterator[BurstItem]:
        """Make the items as they are wanted."""
        step = item_pairs(self.settings)
        counts = (min(step, self.count - start) for start in range(0, self.count, step))
        ahead = deque(WORKER.submit(self.make, count) for count in islice(counts, _AHEAD))
        while ahead:
            made = ahead.popleft().result()
            ahead.extend(WORKER.submit(self.make, count) for count in islice(counts, 1))
            yield BurstItem(made.pairs, made.margins, self.gaps)


class AttemptsSequence(StimulusSequence):
    """Sends stimulus to a certified core, of which most pairs try one of its checks.

    ``rng`` draws what they try, and must not be that of ``make``, which runs in a thread of its own.
    """

    # Of so many pairs, those that try each kind, `Try` by number.
    shares = (2, 4, 1, 1)

    def __init__(
        self, make: Callable[[int], Stimulus], settings: RunSettings, count: int, rng: np.random.Generator
    ) -> None:
        """Make nothing yet."""
        super().__init__(make, settings, count)
        self.rng = rng

    def bursts(self) -> Iterator[BurstItem]:
        """Give each item what its pairs try."""
        kinds = np.repeat(np.arange(len(self.shares)), self.shares)
        for item in super().bursts():
            count, rng = len(item.pairs), self.rng
            item.attempts = attempts_of(rng.choice(kinds, count), rng.integers(0, 1 << WHICH_BITS, count))
            yield item


def of_families(
    families: Sequence[Family], settings: RunSettings, rng: np.random.Generator
) -> Callable[[int], Stimulus]:
    """Return the maker of stimulus of these families, in equal shares in each item."""
    configuration = settings.configuration

    def make(count: int) -> Stimulus:
        shares = divided(count, [1] * len(families))
        return joined(
            [
                family(rng, share, configuration.width, configuration.max_margin)
                for family, share in zip(families, shares, strict=True)
            ]
        )

    return make
