"""A mutated model under play: loaded from its library, and what it does wrong."""

import ctypes
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from triaxis.verif.mutation.stimulus import Play
from triaxis.verif.mutation.targets import Target

# In the order of harness.h.
SYMPTOMS = (
    "", "wrong word", "wrong tag", "unexpected result", "hangs", "wrong latency", "not ready",
    "result changes while it waits", "not quiet in reset", "assertion", "does not settle",
)  # fmt: skip
ASSERTION = "assertion"


@dataclass(frozen=True)
class Killed:
    """How a mutant was found out: the test and family, the model, what was wrong, after how many pairs."""

    test: str
    family: str
    target: str
    symptom: str
    pairs: int


class Library:
    """A shared library of mutants of one target."""

    def __init__(self, path: Path, target: Target) -> None:
        """Load it."""
        self.target = target
        self._library: Any = ctypes.CDLL(str(path))
        pointer, number = ctypes.c_void_p, ctypes.c_int64
        self._library.triaxis_open.restype = pointer
        self._library.triaxis_open.argtypes = [ctypes.c_uint32]
        self._library.triaxis_close.argtypes = [pointer]
        self._library.triaxis_close.restype = None
        if target.combinational:
            self._run = self._library.triaxis_detect
            self._run.argtypes = [pointer, pointer, pointer, number, pointer]
        else:
            self._library.triaxis_data_bytes.restype = number
            self._data_bytes = int(self._library.triaxis_data_bytes())
            self._run = self._library.triaxis_play
            self._run.argtypes = [
                pointer, pointer, pointer, pointer, number, pointer, number, number, pointer,
            ]  # fmt: skip
        self._run.restype = ctypes.c_int32
        self._packed: dict[int, Any] = {}

    def close(self) -> None:
        """Unload it: thousands of libraries would be too many."""
        import _ctypes

        _ctypes.dlclose(self._library._handle)

    def play(self, selected: int, plays: list[Play]) -> Killed | None:
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

    def _one(self, model: int, play: Play) -> tuple[int, int]:
        checked = ctypes.c_int64()
        if self.target.combinational:
            symptom = self._run(
                model, play.coordinates.ctypes.data, play.collides.ctypes.data, len(play),
                ctypes.byref(checked),
            )  # fmt: skip
            return symptom, checked.value
        data = self._data(play)
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
