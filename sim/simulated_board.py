"""The Verilated board, clock by clock: what goes over its serial line and what its pins say."""

import ctypes
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from triaxis.sim.board_parameters import BoardParameters
from triaxis.sim.models import board_build
from triaxis.sim.player import ASSERTION, SYMPTOMS, ZEROS, Player
from triaxis.sim.verilate import library

_DIGITS = 8
_CHUNK = 4096
# Lit segments (bit 0 a .. bit 6 g, bit 7 the point) as characters. 5 and S look the same: on the left, S.
_CHARACTERS = {
    0x00: " ", 0x3F: "0", 0x06: "1", 0x5B: "2", 0x4F: "3", 0x66: "4", 0x6D: "5", 0x7D: "6", 0x07: "7",
    0x7F: "8", 0x6F: "9", 0x40: "-", 0x79: "E", 0x50: "r", 0x5C: "o", 0x78: "t", 0x73: "P", 0x1C: "u",
    0x54: "n", 0x3D: "G",
}  # fmt: skip


# When `BoardPlayer.run` returns before its clocks are over, and what `events` are of: see board_player.cpp.
NEVER, SPOKEN, SETTLED = range(3)
RX, RX_BROKEN, BEGIN, TX, TX_BROKEN, PINS, BEAT, RESET, LIT = range(9)
EVENT = np.dtype([("clock", np.int64), ("kind", np.int32), ("value", np.int32)])


class Pins(ctypes.Structure):
    """The structure BoardPins of board_player.cpp."""

    _fields_ = (
        ("clocks", ctypes.c_int64),
        ("go_clocks", ctypes.c_int64),
        ("bad_clocks", ctypes.c_int64),
        ("bad_scans", ctypes.c_int64),
        ("framing_errors", ctypes.c_int64),
        ("beats", ctypes.c_int64),
        ("leds", ctypes.c_uint16),
        ("go", ctypes.c_uint8),
        ("stop", ctypes.c_uint8),
        ("segments", ctypes.c_uint8 * _DIGITS),
    )

    @property
    def digits(self) -> str:
        """Return what the eight digits show, left to right; ``?`` where it is no known character."""
        text = "".join(_CHARACTERS.get(segments, "?") for segments in reversed(list(self.segments)))
        return text[: _DIGITS // 2].replace("5", "S") + text[_DIGITS // 2 :]


@dataclass(frozen=True)
class BoardProgress:
    """How far a board is: its clocks since power-up, and what is wrong, if anything."""

    clock: int
    symptom: str
    asserted: bool


class BoardPlayer(Player):
    """A library of the board; time passes in `run` and `press` alone."""

    def __init__(self, library: Path, selected: int = 0, initial: int = ZEROS) -> None:
        """Load the library, and power a board up; see `Player`."""
        super().__init__(library, selected, initial)
        board, number, data = ctypes.c_void_p, ctypes.c_int64, ctypes.c_char_p
        signatures = {
            "run": (ctypes.c_int32, [board, number, ctypes.c_int32, ctypes.POINTER(number)]),
            "send": (None, [board, data, number]),
            "pending": (number, [board]),
            "receive": (number, [board, data, number]),
            "break": (None, [board, number]),
            "glitch": (None, [board, number]),
            "unplug": (None, [board]),
            "reset": (None, [board, number]),
            "pins": (None, [board, ctypes.POINTER(Pins)]),
            "note": (None, [board]),
            "noted": (number, [board]),
            "fetch": (None, [board, ctypes.c_void_p]),
        }
        for name, (result, arguments) in signatures.items():
            function = getattr(self.library, f"triaxis_{name}")
            function.restype, function.argtypes = result, arguments
        self.clocks = self.pins().clocks

    def run(self, clocks: int, until: int = SETTLED) -> BoardProgress:
        """Run so many clocks, less where what is asked for has happened."""
        done = ctypes.c_int64()
        symptom = SYMPTOMS[self.library.triaxis_run(self.model, clocks, until, ctypes.byref(done))]
        self.clocks += done.value
        return BoardProgress(self.clocks, "" if symptom == ASSERTION else symptom, symptom == ASSERTION)

    def send(self, data: bytes) -> None:
        """Queue bytes for the line to the board."""
        self.library.triaxis_send(self.model, data, len(data))

    @property
    def pending(self) -> int:
        """Return how many queued bytes are not yet wholly on the line."""
        return self.library.triaxis_pending(self.model)

    def receive(self) -> bytes:
        """Take all bytes that the board has sent since the last call."""
        received = bytearray()
        buffer = ctypes.create_string_buffer(_CHUNK)
        while count := self.library.triaxis_receive(self.model, buffer, _CHUNK):
            received += buffer.raw[:count]
        return bytes(received)

    def break_line(self, clocks: int) -> None:
        """Hold the line to the board low for the next clocks; bits sent meanwhile are lost."""
        self.library.triaxis_break(self.model, clocks)

    def glitch(self, clocks: int) -> None:
        """Invert the line to the board for the next clocks."""
        self.library.triaxis_glitch(self.model, clocks)

    def unplug(self) -> None:
        """Drop what is queued or half sent; the line to the board goes idle."""
        self.library.triaxis_unplug(self.model)

    def press(self, clocks: int) -> None:
        """Press the reset button for that many clocks, and let go."""
        self.library.triaxis_reset(self.model, clocks)
        self.clocks = self.pins().clocks

    def pins(self) -> Pins:
        """Return what the pins say, and have said."""
        pins = Pins()
        self.library.triaxis_pins(self.model, ctypes.byref(pins))
        return pins

    def note(self) -> None:
        """Have what is seen from here on noted."""
        self.library.triaxis_note(self.model)

    def events(self) -> npt.NDArray[np.void]:
        """Return what was noted since the last call, (N,): clock, kind and value."""
        events = np.zeros(self.library.triaxis_noted(self.model), EVENT)
        self.library.triaxis_fetch(self.model, ctypes.c_void_p(events.ctypes.data))
        return events


class SimulatedTop(BoardPlayer):
    """A board after power-up, built on first use; a clock is 10 ns."""

    def __init__(self, parameters: BoardParameters | None = None) -> None:
        """Build the board where needed, and power it up."""
        self.parameters = parameters or BoardParameters()
        super().__init__(library(board_build(self.parameters)))

    def __enter__(self) -> "SimulatedTop":
        """Return the board."""
        return self

    def __exit__(self, *_: object) -> None:
        """Free the board."""
        self.free()

    def step(self, clocks: int, until_event: bool = False) -> int:
        """Run that many clocks, and return how many were run.

        ``until_event``: stop early once the board has sent a byte or its go pin has changed.
        """
        before = self.clocks
        return self.run(clocks, SPOKEN if until_event else NEVER).clock - before

    @property
    def go(self) -> bool:
        """Return the level of the go pin."""
        return bool(self.pins().go)

    @property
    def stop(self) -> bool:
        """Return the level of the stop pin."""
        return bool(self.pins().stop)

    @property
    def go_clocks(self) -> int:
        """Return in how many clocks since power-up the go pin has said go."""
        return self.pins().go_clocks
