"""The Verilated mesh engine as Python sees it: a bus-functional model of its streams; meshes to be run."""

import ctypes
from collections.abc import Iterable
from dataclasses import dataclass, replace
from enum import IntEnum
from typing import Any

import numpy as np
import numpy.typing as npt

from triaxis.golden.errors import InputError
from triaxis.golden.pairs import coordinate_range
from triaxis.sim.core_engine import CoreError
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.models import mesh_build
from triaxis.sim.player import HANGS, SYMPTOMS, Player
from triaxis.sim.verilate import MANY, SAIF, library

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
    FAULT = 7


class Trial(IntEnum):
    """What a run tries; trial_kind_e of triaxis_mesh_pkg."""

    NOTHING = 0
    CLAIM = 1
    PARITY = 2
    NUMBER = 3
    MEMORY = 4
    WALK = 5
    INTAKE = 6
    BOARD = 7


@dataclass(frozen=True)
class MeshRun:
    """What a run answered.

    ``near`` (K, 2): near pairs as (number in A, number in B), in the order of the scan; in a run with zones
    not quite. ``zones``: bits of the zones slow and warn, 0 of a complete run where nothing is in the
    zone, and it is wider than the one within it.
    """

    status: Status
    cycles: int
    group_pairs_skipped: int
    group_pairs_opened: int
    pairs_skipped: int
    tested: int
    near_count: int
    zones: int
    near: npt.NDArray[np.int64]


# Kinds of events, in the order of mesh_player.cpp: what a monitor sees. Of those from NEAR on there are many.
LOADED, ACCEPTED, ABORTED, SUMMARY, RESET, NEAR, REACHED = range(7)
EVENT = np.dtype([(name, np.uint32) for name in ("kind", "a", "b", "c")])
# Of a loaded word: bits of ``a``.
OF_B, CLEAR, WITH_RUN = 1, 2, 4
# Of an accepted run: what was high since the run before.
IDLE_ABORT, ACKNOWLEDGED = 1, 2
# Numbers that come with a loaded triangle, with a run, with a summary; with others none.
NUM_VALUES = np.array([9, 8, 0, 17, 0, 0, 0])

# Margins of the outer zones, slow and warn: none is wider than the run's margin.
NO_ZONES = 0, 0
Runs = npt.NDArray[np.uint16]
ALWAYS: Runs = np.zeros(0, np.uint16)


class _Load(ctypes.Structure):
    _fields_ = (
        ("mesh", ctypes.c_int64),
        ("clear", ctypes.c_int64),
        ("count", ctypes.c_int64),
        ("triangles", ctypes.c_void_p),
        ("num_runs", ctypes.c_int64),
        ("runs", ctypes.c_void_p),
    )


class _Run(ctypes.Structure):
    _fields_ = (
        ("move", ctypes.c_int64 * 3),
        ("margins", ctypes.c_int64 * 3),
        ("mode", ctypes.c_int64),
        ("trial", ctypes.c_int64),
        ("acknowledge", ctypes.c_int64),
        ("idle_abort", ctypes.c_int64),
        ("num_aborts", ctypes.c_int64),
        ("aborts", ctypes.c_void_p),
    )


class _Progress(ctypes.Structure):
    _fields_ = tuple(
        (name, ctypes.c_int64)
        for name in ("asserted", "hung", "clock", "loading", "accepted", "ended", "clocks")
    )


@dataclass(frozen=True)
class MeshProgress:
    """How far an engine is: whether triangles are left to be loaded, runs that were accepted, and ended.

    ``asserted``: an assertion has failed. ``symptom``: what else is wrong, "" where nothing is. ``clock``:
    all clocks so far; ``clocks``: those of the last run that ended, from its acceptance.
    """

    asserted: bool
    symptom: str
    clock: int
    loading: bool
    accepted: int
    ended: int
    clocks: int


