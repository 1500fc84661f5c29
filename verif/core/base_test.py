"""What all tests share: clock, reset, environment, the end of the test."""

import faulthandler
import signal
from pathlib import Path
from typing import Any

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge, Timer
from pyuvm import uvm_report_server, uvm_sequence, uvm_test

from triaxis.sim.clocking import PERIOD_NS
from triaxis.verif.core.burst_agent import use_bursts
from triaxis.verif.core.burst_bfm import BurstBfm
from triaxis.verif.core.env import CoreEnv
from triaxis.verif.core.items import FULL_SPEED, BurstItem, Pace
from triaxis.verif.core.pair_sequence import ItemSequence
from triaxis.verif.testbench.handles import create, publish
from triaxis.verif.testbench.settings import BURST, from_environment

_RESET_CYCLES = 3
# Clocks without a beat on either stream after which the core is taken to hang: no pace pauses so long.
_PATIENCE_CYCLES = 5000
# Clocks in which a result too many would show: more than any latency.
_SURPLUS_CYCLES = 64
# Clocks that the last results may take once nothing stalls them, in steps: far above latency and queue.
_DRAIN_STEPS, _DRAIN_CYCLES = 50, 40


class CoreTest(uvm_test):
    """Resets the core, runs `stimulus`, waits for the last result. Tests override `stimulus`."""

    def build_phase(self) -> None:
        """Take the settings from the runner and make the environment."""
        self.dut: Any = cocotb.top
        self.settings = from_environment()
        # A generator of the test's own name, so that tests of one seed differ.
        self.rng = np.random.default_rng([self.settings.seed, *type(self).__name__.encode()])
        self.in_bursts = self.settings.agent == BURST
        publish(self.settings, self.dut, BurstBfm(self.dut) if self.in_bursts else None)
        if self.in_bursts:
            use_bursts()
        Path(self.settings.folder).mkdir(parents=True, exist_ok=True)
        self.env = create(CoreEnv, "env", self)

    async def run_phase(self) -> None:
        """Run the test."""
        self.raise_objection()
        # The solver's handler of interrupts would jump out of the worker's thread.
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        # Whatever else happens, no run lasts for ever.
        faulthandler.dump_traceback_later(self.settings.time_limit, exit=True)
        # The burst simulation makes its own clock.
        if not self.in_bursts:
            Clock(self.dut.clk_i, PERIOD_NS, "ns").start()
        # From here on a little after the edge: what happens between clocks happens between edges.
        await RisingEdge(self.dut.clk_i)
        await Timer(1, "ns")
        await self.reset(_RESET_CYCLES)
        watchdog = cocotb.start_soon(self.watch())
        await self.stimulus()
        await self.drain()
        watchdog.cancel()
        self.env.scoreboard.sent = self.env.source.driver.next_tag
        self.drop_objection()

    def check_phase(self) -> None:
        """Fail where anything reported an error, even if nothing else noticed."""
        uvm_report_server.get().assert_no_failures()

    async def stimulus(self) -> None:
        """Send what the test is about."""
        raise NotImplementedError

    async def send(self, sequence: uvm_sequence) -> None:
        """Run a sequence on the input agent."""
        await sequence.start(self.env.source.sequencer)

    async def send_item(self, item: BurstItem) -> None:
        """Send one item on the input agent."""
        await self.send(ItemSequence(item))

    async def clocks(self, count: int) -> None:
        """Wait for some clocks. Bursts go on meanwhile, which they would not for each edge."""
        await Timer(count * PERIOD_NS, "ns")

    async def reset(self, cycles: int, late_ns: int = 0) -> None:
        """Hold the core in reset for some clocks, from some time after the edge on."""
        if late_ns:
            await Timer(late_ns, "ns")
        self.dut.rst_ni.value = 0
        await Timer(cycles * PERIOD_NS - late_ns, "ns")
        self.dut.rst_ni.value = 1
        await self.clocks(1)

    def set_stalls(self, pace: Pace) -> None:
        """Take results at this pace from now on."""
        self.env.sink.ready.write(pace)

    async def watch(self) -> None:
        """Fail the test where nothing moves any more: a hung core would keep it waiting for ever.

        A burst has a budget of its own instead: what its monitors saw is fetched at its end.
        """
        if self.in_bursts:
            return
        monitors = (self.env.source.monitor, self.env.sink.monitor)
        before = -1
        while (moved := sum(monitor.moved for monitor in monitors)) != before:
            before = moved
            await self.clocks(_PATIENCE_CYCLES)
        raise AssertionError(f"no beat moved in {_PATIENCE_CYCLES} clocks: the core hangs")

    async def drain(self) -> None:
        """Wait for the last result, without stalls; what is missing then is for the scoreboard."""
        self.set_stalls(FULL_SPEED)
        for _ in range(_DRAIN_STEPS):
            await self.clocks(_DRAIN_CYCLES)
            self.env.flush()
            if self.env.scoreboard.matcher.outstanding == 0:
                break
        await self.clocks(_SURPLUS_CYCLES)
        self.env.flush()
