"""A simulated board at a port of its own, for as long as a test needs it."""

import threading

from triaxis.sim.pseudo_terminal import PseudoTerminal, Wire, serve
from triaxis.sim.simulated_board import SimulatedTop


class ServedBoard:
    """A simulated board at a port, served by a thread while the block runs."""

    def __init__(self, top: SimulatedTop, wire: Wire | None = None) -> None:
        """Make the port of a board."""
        self.top = top
        self._terminal = PseudoTerminal()
        self._wire = wire or Wire()
        self._plugged = True
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._serve, daemon=True)

    @property
    def path(self) -> str:
        """Return the port's path."""
        return self._terminal.path

    def _serve(self) -> None:
        serve(self.top, self._terminal, self._wire, self._end.is_set)

    def __enter__(self) -> "ServedBoard":
        """Begin to serve."""
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Stop the board's clock and take the port away."""
        self.unplug()

    def unplug(self) -> None:
        """Stop the board's clock and take the port away, and what is on the line with it.

        The board can be stepped afterwards.
        """
        self._end.set()
        self._thread.join()
        self.top.unplug()
        if self._plugged:
            self._plugged = False
            self._terminal.close()