class MeshPlayer(Player):
    """The mesh engine of a library behind a bus-functional model; in reset at first."""

    def watch(self, loads: bool, core: bool) -> None:
        """Note what is loaded, and what reaches the core, or do not: it costs time."""
        self.library.triaxis_watch(self.model, int(loads), int(core))

    def set_reset(self, active: bool) -> None:
        """Assert reset, or release it, between two edges."""
        self.library.triaxis_reset(self.model, int(active))

    def set_paces(self, near: Runs = ALWAYS, done: Runs = ALWAYS) -> None:
        """Take near pairs and summaries by patterns of clocks on and off, alternating; empty: always."""
        self.library.triaxis_paces(self.model, *_address(near), *_address(done))

    def load(
        self, mesh: int, triangles: npt.NDArray[np.integer[Any]], clear: bool = True, gaps: Runs = ALWAYS
    ) -> None:
        """Begin to offer triangles (N, 3, 3) for mesh 0 or 1, which is emptied first or not."""
        # Held here: C++ keeps a pointer to them until the last is accepted.
        self._held = np.ascontiguousarray(triangles, np.int32)
        load = _Load(
            mesh, int(clear), len(self._held), self._held.ctypes.data, len(gaps), gaps.ctypes.data
        )  # fmt: skip
        self.library.triaxis_load(self.model, ctypes.byref(load))

    def offer(
        self, translation: Move, margin: int, mode: int, trial: int = 0, aborts: Iterable[int] = (),
        idle_abort: bool = False, acknowledge: bool = False, zones: tuple[int, int] = NO_ZONES,
    ) -> None:  # fmt: skip
        """Offer a run: while no other is offered. ``aborts``: clocks after its acceptance; ``zones``: slow,
        warn.

        ``idle_abort``, ``acknowledge``: this is high for a clock before it is offered.
        """
        clocks = np.array(sorted(set(aborts)), np.int64)
        run = _Run(
            (ctypes.c_int64 * 3)(*translation), (ctypes.c_int64 * 3)(margin, *zones), mode, trial,
            int(acknowledge), int(idle_abort), len(clocks), clocks.ctypes.data,
        )  # fmt: skip
        self.library.triaxis_offer(self.model, ctypes.byref(run))

    def run(self, clocks: int) -> MeshProgress:
        """Run for so many clocks at most: until a load is over, a run is accepted or has ended.

        Also until events are to be fetched, or an assertion fails for the first time.
        """
        progress = _Progress()
        symptom = self.library.triaxis_run(self.model, ctypes.c_int64(clocks), ctypes.byref(progress))
        return MeshProgress(
            bool(progress.asserted), SYMPTOMS[symptom] or (HANGS if progress.hung else ""), progress.clock,
            bool(progress.loading), progress.accepted, progress.ended, progress.clocks,
        )  # fmt: skip

    def events(self) -> tuple[npt.NDArray[np.void], npt.NDArray[np.int64]]:
        """Return what was seen since the last call, of `EVENT` in order of time, and the numbers with it."""
        counts = ctypes.c_int64(), ctypes.c_int64()
        self.library.triaxis_noted(self.model, *map(ctypes.byref, counts))
        events, values = np.empty(counts[0].value, EVENT), np.empty(counts[1].value, np.int64)
        self.library.triaxis_fetch(
            self.model, ctypes.c_void_p(events.ctypes.data), ctypes.c_void_p(values.ctypes.data)
        )
        return events, values

    def held(self, mesh: int) -> int:
        """Return how many triangles the engine says that it holds of mesh 0 or 1."""
        self.library.triaxis_held.restype = ctypes.c_int64
        return int(self.library.triaxis_held(self.model, mesh))


def _address(runs: Runs) -> tuple[ctypes.c_void_p, ctypes.c_int64]:
    return ctypes.c_void_p(runs.ctypes.data), ctypes.c_int64(len(runs))


def pairs_of(events: npt.NDArray[np.void], kind: int) -> npt.NDArray[np.int64]:
    """Return the pairs (N, 2) of events of a kind: NEAR or REACHED."""
    some = events[events["kind"] == kind]
    return np.stack([some["a"], some["b"]], 1).astype(np.int64)


# Clocks after which the model returns in any case.
_MOST_CLOCKS = 1 << 40


