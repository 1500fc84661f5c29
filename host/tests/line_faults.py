"""A serial line that damages, loses, repeats, reorders and delays frames, and makes some up."""

from dataclasses import dataclass, field

import numpy as np

from triaxis.host.link.wire import END

_BOUNDARY = bytes([END])
# Kept to be repeated later, from this session or an earlier one.
_REMEMBERED = 20


@dataclass
class LineFaults:
    """One direction of the line; called with the bytes that enter it, returns those that leave.

    ``rate``: how probable a fault is, a frame; 0 is a good line. ``counts``: what was done so far.
    """

    rng: np.random.Generator
    rate: float
    counts: dict[str, int] = field(default_factory=dict)
    _partial: bytes = b""
    _history: list[bytes] = field(default_factory=list)
    # Frames on their way, with the looks that are left until they leave.
    _delayed: list[tuple[int, bytes]] = field(default_factory=list)

    def __call__(self, data: bytes) -> bytes:
        *frames, self._partial = (self._partial + data).split(_BOUNDARY)
        out = b"".join(self._through(_BOUNDARY + frame + _BOUNDARY) for frame in frames if frame)
        due = [frame for looks, frame in self._delayed if looks <= 0]
        self._delayed = [(looks - 1, frame) for looks, frame in self._delayed if looks > 0]
        return out + b"".join(due)

    def _through(self, frame: bytes) -> bytes:
        self._history = [*self._history[1 - _REMEMBERED :], frame]
        if self.rng.random() >= self.rate:
            return frame
        faults = (self.corrupt, self.truncate, self.drop, self.repeat, self.replay, self.delay, self.noise)
        fault = faults[self.rng.integers(len(faults))]
        self.counts[fault.__name__] = self.counts.get(fault.__name__, 0) + 1
        return fault(frame)

    def corrupt(self, frame: bytes) -> bytes:
        """Flip one to four bits."""
        bits = np.unpackbits(np.frombuffer(frame, np.uint8))
        bits[self.rng.integers(0, len(bits), self.rng.integers(1, 5))] ^= 1
        return np.packbits(bits).tobytes()

    def truncate(self, frame: bytes) -> bytes:
        """Lose the end, the beginning, or a piece between."""
        first, last = sorted(self.rng.integers(0, len(frame) + 1, 2))
        return frame[:first] + frame[last:]

    def drop(self, frame: bytes) -> bytes:
        """Lose all."""
        return b""

    def repeat(self, frame: bytes) -> bytes:
        """Send twice, now or later."""
        self._delayed.append((int(self.rng.integers(0, 100)), frame))
        return frame

    def replay(self, frame: bytes) -> bytes:
        """Send an older frame before or after, which may be of another session."""
        old = self._history[self.rng.integers(len(self._history))]
        return old + frame if self.rng.random() < 0.5 else frame + old

    def delay(self, frame: bytes) -> bytes:
        """Send later, perhaps after others."""
        self._delayed.append((int(self.rng.integers(0, 200)), frame))
        return b""

    def noise(self, frame: bytes) -> bytes:
        """Send other bytes before it."""
        return self.rng.bytes(int(self.rng.integers(1, 40))) + frame


@dataclass
class StaleReplies:
    """The line to the host: once ``replaying``, each reply comes after an earlier one to the same command."""

    replaying: bool = False
    _partial: bytes = b""
    _earlier: dict[int, bytes] = field(default_factory=dict)

    def __call__(self, data: bytes) -> bytes:
        *frames, self._partial = (self._partial + data).split(_BOUNDARY)
        return b"".join(self._through(_BOUNDARY + frame + _BOUNDARY) for frame in frames if frame)

    def _through(self, frame: bytes) -> bytes:
        # No command is a byte that SLIP has to stuff.
        command = frame[1]
        if self.replaying:
            return self._earlier.get(command, b"") + frame
        self._earlier[command] = frame
        return frame
