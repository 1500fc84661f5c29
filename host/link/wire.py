"""Frames and records on the wire.

A frame is SLIP (RFC 1055) around a body that ends with its CRC-32; it begins and ends with END, so that noise
before it costs no more than one frame. A record is a dataclass that is also a byte layout: the order of its
fields and their types say all of it. Numbers are little endian, without gaps.
"""

import struct
import zlib
from dataclasses import dataclass, fields
from functools import cache
from typing import Annotated, Self, dataclass_transform, get_type_hints

END, ESC, ESC_END, ESC_ESC = 0xC0, 0xDB, 0xDC, 0xDD
# Unstuffed, with the CRC: what the board can hold.
LONGEST = 256
CRC_BYTES = 4


def encode(body: bytes) -> bytes:
    """Return the frame of a body, ready for the wire.

    Raises ValueError where the body and its CRC are longer than `LONGEST`.
    """
    if len(body) + CRC_BYTES > LONGEST:
        raise ValueError(f"frame of {len(body) + CRC_BYTES} bytes: at most {LONGEST}")
    whole = body + zlib.crc32(body).to_bytes(CRC_BYTES, "little")
    stuffed = whole.replace(bytes([ESC]), bytes([ESC, ESC_ESC])).replace(bytes([END]), bytes([ESC, ESC_END]))
    return bytes([END]) + stuffed + bytes([END])


def decode(stuffed: bytes) -> bytes | None:
    """Return the body between two ENDs, or None where stuffing, length or CRC is wrong."""
    pieces = stuffed.split(bytes([ESC]))
    whole = bytearray(pieces[0])
    for piece in pieces[1:]:
        if piece[:1] not in (bytes([ESC_END]), bytes([ESC_ESC])):
            return None
        whole.append(END if piece[0] == ESC_END else ESC)
        whole += piece[1:]
    if not CRC_BYTES <= len(whole) <= LONGEST:
        return None
    body, crc = bytes(whole[:-CRC_BYTES]), int.from_bytes(whole[-CRC_BYTES:], "little")
    return body if zlib.crc32(body) == crc else None


class Deframer:
    """Cuts a stream of bytes into bodies."""

    def __init__(self) -> None:
        """Begin with an empty line."""
        self._partial = bytearray()

    def feed(self, data: bytes) -> list[bytes]:
        """Return the bodies that ``data`` completes; what is no frame is left out."""
        *frames, rest = (bytes(self._partial) + data).split(bytes([END]))
        # Twice the longest frame is the longest stuffed one: what is beyond it can only be noise.
        self._partial = bytearray(rest[: 2 * LONGEST + 1])
        return [body for stuffed in frames if stuffed and (body := decode(stuffed)) is not None]

    def clear(self) -> None:
        """Forget the frame that has begun."""
        self._partial.clear()


U8 = Annotated[int, "B"]
U16 = Annotated[int, "H"]
U32 = Annotated[int, "I"]
I32 = Annotated[int, "i"]


class LayoutError(ValueError):
    """Bytes that are not of the layout."""


@cache
def _layout(record: "type[Record]") -> struct.Struct:
    hints = get_type_hints(record, include_extras=True)
    return struct.Struct("<" + "".join(hints[field.name].__metadata__[0] for field in fields(record)))


@dataclass_transform(frozen_default=True)
@dataclass(frozen=True)
class Record:
    """A fixed layout, and a frozen dataclass; its fields are `U8`, `U16`, `U32` or `I32`."""

    def __init_subclass__(cls) -> None:
        """Make it a dataclass."""
        dataclass(frozen=True)(cls)

    @classmethod
    def size(cls) -> int:
        """Return the length in bytes."""
        return _layout(cls).size

    def pack(self) -> bytes:
        """Return the bytes; raises struct.error where a number does not fit its field."""
        return _layout(type(self)).pack(*vars(self).values())

    @classmethod
    def unpack(cls, data: bytes) -> Self:
        """Read all of ``data``; raises LayoutError where the length is wrong."""
        if len(data) != cls.size():
            raise LayoutError(f"{cls.__name__}: {len(data)} bytes, must be {cls.size()}")
        return cls(*_layout(cls).unpack(data))

    @classmethod
    def split(cls, data: bytes) -> tuple[Self, bytes]:
        """Read the beginning of ``data``; return the record and what follows it."""
        return cls.unpack(data[: cls.size()]), data[cls.size() :]
