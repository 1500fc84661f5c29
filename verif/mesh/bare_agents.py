"""Drivers and monitors of the bare Verilated engine, for volume.

They take the places of the pin-level ones by factory override (`use_bare_engine`); sequences, scoreboard and
coverage are the same. The engine is a library there, beside a simulator that has nothing in it, and runs
hundreds of thousands of clocks a second: pin by pin Python has a step for each clock.
"""

from random import Random

from pyuvm import uvm_analysis_port, uvm_factory, uvm_monitor

from triaxis.verif.core.items import FULL_SPEED
from triaxis.verif.mesh import bare_bfm
from triaxis.verif.mesh.handles import bare_bfm_of
from triaxis.verif.mesh.items import LoadItem, RunItem
from triaxis.verif.mesh.load_agent import LoadDriver, LoadMonitor
from triaxis.verif.mesh.result_agent import CoreMonitor, NearMonitor, ResultReadyDriver, SummaryMonitor
from triaxis.verif.mesh.run_agent import RunDriver, RunMonitor
from triaxis.verif.testbench.handles import settings_of


class BareLoadDriver(LoadDriver):
    """Loads whole meshes."""

    def start_of_simulation_phase(self) -> None:
        """Take hold of the engine."""
        self.bfm = bare_bfm_of(self)

    async def drive(self, item: LoadItem) -> None:
        """Load the mesh."""
        self.bfm.load(item, self.random)


class BareRunDriver(RunDriver):
    """Runs whole runs."""

    def start_of_simulation_phase(self) -> None:
        """Take hold of the engine."""
        self.bfm = bare_bfm_of(self)
        self.random = Random(f"runs {settings_of(self).seed}")

    async def drive(self, item: RunItem) -> None:
        """Run."""
        self.bfm.run(item, self.random)


class _Told(uvm_monitor):
    """A monitor that watches no pins: the model tells it."""

    of: str
    ap: uvm_analysis_port

    def start_of_simulation_phase(self) -> None:
        """Ask to be told."""
        bare_bfm_of(self).publish[self.of] = lambda datum: self.ap.write(datum)

    async def run_phase(self) -> None:
        """Wait to be told."""


class BareLoadMonitor(_Told, LoadMonitor):
    """Publishes what was loaded."""

    of = bare_bfm.LOAD


class BareRunMonitor(_Told, RunMonitor):
    """Publishes runs and aborts."""

    of = bare_bfm.RUN


class BareNearMonitor(_Told, NearMonitor):
    """Publishes near pairs."""

    of = bare_bfm.NEAR


class BareCoreMonitor(_Told, CoreMonitor):
    """Publishes the pairs that reached the core."""

    of = bare_bfm.CORE


class BareSummaryMonitor(_Told, SummaryMonitor):
    """Publishes summaries."""

    of = bare_bfm.SUMMARY


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
