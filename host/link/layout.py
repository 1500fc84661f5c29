"""Dataclasses that are also byte layouts: the order of the fields and their types say all of it.

Numbers are little endian, without gaps.
"""

import struct
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Self, get_type_hints

U8 = Annotated[int, "B"]
U16 = Annotated[int, "H"]
U32 = Annotated[int, "I"]
I32 = Annotated[int, "i"]


class LayoutError(ValueError):
    """Bytes that are not of the layout."""


@cache
def _codes(record: type) -> tuple[str, ...]:
    hints = get_type_hints(record, include_extras=True)
    return tuple(hints[name].__metadata__[0] for name in record.__dataclass_fields__)


@cache
def _layout(record: type) -> struct.Struct:
    return struct.Struct("<" + "".join(_codes(record)))


def field_sizes(record: type) -> list[int]:
    """Return the bytes of each field of a record type."""
    return [struct.calcsize(code) for code in _codes(record)]


@dataclass(frozen=True)
class Record:
    """A fixed layout; its fields are `U8`, `U16`, `U32` or `I32`."""

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
