"""The board on its own pins, in the place of its library: the same interface, the same events and clocks.

A step of Python for each clock, as sim/board_player.cpp has one of C++: slow, and the way to a simulator of
four states, and to waves. The board's clock, too, is driven here: it stands still while Python decides.
"""

from collections import deque
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from cocotb.triggers import Timer

from triaxis.sim.board_parameters import BoardParameters
from triaxis.sim.player import PERIOD_NS
from triaxis.sim.simulated_board import (
    BEAT,
    BEGIN,
    EVENT,
    LIT,
    PINS,
    RESET,
    RX,
    RX_BROKEN,
    TX,
    TX_BROKEN,
    BoardProgress,
    Pins,
)
from triaxis.verif.board.line_agent import BoardBfm

_END = 0xC0
_BITS = 10
# The synchroniser of the reset, with room.
_RESET_CLOCKS = 16
_BUSY = 1 << 4
_DIGITS = 8
# Stop, by pin and LED; the line idle; nothing lit; the number 0.
_AT_POWER_UP = {
    "go_o": 0, "stop_o": 1, "beat_o": 0, "beyond_slow_o": 0, "beyond_warn_o": 0, "uart_tx_o": 1, "led_o": 2,
    "an_no": 0xFF, "seg_no": 0xC0,
}  # fmt: skip


class Sender:
    """Puts bytes on the board's line: 8N1, lowest bit first."""

    def __init__(self, clocks_per_three_bits: int) -> None:
        """Start with an idle line."""
        self.queue: deque[int] = deque()
        self._clocks_per_three_bits = clocks_per_three_bits
        self.unplug()

    def unplug(self) -> None:
        """Drop all; the line goes idle."""
        self.queue = deque()
        # Thirds of clocks left of the bit on the line; less than a clock is the next bit's.
        self._frame, self._bits, self._thirds, self._level = 0, 0, 0, 1

    @property
    def under_way(self) -> bool:
        """Return whether a byte is on the line."""
        return self._bits > 0 or self._thirds >= 3

    @property
    def idle(self) -> bool:
        """Return whether there is nothing to send."""
        return not self.queue and not self.under_way

    def next(self) -> int:
        """Return the level of the next clock."""
        if self._thirds < 3:
            if not self._bits and self.queue:
                self._frame, self._bits = self.queue.popleft() << 1 | 1 << 9, _BITS
            if self._bits:
                self._level, self._frame = self._frame & 1, self._frame >> 1
                self._bits -= 1
                self._thirds += self._clocks_per_three_bits
            else:
                self._level, self._thirds = 1, 0
        if self._thirds >= 3:
            self._thirds -= 3
        return self._level


_START, _IDLE, _LOW = -1, -2, -3
_NOTHING, _STARTED, _BYTE, _BROKEN = range(4)


class Receiver:
    """Reads bytes from a line, each bit in its middle.

    A low level that is gone by the middle of the start bit starts nothing; a byte without a stop bit is
    broken, once for however long the line stays low.
    """

    def __init__(self, clocks_per_three_bits: int) -> None:
        """Start at an idle line."""
        self._clocks_per_three_bits = clocks_per_three_bits
        self.reset()

    def reset(self) -> None:
        """Forget a byte under way."""
        self._bit, self._clocks, self.byte = _IDLE, 0, 0

    def take(self, level: int) -> int:
        """Take the level of a clock; return what came of it."""
        if self._bit == _IDLE:
            if not level:
                self._bit, self._clocks = _START, 0
            return _NOTHING
        if self._bit == _LOW:
            if level:
                self._bit = _IDLE
            return _NOTHING
        self._clocks += 1
        if self._clocks < (2 * (self._bit + 1) + 1) * self._clocks_per_three_bits // 6:
            return _NOTHING
        if self._bit == _START:
            self._bit = _IDLE if level else 0
            return _NOTHING if level else _STARTED
        if self._bit < 8:
            self.byte = self.byte >> 1 | (0x80 if level else 0)
            self._bit += 1
            return _NOTHING
        self._bit = _IDLE if level else _LOW
        return _BYTE if level else _BROKEN


