"""The core's input words, TDATA and TUSER of the input stream (see dut/core/triaxis_core.sv)."""

import numpy as np
import numpy.typing as npt

from triaxis.golden.pairs import Pairs
from triaxis.sim.configuration import Configuration

COORDINATES = 18


def data_bytes(width: int) -> int:
    """Return how many bytes TDATA has."""
    return (COORDINATES * width + 7) // 8


def pack_data(pairs: Pairs, width: int) -> list[int]:
    """Return TDATA for pairs (N, 2, 3, 3)."""
    flat = pairs.reshape(-1, COORDINATES)
    bits = (flat[:, :, None] >> np.arange(width)) & 1
    packed = np.packbits(bits.reshape(-1, COORDINATES * width).astype(np.uint8), axis=1, bitorder="little")
    return [int.from_bytes(row.tobytes(), "little") for row in packed]


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
    margins: npt.NDArray[np.int64], tags: npt.NDArray[np.int64], configuration: Configuration
) -> list[int]:
    """Return TUSER for margins and tags of shape (N,)."""
    shift = configuration.margin_bits
    return [tag << shift | margin for margin, tag in zip(margins.tolist(), tags.tolist(), strict=True)]


def unpack_user(
    words: list[int], configuration: Configuration
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Return margins and tags in TUSER words: the inverse of `pack_user`."""
    shift = configuration.margin_bits
    mask = (1 << shift) - 1
    margins = np.array([word & mask for word in words], np.int64)
    tags = np.array([word >> shift for word in words], np.int64)
    return margins, tags
