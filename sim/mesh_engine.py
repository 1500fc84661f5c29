"""The bare Verilated mesh engine as an object with two meshes."""

import ctypes
from dataclasses import dataclass, replace
from enum import IntEnum
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from triaxis.golden.errors import InputError
from triaxis.golden.pairs import coordinate_range
from triaxis.sim.core_engine import CoreError
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.models import mesh_build
from triaxis.sim.paths import DUT
from triaxis.sim.player import SYMPTOMS, Player
from triaxis.sim.verilate import MANY
from triaxis.sim.verilate import library as built_library

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


# In the order of Step in mesh_player.cpp.
_FIELDS = (
    "kind", "mesh", "clear", "first", "count", "held_a", "held_b", "overfull", "move_x", "move_y", "move_z",
    "margin", "mode", "abort_at", "abort_clocks", "status", "exact", "group_pairs_skipped",
    "group_pairs_opened", "pairs_skipped", "tested", "near_count", "near_first", "near_length", "seed",
    "stall", "hold", "early", "cut",
)  # fmt: skip
STEP = np.dtype([(name, np.int64) for name in _FIELDS])
LOAD, RUN, RESET = 0, 1, 2
NEVER = -1
UNKNOWN_CLOCKS = -1


def mesh_step(**values: int) -> npt.NDArray[np.void]:
    """Return a step of `STEP` with these values, the others none."""
    none = dict.fromkeys(_FIELDS, 0) | {"abort_at": NEVER, "abort_clocks": 1, "cut": NEVER}
    unknown = values.keys() - none.keys()
    if unknown:
        raise ValueError(f"{', '.join(unknown)}: not of a step")
    return np.array([tuple(int((none | values)[name]) for name in _FIELDS)], STEP)


@dataclass(frozen=True)
class MeshScript:
    """Steps (S,) of `STEP` from a reset on, with the triangles (N, 9) and near pairs (K, 2) they name.

    ``clocks`` (S,): those of each run, UNKNOWN_CLOCKS where it is not known yet: then it is filled in.
    """

    steps: npt.NDArray[np.void]
    triangles: npt.NDArray[np.int32]
    near: npt.NDArray[np.uint32]
    clocks: npt.NDArray[np.int64]


class _Script(ctypes.Structure):
    _fields_ = (
        ("steps", ctypes.c_void_p),
        ("num_steps", ctypes.c_int64),
        ("triangles", ctypes.c_void_p),
        ("near", ctypes.c_void_p),
        ("clocks", ctypes.c_void_p),
    )


class _Answer(ctypes.Structure):
    _fields_ = (
        ("near", ctypes.c_void_p),
        ("near_room", ctypes.c_int64),
        ("reached", ctypes.c_void_p),
        ("reached_room", ctypes.c_int64),
        ("near_count", ctypes.c_int64),
        ("reached_count", ctypes.c_int64),
        ("summary", ctypes.c_uint64 * 7),
    )


class MeshPlayer(Player):
    """The mesh engine of a library."""

    def play(self, script: MeshScript) -> tuple[str, int]:
        """Play a script from reset; return what is wrong, and how many runs were right before."""
        given = _Script(
            script.steps.ctypes.data, len(script.steps), script.triangles.ctypes.data,
            script.near.ctypes.data, script.clocks.ctypes.data,
        )  # fmt: skip
        checked = ctypes.c_int64()
        play = self.library.triaxis_mesh_play
        play.argtypes = [ctypes.c_void_p] * 3
        symptom = play(self.model, ctypes.byref(given), ctypes.byref(checked))
        return SYMPTOMS[symptom], checked.value

    def held(self, mesh: int) -> int:
        """Return how many triangles the engine says that it holds of mesh 0 or 1."""
        held = self.library.triaxis_mesh_held
        held.argtypes, held.restype = [ctypes.c_void_p, ctypes.c_int], ctypes.c_int64
        return int(held(self.model, mesh))

    def do(
        self,
        step: npt.NDArray[np.void],
        triangles: npt.NDArray[np.int32] | None = None,
        near: npt.NDArray[np.uint32] | None = None,
        reached: npt.NDArray[np.uint32] | None = None,
    ) -> tuple[str, tuple[int, int], list[int]]:
        """Do one step on an engine that is trusted with the rules of its streams; fill ``near``, ``reached``.

        Returns what is wrong, how many near pairs and pairs at the core there were, and the summary.
        """
        answer = _Answer(
            None if near is None else near.ctypes.data, 0 if near is None else len(near),
            None if reached is None else reached.ctypes.data, 0 if reached is None else len(reached),
        )  # fmt: skip
        do = self.library.triaxis_mesh_step
        do.argtypes = [ctypes.c_void_p] * 4
        given = None if triangles is None else triangles.ctypes.data
        symptom = do(self.model, step.ctypes.data, given, ctypes.byref(answer))
        return SYMPTOMS[symptom], (answer.near_count, answer.reached_count), list(answer.summary)


_NO_STALLS = Traffic()


class MeshEngine:
    """The engine in one configuration, built on first use."""

    def __init__(
        self,
        configuration: MeshConfiguration,
        dut: Path = DUT,
        traced: bool = False,
        library: Path | None = None,
    ) -> None:
        """Build the engine where needed, load and reset it. ``dut``: another folder of the same files.

        ``library``: that of another build of it, which is there. ``traced``: a build that follows its own
        switching activity; see `triaxis.sim.player.followed`.
        """
        self.configuration = configuration
        self.counts: tuple[int, int] = (0, 0)
        build = mesh_build(configuration, dut)
        usual = replace(build, traced=True, speed=MANY) if traced else build
        self._player = MeshPlayer(library or built_library(usual))
        self.library = self._player.library

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
        step = mesh_step(
            kind=LOAD, mesh=mesh, clear=1, count=len(words), seed=traffic.seed, stall=traffic.stall_chance
        )
        symptom, _, _ = self._player.do(step, words)
        if symptom:
            raise CoreError(f"mesh engine {self.configuration.name}: not ready to load")
        counts = list(self.counts)
        counts[mesh] = len(words)
        self.counts = (counts[0], counts[1])
        return self._player.held(mesh)

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
        x, y, z = translation
        step = mesh_step(
            kind=RUN, move_x=x, move_y=y, move_z=z, margin=margin, mode=mode, abort_at=traffic.abort_at,
            seed=traffic.seed, stall=traffic.stall_chance,
        )  # fmt: skip
        symptom, (streamed, at_core), summary = self._player.do(step, None, near, tested)
        if symptom:
            raise CoreError(f"mesh engine {self.configuration.name}: it hangs")
        if streamed > len(near):
            raise CoreError(f"mesh engine {self.configuration.name}: {streamed} near pairs of {pairs}")
        if reached and at_core > len(tested):
            raise CoreError(f"mesh engine {self.configuration.name}: tested {at_core} of {pairs} pairs")
        told = near[:streamed].astype(np.int64)
        seen = tested[:at_core].astype(np.int64) if reached else None
        return MeshRun(Status(summary[0]), *summary[1:], near=told, reached=seen)
