"""Drivers and monitors of the bare Verilated engine, for volume.

They take the places of the pin-level ones by factory override (`use_bare_engine`); sequences, scoreboard and
coverage are the same. The engine is a library there, beside a simulator that has nothing in it, and runs
hundreds of thousands of clocks a second: pin by pin Python has a step for each clock.
"""

from collections.abc import Callable
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
from pyuvm import uvm_factory

from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.mesh_engine import MeshEngine, Traffic
from triaxis.verif.core.items import FULL_SPEED, Pace
from triaxis.verif.mesh.items import (
    AbortAsked,
    CorePairs,
    Loaded,
    LoadItem,
    NearTaken,
    RunAccepted,
    RunItem,
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
from triaxis.verif.testbench.environment import FastModel, bfm_of, settings_of


class BareBfm(FastModel):
    """The one that knows the library; drivers hand it items, monitors say who is told of what."""

    def __init__(self, configuration: MeshConfiguration) -> None:
        """Nobody is told of anything yet."""
        self.configuration = configuration
        self.publish: dict[type, Callable[[Any], None]] = {}
        self._held = [0, 0]

    def open(self, library: Path, selected: int) -> None:
        """Load the library."""
        self.engine = MeshEngine(self.configuration, library=library)

    async def clocks(self, count: int) -> None:
        """Wait for nothing: between two items the clock stands still."""

    async def reset(self, cycles: int) -> None:
        """Do nothing: it begins with a reset."""

    def close(self, counters: Path) -> None:
        """Write what the library's build has counted."""

    def load(self, item: LoadItem, random: Random) -> None:
        """Load a mesh."""
        if not item.clear:
            raise ValueError("the bare engine empties a mesh before it loads it")
        held = self.engine.load_unchecked(item.mesh, item.triangles, _traffic(random, (item.gaps,)))
        self._held[item.mesh] = held
        self.publish[LoadMonitor](Loaded(item.mesh, True, item.triangles.astype(np.int64)))

    def run(self, item: RunItem, random: Random) -> None:
        """Run; aborted once at most."""
        request, traffic = item.request, item.traffic
        abort = traffic.aborts[0] if traffic.aborts else -1
        self.publish[RunMonitor](RunAccepted(request))
        stalls = _traffic(random, (traffic.near, traffic.done), abort)
        run = self.engine.run(request.translation, request.margin, request.mode, stalls, reached=True)
        item.clocks = run.cycles
        # Later ones never came: the summary was taken before.
        came = abort < run.cycles or run.cycles == self.engine.configuration.max_cycles
        if traffic.aborts and came:
            self.publish[RunMonitor](AbortAsked(abort))
        assert run.reached is not None
        self.publish[CoreMonitor](CorePairs(run.reached))
        self.publish[NearMonitor](NearTaken(run.near))
        self.publish[SummaryMonitor](
            Summary(
                run.status,
                run.cycles,
                run.group_pairs_skipped,
                run.group_pairs_opened,
                run.pairs_skipped,
                run.tested,
                run.near_count,
                held=(self._held[0], self._held[1]),
            )
        )


def _traffic(random: Random, paces: tuple[Pace, ...], abort_at: int = -1) -> Traffic:
    """Return stalls that come as often as at the slowest of some paces."""
    off = 1 - min(pace.duty for pace in paces)
    return Traffic(random.randrange(1, 1 << 60), min(250, int(256 * off)), abort_at)


class BareLoadDriver(LoadDriver):
    """Loads whole meshes."""

    def start_of_simulation_phase(self) -> None:
        """Take hold of the engine."""
        self.bfm = bfm_of(self)

    async def drive(self, item: LoadItem) -> None:
        """Load the mesh."""
        self.bfm.load(item, self.random)


class BareRunDriver(RunDriver):
    """Runs whole runs."""

    def start_of_simulation_phase(self) -> None:
        """Take hold of the engine."""
        self.bfm = bfm_of(self)
        self.random = Random(f"runs {settings_of(self).seed}")

    async def drive(self, item: RunItem) -> None:
        """Run."""
        self.bfm.run(item, self.random)


def _told(pins: Any) -> type:
    """Return the monitor in the place of one on the pins: it watches nothing, the model tells it."""

    class Told(pins):
        """Publishes what it is told."""

        def start_of_simulation_phase(self) -> None:
            """Ask to be told."""
            bfm_of(self).publish[pins] = lambda datum: self.ap.write(datum)

        async def run_phase(self) -> None:
            """Wait to be told."""

    Told.__name__ = f"Bare{pins.__name__}"
    return Told


BareLoadMonitor, BareRunMonitor = _told(LoadMonitor), _told(RunMonitor)
BareNearMonitor, BareCoreMonitor = _told(NearMonitor), _told(CoreMonitor)
BareSummaryMonitor = _told(SummaryMonitor)


class BareReadyDriver(ResultReadyDriver):
    """Drives nothing: the engine's harness stalls by itself."""

    def start_of_simulation_phase(self) -> None:
        """Leave the pins, which are not there."""
        self.near, self.done = FULL_SPEED, FULL_SPEED


def use_bare_engine() -> None:
    """Make the factory give the bare engine's drivers and monitors in place of the pin-level ones."""
    factory = uvm_factory()
    for pins, bare in (
        (LoadDriver, BareLoadDriver),
        (LoadMonitor, BareLoadMonitor),
        (RunDriver, BareRunDriver),
        (RunMonitor, BareRunMonitor),
        (NearMonitor, BareNearMonitor),
        (CoreMonitor, BareCoreMonitor),
        (SummaryMonitor, BareSummaryMonitor),
        (ResultReadyDriver, BareReadyDriver),
    ):
        factory.set_type_override_by_type(pins, bare)
