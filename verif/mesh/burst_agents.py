"""Drivers and monitors that work through the bus-functional model of a library.

They take the places of the pin-level ones by factory override (`use_bursts`); sequences, scoreboard and
coverage are the same. The model, sim/mesh_player.cpp, runs hundreds of thousands of clocks a second beside a
simulator that has nothing in it: pin by pin Python has a step for each clock.
"""

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt
from cocotb.triggers import Event
from pyuvm import uvm_factory

from triaxis.sim.mesh_engine import (
    ABORTED,
    ACCEPTED,
    ACKNOWLEDGED,
    CLEAR,
    IDLE_ABORT,
    LOADED,
    NEAR,
    NUM_VALUES,
    OF_B,
    REACHED,
    RESET,
    SUMMARY,
    WITH_RUN,
    MeshPlayer,
    MeshProgress,
    pairs_of,
)
from triaxis.verif.core.items import ResetSeen
from triaxis.verif.mesh.items import (
    WHICHES,
    AbortAsked,
    CorePairs,
    Loaded,
    LoadItem,
    NearTaken,
    RunAccepted,
    RunItem,
    RunRequest,
    RunTraffic,
    Summary,
)
from triaxis.verif.mesh.pin_agents import (
    CoreMonitor,
    LoadDriver,
    LoadMonitor,
    NearMonitor,
    ResultReadyDriver,
    RunDriver,
    RunMonitor,
    SummaryMonitor,
)
from triaxis.verif.testbench.environment import bfm_of, settings_of
from triaxis.verif.testbench.fast_model import FastModel

# Clocks on and off that are drawn for a pace; the model uses them over and over.
_RUNS = 2048

Events = npt.NDArray[np.void]
Numbers = npt.NDArray[np.int64]


class MeshBfm(FastModel[MeshPlayer]):
    """The engine's model: it is busy while triangles are loaded, and while a run is offered or under way."""

    def __init__(self) -> None:
        """Nobody is told of anything yet."""
        super().__init__(MeshPlayer)
        self.publish: dict[type, Callable[[Any], None]] = {}
        self._loading = False
        self._loaded, self._moved = Event(), Event()
        self._offered = self._accepted = self._ended = self._clocks = 0

    @property
    def busy(self) -> bool:
        """Return whether a driver waits."""
        return self._loading or self._offered > self._ended

    def follow(self, progress: MeshProgress) -> None:
        """Publish what was seen; tell the drivers what is over."""
        self._publish(*self.player.events())
        if self._loading and not progress.loading:
            self._loading = False
            self._loaded.set()
        if (self._accepted, self._ended) != (progress.accepted, progress.ended):
            self._accepted, self._ended = progress.accepted, progress.ended
            self._clocks = progress.clocks
            self._moved.set()

    async def load(self, item: LoadItem, rng: np.random.Generator) -> None:
        """Offer triangles until the last is accepted."""
        if not item.clear and not len(item.triangles):
            return
        start = self.clock
        self.player.load(item.mesh, item.triangles, item.clear, item.gaps.runs(rng, _RUNS))
        self._loading = True
        self._loaded.clear()
        self.wake()
        await self._loaded.wait()
        item.clocks = self.clock - start

    def offer(self, item: RunItem) -> None:
        """Offer a run."""
        request, traffic = item.request, item.traffic
        self.player.offer(
            request.translation, request.margin, request.mode, request.trial, traffic.aborts,
            traffic.idle_abort, traffic.acknowledge, request.zones,
        )  # fmt: skip
        self._offered += 1
        self.wake()

    async def accepted(self) -> None:
        """Wait until the run that is offered is accepted."""
        while self._accepted < self._offered:
            await self._move()

    async def ended(self, number: int) -> int:
        """Wait until that many runs have ended; return the clocks of the last."""
        while self._ended < number:
            await self._move()
        return self._clocks

    async def _move(self) -> None:
        self._moved.clear()
        await self._moved.wait()

    def _publish(self, events: Events, values: Numbers) -> None:
        """Publish events in their order; what can be told at once, together."""
        if not len(events):
            return
        kinds = events["kind"]
        starts = np.concatenate([[0], np.cumsum(NUM_VALUES[kinds])])
        edges = [0, *(np.flatnonzero(_parted(events)) + 1).tolist(), len(events)]
        for first, last in pairwise(edges):
            self._tell(events[first:last], values[starts[first] : starts[last]])

    def _tell(self, events: Events, values: Numbers) -> None:
        kind, number = int(events["kind"][0]), int(events["a"][0])
        if kind == LOADED:
            triangles = values.reshape(-1, 3, 3)[bool(number & CLEAR) :]
            loaded = Loaded(number & OF_B, bool(number & CLEAR), triangles, bool(number & WITH_RUN))
            self.publish[LoadMonitor](loaded)
        elif kind == ACCEPTED:
            x, y, z, margin, slow, warn, mode, trial = values.tolist()
            request = RunRequest((x, y, z), margin, mode, divmod(trial, WHICHES), (slow, warn))
            before = bool(number & IDLE_ABORT), bool(number & ACKNOWLEDGED)
            self.publish[RunMonitor](RunAccepted(request, *before))
        elif kind == ABORTED:
            self.publish[RunMonitor](AbortAsked(number))
        elif kind == SUMMARY:
            *numbers, held_a, held_b, signature_a, signature_b, overfull, fault, clock = values.tolist()
            self.publish[SummaryMonitor](
                Summary(
                    *numbers,
                    held=(held_a, held_b),
                    signatures=(signature_a, signature_b),
                    overfull=overfull,
                    fault=fault,
                    clock=clock,
                )
            )
        elif kind == RESET:
            self.publish[SummaryMonitor](ResetSeen())
        else:
            self._tell_pairs(events)

    def _tell_pairs(self, events: Events) -> None:
        reached, near = pairs_of(events, REACHED), pairs_of(events, NEAR)
        if len(reached):
            self.publish[CoreMonitor](CorePairs(reached))
        if len(near):
            wait = int(events["c"][events["kind"] == NEAR].max())
            self.publish[NearMonitor](NearTaken(near, wait))


