"""Requests and replies of the board: the one place that knows their layout and numbers."""

from dataclasses import dataclass
from enum import IntEnum, IntFlag
from typing import NamedTuple, Self

import numpy as np
import numpy.typing as npt

from triaxis.host.link.wire import CRC_BYTES, I32, LONGEST, U8, U16, U32, LayoutError, Record

# The version of the protocol, and what a reply adds to its command.
PROTOCOL = 7
REPLY = 0x80


# What the host may ask for, and what the board says to it.
Command = IntEnum("Command", "HELLO LOAD RUN RESULTS STATUS ABORT", start=1)
Code = IntEnum(
    "Code",
    ("OK", "UNKNOWN_COMMAND", "BAD_LENGTH", "OTHER_SESSION", "BAD_SEQUENCE", "BUSY", "BAD_VALUE",
     "OUT_OF_PLACE", "COUNTS_DIFFER", "EMPTY_MESH", "OVERFULL"),
    start=0,
)  # fmt: skip
# The board's two memories.
Mesh = IntEnum("Mesh", "A B", start=0)
# What a run looks for; where the last one stands; how the engine ended it.
Mode = IntEnum("Mode", "FIRST ALL COUNT", start=0)
State = IntEnum("State", "IDLE RUNNING DONE", start=0)
RunEnd = IntEnum("RunEnd", "NONE COMPLETE FIRST ABORTED OVERFLOW OVERFULL BAD_MODE FAULT", start=0)
# What a run tries, so that a check is seen to work; and of which memory, for TrialKind.MEMORY.
TrialKind = IntEnum("TrialKind", "NOTHING CLAIM PARITY NUMBER MEMORY WALK INTAKE BOARD", start=0)
Memory = IntEnum("Memory", "GROUPS_A GROUPS_B BOXES_A BOXES_B TRIANGLES_A TRIANGLES_B", start=0)
WHICHES = 32
# Of TrialKind.MEMORY from the one on: a memory where it is scrubbed, after the run; from the other on a
# comparison of the scrub itself.
SCRUB, SCRUBBED, SCRUB_COMPARISONS = 8, 16, 14


class Flag(IntFlag):
    """Bits of a status.

    ``SLOW``, ``WARN``: the last run has ended, and found something in that zone, or it is no wider than the
    one within it.
    """

    GO = 1
    NEAR_WAITING = 2
    WATCHDOG_EXPIRED = 4
    FAULT = 8
    SLOW = 16
    WARN = 32


ZONES = Flag.SLOW | Flag.WARN
# Margins of the zones slow and warn: the board is not asked about them.
NO_ZONES = 0, 0


MOST_TRIANGLES = 12


class RequestHead(Record):
    """The beginning of every request."""

    command: U8
    sequence: U32
    session: U32


class ReplyHead(RequestHead):
    """The beginning of every reply; sequence and session are those of the request."""

    code: U8


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
    certifies: U8


class LoadHead(Record):
    """The beginning of LOAD; ``count`` triangles follow, see `pack_triangles`."""

    mesh: U8
    first: U16
    count: U8


class Loaded(Record):
    """How many triangles the mesh holds, and the CRC-32 of their bytes: the answer to LOAD."""

    count: U16
    signature: U32


class Pose(NamedTuple):
    """Where A stands, in steps of the grid from where it was loaded."""

    x: int
    y: int
    z: int


LOADED_POSE = Pose(0, 0, 0)


class RunRequest(Record):
    """RUN: the counts must be those that the board holds. ``trial``: see `trial_of`; 0 in use.

    ``hold``: for so many milliseconds go stands from the run's end on, where it is clear; go that is said as
    the run begins stays until then. 0: go ends as the run begins, and has no time.
    ``slow``, ``warn``: margins of the zones around. Of one that is no wider than what is within it (as 0)
    nothing is asked, and it is never said that nothing is there.
    """

    mode: U8
    margin: U32
    slow: U32
    warn: U32
    count_a: U16
    count_b: U16
    trial: U8 = 0
    x: I32 = 0
    y: I32 = 0
    z: I32 = 0
    hold: U16 = 0

    @property
    def asked(self) -> Flag:
        """Return the zones that are asked about."""
        slow = Flag.SLOW if self.slow > self.margin else Flag(0)
        return slow | (Flag.WARN if self.warn > max(self.margin, self.slow) else Flag(0))


def trial_of(kind: TrialKind, which: int) -> int:
    """Return what a run is to try; ``which`` of that kind, below `WHICHES`."""
    return kind * WHICHES + which


class Begun(Record):
    """Which run has begun, and its hold: RUN's answer. The first after HELLO is 1; 255 is followed by 0."""

    number: U8
    hold: U16


class ResultsRequest(Record):
    """RESULTS: near pairs before ``start`` may be forgotten."""

    start: U32


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


class Reply(NamedTuple):
    """A reply whose CRC was right."""

    head: ReplyHead
    payload: bytes


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
        if len(pairs) != 4 * head.count:
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
