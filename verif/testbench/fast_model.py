"""The bus-functional model of a library in the place of the pins: what all of them share, above all time."""

from collections.abc import Callable
from heapq import heappop, heappush
from itertools import count
from pathlib import Path
from typing import Any, Generic, Protocol, TypeVar

import cocotb
from cocotb.triggers import Event, Timer

from triaxis.sim.player import ASSERTION
from triaxis.verif.testbench.failures import HungError, report_failure

# Clocks after which a model returns in any case.
_MOST_CLOCKS = 1 << 30


class Progress(Protocol):
    """How far a model is."""

    @property
    def clock(self) -> int:
        """All clocks so far."""
        ...

    @property
    def asserted(self) -> bool:
        """Whether an assertion has failed."""
        ...

    @property
    def symptom(self) -> str:
        """What else is wrong; "" where nothing is."""
        ...


class SteppedPlayer(Protocol):
    """A model in steps of clocks."""

    def run(self, clocks: int) -> Progress:
        """Run for so many clocks at most, or until there is something to be said."""
        ...

    def set_reset(self, active: bool) -> None:
        """Assert reset, or release it, between two edges."""
        ...

    def write_coverage(self, file: Path) -> None:
        """Write what its build has counted."""
        ...


PlayerT = TypeVar("PlayerT", bound=SteppedPlayer)


class FastModel(Generic[PlayerT]):
    """The one that knows the library; drivers and monitors know only this.

    Its clock runs while it is busy or someone waits for it, up to the next moment that someone has asked for,
    and stands still while Python decides what comes next.
    """

    player: PlayerT

    def __init__(self, make: Callable[[Path, int, int], PlayerT]) -> None:
        """Nobody waits yet. ``make``: from a library, the number of the mutant in it, a seed."""
        self._make = make
        self._due: list[tuple[int, int, Event]] = []
        self._numbers = count()
        self._wanted = Event()
        self._asserted = False
        self.clock = 0

    def open(self, library: Path, selected: int, initial: int) -> None:
        """Load the library, and let it run."""
        self.player = self._make(library, selected, initial)
        cocotb.start_soon(self._run())

    @property
    def busy(self) -> bool:
        """Return whether something goes on that is waited for."""
        raise NotImplementedError

    def follow(self, progress: Any) -> None:
        """Tell monitors what was seen, and drivers what is over."""
        raise NotImplementedError

    def wake(self) -> None:
        """Let the clock run: there is something to do."""
        self._wanted.set()

    async def _run(self) -> None:
        while True:
            # Whoever can go on does so at this very clock.
            await Timer(1, "ns")
            if not self.busy and not self._due:
                self._wanted.clear()
                await self._wanted.wait()
                continue
            await self._advance(self._due[0][0] - self.clock if self._due else _MOST_CLOCKS)

    async def progress(self, clocks: int) -> Progress:
        """Run the model for so many clocks at most; on pins that takes time of the simulator."""
        return self.player.run(clocks)

    async def _advance(self, clocks: int) -> None:
        """Run until something is due; tell those who wait for it."""
        progress = await self.progress(clocks)
        self.clock = progress.clock
        if progress.asserted and not self._asserted:
            self._asserted = True
            report_failure(ASSERTION)
        if progress.symptom:
            report_failure(progress.symptom)
            raise HungError(f"what is under test {progress.symptom}")
        self.follow(progress)
        while self._due and self._due[0][0] <= self.clock:
            heappop(self._due)[2].set()

    async def clocks(self, count: int) -> None:
        """Wait for some clocks."""
        come = Event()
        heappush(self._due, (self.clock + count, next(self._numbers), come))
        self.wake()
        await come.wait()

    async def reset(self, cycles: int) -> None:
        """Hold what is under test in reset for some clocks."""
        self.player.set_reset(True)
        await self.clocks(cycles)
        self.player.set_reset(False)
        await self.clocks(1)

    def close(self, counters: Path) -> None:
        """Write what the library's build has counted; raise AssertionError where an assertion has failed."""
        self.player.write_coverage(counters)
        if self._asserted:
            raise AssertionError("an assertion failed")
