"""The agent of the board's line and pins: items go on the line, all that is seen is published.

The board is a library (sim/board_player.cpp): its serial line takes 57 clocks a byte, too many for Python to
have a step at each.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import Enum, auto
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from cocotb.triggers import Event
from pyuvm import uvm_analysis_port, uvm_driver, uvm_monitor, uvm_sequence_item

from triaxis.sim.simulated_board import PINS, TX, BoardPlayer, BoardProgress, Pins
from triaxis.verif.testbench.environment import StimulusAgent, bfm_of
from triaxis.verif.testbench.fast_model import FastModel

_END = 0xC0
_BUSY = 1 << 4
# A reply comes, and a run ends, within so many bits of the line, and those of the bytes that are sent, or the
# driver goes on; the scoreboard knows better.
_PATIENCE, _BYTE = 10_000, 10


class Until(Enum):
    """When an item is done: at once, when its bytes are on the line, a reply has come, no run goes on."""

    NOW = auto()
    SENT = auto()
    ANSWERED = auto()
    IDLE = auto()


class Act(Enum):
    """What else happens to the line, or the board, before an item's bytes, for some clocks."""

    NONE = auto()
    BREAK = auto()
    GLITCH = auto()
    UNPLUG = auto()
    RESET = auto()


class LineItem(uvm_sequence_item):
    """Bytes for the line; then it is waited, and then for ``gap`` clocks more.

    ``replies``: what the board said meanwhile, between ENDs; the driver's answer.
    """

    def __init__(
        self,
        data: bytes = b"",
        until: Until = Until.ANSWERED,
        gap: int = 0,
        act: Act = Act.NONE,
        clocks: int = 0,
    ) -> None:
        """Hold them."""
        super().__init__("line")
        self.data, self.until, self.gap, self.act, self.clocks = data, until, gap, act, clocks
        self.replies: list[bytes] = []


@dataclass(frozen=True)
class Seen:
    """What was seen until a clock, in order; and what the pins have said since power-up."""

    events: npt.NDArray[np.void]
    clock: int
    pins: Pins


@dataclass
class _Wait:
    until: Until
    end: int
    over: Event = field(default_factory=Event)


# The button is pressed for some clocks at once: `reset` is the board's own.
class BoardBfm(FastModel[BoardPlayer]):  # pyright: ignore[reportInvalidTypeArguments]
    """The board's model: it runs while someone waits for it."""

    def __init__(
        self, clocks_per_three_bits: int, make: Callable[[Path, int, int], Any] = BoardPlayer
    ) -> None:
        """Nobody is told of anything yet. ``make``: see `FastModel`; on pins, see pin_agents.py."""
        super().__init__(make)
        self._clocks_per_three_bits = clocks_per_three_bits
        self.publish: Any = None
        self._wait: _Wait | None = None
        self._heard = bytearray()
        self.replies: list[bytes] = []
        self._value = 0

    def open(self, library: Path, selected: int, initial: int) -> None:
        """Load the library, and note what is seen."""
        super().open(library, selected, initial)
        self.player.note()

    @property
    def busy(self) -> bool:
        """Return whether the driver waits."""
        return self._wait is not None

    async def _advance(self, clocks: int) -> None:
        if self._wait:
            clocks = min(clocks, max(1, self._wait.end - self.clock))
        await super()._advance(clocks)

    def follow(self, progress: BoardProgress) -> None:
        """Publish what was seen; tell the driver that what it waits for has come."""
        events = self.player.events()
        for value in events["value"][events["kind"] == TX].tolist():
            if value != _END:
                self._heard.append(value)
            elif self._heard:
                self.replies.append(bytes(self._heard))
                self._heard.clear()
        changes = events["value"][events["kind"] == PINS]
        if len(changes):
            self._value = int(changes[-1])
        self.publish(Seen(events, progress.clock, self.player.pins()))
        if self._wait and (self._over(self._wait.until) or self.clock >= self._wait.end):
            self._wait.over.set()
            self._wait = None

    def _over(self, until: Until) -> bool:
        if until is Until.ANSWERED:
            return bool(self.replies)
        return not self._value & _BUSY if until is Until.IDLE else not self.player.pending

    async def wait(self, until: Until, clocks: int) -> None:
        """Wait until something has come, or so many clocks are over."""
        if self._over(until):
            return
        self._wait = wait = _Wait(until, self.clock + clocks)
        self.wake()
        await wait.over.wait()

    async def reset(self, cycles: int) -> None:
        """Press the button for some clocks."""
        self.player.press(cycles)
        await self.clocks(1)

    async def drive(self, item: LineItem) -> None:
        """Do what an item says."""
        self.replies = []
        if item.act is Act.RESET:
            await self.reset(item.clocks)
        elif item.act is Act.UNPLUG:
            self.player.unplug()
        elif item.act is not Act.NONE:
            (self.player.break_line if item.act is Act.BREAK else self.player.glitch)(item.clocks)
        self.player.send(item.data)
        if item.until is not Until.NOW:
            await self.wait(
                item.until, self._clocks_per_three_bits * (_PATIENCE + _BYTE * len(item.data)) // 3
            )
        if item.gap:
            await self.clocks(item.gap)
        item.replies = self.replies


class LineDriver(uvm_driver):
    """Hands items to the model."""

    async def run_phase(self) -> None:
        """Drive items as they come."""
        bfm: BoardBfm = bfm_of(self)
        while True:
            item: LineItem = await self.seq_item_port.get_next_item()
            await bfm.drive(item)
            self.seq_item_port.item_done()


class LineMonitor(uvm_monitor):
    """Publishes what it is told by the model."""

    def build_phase(self) -> None:
        """Make the port, and ask to be told."""
        self.ap = uvm_analysis_port("ap", self)
        bfm_of(self).publish = lambda datum: self.ap.write(datum)


class LineAgent(StimulusAgent):
    """Both lines and all pins."""

    driver_kind, monitor_kind = LineDriver, LineMonitor
