"""The bare Verilated mesh engine as an object with two meshes."""

import ctypes
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from triaxis.golden.errors import InputError
from triaxis.golden.pairs import coordinate_range
from triaxis.sim.build import mesh_library
from triaxis.sim.core_engine import CoreError
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.paths import DUT

Move = tuple[int, int, int]


class Mode(IntEnum):
    """What a run is to do; mode_e of triaxis_mesh_pkg."""

    FIRST = 0
    ALL = 1
    COUNT = 2


class Status(IntEnum):
    """How a run ended; status_e of triaxis_mesh_pkg."""

    COMPLETE = 1
    FIRST = 2
    ABORTED = 3
    OVERFLOW = 4
    OVERFULL = 5
    BAD_MODE = 6


@dataclass(frozen=True)
class MeshRun:
    """What a run answered.

    ``near`` (K, 2): near pairs as (number in A, number in B), in the order of the scan. ``reached`` (T, 2):
    the pairs that reached the core, in the same form, where they were asked for.
    """

    status: Status
    cycles: int
    group_pairs_skipped: int
    group_pairs_opened: int
    pairs_skipped: int
    tested: int
    near_count: int
    near: npt.NDArray[np.int64]
    reached: npt.NDArray[np.int64] | None = None


@dataclass(frozen=True)
class Traffic:
    """How a run's streams are treated: stalls with a chance in 256, repeated by seed; an abort at a clock."""

    seed: int = 1
    stall_chance: int = 0
    abort_at: int = -1


class _Summary(ctypes.Structure):
    _fields_ = [
        (name, ctypes.c_int64)
        for name in (
            "status",
            "cycles",
            "group_pairs_skipped",
            "group_pairs_opened",
            "pairs_skipped",
            "tested",
            "near_count",
            "reached",
        )
    ]


_NO_STALLS = Traffic()


class MeshEngine:
    """The engine in one configuration, built on first use."""

    def __init__(self, configuration: MeshConfiguration, dut: Path = DUT, traced: bool = False) -> None:
        """Build the engine where needed, load and reset it. ``dut``: another folder of the same files.

        ``traced``: a build that follows its own switching activity; see `followed`.
        """
        self.configuration = configuration
        self.counts: tuple[int, int] = (0, 0)
        self.library = library = ctypes.CDLL(str(mesh_library(configuration, dut, traced)))
        self._delete = library.triaxis_mesh_delete
        self._delete.argtypes = [ctypes.c_void_p]
        library.triaxis_mesh_new.restype = ctypes.c_void_p
        self._load = library.triaxis_mesh_load
        self._load.restype = ctypes.c_int64
        self._load.argtypes = [
            ctypes.c_void_p, ctypes.c_int, ctypes.c_void_p, ctypes.c_int64, ctypes.c_uint64, ctypes.c_uint32,
        ]  # fmt: skip
        self._run = library.triaxis_mesh_run
        self._run.restype = ctypes.c_int64
        self._run.argtypes = [
            ctypes.c_void_p, ctypes.c_void_p, ctypes.c_uint64, ctypes.c_int, ctypes.c_int64, ctypes.c_uint64,
            ctypes.c_uint32, ctypes.c_void_p, ctypes.c_int64, ctypes.c_void_p, ctypes.c_int64,
            ctypes.c_void_p,
        ]  # fmt: skip
        self._handle = library.triaxis_mesh_new()

    def __del__(self) -> None:
        """Free the model."""
        if getattr(self, "_handle", None):
            self._delete(self._handle)
            self._handle = None

    def load(
        self, a: npt.NDArray[np.integer[Any]], b: npt.NDArray[np.integer[Any]], traffic: Traffic = _NO_STALLS
    ) -> None:
        """Load meshes of shape (N, 3, 3) and (M, 3, 3), coordinates in LSB.

        Raises InputError where they do not fit.
        """
        for mesh, triangles in enumerate((a, b)):
            if len(triangles) > self.configuration.depth:
                raise InputError(
                    f"mesh {'AB'[mesh]}: {len(triangles)} triangles: the engine holds "
                    f"{self.configuration.depth}; split the mesh, or build the engine with a greater depth"
                )
            held = self.load_unchecked(mesh, triangles, traffic)
            if held != len(triangles):
                what = f"holds {held} of the {len(triangles)} triangles of {'AB'[mesh]}"
                raise CoreError(f"mesh engine {self.configuration.name}: {what}")

    def load_unchecked(
        self, mesh: int, triangles: npt.NDArray[np.integer[Any]], traffic: Traffic = _NO_STALLS
    ) -> int:
        """Load mesh 0 (A) or 1 (B), more than fit too; return how many triangles the engine then holds."""
        low, high = coordinate_range(self.configuration.width)
        if len(triangles) and (triangles.min() < low or triangles.max() > high):
            raise InputError(f"mesh {'AB'[mesh]}: coordinates must be {low}..{high}")
        words = np.ascontiguousarray(triangles, np.int32)
        held = self._load(
            self._handle, mesh, words.ctypes.data, len(words), traffic.seed, traffic.stall_chance
        )
        if held < 0:
            raise CoreError(f"mesh engine {self.configuration.name}: not ready to load")
        counts = list(self.counts)
        counts[mesh] = len(words)
        self.counts = (counts[0], counts[1])
        return int(held)

    def run(
        self,
        translation: Move = (0, 0, 0),
        margin: int = 0,
        mode: int = Mode.ALL,
        traffic: Traffic = _NO_STALLS,
        reached: bool = False,
    ) -> MeshRun:
        """Run at a translation of A and a margin, both in LSB.

        ``reached``: note the pairs that reach the core. Raises InputError where translation or margin are
        beyond the engine's ports, CoreError where it hangs.
        """
        limit = 1 << self.configuration.width
        if not all(-limit <= part < limit for part in translation):
            raise InputError(f"translation {translation}: must be {-limit}..{limit - 1} in each coordinate")
        if not 0 <= margin <= self.configuration.max_margin:
            raise InputError(f"margin {margin}: must be 0..{self.configuration.max_margin}")
        pairs = self.counts[0] * self.counts[1]
        near = np.zeros((pairs if mode == Mode.ALL else 1, 2), np.uint32)
        tested = np.zeros((pairs if reached else 0, 2), np.uint32)
        move = np.array(translation, np.int64)
        summary = _Summary()
        streamed = self._run(
            self._handle, move.ctypes.data, margin, int(mode), traffic.abort_at, traffic.seed,
            traffic.stall_chance, near.ctypes.data, len(near), tested.ctypes.data, len(tested),
            ctypes.byref(summary),
        )  # fmt: skip
        if streamed < 0:
            raise CoreError(f"mesh engine {self.configuration.name}: it hangs")
        if streamed > len(near):
            raise CoreError(f"mesh engine {self.configuration.name}: {streamed} near pairs of {pairs}")
        if reached and summary.reached > len(tested):
            raise CoreError(
                f"mesh engine {self.configuration.name}: tested {summary.reached} of {pairs} pairs"
            )
        return MeshRun(
            Status(summary.status),
            summary.cycles,
            summary.group_pairs_skipped,
            summary.group_pairs_opened,
            summary.pairs_skipped,
            summary.tested,
            summary.near_count,
            near[:streamed].astype(np.int64),
            tested[: summary.reached].astype(np.int64) if reached else None,
        )