def _parted(events: Events) -> npt.NDArray[np.bool_]:
    """Return whether each event but the first is to be told apart from the one before it: (N - 1,).

    Triangles of one load are together, and all pairs between two events of another kind.
    """
    kinds, numbers = events["kind"], events["a"]
    loads, pairs = kinds == LOADED, kinds >= NEAR
    # The one that empties the mesh begins a load.
    alike = ((numbers[:-1] & ~np.uint32(CLEAR)) == numbers[1:]) & loads[:-1] & loads[1:]
    return ~(alike | (pairs[:-1] & pairs[1:]))


class BurstLoadDriver(LoadDriver):
    """Hands meshes to the model."""

    def start_of_simulation_phase(self) -> None:
        """Take hold of the model."""
        self.bfm: MeshBfm = bfm_of(self)
        self.rng = np.random.default_rng([settings_of(self).seed, *b"load"])

    async def drive(self, item: LoadItem) -> None:
        """Offer the triangles until the last is accepted."""
        await self.bfm.load(item, self.rng)


class BurstRunDriver(RunDriver):
    """Hands runs to the model."""

    def start_of_simulation_phase(self) -> None:
        """Take hold of the model."""
        self.bfm: MeshBfm = bfm_of(self)
        self.over = 0

    async def offer(self, item: RunItem) -> None:
        """Offer the run."""
        self.bfm.offer(item)

    async def accepted(self) -> None:
        """Wait until it is accepted."""
        await self.bfm.accepted()

    async def ended(self, item: RunItem) -> int:
        """Wait for the summary, or for a reset."""
        self.over += 1
        return await self.bfm.ended(self.over)


def _told(pins: Any) -> type:
    """Return the monitor in the place of one on the pins: it watches nothing, the model tells it."""

    class Told(pins):
        """Publishes what it is told."""

        def start_of_simulation_phase(self) -> None:
            """Ask to be told."""
            bfm_of(self).publish[pins] = lambda datum: self.ap.write(datum)

        async def run_phase(self) -> None:
            """Wait to be told."""

    Told.__name__ = f"Burst{pins.__name__}"
    return Told


BurstLoadMonitor, BurstRunMonitor = _told(LoadMonitor), _told(RunMonitor)
BurstNearMonitor, BurstCoreMonitor = _told(NearMonitor), _told(CoreMonitor)
BurstSummaryMonitor = _told(SummaryMonitor)


class BurstReadyDriver(ResultReadyDriver):
    """Sets the paces at which the model takes results."""

    def start_of_simulation_phase(self) -> None:
        """Take hold of the model."""
        self.bfm: MeshBfm = bfm_of(self)
        self.rng = np.random.default_rng([settings_of(self).seed, *b"results"])

    def write(self, tt: RunTraffic) -> None:
        """Take results at these paces from now on."""
        if (self.near, self.done) == (tt.near, tt.done):
            return
        self.near, self.done = tt.near, tt.done
        self.bfm.player.set_paces(self.near.runs(self.rng, _RUNS), self.done.runs(self.rng, _RUNS))


def use_bursts() -> None:
    """Make the factory give drivers and monitors of bursts in place of the pin-level ones."""
    factory = uvm_factory()
    for pins, burst in (
        (LoadDriver, BurstLoadDriver),
        (LoadMonitor, BurstLoadMonitor),
        (RunDriver, BurstRunDriver),
        (RunMonitor, BurstRunMonitor),
        (NearMonitor, BurstNearMonitor),
        (CoreMonitor, BurstCoreMonitor),
        (SummaryMonitor, BurstSummaryMonitor),
        (ResultReadyDriver, BurstReadyDriver),
    ):
        factory.set_type_override_by_type(pins, burst)
