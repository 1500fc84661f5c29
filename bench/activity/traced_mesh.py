"""The mesh engine that follows its own switching activity while it runs."""

import ctypes
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from triaxis.bench.activity.traced_build import FOLDER, TracedBuild, traced_library
from triaxis.sim.core_engine import CoreError
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.mesh_engine import Mode, Status
from triaxis.sim.paths import DUT, SIM, mesh_sources

# Fields of the summary in sim/mesh_harness.cpp.
_STATUS, _NEAR, _FIELDS = 0, 6, 8


class TracedMeshEngine:
    """The engine in one configuration, built on first use."""

    def __init__(self, configuration: MeshConfiguration, dut: Path = DUT) -> None:
        """Build the engine where needed, and load it. ``dut``: another folder of the same files."""
        self.configuration = configuration
        build = TracedBuild(
            f"mesh_{configuration.name}", "triaxis_mesh", "Vmesh", configuration.parameters,
            {
                "WIDTH": configuration.width,
                "MARGIN_BITS": configuration.margin_bits,
                "INDEX_BITS": configuration.index_bits,
            },
            (FOLDER / "mesh.cpp", SIM / "mesh_harness.cpp"),
            (*mesh_sources(dut), SIM / "mesh_public.vlt"),
        )  # fmt: skip
        library = ctypes.CDLL(str(traced_library(build, dut)))
        pointer, number, small = ctypes.c_void_p, ctypes.c_int64, ctypes.c_int
        seed, chance = ctypes.c_uint64, ctypes.c_uint32
        self._new, self._delete = library.triaxis_mesh_new, library.triaxis_mesh_delete
        self._new.restype, self._delete.argtypes = pointer, [pointer]
        self._load, self._run = library.triaxis_mesh_load, library.triaxis_mesh_run
        self._load.restype = self._run.restype = number
        self._load.argtypes = [pointer, small, pointer, number, seed, chance]
        self._run.argtypes = [
            pointer, pointer, seed, small, number, seed, chance, pointer, number, pointer, number, pointer,
        ]  # fmt: skip
        self._open, self._close = library.triaxis_trace_open, library.triaxis_trace_close
        self._open.argtypes, self._close.argtypes = [pointer, ctypes.c_char_p], [pointer]

    def count_near(
        self, a: npt.NDArray[np.integer[Any]], b: npt.NDArray[np.integer[Any]], margin: int, file: Path
    ) -> int:
        """Load meshes (N, 3, 3) and (M, 3, 3), run at a margin in LSB; return how many pairs are near.

        What toggled during the run, without loading, is written to ``file`` as SAIF, at 100 MHz.
        """
        file.parent.mkdir(parents=True, exist_ok=True)
        handle = self._new()
        try:
            for mesh, triangles in enumerate((a, b)):
                words = np.ascontiguousarray(triangles, np.int32)
                if self._load(handle, mesh, words.ctypes.data, len(words), 1, 0) != len(words):
                    raise CoreError(f"mesh engine {self.configuration.name}: does not load")
            move, summary = np.zeros(3, np.int64), np.zeros(_FIELDS, np.int64)
            self._open(handle, str(file).encode())
            done = self._run(
                handle, move.ctypes.data, margin, int(Mode.COUNT), -1, 1, 0, None, 0, None, 0,
                summary.ctypes.data,
            )  # fmt: skip
            self._close(handle)
        finally:
            self._delete(handle)
        if done < 0 or summary[_STATUS] != Status.COMPLETE:
            raise CoreError(f"mesh engine {self.configuration.name}: the run did not end complete")
        return int(summary[_NEAR])
