"""The simulated board behind a pseudo-terminal: a serial port that any program can open."""

import contextlib
import os
import select
import time
import tty
from collections.abc import Callable
from dataclasses import dataclass

from triaxis.sim.simulated_board import SimulatedTop

_CHUNK = 4096
# So many clocks between two looks at the terminal: a few bytes of the line.
_SLICE_CLOCKS = 500
# Between two looks at a line that has long been silent.
_REST_SECONDS = 0.02

Filter = Callable[[bytes], bytes]


def unchanged(data: bytes) -> bytes:
    """Return the bytes as they are: a line without faults."""
    return data


class PseudoTerminal:
    """A port at ``path`` for other programs, and its far end for us."""

    def __init__(self) -> None:
        """Make the port."""
        self._end, port = os.openpty()
        # Bytes as they are, before the first program has opened it and said so itself.
        tty.setraw(port)
        self.path = os.ttyname(port)
        os.close(port)
        os.set_blocking(self._end, False)
        self._poll = select.poll()
        self._poll.register(self._end, select.POLLIN | select.POLLHUP)

    def look(self, seconds: float) -> tuple[bool, bytes]:
        """Return whether a program has the port open, and what it has sent; wait so long for either."""
        events = dict(self._poll.poll(seconds * 1000)).get(self._end, 0)
        if events == select.POLLHUP:
            # A port that nobody has open ends every wait at once.
            time.sleep(seconds)
        data = b""
        if events & select.POLLIN:
            with contextlib.suppress(OSError):
                data = os.read(self._end, _CHUNK)
        return not events & select.POLLHUP, data

    def write(self, data: bytes) -> None:
        """Send bytes; what nobody fetches is lost, as on a wire."""
        with contextlib.suppress(OSError):
            while data:
                data = data[os.write(self._end, data) :]

    def close(self) -> None:
        """Pull the plug: the program at the port gets an error."""
        os.close(self._end)


@dataclass
class Wire:
    """What lies between terminal and board; called at every look, with or without bytes."""

    to_board: Filter = unchanged
    to_host: Filter = unchanged


def serve(
    top: SimulatedTop, terminal: PseudoTerminal, wire: Wire, stopped: Callable[[], bool], once: bool = False
) -> None:
    """Run the board at the terminal until ``stopped``; with ``once``, until its first user has gone."""
    silent, used = 0, False
    while not stopped():
        resting = silent > 2 * top.parameters.watchdog_clocks
        connected, data = terminal.look(_REST_SECONDS if resting else 0)
        if once and used and not connected:
            return
        used |= connected
        top.send(wire.to_board(data))
        silent += top.step(_SLICE_CLOCKS)
        answer = wire.to_host(top.receive())
        if answer and connected:
            terminal.write(answer)
        if data or answer or top.pending:
            silent = 0
