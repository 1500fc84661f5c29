"""What every environment is made of: what components find in the ConfigDB, agents, scoreboards, tests."""

import faulthandler
import json
import resource
import signal
import sys
import time
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from itertools import count
from pathlib import Path
from typing import Any, Protocol, TypeVar, cast

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.handle import LogicArrayObject, LogicObject
from cocotb.triggers import RisingEdge, Timer
from cocotb.utils import get_sim_time
from pyuvm import (
    UVM_HIGH,
    ConfigDB,
    uvm_agent,
    uvm_analysis_export,
    uvm_component,
    uvm_driver,
    uvm_monitor,
    uvm_scoreboard,
    uvm_sequence,
    uvm_sequence_item,
    uvm_sequencer,
    uvm_test,
)

from triaxis.golden.outputs import write_whole
from triaxis.sim.player import PERIOD_NS
from triaxis.verif.testbench.fast_model import FastModel
from triaxis.verif.testbench.reports import INFO, report
from triaxis.verif.testbench.settings import (
    PIN,
    RunSettings,
    counters_file,
    from_environment,
    library_from_environment,
    limit_file,
    result_file,
)
from triaxis.verif.testbench.trials import Model, in_trials, next_model
from triaxis.verif.testbench.unknown_values import UnknownMonitor

Component = TypeVar("Component", bound=uvm_component)

_SETTINGS, _DUT, _BFM = "SETTINGS", "DUT", "BFM"
_RESET_CYCLES = 3
_NUMBERS = count()

# The one thread beside the simulation, in the simulator's process: it makes stimulus and checks results. One
# and not several: between two such threads Python's lock would change hands at every array operation, which
# costs more than it brings. The simulation itself runs without the lock.
WORKER = ThreadPoolExecutor(1, "worker")


class StreamPins(Protocol):
    """The pins of an AXI4-Stream, as cocotb-bus finds them."""

    tvalid: LogicObject
    tready: LogicObject
    tdata: LogicArrayObject
    tuser: LogicArrayObject


def settings_of(component: uvm_component) -> RunSettings:
    """Return the settings of the run."""
    return cast(RunSettings, ConfigDB().get(component, "", _SETTINGS))


def dut_of(component: uvm_component) -> Any:
    """Return the handle of what is under test; its attributes are its pins."""
    return ConfigDB().get(component, "", _DUT)


def bfm_of(component: uvm_component) -> Any:
    """Return the bus-functional model; there is one where the run is not one on the pins."""
    return ConfigDB().get(component, "", _BFM)


def clock_now() -> int:
    """Return the clock on the pins, the first being 0, as the model of a library counts them."""
    return int(get_sim_time("ns")) // PERIOD_NS


def create(kind: type[Component], name: str, parent: uvm_component) -> Component:
    """Create a component by the factory, so that overrides apply."""
    return cast(Component, kind.create(name, parent))


class ItemsSequence(uvm_sequence):
    """Sends items one after another, each made as it is wanted."""

    def __init__(self, items: Iterable[uvm_sequence_item]) -> None:
        """Hold the items."""
        super().__init__("items")
        self.items = items

    async def body(self) -> None:
        """Send them."""
        for item in self.items:
            report(INFO, f"{item.get_name()} {next(_NUMBERS)}", "ITEM", UVM_HIGH)
            await self.start_item(item)
            await self.finish_item(item)


class StimulusAgent(uvm_agent):
    """Sends items of a sequencer by a driver, and sees by a monitor what is accepted."""

    driver_kind: type[uvm_driver]
    monitor_kind: type[uvm_monitor]

    def build_phase(self) -> None:
        """Make the parts."""
        super().build_phase()
        self.sequencer = create(uvm_sequencer, "sequencer", self)
        self.driver: Any = create(self.driver_kind, "driver", self)
        self.monitor: Any = create(self.monitor_kind, "monitor", self)

    def connect_phase(self) -> None:
        """Give the driver its items."""
        self.driver.seq_item_port.connect(self.sequencer.seq_item_export)


class Export(uvm_analysis_export):
    """An analysis export that hands transactions to a function: a scoreboard needs several of them."""

    def __init__(self, name: str, parent: uvm_component, write: Callable[[Any], None]) -> None:
        """Hold the function."""
        super().__init__(name, parent)
        self._write = write

    def write(self, datum: Any) -> None:
        """Hand the transaction on."""
        self._write(datum)


