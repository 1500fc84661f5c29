"""Numbers and layouts of the board's line, as docs/board.md has them: shared with neither of its sides.

What the host's program and the RTL have in common could be wrong in both.
"""

import struct
import zlib
from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Integers = npt.NDArray[np.int64]

Command = IntEnum("Command", "HELLO LOAD RUN RESULTS STATUS ABORT")
Code = IntEnum("Code", "OK UNKNOWN LENGTH SESSION SEQUENCE BUSY VALUE PLACE COUNTS EMPTY OVERFULL", start=0)
Mode = IntEnum("Mode", "FIRST ALL COUNT", start=0)
State = IntEnum("State", "NEVER RUNNING DONE", start=0)
End = IntEnum("End", "NONE COMPLETE FIRST ABORTED OVERFLOW OVERFULL BAD_MODE FAULT", start=0)
Flag = IntEnum("Flag", "GO WAITING EXPIRED FAULT SLOW WARN", start=0)

VERSION = 7
REPLY = 0x80
END, ESC, ESC_END, ESC_ESC = 0xC0, 0xDB, 0xDC, 0xDD
SHORTEST, LONGEST = 13, 256
HEAD = struct.Struct("<BII")
MOST_TRIANGLES, MOST_NEAR = 12, 32
RING = 1024
MOST_ERRORS = (1 << 12) - 1
COUNTERS = ("cycles", "groups_skipped", "groups_opened", "pairs_skipped", "tested", "near")

# RUN's payload: mode, margin, slow, warn, counts, what it tries, pose, hold; and its answer: number, hold.
RUN, BEGUN = struct.Struct("<B3IHHB3iH"), struct.Struct("<BH")
# LOAD's answer: triangles held, and their signature.
LOADED = struct.Struct("<HI")
_STATUS = struct.Struct("<5B3i7I3H")


def checked(body: bytes) -> bytes:
    """Return a body with its CRC."""
    return body + struct.pack("<I", zlib.crc32(body))


def stuffed(data: bytes) -> bytes:
    """Return bytes as they stand between two ENDs."""
    return data.replace(b"\xdb", b"\xdb\xdd").replace(b"\xc0", b"\xdb\xdc")


def framed(body: bytes) -> bytes:
    """Return a body with its CRC and its ENDs, as it goes over the line."""
    return b"\xc0" + stuffed(checked(body)) + b"\xc0"


def coordinate_bytes(width: int) -> int:
    """Return the bytes of a coordinate of ``width`` bits."""
    return -(-width // 8)


def triangle_bytes(triangles: Integers, width: int) -> bytes:
    """Return triangles (N, 3, 3) as LOAD has them."""
    size = coordinate_bytes(width)
    return b"".join(int(value).to_bytes(size, "little", signed=True) for value in triangles.reshape(-1))


def load_payload(mesh: int, first: int, triangles: Integers, width: int) -> bytes:
    """Return the payload of a LOAD of triangles (N, 3, 3)."""
    return struct.pack("<BHB", mesh, first, len(triangles)) + triangle_bytes(triangles, width)


def loaded_triangles(payload: bytes, width: int) -> Integers:
    """Return the triangles (N, 3, 3) of a LOAD's payload, whatever their coordinates."""
    size = coordinate_bytes(width)
    values = [
        int.from_bytes(payload[at : at + size], "little", signed=True)
        for at in range(4, len(payload), size)
    ]  # fmt: skip
    return np.array(values, np.int64).reshape(-1, 3, 3)


class Status(NamedTuple):
    """The status block."""

    run: int
    state: int
    end: int
    flags: int
    mode: int
    x: int
    y: int
    z: int
    margin: int
    cycles: int
    groups_skipped: int
    groups_opened: int
    pairs_skipped: int
    tested: int
    near: int
    errors: int
    count_a: int
    count_b: int

    SIZE = _STATUS.size

    @classmethod
    def unpack(cls, data: bytes) -> "Status":
        """Read it."""
        return cls(*_STATUS.unpack(data[: _STATUS.size]))


@dataclass(frozen=True)
class Reply:
    """A frame of the board. ``pairs``: those after the payload of RESULTS, (K, 2)."""

    command: int
    sequence: int
    session: int
    code: int
    payload: bytes
    pairs: Integers

    @classmethod
    def of(cls, line: bytes) -> "Reply":
        """Read what stood between two ENDs; raise ValueError with what is wrong with it."""
        whole = line.replace(b"\xdb\xdc", b"\xc0").replace(b"\xdb\xdd", b"\xdb")
        if stuffed(whole) != line:
            raise ValueError("a reply with bad stuffing")
        if not SHORTEST < len(whole) <= LONGEST or checked(whole[:-4]) != whole:
            raise ValueError(f"a reply of {len(whole)} bytes with a bad CRC or length")
        head, payload = HEAD.unpack(whole[:9]), whole[10:-4]
        size = (
            Status.SIZE + 5 if head[0] == REPLY | Command.RESULTS and len(payload) > 8 else len(payload) // 2
        )
        once, again, pairs = payload[:size], payload[size : 2 * size], payload[2 * size :]
        if bytes(byte ^ 0xFF for byte in once) != again or len(pairs) % 4:
            raise ValueError("a payload and its inverted copy differ")
        found = np.frombuffer(pairs, "<u2").astype(np.int64).reshape(-1, 2)
        return cls(head[0], head[1], head[2], whole[9], once, found)
