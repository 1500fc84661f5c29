"""One request, one reply, over a serial port that may lose, damage, repeat or delay either.

What is wrong with the port is said in one line.
"""

import contextlib
import errno
import secrets
import termios
import time
from collections.abc import Iterator
from typing import Protocol

import serial

from triaxis.golden.errors import InputError
from triaxis.host.link.messages import REPLY, Code, Command, Reply, ReplyHead, RequestHead
from triaxis.host.link.wire import Deframer, LayoutError, Record, encode


class LinkError(InputError):
    """No verdict can be had from the board: one line that says why and what to do."""


class SessionLostError(LinkError):
    """The board stands elsewhere than the host thinks; starting again from HELLO may help."""


# The most that the board's USB bridge has; the top's ClocksPerThreeBits.
BAUD = 12_000_000
# So long a silence is short against every time limit of the link.
_SLICE_SECONDS = 0.002
_WRITE_SECONDS = 2.0
# What pyserial raises, its own SerialException being an OSError.
_TROUBLE = (OSError, termios.error)


class Line(Protocol):
    """Bytes to and from a board, and the time that goes by meanwhile."""

    name: str

    def send(self, data: bytes) -> None:
        """Send bytes; raises LinkError where the line is gone."""

    def receive(self, seconds: float) -> bytes:
        """Return what has come, waiting for the first byte at most so long; raises LinkError likewise."""
        ...

    def drop_input(self) -> None:
        """Forget what has come."""

    def now(self) -> float:
        """Return the time in seconds since some moment."""
        ...

    def wait(self, seconds: float) -> None:
        """Let time go by."""

    def close(self) -> None:
        """End the use of the line."""


class SerialLine:
    """A serial port of this machine, for us alone."""

    def __init__(self, name: str) -> None:
        """Open the port; raises LinkError where it is missing, forbidden, or in use."""
        self.name = name
        try:
            self._port = serial.Serial(
                name, BAUD, timeout=_SLICE_SECONDS, write_timeout=_WRITE_SECONDS, exclusive=True
            )
        except (*_TROUBLE, ValueError) as error:
            raise LinkError(f"{name}: {_why_not_open(error)}") from error
        # USB bridges otherwise keep short replies back for 16 ms. Not every port knows of it.
        with contextlib.suppress(*_TROUBLE, ValueError, NotImplementedError):
            self._port.set_low_latency_mode(True)

    def send(self, data: bytes) -> None:
        """Send bytes; raises LinkError where the port is gone or takes none."""
        with self._there():
            try:
                self._port.write(data)
            except serial.SerialTimeoutException as error:
                raise LinkError(f"{self.name}: takes no bytes: check the cable; verdict unknown") from error

    def receive(self, seconds: float) -> bytes:
        """Return what has come, waiting for the first byte at most so long."""
        deadline = self.now() + seconds
        with self._there():
            data = self._port.read(1)
            while not data and self.now() < deadline:
                data = self._port.read(1)
            return data + self._port.read(self._port.in_waiting) if data else data

    def drop_input(self) -> None:
        """Forget what has come."""
        with self._there():
            self._port.reset_input_buffer()

    def now(self) -> float:
        """Return the time in seconds since some moment."""
        return time.monotonic()

    def wait(self, seconds: float) -> None:
        """Let time go by."""
        time.sleep(seconds)

    def close(self) -> None:
        """Close the port, whatever state it is in."""
        self._port.close()

    @contextlib.contextmanager
    def _there(self) -> Iterator[None]:
        try:
            yield
        except _TROUBLE as error:
            raise LinkError(
                f"{self.name}: the port is gone: plug the board in again and repeat; verdict unknown"
            ) from error


