"""The combinational wrapper CollisionDetector as a function on arrays."""

import ctypes
from pathlib import Path

import numpy as np
import numpy.typing as npt

from triaxis.golden.errors import InputError
from triaxis.golden.pairs import Pairs, check_pairs, coordinate_range
from triaxis.sim.core_engine import CoreError
from triaxis.sim.models import DETECTOR_TOP, detector_build
from triaxis.sim.packing import COORDINATES
from triaxis.sim.paths import DUT
from triaxis.sim.player import SYMPTOMS, Player
from triaxis.sim.verilate import library

WIDTH = 16


class DetectorPlayer(Player):
    """The wrapper of a library."""

    def play(self, inputs: npt.NDArray[np.int64]) -> npt.NDArray[np.bool_]:
        """Return CollisionOccurs (N,) for inputs (N, 24); CoreError where the wrapper does not settle."""
        collides = np.zeros(len(inputs), np.uint8)
        detect = self.library.triaxis_detect
        detect.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int64, ctypes.c_void_p]
        symptom = SYMPTOMS[detect(self.model, inputs.ctypes.data, len(inputs), collides.ctypes.data)]
        if symptom:
            raise CoreError(f"{DETECTOR_TOP}: {symptom}")
        return collides.astype(np.bool_)


def detector_inputs(pairs: Pairs, normals: npt.NDArray[np.int64], width: int) -> npt.NDArray[np.int64]:
    """Return the wrapper's inputs (N, 24) for pairs (N, 2, 3, 3) and given normals (N, 2, 3)."""
    count, mask = len(pairs), (1 << width) - 1
    whole = np.concatenate([pairs.reshape(count, COORDINATES), normals.reshape(count, 6)], 1)
    return np.ascontiguousarray(whole & mask, np.int64)


def detect(pairs: Pairs, normals: npt.NDArray[np.int64], dut: Path = DUT) -> npt.NDArray[np.bool_]:
    """Return CollisionOccurs for pairs (N, 2, 3, 3) with given normals (N, 2, 3): (N,).

    ``dut``: another folder of RTL with the same files. Raises InputError for what does not fit the ports.
    """
    pairs = check_pairs(pairs, WIDTH)
    low, high = coordinate_range(WIDTH)
    if normals.min(initial=0) < low or normals.max(initial=0) > high:
        raise InputError(f"normals: must be {low}..{high} (width {WIDTH})")
    player = DetectorPlayer(library(detector_build(WIDTH, dut)))
    return player.play(detector_inputs(pairs, normals, WIDTH))
