"""The core's input words, TDATA and TUSER of the input stream (see dut/core/triaxis_core.sv).

Of the certified core what a pair tries counts as the upper bits of its tag.
"""

from enum import IntEnum

import numpy as np
import numpy.typing as npt

from triaxis.golden.pairs import Pairs
from triaxis.sim.configuration import Configuration

COORDINATES = 18

# The parity bits that a pair can try, by number: of its 18 coordinates, of the rest of it, of its result.
PARITIES = (*range(COORDINATES + 1), 31)


class Try(IntEnum):
    """What a pair of the certified core tries: upper bits of try_t, above a number of `WHICH_BITS` bits.

    A claim in place of the core's, of the axis of that number; that parity bit inverted; that bit of the
    pair's number inverted.
    """

    NOTHING = 0
    CLAIM = 1
    PARITY = 2
    NUMBER = 3


WHICH_BITS = 5


def attempts_of(
    kinds: npt.NDArray[np.integer] | Try, which: npt.NDArray[np.integer]
) -> npt.NDArray[np.uint8]:
    """Return attempts of kinds, with numbers (N,)."""
    return (np.asarray(kinds) << WHICH_BITS | which).astype(np.uint8)


def data_bytes(width: int) -> int:
    """Return how many bytes TDATA has."""
    return (COORDINATES * width + 7) // 8


def pack_data(pairs: Pairs, width: int) -> list[int]:
    """Return TDATA for pairs (N, 2, 3, 3) as numbers."""
    coordinates = pairs.astype("<i4").reshape(-1, COORDINATES, 1).view(np.uint8)
    bits = np.unpackbits(coordinates, axis=2, bitorder="little")[:, :, :width]
    rows = np.packbits(bits.reshape(len(bits), COORDINATES * width), axis=1, bitorder="little")
    return [int.from_bytes(row.tobytes(), "little") for row in rows]


def unpack_data(words: list[int], width: int) -> Pairs:
    """Return the pairs (N, 2, 3, 3) in TDATA words: the inverse of `pack_data`."""
    size = data_bytes(width)
    raw = np.frombuffer(b"".join(word.to_bytes(size, "little") for word in words), np.uint8)
    bits = np.unpackbits(raw.reshape(len(words), size), axis=1, bitorder="little")
    bits = bits[:, : COORDINATES * width].reshape(-1, COORDINATES, width).astype(np.int64)
    weights = np.left_shift(np.int64(1), np.arange(width))
    weights[-1] = -weights[-1]
    return (bits @ weights).reshape(-1, 2, 3, 3)


def pack_user(
    margins: npt.NDArray[np.integer], tags: npt.NDArray[np.integer], configuration: Configuration
) -> list[int]:
    """Return TUSER for margins and tags of shape (N,) as numbers; both together may exceed 64 bits."""
    shift = configuration.margin_bits
    return [tag << shift | margin for tag, margin in zip(tags.tolist(), margins.tolist(), strict=True)]


def unpack_user(
    words: list[int], configuration: Configuration
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.uint64]]:
    """Return margins and tags in TUSER words: the inverse of `pack_user`."""
    shift = configuration.margin_bits
    mask = (1 << shift) - 1
    margins = np.array([word & mask for word in words], np.int64)
    tags = np.array([word >> shift for word in words], np.uint64)
    return margins, tags
