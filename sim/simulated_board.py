"""The Verilated board, clock by clock: what goes over its serial line and what its pins say."""

import ctypes
from pathlib import Path

from triaxis.sim.board_parameters import BoardParameters
from triaxis.sim.models import board_build
from triaxis.sim.paths import DUT
from triaxis.sim.verilate import library

_DIGITS = 8
_CHUNK = 4096
# Lit segments (bit 0 a .. bit 6 g) as characters. 5 and S look the same: on the left it is S.
_CHARACTERS = {
    0x00: " ", 0x3F: "0", 0x06: "1", 0x5B: "2", 0x4F: "3", 0x66: "4", 0x6D: "5", 0x7D: "6", 0x07: "7",
    0x7F: "8", 0x6F: "9", 0x40: "-", 0x79: "E", 0x50: "r", 0x5C: "o", 0x78: "t", 0x73: "P", 0x1C: "u",
    0x54: "n", 0x3D: "G",
}  # fmt: skip


class _Pins(ctypes.Structure):
    """The structure BoardPins of board_player.cpp."""

    _fields_ = (
        ("clocks", ctypes.c_int64),
        ("go_clocks", ctypes.c_int64),
        ("bad_clocks", ctypes.c_int64),
        ("framing_errors", ctypes.c_int64),
        ("beats", ctypes.c_int64),
        ("leds", ctypes.c_uint16),
        ("go", ctypes.c_uint8),
        ("stop", ctypes.c_uint8),
        ("segments", ctypes.c_uint8 * _DIGITS),
    )


def _interface(path: Path) -> ctypes.CDLL:
    """Return the loaded library with the types of board_player.cpp's functions."""
    loaded = ctypes.CDLL(str(path))
    board, number, data = ctypes.c_void_p, ctypes.c_int64, ctypes.c_char_p
    signatures = {
        "new": (board, []),
        "delete": (None, [board]),
        "step": (number, [board, number, ctypes.c_int]),
        "send": (None, [board, data, number]),
        "pending": (number, [board]),
        "receive": (number, [board, data, number]),
        "break": (None, [board, number]),
        "glitch": (None, [board, number]),
        "unplug": (None, [board]),
        "reset": (None, [board, number]),
        "pins": (None, [board, ctypes.POINTER(_Pins)]),
    }
    for name, (result, arguments) in signatures.items():
        function = getattr(loaded, f"board_{name}")
        function.restype, function.argtypes = result, arguments
    return loaded


class SimulatedTop:
    """A board after power-up, built on first use. Time passes in `step` alone; a clock is 10 ns."""

    def __init__(self, parameters: BoardParameters | None = None, rtl: Path = DUT / "board") -> None:
        """Build the board where needed, and power it up. ``rtl``: another folder with the board's files."""
        self.parameters = parameters or BoardParameters()
        self._functions = _interface(library(board_build(self.parameters, rtl)))
        self._board = ctypes.c_void_p(self._functions.board_new())

    def close(self) -> None:
        """Free the board; it cannot be used afterwards."""
        if self._board:
            self._functions.board_delete(self._board)
            self._board = ctypes.c_void_p()

    def __enter__(self) -> "SimulatedTop":
        """Return the board."""
        return self

    def __exit__(self, *_: object) -> None:
        """Free the board."""
        self.close()

    def __del__(self) -> None:
        """Free the board."""
        # Absent where the build failed.
        if hasattr(self, "_board"):
            self.close()

    def step(self, clocks: int, until_event: bool = False) -> int:
        """Run that many clocks, and return how many were run.

        ``until_event``: stop early once the board has sent a byte or its go pin has changed.
        """
        return self._functions.board_step(self._board, clocks, int(until_event))

    def send(self, data: bytes) -> None:
        """Queue bytes for the line to the board."""
        self._functions.board_send(self._board, data, len(data))

    @property
    def pending(self) -> int:
        """Return how many queued bytes are not yet wholly on the line."""
        return self._functions.board_pending(self._board)

    def receive(self) -> bytes:
        """Take all bytes that the board has sent since the last call."""
        received = bytearray()
        buffer = ctypes.create_string_buffer(_CHUNK)
        while count := self._functions.board_receive(self._board, buffer, _CHUNK):
            received += buffer.raw[:count]
        return bytes(received)

    def break_line(self, clocks: int) -> None:
        """Hold the line to the board low for the next clocks; bits sent meanwhile are lost."""
        self._functions.board_break(self._board, clocks)

    def glitch(self, clocks: int) -> None:
        """Invert the line to the board for the next clocks."""
        self._functions.board_glitch(self._board, clocks)

    def unplug(self) -> None:
        """Drop what is queued or half sent; the line to the board goes idle."""
        self._functions.board_unplug(self._board)

    def reset(self, clocks: int = 16) -> None:
        """Press the reset button for that many clocks, and let go."""
        self._functions.board_reset(self._board, clocks)

    def _pins(self) -> _Pins:
        pins = _Pins()
        self._functions.board_pins(self._board, ctypes.byref(pins))
        return pins

    @property
    def clocks(self) -> int:
        """Return the clocks since power-up."""
        return self._pins().clocks

    @property
    def go(self) -> bool:
        """Return the level of the go pin."""
        return bool(self._pins().go)

    @property
    def stop(self) -> bool:
        """Return the level of the stop pin."""
        return bool(self._pins().stop)

    @property
    def go_clocks(self) -> int:
        """Return in how many clocks since power-up the go pin has said go."""
        return self._pins().go_clocks

    @property
    def bad_clocks(self) -> int:
        """Return in how many clocks since power-up the go and stop pins were not opposite."""
        return self._pins().bad_clocks

    @property
    def beats(self) -> int:
        """Return how many edges the beat pin has made since power-up."""
        return self._pins().beats

    @property
    def framing_errors(self) -> int:
        """Return how many bytes from the board had no stop bit."""
        return self._pins().framing_errors

    @property
    def leds(self) -> int:
        """Return the 16 LEDs, bit 0 the rightmost."""
        return self._pins().leds

    @property
    def digits(self) -> str:
        """Return what the eight digits show, left to right; ``?`` where it is no known character."""
        shown = [segments & 0x7F for segments in self._pins().segments]
        text = "".join(_CHARACTERS.get(segments, "?") for segments in reversed(shown))
        return text[: _DIGITS // 2].replace("5", "S") + text[_DIGITS // 2 :]
