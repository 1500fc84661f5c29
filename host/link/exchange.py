"""One request, one reply, over a line that may lose, damage, repeat or delay either."""

import secrets

from triaxis.host.link.codes import REPLY, Code, Command
from triaxis.host.link.errors import LinkError
from triaxis.host.link.framing import Deframer, encode
from triaxis.host.link.layout import LayoutError, Record
from triaxis.host.link.line import Line
from triaxis.host.link.messages import Reply, RequestHead

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

    def ask(self, command: Command, request: Record | bytes = b"", tries: int = _TRIES) -> Reply:
        """Return the reply, whatever its code; raises LinkError where none comes."""
        payload = request.pack() if isinstance(request, Record) else request
        frame = self.next_frame(command, payload)
        # What came before was asked by somebody else, or a repeat.
        self._line.drop_input()
        self._deframer.clear()
        begin, seconds = self._line.now(), self._patience
        for _ in range(tries):
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
            reply = Reply.read(body)
        except LayoutError:
            return None
        head = reply.head
        expected = (command | REPLY, self._sequence, self._session)
        known = head.code in _CODES
        return reply if known and (head.command, head.sequence, head.session) == expected else None
