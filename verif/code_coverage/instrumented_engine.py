"""The mesh engine built with coverage counters, and played with scripts. The core in it has none there."""

import ctypes
from collections.abc import Sequence
from pathlib import Path

from triaxis.sim.paths import DUT
from triaxis.verif.code_coverage.instrumented_core import FOLDER, Model, instrumented_library
from triaxis.verif.mutation.engine_play import EnginePlay
from triaxis.verif.mutation.models import SYMPTOMS
from triaxis.verif.mutation.targets import EngineTarget


def engine_model(target: EngineTarget) -> Model:
    """Return the mesh engine in that configuration."""
    return Model(target.name, target.top, target.parameters, above_core=True)


class InstrumentedEngine:
    """The mesh engine in one configuration with coverage counters, built on first use."""

    def __init__(self, target: EngineTarget, dut: Path = DUT) -> None:
        """Build the engine where needed, and load it."""
        path = instrumented_library(
            engine_model(target), FOLDER / "engine.cpp", "Vengine", target.defines, dut
        )
        library = ctypes.CDLL(str(path))
        pointer, number = ctypes.c_void_p, ctypes.c_int64
        self._open = library.triaxis_cover_open
        self._open.restype = pointer
        self._play = library.triaxis_cover_play
        self._play.argtypes = [pointer, pointer, number, pointer, pointer, pointer, pointer]
        self._close = library.triaxis_cover_close
        self._close.argtypes = [pointer, ctypes.c_char_p]
        self._close.restype = None

    def play(self, plays: Sequence[EnginePlay], file: Path) -> tuple[int, list[str]]:
        """Play scripts one after the other; write the coverage to ``file``.

        Returns how many runs were right, and what was wrong, one line a script.
        """
        handle, runs, wrong = self._open(), 0, []
        for play in plays:
            checked = ctypes.c_int64()
            symptom = self._play(
                handle, play.steps.ctypes.data, len(play.steps), play.triangles.ctypes.data,
                play.near.ctypes.data, play.clocks.ctypes.data, ctypes.byref(checked),
            )  # fmt: skip
            runs += checked.value
            if symptom:
                wrong.append(f"{play.family}: {SYMPTOMS[symptom]}")
        self._close(handle, str(file).encode())
        return runs, wrong