_WHY_NOT_OPEN = {
    **dict.fromkeys(
        (errno.ENOENT, errno.ENODEV), "no such port: plug the board in, or see /dev/ttyUSB* for its name"
    ),
    errno.EACCES: "no permission: join the port's group (Debian: adduser USER dialout) and log in again",
    **dict.fromkeys((errno.EBUSY, errno.EAGAIN), "port in use: end the other program"),
    errno.EIO: "the port does not answer: plug the board in again",
}


def _why_not_open(error: Exception) -> str:
    number = error.errno if isinstance(error, OSError) else None
    other = f"cannot be used as a serial port: {str(error) or type(error).__name__}"
    return _WHY_NOT_OPEN.get(number or 0, other)


# The first is well above what a USB bridge takes (16 ms), and half of the board's watchdog time.
_SHORTEST_SECONDS, _LONGEST_SECONDS = 0.05, 1.0
_TRIES = 8
_CODES = frozenset(Code)


class Exchange:
    """Sends requests of one session and finds their replies.

    The same frame is sent again until its reply comes: the board does what a sequence number asks for
    once. Whatever else comes is no reply to it, and ignored.
    """

    def __init__(self, line: Line) -> None:
        """Begin a session of a random number on the line."""
        self._line = line
        self._deframer = Deframer()
        self._patience = _SHORTEST_SECONDS
        self.renew()

    def renew(self) -> None:
        """Begin another session, so that no frame of the last one counts."""
        # Session 0 is none.
        self._session = secrets.randbelow(2**32 - 1) + 1
        self._sequence = secrets.randbelow(2**32)

    def next_frame(self, command: Command, payload: bytes) -> bytes:
        """Return the frame of the next sequence number."""
        self._sequence = (self._sequence + 1) % 2**32
        return encode(RequestHead(command, self._sequence, self._session).pack() + payload)

    def go_back(self) -> None:
        """Have the next frame take the number before the last one's, which the board may never have got."""
        self._sequence = (self._sequence - 2) % 2**32

    def tell(self, command: Command) -> None:
        """Send a command with either number that the board may expect, and wait for nothing.

        The higher first: a frame waits for the answer to one that is refused, but not for a run to end.
        """
        last = encode(RequestHead(command, self._sequence, self._session).pack())
        for frame in (self.next_frame(command, b""), last):
            self._line.send(frame)

    def ask(self, command: Command, request: Record | bytes = b"") -> Reply:
        """Return the reply, whatever its code; raises LinkError where none comes."""
        payload = request.pack() if isinstance(request, Record) else request
        frame = self.next_frame(command, payload)
        # What came before was asked by somebody else, or a repeat.
        self._line.drop_input()
        self._deframer.clear()
        begin, seconds = self._line.now(), self._patience
        for _ in range(_TRIES):
            reply = self.send(command, frame, seconds)
            if reply:
                # A board in a simulation takes longer.
                elapsed = self._line.now() - begin
                self._patience = min(max(_SHORTEST_SECONDS, 2 * elapsed), _LONGEST_SECONDS)
                return reply
            seconds = min(2 * seconds, _LONGEST_SECONDS)
        raise LinkError(
            f"{self._line.name}: no answer to {command.name} in {self._line.now() - begin:.1f} s: check the "
            "cable and the board's power; verdict unknown"
        )

    def send(self, command: Command, frame: bytes, seconds: float) -> Reply | None:
        """Send a frame once; return its reply, or None where there is none within the time."""
        self._line.send(frame)
        deadline = self._line.now() + seconds
        while (left := deadline - self._line.now()) > 0:
            for body in self._deframer.feed(self._line.receive(left)):
                reply = self._reply_to(command, body)
                if reply:
                    return reply
        return None

    def _reply_to(self, command: Command, body: bytes) -> Reply | None:
        try:
            reply = Reply(*ReplyHead.split(body))
        except LayoutError:
            return None
        head = reply.head
        expected = (command | REPLY, self._sequence, self._session)
        known = head.code in _CODES
        return reply if known and (head.command, head.sequence, head.session) == expected else None
