"""The serial port as the client sees it, with its troubles in one line each."""

import contextlib
import errno
import termios
import time
from typing import Protocol

import serial

from triaxis.host.link.errors import LinkError

BAUD = 2_000_000
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
        ...

    def receive(self, seconds: float) -> bytes:
        """Return what has come, waiting for the first byte at most so long; raises LinkError likewise."""
        ...

    def drop_input(self) -> None:
        """Forget what has come."""
        ...

    def now(self) -> float:
        """Return the time in seconds since some moment."""
        ...

    def wait(self, seconds: float) -> None:
        """Let time go by."""
        ...

    def close(self) -> None:
        """End the use of the line."""
        ...


class SerialLine:
    """A serial port of this machine, for us alone."""

    def __init__(self, name: str, baud: int = BAUD) -> None:
        """Open the port; raises LinkError where it is missing, forbidden, or in use."""
        self.name = name
        try:
            self._port = serial.Serial(
                name, baud, timeout=_SLICE_SECONDS, write_timeout=_WRITE_SECONDS, exclusive=True
            )
        except (*_TROUBLE, ValueError) as error:
            raise LinkError(f"{name}: {_why_not_open(error)}") from error
        # USB bridges otherwise keep short replies back for 16 ms. Not every port knows of it.
        with contextlib.suppress(*_TROUBLE, ValueError, NotImplementedError):
            self._port.set_low_latency_mode(True)

    def send(self, data: bytes) -> None:
        """Send bytes; raises LinkError where the port is gone or takes none."""
        try:
            self._port.write(data)
        except serial.SerialTimeoutException as error:
            raise LinkError(f"{self.name}: takes no bytes: check the cable; verdict unknown") from error
        except _TROUBLE as error:
            raise self._gone() from error

    def receive(self, seconds: float) -> bytes:
        """Return what has come, waiting for the first byte at most so long."""
        deadline = self.now() + seconds
        try:
            data = self._port.read(1)
            while not data and self.now() < deadline:
                data = self._port.read(1)
            return data + self._port.read(self._port.in_waiting) if data else data
        except _TROUBLE as error:
            raise self._gone() from error

    def drop_input(self) -> None:
        """Forget what has come."""
        try:
            self._port.reset_input_buffer()
        except _TROUBLE as error:
            raise self._gone() from error

    def now(self) -> float:
        """Return the time in seconds since some moment."""
        return time.monotonic()

    def wait(self, seconds: float) -> None:
        """Let time go by."""
        time.sleep(seconds)

    def close(self) -> None:
        """Close the port, whatever state it is in."""
        self._port.close()

    def _gone(self) -> LinkError:
        return LinkError(
            f"{self.name}: the port is gone: plug the board in again and repeat; verdict unknown"
        )


def _why_not_open(error: Exception) -> str:
    number = error.errno if isinstance(error, OSError) else None
    reasons = {
        errno.ENOENT: "no such port: plug the board in, or see /dev/ttyUSB* for its name",
        errno.ENODEV: "no such port: plug the board in, or see /dev/ttyUSB* for its name",
        errno.EACCES: "no permission: join the port's group (Debian: adduser USER dialout) and log in again",
        errno.EBUSY: "port in use: end the other program",
        errno.EAGAIN: "port in use: end the other program",
        errno.EIO: "the port does not answer: plug the board in again",
    }
    if number in reasons:
        return reasons[number]
    return f"cannot be used as a serial port: {str(error) or type(error).__name__}"