class PinPlayer:
    """The pins as `BoardPlayer` has the library; `run` alone takes time, and presses the button too."""

    def __init__(self, dut: Any, parameters: BoardParameters) -> None:
        """Take hold of the pins; the first `run` powers the board up."""
        self._dut = dut
        self._digit_clocks = parameters.digit_clocks
        self._sender = Sender(parameters.clocks_per_three_bits)
        self._to_board = Receiver(parameters.clocks_per_three_bits)
        self._from_board = Receiver(parameters.clocks_per_three_bits)
        self._half = Timer(PERIOD_NS // 2, "ns")
        self._events: list[tuple[int, int, int]] = []
        self._powered = False
        self._presses: list[int] = []
        self._broken = self._inverted = 0
        self._watched = [(name, getattr(dut, name), value) for name, value in _AT_POWER_UP.items()]
        self._values = dict(_AT_POWER_UP)
        self._pins = Pins()
        self._seen, self._beat = 0b1010, 0
        self._level, self._up = 1, True
        self._settled = self._in_frame = self._in_body = self._first = False
        self._digit, self._left = -1, 0
        dut.clk_100mhz_i.value, dut.cpu_reset_ni.value, dut.uart_rx_i.value = 0, 1, 1

    async def run(self, clocks: int) -> BoardProgress:
        """Run so many clocks, less where a frame or a run has ended, or all is on the line."""
        if not self._powered:
            self._powered = True
            for _ in range(_RESET_CLOCKS):
                await self._clock()
            self._events.clear()
        while self._presses:
            await self._press(self._presses.pop(0))
        for _ in range(clocks):
            await self._clock()
            if self._settled:
                break
        return BoardProgress(self._pins.clocks, "", asserted=False)

    def note(self) -> None:
        """All is noted from the end of power-up on."""

    def send(self, data: bytes) -> None:
        """Queue bytes for the line to the board."""
        self._sender.queue.extend(data)

    @property
    def pending(self) -> int:
        """Return how many queued bytes are not yet wholly on the line."""
        return len(self._sender.queue) + self._sender.under_way

    def break_line(self, clocks: int) -> None:
        """Hold the line to the board low for the next clocks; bits sent meanwhile are lost."""
        self._broken = clocks

    def glitch(self, clocks: int) -> None:
        """Invert the line to the board for the next clocks."""
        self._inverted = clocks

    def unplug(self) -> None:
        """Drop what is queued or half sent; the line to the board goes idle."""
        self._sender.unplug()

    def press(self, clocks: int) -> None:
        """Press the reset button for that many clocks, and let go, before the next clock of `run`."""
        self._presses.append(clocks)

    def pins(self) -> Pins:
        """Return what the pins say, and have said."""
        pins = Pins.from_buffer_copy(self._pins)
        values = self._values
        pins.leds, pins.go, pins.stop = values["led_o"], values["go_o"], values["stop_o"]
        return pins

    def events(self) -> npt.NDArray[np.void]:
        """Return what was noted since the last call, (N,): clock, kind and value."""
        events = np.array(self._events, EVENT)
        self._events.clear()
        return events

    def write_coverage(self, file: Path) -> None:
        """Write nothing: a program for cocotb has no counters."""

    # --- Clocks -------------------------------------------------------------------------------------------

    async def _press(self, clocks: int) -> None:
        """Press the button between two edges, and let go between two; the line is idle, queued bytes wait."""
        waiting = self._sender.queue
        self._sender.unplug()
        await self._button(up=False)
        for _ in range(clocks):
            await self._clock()
        await self._button(up=True)
        for _ in range(_RESET_CLOCKS):
            await self._clock()
        self._sender.queue = waiting

    async def _button(self, *, up: bool) -> None:
        self._dut.cpu_reset_ni.value = self._up = up
        await Timer(1, "ns")
        self._look()
        self._tell(RESET, not up)
        if not up:
            self._to_board.reset()
            self._from_board.reset()
        self._in_frame = False
        self._digit, self._left = -1, 0
        self._note()

    async def _clock(self) -> None:
        self._settled = False
        was_idle = self._sender.idle
        level = self._sender.next()
        if self._inverted:
            self._inverted -= 1
            level ^= 1
        if self._broken:
            self._broken -= 1
            level = 0
        dut = self._dut
        if level != self._level:
            dut.uart_rx_i.value = self._level = level
        # The line settles before the edge, and what follows the edge before it is looked at.
        await self._half
        dut.clk_100mhz_i.value = 1
        await self._half
        self._look()
        dut.clk_100mhz_i.value = 0
        self._pins.clocks += 1
        self._pins.go_clocks += self._values["go_o"]
        self._settled = not was_idle and self._sender.idle
        if self._up:
            seen = self._to_board.take(level)
            if seen == _BYTE:
                self._tell(RX, self._to_board.byte)
            elif seen == _BROKEN:
                self._tell(RX_BROKEN, 0)
            self._listen(self._from_board.take(self._values["uart_tx_o"]))
        self._scan()
        self._note()

    def _look(self) -> None:
        """Read the pins. One that is unknown is as at power-up: the monitor of unknown values tells of it."""
        values = self._values
        for name, handle, at_power_up in self._watched:
            value = handle.value
            values[name] = int(value) if value.is_resolvable else at_power_up

    def _listen(self, seen: int) -> None:
        if seen == _STARTED and not self._in_frame:
            self._in_frame, self._in_body = True, False
            self._tell(BEGIN, 0)
        elif seen == _BYTE:
            byte = self._from_board.byte
            self._tell(TX, byte)
            if self._in_body and byte == _END:
                self._settled, self._in_frame = True, False
            self._in_body = byte != _END
        elif seen == _BROKEN:
            self._pins.framing_errors += 1
            self._tell(TX_BROKEN, 0)

    def _scan(self) -> None:
        """Exactly one digit is lit, the next one to the left after so many clocks; none before the first."""
        lit, pins = self._values["an_no"] ^ 0xFF, self._pins
        if not lit:
            pins.bad_scans += self._digit >= 0
            return
        for digit in range(_DIGITS):
            if lit >> digit & 1:
                pins.segments[digit] = self._values["seg_no"] ^ 0xFF
        if lit == 1 << max(self._digit, 0) and self._left > 0:
            self._left -= 1
            pins.bad_scans += self._first
            return
        after = (self._digit + 1) % _DIGITS
        # The first digit after a reset is passed over in a clock.
        pins.bad_scans += lit != 1 << after or (self._left > 0 and not self._first)
        self._first = self._digit < 0
        if self._first:
            self._tell(LIT, 0)
        self._digit, self._left = after, self._digit_clocks - 1

    def _note(self) -> None:
        values = self._values
        beyond = values["beyond_warn_o"] << 1 | values["beyond_slow_o"]
        seen = beyond << 18 | values["led_o"] << 2 | values["stop_o"] << 1 | values["go_o"]
        if seen != self._seen:
            # A run has ended.
            self._settled |= bool(self._seen & ~seen & _BUSY)
            self._seen = seen
            self._tell(PINS, seen)
        if values["beat_o"] != self._beat:
            self._beat = values["beat_o"]
            self._pins.beats += 1
            self._tell(BEAT, self._beat)
        self._pins.bad_clocks += values["go_o"] == values["stop_o"]

    def _tell(self, kind: int, value: int) -> None:
        self._events.append((self._pins.clocks, kind, value))


class PinBoardBfm(BoardBfm):
    """The board's model on its pins: drivers and monitors see no difference."""

    def __init__(self, dut: Any, parameters: BoardParameters) -> None:
        """Hold the pins."""
        super().__init__(parameters.clocks_per_three_bits, lambda *_: PinPlayer(dut, parameters))

    async def progress(self, clocks: int) -> BoardProgress:
        """Run for so many clocks at most."""
        player: Any = self.player
        return await player.run(clocks)
