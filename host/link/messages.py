"""Requests and replies of the board: the one place that knows their layout and numbers."""

from dataclasses import dataclass
from enum import IntEnum, IntFlag
from typing import Self

import numpy as np
import numpy.typing as npt

from triaxis.host.link.wire import CRC_BYTES, I32, LONGEST, U8, U16, U32, LayoutError, Record

# The version of the protocol, and what a reply adds to its command.
PROTOCOL = 3
REPLY = 0x80


class Command(IntEnum):
    """What the host may ask for."""

    HELLO = 1
    LOAD = 2
    MOVE = 3
    RUN = 4
    RESULTS = 5
    STATUS = 6
    ABORT = 7


class Code(IntEnum):
    """What the board says to it."""

    OK = 0
    UNKNOWN_COMMAND = 1
    BAD_LENGTH = 2
    OTHER_SESSION = 3
    BAD_SEQUENCE = 4
    BUSY = 5
    BAD_VALUE = 6
    OUT_OF_PLACE = 7
    COUNTS_DIFFER = 8
    EMPTY_MESH = 9
    OVERFULL = 10


class Mesh(IntEnum):
    """The board's two memories."""

    A = 0
    B = 1


class Mode(IntEnum):
    """What a run looks for."""

    FIRST = 0
    ALL = 1
    COUNT = 2


class State(IntEnum):
    """Where the board's last run stands."""

    IDLE = 0
    RUNNING = 1
    DONE = 2


class RunEnd(IntEnum):
    """How the engine ended a run."""

    NONE = 0
    COMPLETE = 1
    FIRST = 2
    ABORTED = 3
    OVERFLOW = 4
    OVERFULL = 5
    BAD_MODE = 6


class Flag(IntFlag):
    """Bits of a status."""

    GO = 1
    NEAR_WAITING = 2
    WATCHDOG_EXPIRED = 4


MOST_TRIANGLES, MOST_NEAR = 12, 32


@dataclass(frozen=True)
class RequestHead(Record):
    """The beginning of every request."""

    command: U8
    sequence: U32
    session: U32


@dataclass(frozen=True)
class ReplyHead(Record):
    """The beginning of every reply; sequence and session are those of the request."""

    command: U8
    sequence: U32
    session: U32
    code: U8


@dataclass(frozen=True)
class Description(Record):
    """What the board is: the answer to HELLO."""

    protocol: U8
    width: U8
    margin_bits: U8
    depth: U16
    group: U8
    lanes: U8
    build: U32
    watchdog_ms: U16


@dataclass(frozen=True)
class LoadHead(Record):
    """The beginning of LOAD; ``count`` triangles follow, see `pack_triangles`."""

    mesh: U8
    first: U16
    count: U8


@dataclass(frozen=True)
class Loaded(Record):
    """How many triangles the mesh holds: the answer to LOAD."""

    count: U16


@dataclass(frozen=True)
class Pose(Record):
    """Where A stands, in steps of the grid: MOVE and its answer."""

    x: I32
    y: I32
    z: I32


@dataclass(frozen=True)
class RunRequest(Record):
    """RUN: the counts must be those that the board holds."""

    mode: U8
    margin: U32
    count_a: U16
    count_b: U16


@dataclass(frozen=True)
class RunNumber(Record):
    """Which run has begun: the answer to RUN. The first after HELLO is 1; 255 is followed by 0."""

    number: U8


@dataclass(frozen=True)
class ResultsRequest(Record):
    """RESULTS: near pairs before ``start`` may be forgotten."""

    start: U32


@dataclass(frozen=True)
class Status(Record):
    """The status block. ``end`` and all after the flags but the last three are of the last finished run."""

    run: U8
    state: U8
    end: U8
    flags: U8
    mode: U8
    x: I32
    y: I32
    z: I32
    margin: U32
    cycles: U32
    groups_skipped: U32
    groups_opened: U32
    pairs_skipped: U32
    tested: U32
    near: U32
    errors: U16
    count_a: U16
    count_b: U16


@dataclass(frozen=True)
class ResultsHead(Record):
    """What follows the status in the answer to RESULTS; ``count`` pairs of U16 follow."""

    start: U32
    count: U8


def twice(record: bytes) -> bytes:
    """Return a record as a reply has it: as it is, then with every bit inverted."""
    return record + bytes(byte ^ 0xFF for byte in record)


def once(payload: bytes) -> bytes:
    """Return the record that a reply has twice; raises LayoutError where the two forms differ."""
    record = payload[: len(payload) // 2]
    if twice(record) != payload:
        raise LayoutError("a payload and its inverted copy differ")
    return record


@dataclass(frozen=True)
class Reply:
    """A reply whose CRC was right."""

    head: ReplyHead
    payload: bytes

    @classmethod
    def read(cls, body: bytes) -> Self:
        """Read a body; raises LayoutError where it is too short."""
        return cls(*ReplyHead.split(body))


@dataclass(frozen=True)
class Results:
    """The answer to RESULTS. ``near``: (i in A, j in B) as loaded, shape (K, 2), from number ``start``."""

    status: Status
    start: int
    near: npt.NDArray[np.int64]

    def pack(self) -> bytes:
        """Return the payload."""
        head = ResultsHead(self.start, len(self.near))
        return twice(self.status.pack() + head.pack()) + self.near.astype("<u2").tobytes()

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read a payload; raises LayoutError where the length is wrong, or the two forms differ."""
        size = 2 * (Status.size() + ResultsHead.size())
        pairs = payload[size:]
        status, rest = Status.split(once(payload[:size]))
        head = ResultsHead.unpack(rest)
        if head.count > MOST_NEAR or len(pairs) != 4 * head.count:
            raise LayoutError(f"Results: {len(pairs)} bytes for {head.count} near pairs")
        return cls(status, head.start, np.frombuffer(pairs, "<u2").astype(np.int64).reshape(-1, 2))


def coordinate_bytes(width: int) -> int:
    """Return the bytes of a coordinate of ``width`` bits."""
    return -(-width // 8)


def triangles_per_load(width: int) -> int:
    """Return how many triangles fit one LOAD."""
    room = LONGEST - CRC_BYTES - RequestHead.size() - LoadHead.size()
    return min(MOST_TRIANGLES, room // (9 * coordinate_bytes(width)))


def pack_triangles(triangles: npt.NDArray[np.int64], width: int) -> bytes:
    """Return the bytes of triangles (N, 3, 3) on a grid of ``width`` bits: 9 coordinates each.

    The coordinates must be in range: the higher bits are left out.
    """
    words = np.ascontiguousarray(triangles, "<i8").reshape(-1, 9, 1).view(np.uint8)
    return words[:, :, : coordinate_bytes(width)].tobytes()


def unpack_triangles(data: bytes, width: int) -> npt.NDArray[np.int64]:
    """Return the triangles (N, 3, 3) of some bytes; raises LayoutError where the length is wrong."""
    size = coordinate_bytes(width)
    if len(data) % (9 * size):
        raise LayoutError(f"{len(data)} bytes: triangles have {9 * size}")
    low = np.frombuffer(data, np.uint8).reshape(-1, 9, size)
    words = np.zeros((len(low), 9, 8), np.uint8)
    # The shift back extends the sign.
    words[:, :, 8 - size :] = low
    return (words.view("<i8") >> (8 * (8 - size))).astype(np.int64).reshape(-1, 3, 3)