class CountingScoreboard(uvm_scoreboard):
    """A scoreboard that leaves the counts of its run in a file.

    ``resets_sent``: those that the test says it gave, at its end.
    """

    resets_sent = 0

    def start_of_simulation_phase(self) -> None:
        """Start the clock on the wall, and that of the processor."""
        self._start, self._busy = time.perf_counter(), time.process_time()

    def write_counts(self, counts: dict[str, Any]) -> None:
        """Write the counts, and what the run took, without the start of the simulator."""
        taken = {
            "seconds": time.perf_counter() - self._start,
            "cpu_seconds": time.process_time() - self._busy,
            "peak_memory_mib": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024,
        }
        settings = settings_of(self)
        # Of registers without a reset and of memories, too.
        taken["seed"] = settings.seed
        path = result_file(Path(settings.folder))
        write_whole(path, json.dumps({**counts, **taken}, indent=2) + "\n")


class EnvironmentTest(uvm_test):
    """What all tests share: settings, clock, reset. Tests override `stimulus`, environments the rest.

    ``outputs``: see `UnknownMonitor`.
    """

    outputs: Mapping[str, str | None]
    clock_and_reset = "clk_i", "rst_ni"

    def build_phase(self) -> None:
        """Take the settings from the runner, and let every component find them."""
        self.dut: Any = cocotb.top
        self.settings = from_environment()
        # A generator of the test's own name, so that tests of one seed differ.
        self.rng = np.random.default_rng([self.settings.seed, *type(self).__name__.encode()])
        self.on_pins = self.settings.agent == PIN
        # How many resets there were after the first.
        self.resets = -1
        Path(self.settings.folder).mkdir(parents=True, exist_ok=True)
        self.bfm = self.pin_model() if self.on_pins else self.fast_model()
        for key, value in ((_SETTINGS, self.settings), (_DUT, self.dut), (_BFM, self.bfm)):
            ConfigDB().set(None, "*", key, value)
        if self.settings.four_state:
            monitor = create(UnknownMonitor, "unknown", self)
            monitor.dut, monitor.settings, monitor.outputs = self.dut, self.settings, self.outputs
            monitor.clock, monitor.reset_n = self.clock_and_reset

    def pin_model(self) -> FastModel[Any] | None:
        """Return what takes the place of that model on the pins; None: agents drive them, one each."""
        return None

    def fast_model(self) -> FastModel[Any]:
        """Return the bus-functional model that takes the place of the pins, and have its agents made."""
        raise NotImplementedError

    async def run_phase(self) -> None:
        """Run the test."""
        self.raise_objection()
        model = next_model(type(self).__name__, Model("", library_from_environment()))
        # An interrupt ends this process at once: Python's handler would wait for the simulator.
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        # Whatever else happens, no run computes for ever: where it was is said, then it is killed.
        limit = int(self.settings.time_limit)
        # Of trials it is said by how they end. Open from here on: then nothing of Python runs any more.
        self._where = sys.stderr if in_trials() else limit_file(Path(self.settings.folder)).open("w")
        faulthandler.register(signal.SIGXCPU, self._where)
        resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 5))
        if self.bfm:
            self.bfm.open(Path(model.library), model.selected, self.settings.seed)
        else:
            # Some simulators do not know the value of an input that nothing drives yet.
            self.dut.rst_ni.value = 0
            Clock(self.dut.clk_i, PERIOD_NS, "ns").start()
            await self.between_edges()
        await self.reset(_RESET_CYCLES)
        await self.traffic()
        self.drop_objection()

    async def traffic(self) -> None:
        """Run `stimulus`, and wait for the end of what it asked for."""
        raise NotImplementedError

    async def stimulus(self) -> None:
        """Send what the test is about."""
        raise NotImplementedError

    def check_phase(self) -> None:
        """Write what the build has counted; fail where an assertion failed."""
        if self.bfm:
            self.bfm.close(counters_file(Path(self.settings.folder)))

    async def clocks(self, count: int) -> None:
        """Wait for some clocks."""
        if self.bfm:
            await self.bfm.clocks(count)
        else:
            await Timer(count * PERIOD_NS, "ns")

    async def between_edges(self) -> None:
        """Wait until a little after an edge: what happens between clocks must not happen at one.

        A bus-functional model always stands between two edges.
        """
        if self.bfm:
            return
        await RisingEdge(self.dut.clk_i)
        await Timer(1, "ns")

    async def reset(self, cycles: int, late_ns: int = 0) -> None:
        """Hold what is under test in reset for some clocks, from some time after the edge on."""
        self.resets += 1
        if self.bfm:
            await self.bfm.reset(cycles)
            return
        if late_ns:
            await Timer(late_ns, "ns")
        self.dut.rst_ni.value = 0
        await Timer(cycles * PERIOD_NS - late_ns, "ns")
        self.dut.rst_ni.value = 1
        await self.clocks(1)