class MeshEngine:
    """The engine in one configuration, built on first use."""

    def __init__(self, configuration: MeshConfiguration, traced: bool = False) -> None:
        """Build the engine where needed, load and reset it.

        ``traced``: a build that follows its own switching activity; see `triaxis.sim.player.followed`.
        """
        self.configuration = configuration
        self.counts: tuple[int, int] = (0, 0)
        build = mesh_build(configuration)
        self._player = MeshPlayer(library(replace(build, trace=SAIF, speed=MANY) if traced else build))
        self.library = self._player.library
        self._player.run(1)
        self._player.set_reset(False)
        self._player.run(1)

    def load(self, a: npt.NDArray[np.integer[Any]], b: npt.NDArray[np.integer[Any]]) -> None:
        """Load meshes of shape (N, 3, 3) and (M, 3, 3), coordinates in LSB.

        Raises InputError where they do not fit.
        """
        for mesh, triangles in enumerate((a, b)):
            if len(triangles) > self.configuration.depth:
                raise InputError(
                    f"mesh {'AB'[mesh]}: {len(triangles)} triangles: the engine holds "
                    f"{self.configuration.depth}; split the mesh, or build the engine with a greater depth"
                )
            held = self.load_unchecked(mesh, triangles)
            if held != len(triangles):
                what = f"holds {held} of the {len(triangles)} triangles of {'AB'[mesh]}"
                raise CoreError(f"mesh engine {self.configuration.name}: {what}")

    def load_unchecked(self, mesh: int, triangles: npt.NDArray[np.integer[Any]]) -> int:
        """Load mesh 0 (A) or 1 (B), more than fit too; return how many triangles the engine then holds."""
        low, high = coordinate_range(self.configuration.width)
        if len(triangles) and (triangles.min() < low or triangles.max() > high):
            raise InputError(f"mesh {'AB'[mesh]}: coordinates must be {low}..{high}")
        self._player.watch(False, False)
        self._player.load(mesh, triangles)
        if self._player.run(_MOST_CLOCKS).loading:
            raise CoreError(f"mesh engine {self.configuration.name}: not ready to load")
        counts = list(self.counts)
        counts[mesh] = len(triangles)
        self.counts = (counts[0], counts[1])
        return self._player.held(mesh)

    def run(
        self, translation: Move = (0, 0, 0), margin: int = 0, mode: int = Mode.ALL,
        zones: tuple[int, int] = NO_ZONES,
    ) -> MeshRun:  # fmt: skip
        """Run at a translation of A, a margin, and those of the zones slow and warn, all in LSB.

        Raises InputError where they are beyond the engine's ports, CoreError where it hangs.
        """
        limit = 1 << self.configuration.width
        if not all(-limit <= part < limit for part in translation):
            raise InputError(f"translation {translation}: must be {-limit}..{limit - 1} in each coordinate")
        for one in (margin, *zones):
            if not 0 <= one <= self.configuration.max_margin:
                raise InputError(f"margin {one}: must be 0..{self.configuration.max_margin}")
        pairs = self.counts[0] * self.counts[1]
        self._player.watch(False, False)
        self._player.offer(translation, margin, mode, zones=zones)
        near, summary = self._follow()
        if len(near) > pairs:
            raise CoreError(f"mesh engine {self.configuration.name}: {len(near)} near pairs of {pairs}")
        return MeshRun(Status(summary[0]), *summary[1:8], near=near)

    def _follow(self) -> tuple[npt.NDArray[np.int64], list[int]]:
        """Run until a summary was taken; return near pairs, and what it says."""
        parts: list[npt.NDArray[np.void]] = []
        before = self._player.run(0).ended
        progress = self._player.run(_MOST_CLOCKS)
        while True:
            events, values = self._player.events()
            parts.append(events)
            if progress.symptom:
                raise CoreError(f"mesh engine {self.configuration.name}: {progress.symptom}")
            if progress.ended > before:
                break
            progress = self._player.run(_MOST_CLOCKS)
        seen = np.concatenate(parts)
        return pairs_of(seen, NEAR), values[-NUM_VALUES[SUMMARY] :].tolist()


def spatial_order(triangles: npt.NDArray[Any], group: int) -> npt.NDArray[np.int64]:
    """Return the numbers of triangles (N, 3, 3) in an order with compact groups of ``group``: (N,).

    The set is cut in two across the longest side of the box of its boxes' centres, at a multiple of
    the group next to the median, and each part again, as a k-d tree is built.
    """
    # Twice the centres of the boxes, in the unit of the coordinates.
    centres = triangles.min(1).astype(np.float64) + triangles.max(1).astype(np.float64)
    parts = [np.arange(len(triangles))]
    done: list[npt.NDArray[np.int64]] = []
    while parts:
        part = parts.pop()
        if len(part) <= group:
            done.append(part)
            continue
        groups = -(-len(part) // group)
        # All groups but the last are full: the first part takes whole ones.
        half = groups // 2 * group
        axis = int(np.argmax(np.ptp(centres[part], axis=0)))
        sorted_part = part[np.argsort(centres[part, axis], kind="stable")]
        parts += [sorted_part[half:], sorted_part[:half]]
    return np.concatenate(done) if done else np.zeros(0, np.int64)
