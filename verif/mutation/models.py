"""A mutated model under play: loaded from its library, and what it does wrong."""

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from triaxis.verif.mutation.engine_play import EnginePlay
from triaxis.verif.mutation.stimulus import Play
from triaxis.verif.mutation.targets import AnyTarget, EngineTarget

# In the order of harness.h.
SYMPTOMS = (
    "", "wrong word", "wrong tag", "unexpected result", "hangs", "wrong latency", "not ready",
    "result changes while it waits", "not quiet in reset", "assertion", "does not settle",
    "wrong status", "wrong number of clocks", "wrong counters", "wrong near pair", "near pair lost",
    "wrong number of triangles", "ready or busy at a wrong time", "summary too early",
)  # fmt: skip
ASSERTION = "assertion"

AnyPlay = Play | EnginePlay

_POINTER, _NUMBER = ctypes.c_void_p, ctypes.c_int64


@dataclass(frozen=True)
class Killed:
    """How a mutant was found out: the test and family, the model, what was wrong, after how many pairs.

    Of the mesh engine, after how many runs.
    """

    test: str
    family: str
    target: str
    symptom: str
    pairs: int


class Library:
    """A shared library of mutants of one target."""

    def __init__(self, path: Path, target: AnyTarget) -> None:
        """Load it."""
        self.target = target
        self._library: Any = ctypes.CDLL(str(path))
        self._library.triaxis_open.restype = _POINTER
        self._library.triaxis_open.argtypes = [ctypes.c_uint32]
        self._library.triaxis_close.argtypes = [_POINTER]
        self._library.triaxis_close.restype = None
        if isinstance(target, EngineTarget):
            self._run = self._library.triaxis_engine
            self._run.argtypes = [
                _POINTER, _POINTER, _NUMBER, _POINTER, _POINTER, _POINTER, _POINTER,
            ]  # fmt: skip
        elif target.combinational:
            self._run = self._library.triaxis_detect
            self._run.argtypes = [_POINTER, _POINTER, _POINTER, _NUMBER, _POINTER]
        else:
            self._library.triaxis_data_bytes.restype = _NUMBER
            self._data_bytes = int(self._library.triaxis_data_bytes())
            self._run = self._library.triaxis_play
            self._run.argtypes = [
                _POINTER, _POINTER, _POINTER, _POINTER, _NUMBER, _POINTER, _NUMBER, _NUMBER, _POINTER,
            ]  # fmt: skip
        self._run.restype = ctypes.c_int32
        self._packed: dict[int, Any] = {}

    def close(self) -> None:
        """Unload it: thousands of libraries would be too many."""
        import _ctypes

        _ctypes.dlclose(self._library._handle)

    def play(self, selected: int, plays: Sequence[AnyPlay]) -> Killed | None:
        """Return how the mutant with that number is found out by the plays in turn; None where it is not."""
        model = self._library.triaxis_open(selected)
        before = 0
        try:
            for play in plays:
                symptom, checked = self._one(model, play)
                if symptom:
                    return Killed(
                        play.test, play.family, self.target.name, SYMPTOMS[symptom], before + checked
                    )
                before += checked
        finally:
            self._library.triaxis_close(model)
        return None

    def _one(self, model: int, play: AnyPlay) -> tuple[int, int]:
        checked = ctypes.c_int64()
        if isinstance(play, EnginePlay):
            symptom = self._run(
                model, play.steps.ctypes.data, len(play.steps), play.triangles.ctypes.data,
                play.near.ctypes.data, play.clocks.ctypes.data, ctypes.byref(checked),
            )  # fmt: skip
            return symptom, checked.value
        if self.target.combinational:
            symptom = self._run(
                model, play.coordinates.ctypes.data, play.collides.ctypes.data, len(play),
                ctypes.byref(checked),
            )  # fmt: skip
            return symptom, checked.value
        data = self._data(play)
        assert not isinstance(self.target, EngineTarget)
        symptom = self._run(
            model, data.ctypes.data, play.user.ctypes.data, play.expected.ctypes.data, len(play),
            play.steps.ctypes.data, len(play.steps), self.target.latency, ctypes.byref(checked),
        )  # fmt: skip
        return symptom, checked.value

    def _data(self, play: Play) -> Any:
        # The play is kept with its words: its id stays its own as long.
        if id(play) not in self._packed:
            self._packed[id(play)] = (play, play.data(self._data_bytes))
        return self._packed[id(play)][1]
