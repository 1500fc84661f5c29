"""A host of the simulated board that keeps to no rule but the test's: any frame, any number, any bytes.

Written from the protocol alone, so that a mistake that board and host program share is seen.
"""

import struct
import zlib
from collections import namedtuple
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np

from triaxis.sim.board_parameters import BoardParameters
from triaxis.sim.simulated_board import SimulatedTop

Command = IntEnum("Command", "HELLO LOAD MOVE RUN RESULTS STATUS ABORT")
Code = IntEnum("Code", "OK UNKNOWN LENGTH SESSION SEQUENCE BUSY VALUE PLACE COUNTS EMPTY OVERFULL", start=0)
Mode = IntEnum("Mode", "FIRST ALL COUNT", start=0)
State = IntEnum("State", "NEVER RUNNING DONE", start=0)
End = IntEnum("End", "COMPLETE STOPPED ABORTED OVERFLOW")

BUSY_LED, RING_FULL_LED = 1 << 2, 1 << 5

PARAMETERS = BoardParameters(watchdog_clocks=100_000, build_id=0xC0DBDCDD)

# Above what any reply takes.
PATIENCE = 30_000


def stuffed(data: bytes) -> bytes:
    return data.replace(b"\xdb", b"\xdb\xdd").replace(b"\xc0", b"\xdb\xdc")


def on_line(body: bytes) -> bytes:
    """Return a body with its CRC and its ENDs as it goes over the line."""
    return b"\xc0" + stuffed(body + struct.pack("<I", zlib.crc32(body))) + b"\xc0"


def unstuffed(data: bytes) -> bytes:
    """Return a frame's body; every fault of it fails the test."""
    whole = data.replace(b"\xdb\xdc", b"\xc0").replace(b"\xdb\xdd", b"\xdb")
    assert stuffed(whole) == data
    assert len(whole) <= 256
    assert zlib.crc32(whole[:-4]) == struct.unpack("<I", whole[-4:])[0]
    return whole[:-4]


def halved(command: int, payload: bytes) -> bytes:
    """Return a reply's payload without its inverted copy, which must be there and fit."""
    size = STATUS_LAYOUT.size + 5 if command == Command.RESULTS | 0x80 and payload else len(payload) // 2
    once, inverted, pairs = payload[:size], payload[size : 2 * size], payload[2 * size :]
    assert bytes(byte ^ 0xFF for byte in once) == inverted
    return once + pairs


class Reply(NamedTuple):
    command: int
    sequence: int
    session: int
    code: int
    payload: bytes


STATUS_LAYOUT = struct.Struct("<5B3i7I3H")
_FIELDS = (
    "run state end flags mode x y z margin cycles groups_skipped groups_opened pairs_skipped tested near "
    "errors count_a count_b go waiting expired"
)
StatusBlock = namedtuple("StatusBlock", _FIELDS)


def status_of(payload: bytes) -> Any:
    fields = STATUS_LAYOUT.unpack(payload[: STATUS_LAYOUT.size])
    return StatusBlock(*fields, *(bool(fields[3] >> bit & 1) for bit in range(3)))


