"""The combinational wrapper CollisionDetector as a function on arrays."""

import ctypes
from pathlib import Path

import numpy as np
import numpy.typing as npt

from triaxis.golden.errors import InputError
from triaxis.golden.pairs import Pairs, check_pairs, coordinate_range
from triaxis.sim.build import detector_library
from triaxis.sim.paths import DUT

WIDTH = 16


def detect(pairs: Pairs, normals: npt.NDArray[np.int64], dut: Path = DUT) -> npt.NDArray[np.bool_]:
    """Return CollisionOccurs for pairs (N, 2, 3, 3) with given normals (N, 2, 3): (N,).

    ``dut``: another folder of RTL with the same files. Raises InputError for what does not fit the ports.
    """
    pairs = check_pairs(pairs, WIDTH)
    low, high = coordinate_range(WIDTH)
    if normals.min(initial=0) < low or normals.max(initial=0) > high:
        raise InputError(f"normals: must be {low}..{high} (width {WIDTH})")
    function = ctypes.CDLL(str(detector_library(WIDTH, dut))).triaxis_detect
    function.argtypes = [ctypes.c_void_p, ctypes.c_int64, ctypes.c_void_p]
    function.restype = None
    count = len(pairs)
    mask = (1 << WIDTH) - 1
    inputs = np.concatenate([pairs.reshape(count, 18), normals.reshape(count, 6)], 1) & mask
    inputs = np.ascontiguousarray(inputs, np.int64)
    collides = np.zeros(count, np.uint8)
    function(inputs.ctypes.data, count, collides.ctypes.data)
    return collides.astype(np.bool_)
