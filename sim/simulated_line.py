"""A line to a simulated board in simulated time: the same seed gives the same bytes at the same clock."""

from triaxis.sim.pseudo_terminal import Wire
from triaxis.sim.simulated_board import SimulatedTop

# Between two looks of a wire that delays what it carries.
_LOOK_CLOCKS = 500


class SimulatedWire:
    """The wire of a board, with any number of lines to it, each of which hears all that it says.

    ``clocks_per_second``: how fast the board runs in the lines' time.
    """

    def __init__(self, top: SimulatedTop, clocks_per_second: int, wire: Wire | None = None) -> None:
        """Join a board."""
        self.top = top
        self.wire = wire or Wire()
        self.lines: list[SimulatedLine] = []
        self.clocks_per_second = clocks_per_second

    def pass_on(self, data: bytes, clocks: int) -> int:
        """Send bytes, let time pass until the board speaks, and give its bytes to every line."""
        self.top.send(self.wire.to_board(data))
        done = self.top.step(clocks, until_event=True)
        answer = self.wire.to_host(self.top.receive())
        for line in self.lines:
            line.heard += answer
        return done


class SimulatedLine:
    """A `triaxis.host.link.exchange.Line` to a simulated board; time passes only while it is used."""

    name = "simulated board"

    def __init__(self, wire: SimulatedWire) -> None:
        """Join a wire."""
        self.heard = bytearray()
        self._wire = wire
        wire.lines.append(self)

    def send(self, data: bytes) -> None:
        """Queue bytes for the board."""
        self._wire.pass_on(data, 0)

    def receive(self, seconds: float) -> bytes:
        """Return what has come, waiting for the first byte at most so long."""
        left = int(seconds * self._wire.clocks_per_second)
        # One clock at least, so that time goes on whatever the caller's rounding.
        left = max(left, 1)
        while left > 0 and not self.heard:
            left -= self._wire.pass_on(b"", min(left, _LOOK_CLOCKS))
        data = bytes(self.heard)
        self.heard.clear()
        return data

    def drop_input(self) -> None:
        """Forget what has come."""
        self.heard.clear()

    def now(self) -> float:
        """Return the board's time in seconds."""
        return self._wire.top.clocks / self._wire.clocks_per_second

    def wait(self, seconds: float) -> None:
        """Let the board run on."""
        end = self.now() + seconds
        while self.now() < end:
            self._wire.pass_on(b"", _LOOK_CLOCKS)

    def close(self) -> None:
        """Leave the wire."""
        self._wire.lines.remove(self)
