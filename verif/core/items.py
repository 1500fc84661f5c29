"""What is sent, and what the monitors publish: bursts of pairs with their paces, runs of beats as arrays."""

from dataclasses import dataclass
from random import Random
from typing import Any

import numpy as np
import numpy.typing as npt
from pyuvm import uvm_sequence_item


@dataclass(frozen=True)
class Pace:
    """Cycles on and off, alternating, drawn anew each time from 1..on and 0..off at random.

    ``off`` = 0: never a pause.
    """

    on: int = 1
    off: int = 0

    @property
    def duty(self) -> float:
        """Return the mean share of the cycles that are on."""
        return 1.0 if not self.off else (self.on + 1) / (self.on + 1 + self.off)

    def draw(self, random: Random) -> tuple[int, int]:
        """Return cycles on and off, the next ones."""
        return random.randint(1, self.on), random.randint(0, self.off)

    def runs(self, rng: np.random.Generator, count: int) -> npt.NDArray[np.uint16]:
        """Return ``count`` runs on and off, alternating: (2 count,); empty where there is no pause."""
        if not self.off:
            return np.zeros(0, np.uint16)
        runs = np.stack([rng.integers(1, self.on + 1, count), rng.integers(0, self.off + 1, count)], 1)
        return runs.astype(np.uint16).ravel()


@dataclass(frozen=True)
class Steady(Pace):
    """So many cycles on and off, always the same."""

    def draw(self, random: Random) -> tuple[int, int]:
        """Return cycles on and off."""
        return self.on, self.off

    def runs(self, rng: np.random.Generator, count: int) -> npt.NDArray[np.uint16]:
        """Return them once: they are used over and over."""
        return np.array([self.on, self.off], np.uint16)


@dataclass(frozen=True)
class Once(Steady):
    """So many cycles on and then off, once; on from then on, for longer than any test of clocks.

    For bursts: on the pins, where each pause is drawn by itself, it is as `Steady`.
    """

    def runs(self, rng: np.random.Generator, count: int) -> npt.NDArray[np.uint16]:
        """Return them, and as many cycles on as can be said."""
        return np.array([self.on, self.off, np.iinfo(np.uint16).max, 1], np.uint16)


FULL_SPEED = Pace()


class BurstItem(uvm_sequence_item):
    """Pairs (N, 2, 3, 3) at margins (N,), offered with gaps.

    ``stalls``: the pace at which results are taken from then on; None leaves it as it is. ``attempts``
    (N,): what each pair tries of a certified core, see `triaxis.sim.packing.Try`; None: nothing.
    """

    def __init__(
        self,
        pairs: npt.NDArray[np.integer[Any]],
        margins: npt.NDArray[np.integer[Any]],
        gaps: Pace = FULL_SPEED,
        stalls: Pace | None = None,
        attempts: npt.NDArray[np.integer[Any]] | None = None,
    ) -> None:
        """Hold the arrays."""
        super().__init__("burst")
        self.pairs = pairs
        self.margins = margins
        self.gaps = gaps
        self.stalls = stalls
        self.attempts = attempts


Integers = npt.NDArray[np.integer[Any]]


@dataclass(frozen=True)
class PairBatch:
    """Pairs (N, 2, 3, 3) accepted by the core, at margins (N,).

    ``tags``: with what the pair tries above them. ``waits``: clocks that each was offered before it was
    accepted.
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
    """Results taken from the core. ``waits``: clocks that each was offered before it was taken.

    ``clocks``: the clock at which each was taken, the first of the run being 0.
    """

    words: npt.NDArray[np.uint16]
    tags: Integers
    waits: Integers
    clocks: Integers

    def __len__(self) -> int:
        """Return the number of results."""
        return len(self.tags)

    def __getitem__(self, part: slice) -> "ResultBatch":
        """Return a part."""
        return ResultBatch(self.words[part], self.tags[part], self.waits[part], self.clocks[part])


@dataclass(frozen=True)
class ResetSeen:
    """The core was reset: what it held is gone."""