class BoardHost:
    def __init__(self, top: SimulatedTop, session: int = 0x11DBC022) -> None:
        self.top = top
        self.session = session
        self.sequence = 0
        self._heard = b""

    def frame(
        self, command: int, payload: bytes = b"", sequence: int | None = None, session: int | None = None
    ) -> bytes:
        """Return a frame; without a number, that of the next command."""
        number = self.sequence + 1 if sequence is None else sequence
        whose = self.session if session is None else session
        return struct.pack("<BII", command, number % 2**32, whose) + payload

    def replies(self, clocks: int, count: int | None = None) -> list[Reply]:
        """Run so many clocks, less when ``count`` replies have come; return those that have."""
        found: list[Reply] = []
        while clocks > 0 and (count is None or len(found) < count):
            clocks -= self.top.step(clocks, until_event=True)
            *frames, self._heard = (self._heard + self.top.receive()).split(b"\xc0")
            bodies = [unstuffed(frame) for frame in frames if frame]
            heads = [struct.unpack("<BIIB", body[:10]) for body in bodies]
            found += [
                Reply(*head, halved(head[0], body[10:])) for head, body in zip(heads, bodies, strict=True)
            ]
        return found

    def exchange(self, line: bytes) -> Reply:
        """Send bytes as they are; return the one reply."""
        self.top.send(line)
        (reply,) = self.replies(PATIENCE, 1)
        return reply

    def silent(self, line: bytes) -> None:
        """Send bytes as they are; fail where the board answers."""
        self.top.send(line)
        assert self.replies(40 * len(line) + 4000) == []

    def ask(
        self, command: int, payload: bytes = b"", sequence: int | None = None, session: int | None = None
    ) -> Reply:
        """Send a command and return its reply; an executed one counts."""
        body = self.frame(command, payload, sequence, session)
        reply = self.exchange(on_line(body))
        (number,) = struct.unpack_from("<I", body, 1)
        assert (reply.command, reply.sequence) == (command | 0x80, number)
        assert reply.session == (self.session if session is None else session)
        if reply.code == Code.OK:
            self.sequence = number
        return reply

    def hello(self) -> bytes:
        return self.good(Command.HELLO)

    def good(self, command: int, payload: bytes = b"") -> bytes:
        reply = self.ask(command, payload)
        assert reply.code == Code.OK
        return reply.payload

    def status(self) -> Any:
        payload = self.good(Command.STATUS)
        assert len(payload) == STATUS_LAYOUT.size
        return status_of(payload)

    def load(self, mesh: int, triangles: np.ndarray) -> None:
        """Replace a mesh by triangles (N, 3, 3)."""
        width = self.top.parameters.width
        step = min(12, 235 // (9 * ((width + 7) // 8)))
        for first in range(0, len(triangles), step):
            payload = load_payload(mesh, first, triangles[first : first + step], width)
            count = self.good(Command.LOAD, payload)
            assert count == struct.pack("<H", min(first + step, len(triangles)))

    def load_both(self, triangles: np.ndarray) -> None:
        """Replace both meshes by the same triangles."""
        self.load(0, triangles)
        self.load(1, triangles)

    def move(self, x: int, y: int, z: int) -> None:
        assert self.good(Command.MOVE, struct.pack("<3i", x, y, z)) == struct.pack("<3i", x, y, z)

    def run_payload(self, mode: int, margin: int = 0) -> bytes:
        status = self.status()
        return run_asked(mode, margin, status.count_a, status.count_b)

    def start(self, mode: int, margin: int = 0) -> int:
        """Start a run and return its number."""
        return self.good(Command.RUN, self.run_payload(mode, margin))[0]

    def finish(self) -> None:
        """Let the board run until its run has ended."""
        for _ in range(1000):
            if not self.top.leds & BUSY_LED:
                return
            self.top.step(100)
        raise AssertionError("the run does not end")

    def run(self, mode: int, margin: int = 0) -> Any:
        number = self.start(mode, margin)
        self.finish()
        status = self.status()
        assert (status.run, status.state, status.mode) == (number, State.DONE, mode)
        return status

    def results(self, start: int) -> tuple[Any, np.ndarray]:
        """Return the status and the near pairs (K, 2) from number ``start`` on."""
        payload = self.good(Command.RESULTS, struct.pack("<I", start))
        return read_results(payload, start)

    def all_results(self) -> tuple[Any, np.ndarray]:
        """Return the status of the run's end and all of its near pairs (K, 2)."""
        found = np.empty((0, 2), np.int64)
        while True:
            status, near = self.results(len(found))
            found = np.concatenate([found, near])
            if not len(near) and status.state == State.DONE:
                return status, found


def read_results(payload: bytes, start: int) -> tuple[Any, np.ndarray]:
    number, count = struct.unpack_from("<IB", payload, STATUS_LAYOUT.size)
    assert number == start
    assert count <= 32
    near = np.frombuffer(payload, "<u2", offset=STATUS_LAYOUT.size + 5).reshape(-1, 2)
    assert len(near) == count
    return status_of(payload), near.astype(np.int64)


def load_payload(mesh: int, first: int, triangles: np.ndarray, width: int = PARAMETERS.width) -> bytes:
    """Return the payload of a LOAD of triangles (N, 3, 3), in coordinates of whole bytes."""
    size = (width + 7) // 8
    values = (int(value).to_bytes(size, "little", signed=True) for value in triangles.reshape(-1))
    return struct.pack("<BHB", mesh, first, len(triangles)) + b"".join(values)


def run_asked(mode: int, margin: int, count_a: int, count_b: int) -> bytes:
    """Return the payload of a RUN."""
    return struct.pack("<BIHH", mode, margin, count_a, count_b)


def flat(z: int, count: int = 1) -> np.ndarray:
    """Return ``count`` times the same triangle, of 10 by 10 at height ``z``."""
    return np.tile(np.array([[0, 0, z], [10, 0, z], [0, 10, z]], np.int64), (count, 1, 1))


def corners(count: int) -> np.ndarray:
    """Return ``count`` triangles that the boxes of `flat`'s overlap, and that are not near them at 0."""
    return np.tile(np.array([[10, 10, 0], [10, 6, 0], [6, 10, 0]], np.int64), (count, 1, 1))


def long_clear_scene(host: "BoardHost") -> None:
    """Load a scene that is clear, of which every pair must be tested: the longest that there is."""
    host.load(0, flat(0, host.top.parameters.depth))
    host.load(1, corners(host.top.parameters.depth))


def start_at_once(host: "BoardHost", mode: int) -> None:
    """Send a run, and return in the clock in which the board begins it, before its reply."""
    host.top.send(on_line(host.frame(Command.RUN, host.run_payload(mode))))
    host.sequence += 1
    while not host.top.leds & BUSY_LED:
        host.top.step(1)


def powered(session: int = 0x11DBC022) -> BoardHost:
    """Return a host of a board after power-up and HELLO."""
    host = BoardHost(SimulatedTop(PARAMETERS), session)
    host.hello()
    return host


def clear_scene(host: BoardHost) -> None:
    """Load two triangles 5 apart."""
    host.load(0, flat(0))
    host.load(1, flat(5))


def clear_run(host: BoardHost) -> None:
    """Run the scene to go."""
    status = host.run(Mode.ALL)
    assert (status.end, status.near) == (End.COMPLETE, 0)
    assert says_go(host.top)


def says_go(top: SimulatedTop) -> bool:
    """Return what the two outputs say; they must never agree."""
    assert top.bad_clocks == 0
    assert top.go != top.stop
    return top.go
