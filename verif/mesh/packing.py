"""Beats of the engine's streams, from numbers and back."""

from collections.abc import Iterable, Sequence

import numpy as np

from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.verif.mesh.items import RunRequest
from triaxis.verif.mesh.observed import Integers


def _packed(values: Iterable[int], bits: int) -> int:
    mask = (1 << bits) - 1
    return sum((value & mask) << bits * n for n, value in enumerate(values))


def _unpacked(word: int, bits: int, count: int) -> list[int]:
    """Return signed numbers, the lowest first."""
    sign, mask = 1 << (bits - 1), (1 << bits) - 1
    return [((word >> bits * n & mask) ^ sign) - sign for n in range(count)]


def pack_triangle(triangle: Sequence[int], width: int) -> int:
    """Return tdata for nine coordinates."""
    return _packed(triangle, width)


def unpack_triangle(data: int, width: int) -> Integers:
    """Return a triangle (3, 3)."""
    return np.array(_unpacked(data, width, 9), np.int64).reshape(3, 3)


def pack_run(request: RunRequest, configuration: MeshConfiguration) -> tuple[int, int]:
    """Return tdata and tuser of a run."""
    data = _packed(request.translation, configuration.width + 1)
    return data, request.mode << configuration.margin_bits | request.margin


def unpack_run(data: int, user: int, configuration: MeshConfiguration) -> RunRequest:
    """Return what a beat asks for."""
    x, y, z = _unpacked(data, configuration.width + 1, 3)
    return RunRequest((x, y, z), user & configuration.max_margin, user >> configuration.margin_bits)


def unpack_pair(data: int, configuration: MeshConfiguration) -> tuple[int, int]:
    """Return (index in A, index in B) of a near pair's tdata."""
    return data & (configuration.depth - 1), data >> configuration.index_bits
