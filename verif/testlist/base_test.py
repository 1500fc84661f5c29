"""What all tests share: clock, reset, environment, the end of the test."""

from pathlib import Path
from typing import Any

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles
from pyuvm import uvm_report_server, uvm_test

from triaxis.verif.agents.items import FULL_SPEED
from triaxis.verif.env import CoreEnv
from triaxis.verif.handles import create, publish
from triaxis.verif.sequences.pair_sequence import ArraySequence
from triaxis.verif.settings import from_environment

_PERIOD_NS = 10
_RESET_CYCLES = 3
# Clocks without a beat on either stream after which the core is taken to hang: no pace pauses so long.
_PATIENCE_CYCLES = 5000
# Clocks in which a result too many would show: more than any latency.
_SURPLUS_CYCLES = 64
# Clocks that the last results may take once nothing stalls them: far above latency and queue.
_DRAIN_CYCLES = 2000


class CoreTest(uvm_test):
    """Resets the core, runs `stimulus`, waits for the last result. Tests override `stimulus`."""

    def build_phase(self) -> None:
        """Take the settings from the runner and make the environment."""
        self.dut: Any = cocotb.top
        self.settings = from_environment()
        # A generator of the test's own name, so that tests of one seed differ.
        self.rng = np.random.default_rng([self.settings.seed, *type(self).__name__.encode()])
        publish(self.settings, self.dut)
        Path(self.settings.folder).mkdir(parents=True, exist_ok=True)
        self.env = create(CoreEnv, "env", self)

    async def run_phase(self) -> None:
        """Run the test."""
        self.raise_objection()
        Clock(self.dut.clk_i, _PERIOD_NS, "ns").start()
        await self.reset(_RESET_CYCLES)
        watchdog = cocotb.start_soon(self.watch())
        await self.stimulus()
        await self.drain()
        watchdog.cancel()
        self.drop_objection()

    def check_phase(self) -> None:
        """Fail where anything reported an error, even if nothing else noticed."""
        uvm_report_server.get().assert_no_failures()

    async def stimulus(self) -> None:
        """Send what the test is about."""
        raise NotImplementedError

    async def send(self, sequence: ArraySequence) -> None:
        """Run a sequence on the input agent."""
        await sequence.start(self.env.source.sequencer)

    async def reset(self, cycles: int) -> None:
        """Hold the core in reset for some clocks."""
        self.dut.rst_ni.value = 0
        await ClockCycles(self.dut.clk_i, cycles)
        self.dut.rst_ni.value = 1
        await ClockCycles(self.dut.clk_i, 1)

    async def watch(self) -> None:
        """Fail the test where nothing moves any more: a hung core would keep it waiting for ever."""
        monitors = (self.env.source.monitor.bus, self.env.sink.monitor.bus)
        before = -1
        while (moved := sum(monitor.moved for monitor in monitors)) != before:
            before = moved
            await ClockCycles(self.dut.clk_i, _PATIENCE_CYCLES)
        raise AssertionError(f"no beat moved in {_PATIENCE_CYCLES} clocks: the core hangs")

    async def drain(self) -> None:
        """Wait for the last result, without stalls; what is missing then is for the scoreboard."""
        self.env.sink.ready.pace = FULL_SPEED
        for _ in range(_DRAIN_CYCLES):
            await ClockCycles(self.dut.clk_i, 1)
            self.env.flush()
            if self.env.scoreboard.matcher.outstanding == 0:
                break
        await ClockCycles(self.dut.clk_i, _SURPLUS_CYCLES)
        self.env.flush()
