"""The agent of what comes out: ready drivers; monitors of near pairs, summaries, the core's input."""

from collections.abc import Iterator
from random import Random
from typing import Any

import numpy as np
from cocotb.triggers import RisingEdge
from cocotb_bus.drivers import BitDriver
from pyuvm import uvm_agent, uvm_analysis_port, uvm_monitor, uvm_subscriber

from triaxis.verif.core.items import FULL_SPEED, Pace
from triaxis.verif.mesh.handles import mesh_configuration_of
from triaxis.verif.mesh.items import RunTraffic
from triaxis.verif.mesh.observed import CorePairs, NearTaken, Summary
from triaxis.verif.mesh.packing import unpack_pair
from triaxis.verif.testbench.batches import ResetSeen
from triaxis.verif.testbench.handles import create, dut_of, settings_of


class ResultReadyDriver(uvm_subscriber):
    """Takes near pairs and summaries at the paces that each run asks for."""

    def build_phase(self) -> None:
        """Start always ready."""
        self.near, self.done = FULL_SPEED, FULL_SPEED
        self.random = Random(f"results {settings_of(self).seed}")

    def write(self, tt: RunTraffic) -> None:  # pyright: ignore[reportIncompatibleMethodOverride]
        """Take results at these paces from now on."""
        self.near, self.done = tt.near, tt.done

    def start_of_simulation_phase(self) -> None:
        """Take hold of the pins."""
        dut = dut_of(self)
        BitDriver(dut.m_axis_near_tready_i, dut.clk_i).start(self._cycles("near"))
        BitDriver(dut.m_axis_done_tready_i, dut.clk_i).start(self._cycles("done"))

    def _cycles(self, stream: str) -> Iterator[tuple[int, int]]:
        while True:
            pace: Pace = getattr(self, stream)
            yield self.random.randint(1, pace.on), self.random.randint(0, pace.off)


class ResultMonitor(uvm_monitor):
    """What the monitors of results share: a look at the pins at every edge, before it takes effect."""

    def build_phase(self) -> None:
        """Make the analysis port."""
        self.ap = uvm_analysis_port("ap", self)
        self.configuration = mesh_configuration_of(self)

    async def run_phase(self) -> None:
        """Watch."""
        dut = dut_of(self)
        edge = RisingEdge(dut.clk_i)
        while True:
            await edge
            if int(dut.rst_ni.value):
                self.look(dut)
            else:
                self.reset()

    def look(self, dut: Any) -> None:
        """Look at the pins once."""
        raise NotImplementedError

    def reset(self) -> None:
        """Follow a reset."""


class NearMonitor(ResultMonitor):
    """Publishes near pairs one by one: NearTaken."""

    wait = 0

    def look(self, dut: Any) -> None:
        """See a pair, and whether it was taken."""
        if not int(dut.m_axis_near_tvalid_o.value):
            return
        if not int(dut.m_axis_near_tready_i.value):
            self.wait += 1
            return
        pair = unpack_pair(int(dut.m_axis_near_tdata_o.value), self.configuration)
        self.ap.write(NearTaken(np.array([pair], np.int64), self.wait))
        self.wait = 0

    def reset(self) -> None:
        """Forget a pair that waited."""
        self.wait = 0


class CoreMonitor(ResultMonitor):
    """Publishes pairs that the core accepts: CorePairs."""

    def look(self, dut: Any) -> None:
        """See whether the core accepts one."""
        if int(dut.core_valid.value) and int(dut.core_ready.value):
            pair = int(dut.core_a.value), int(dut.core_b.value)
            self.ap.write(CorePairs(np.array([pair], np.int64)))


class SummaryMonitor(ResultMonitor):
    """Publishes summaries (Summary) and the beginnings of resets (ResetSeen)."""

    clocks = wait = 0
    in_reset = True

    def look(self, dut: Any) -> None:
        """Count the clocks of a run, see its summary, and whether it was taken."""
        self.in_reset = False
        if not int(dut.busy_o.value):
            # The clock at which a run is accepted counts as well.
            self.clocks, self.wait = 1, 0
            # A summary without a run is one too many; the scoreboard says so.
            if not int(dut.m_axis_done_tvalid_o.value):
                return
        if not int(dut.m_axis_done_tvalid_o.value):
            self.clocks += 1
            return
        if not int(dut.m_axis_done_tready_i.value):
            self.wait += 1
            return
        pins = (
            dut.status_o,
            dut.cycles_o,
            dut.group_pairs_skipped_o,
            dut.group_pairs_opened_o,
            dut.pairs_skipped_o,
            dut.tested_o,
            dut.near_o,
        )
        held = int(dut.count_a_o.value), int(dut.count_b_o.value)
        overfull = int(dut.overfull_o.value)
        numbers = (int(pin.value) for pin in pins)
        self.ap.write(
            Summary(*numbers, offered_after=self.clocks, wait=self.wait, held=held, overfull=overfull)
        )

    def reset(self) -> None:
        """Say that a reset began."""
        if not self.in_reset:
            self.ap.write(ResetSeen())
        self.in_reset = True
        self.clocks = self.wait = 0


class ResultAgent(uvm_agent):
    """Takes results and sees them."""

    def build_phase(self) -> None:
        """Make the parts."""
        super().build_phase()
        self.ready = create(ResultReadyDriver, "ready", self)
        self.near = create(NearMonitor, "near", self)
        self.core = create(CoreMonitor, "core", self)
        self.summary = create(SummaryMonitor, "summary", self)
