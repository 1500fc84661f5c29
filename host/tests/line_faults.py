"""Serial lines: one that damages, loses, repeats, reorders, delays and makes up frames; and a patient one."""

import time
from dataclasses import dataclass, field

import numpy as np

from triaxis.host.link.wire import END

_BOUNDARY = bytes([END])
# Kept to be repeated later, from this session or an earlier one.
_REMEMBERED = 20


# Looks at the line in which an answer has long come, and those after them that last a second together.
_ANSWERED, _PATIENT = 40, 40


def patient(top):
    """Return a line on which the board's clock waits for a host that gets no core.

    A second until go ends, and a second between two frames: the watchdog's time would be over.
    """
    quiet = 0

    def to_board(data: bytes) -> bytes:
        nonlocal quiet
        quiet = 0 if data or top.pending else quiet + 1
        if top.go and not data:
            time.sleep(0.005)
        elif _ANSWERED < quiet <= _ANSWERED + _PATIENT:
            time.sleep(1 / _PATIENT)
        return data

    return to_board


class _Frames:
    """One direction of the line: called with the bytes that enter it, it returns those that leave."""

    def __init__(self) -> None:
        self._partial = b""

    def __call__(self, data: bytes) -> bytes:
        *frames, self._partial = (self._partial + data).split(_BOUNDARY)
        return b"".join(self.through(_BOUNDARY + frame + _BOUNDARY) for frame in frames if frame)

    def through(self, frame: bytes) -> bytes:
        raise NotImplementedError


@dataclass
class LineFaults(_Frames):
    """``rate``: how probable a fault is, a frame; 0 is a good line."""

    rng: np.random.Generator
    rate: float
    _history: list[bytes] = field(default_factory=list)
    # Frames on their way, with the looks that are left until they leave.
    _delayed: list[tuple[int, bytes]] = field(default_factory=list)

    def __post_init__(self) -> None:
        super().__init__()

    def __call__(self, data: bytes) -> bytes:
        out = super().__call__(data)
        due = [frame for looks, frame in self._delayed if looks <= 0]
        self._delayed = [(looks - 1, frame) for looks, frame in self._delayed if looks > 0]
        return out + b"".join(due)

    def through(self, frame: bytes) -> bytes:
        self._history = [*self._history[1 - _REMEMBERED :], frame]
        if self.rng.random() >= self.rate:
            return frame
        faults = ("corrupt", "truncate", "drop", "repeat", "replay", "delay", "noise")
        fault = faults[self.rng.integers(len(faults))]
        match fault:
            case "corrupt":
                bits = np.unpackbits(np.frombuffer(frame, np.uint8))
                bits[self.rng.integers(0, len(bits), self.rng.integers(1, 5))] ^= 1
                return np.packbits(bits).tobytes()
            case "truncate":
                first, last = sorted(self.rng.integers(0, len(frame) + 1, 2))
                return frame[:first] + frame[last:]
            case "repeat" | "delay":
                self._delayed.append((int(self.rng.integers(0, 200)), frame))
                return frame if fault == "repeat" else b""
            case "replay":
                # An older one, which may be of another session.
                old = self._history[self.rng.integers(len(self._history))]
                return old + frame if self.rng.random() < 0.5 else frame + old
            case "noise":
                return self.rng.bytes(int(self.rng.integers(1, 40))) + frame
            case _:
                return b""


class StaleReplies(_Frames):
    """The line to the host: once ``replaying``, each reply comes after an earlier one to the same command."""

    def __init__(self) -> None:
        super().__init__()
        self.replaying = False
        self._earlier: dict[int, bytes] = {}

    def through(self, frame: bytes) -> bytes:
        # No command is a byte that SLIP has to stuff.
        command = frame[1]
        if self.replaying:
            return self._earlier.get(command, b"") + frame
        self._earlier[command] = frame
        return frame
