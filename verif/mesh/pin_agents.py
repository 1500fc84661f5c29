"""The agents on the pins: of the load stream, of the run stream, and of what comes out.

Pins are read at a rising edge before it takes effect, and driven after it.
"""

from collections.abc import Iterator
from random import Random
from typing import Any

import cocotb
import numpy as np
from cocotb.triggers import RisingEdge
from cocotb_bus.drivers import BitDriver
from pyuvm import uvm_agent, uvm_analysis_port, uvm_driver, uvm_monitor, uvm_subscriber

from triaxis.golden.errors import InputError
from triaxis.golden.pairs import coordinate_range
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.player import HANGS
from triaxis.verif.core.items import FULL_SPEED, Pace, ResetSeen
from triaxis.verif.core.pin_agents import SourceBus
from triaxis.verif.mesh.items import (
    AbortAsked,
    CorePairs,
    Loaded,
    LoadItem,
    NearTaken,
    RunAccepted,
    RunItem,
    RunTraffic,
    Summary,
    pack_run,
    pack_triangle,
    unpack_pair,
    unpack_run,
    unpack_triangle,
)
from triaxis.verif.testbench.environment import StimulusAgent, clock_now, create, dut_of, settings_of
from triaxis.verif.testbench.failures import HungError, report_failure

_NO_TRIANGLES = np.empty((0, 3, 3), np.int64)


# Clocks that a run may take for each pair that the meshes can have, and at least: stalls are included.
_CLOCKS_A_PAIR, _LEAST_CLOCKS = 100, 20_000


def _longest_run(configuration: MeshConfiguration) -> int:
    """Return the clocks after which a run that has not ended means that the engine hangs."""
    return _LEAST_CLOCKS + _CLOCKS_A_PAIR * min(configuration.depth, 256) ** 2


class LoadDriver(uvm_driver):
    """Offers triangles one by one."""

    def build_phase(self) -> None:
        """Fetch the settings."""
        self.settings = settings_of(self)
        self.configuration = self.settings.mesh_configuration
        self.random = Random(f"load {self.settings.seed}")
        self.sent = 0

    def start_of_simulation_phase(self) -> None:
        """Take hold of the pins."""
        patience = _longest_run(self.configuration)
        self.bus = SourceBus(dut_of(self), "s_axis_load", patience, self.settings)

    async def run_phase(self) -> None:
        """Drive items as they come."""
        while True:
            item: LoadItem = await self.seq_item_port.get_next_item()
            low, high = coordinate_range(self.configuration.width)
            if item.triangles.min(initial=0) < low or item.triangles.max(initial=0) > high:
                raise InputError(f"stimulus: coordinates must be {low}..{high}")
            self.sent += len(item.triangles)
            await self.drive(item)
            self.seq_item_port.item_done()

    async def drive(self, item: LoadItem) -> None:
        """Offer the triangles until the last is accepted."""
        width = self.configuration.width
        beats = [(0, 2 | item.mesh)] if item.clear else []
        rows = item.triangles.reshape(-1, 9).tolist()
        beats += [(pack_triangle(row, width), item.mesh) for row in rows]
        start = clock_now()
        self.bus.set_pace(item.gaps, self.random)
        for beat in beats:
            await self.bus.send(beat, sync=False)
        self.bus.idle()
        item.clocks = clock_now() - start


class PinMonitor(uvm_monitor):
    """What the monitors share: a look at the pins at every edge, before it takes effect."""

    def build_phase(self) -> None:
        """Make the analysis port."""
        self.ap = uvm_analysis_port("ap", self)
        self.configuration = settings_of(self).mesh_configuration

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


class LoadMonitor(PinMonitor):
    """Publishes what the engine was loaded with, beat by beat: Loaded."""

    def look(self, dut: Any) -> None:
        """See whether a beat is accepted."""
        if not int(dut.s_axis_load_tvalid_i.value) or not int(dut.s_axis_load_tready_o.value):
            return
        user = int(dut.s_axis_load_tuser_i.value)
        clear = bool(user & 2)
        triangle = unpack_triangle(int(dut.s_axis_load_tdata_i.value), self.configuration.width)[None]
        run = int(dut.s_axis_run_tvalid_i.value) and int(dut.s_axis_run_tready_o.value)
        self.ap.write(Loaded(user & 1, clear, _NO_TRIANGLES if clear else triangle, bool(run)))


class LoadAgent(StimulusAgent):
    """Loads meshes and sees what is accepted."""

    driver_kind, monitor_kind = LoadDriver, LoadMonitor


class RunDriver(uvm_driver):
    """Offers runs, aborts them where the item says so, and waits for their summaries."""

    def build_phase(self) -> None:
        """Make the port that tells how the results are to be taken."""
        self.settings = settings_of(self)
        self.configuration = self.settings.mesh_configuration
        self.traffic_ap = uvm_analysis_port("traffic_ap", self)
        self.sent = 0

    def start_of_simulation_phase(self) -> None:
        """Take hold of the pins."""
        self.dut = dut_of(self)
        patience = _longest_run(self.configuration)
        self.bus = SourceBus(self.dut, "s_axis_run", patience, self.settings)
        self.dut.abort_i.value = 0
        self.dut.acknowledge_i.value = 0
        self.edge = RisingEdge(self.dut.clk_i)

    async def run_phase(self) -> None:
        """Drive items as they come."""
        while True:
            item: RunItem = await self.seq_item_port.get_next_item()
            self.begin(item)
            await self.drive(item)
            self.seq_item_port.item_done()

    async def drive(self, item: RunItem) -> None:
        """Offer the run, see it end; then those that follow it, each offered while the one before goes on."""
        await self.offer(item)
        while True:
            await self.accepted()
            following = item.following
            if following:
                await self.offer(following)
            item.clocks = await self.ended(item)
            if following is None:
                return
            item = following
            self.begin(item)

    def begin(self, item: RunItem) -> None:
        """Say how the results of the run are to be taken."""
        self.sent += 1
        self.traffic_ap.write(item.traffic)

    async def offer(self, item: RunItem) -> None:
        """Begin to offer the run."""
        dut = self.dut
        if item.traffic.idle_abort or item.traffic.acknowledge:
            dut.abort_i.value = int(item.traffic.idle_abort)
            dut.acknowledge_i.value = int(item.traffic.acknowledge)
            await self.edge
            dut.abort_i.value = dut.acknowledge_i.value = 0
        self.offered = cocotb.start_soon(self._send(pack_run(item.request, self.configuration)))

    async def _send(self, beat: tuple[int, int]) -> None:
        await self.bus.send(beat, sync=False)
        self.bus.idle()

    async def accepted(self) -> None:
        """Wait until the run is accepted."""
        await self.offered

    async def ended(self, item: RunItem) -> int:
        """Wait for the summary, or for a reset; return the clocks since the run was accepted."""
        dut, traffic = self.dut, item.traffic
        limit = _longest_run(self.configuration)
        for clock in range(limit):
            dut.abort_i.value = int(clock in traffic.aborts)
            await self.edge
            taken = int(dut.m_axis_done_tvalid_o.value) and int(dut.m_axis_done_tready_i.value)
            if taken or not int(dut.rst_ni.value):
                dut.abort_i.value = 0
                return clock + 1
        report_failure(HANGS)
        raise HungError(f"no summary in {limit} clocks: the engine hangs")


class RunMonitor(PinMonitor):
    """Publishes runs that are accepted (RunAccepted) and aborts during them (AbortAsked)."""

    clock, idle_abort, acknowledged = 0, False, False

    def look(self, dut: Any) -> None:
        """See whether a run is accepted, or aborted."""
        busy, abort = int(dut.busy_o.value), int(dut.abort_i.value)
        if busy:
            if abort:
                self.ap.write(AbortAsked(self.clock))
            self.clock += 1
            return
        self.idle_abort |= bool(abort)
        self.acknowledged |= bool(int(dut.acknowledge_i.value))
        if int(dut.s_axis_run_tvalid_i.value) and int(dut.s_axis_run_tready_o.value):
            data, user = int(dut.s_axis_run_tdata_i.value), int(dut.s_axis_run_tuser_i.value)
            request = unpack_run(data, user, self.configuration)
            self.ap.write(RunAccepted(request, self.idle_abort, self.acknowledged))
            self.clock, self.idle_abort, self.acknowledged = 0, False, False

    def reset(self) -> None:
        """Forget an abort, and an acknowledgement."""
        self.idle_abort = self.acknowledged = False


class RunAgent(StimulusAgent):
    """Asks for runs and sees what is accepted. A run item is done once its summary was taken."""

    driver_kind, monitor_kind = RunDriver, RunMonitor


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
            yield pace.draw(self.random)


class NearMonitor(PinMonitor):
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


class CoreMonitor(PinMonitor):
    """Publishes pairs that the core accepts: CorePairs."""

    def look(self, dut: Any) -> None:
        """See whether the core accepts one."""
        if int(dut.core_valid.value) and int(dut.core_ready.value):
            pair = int(dut.core_a.value), int(dut.core_b.value)
            self.ap.write(CorePairs(np.array([pair], np.int64)))


class SummaryMonitor(PinMonitor):
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
            dut.zones_o,
        )
        held = int(dut.count_a_o.value), int(dut.count_b_o.value)
        overfull = int(dut.overfull_o.value)
        numbers = (int(pin.value) for pin in pins)
        self.ap.write(
            Summary(
                *numbers,
                offered_after=self.clocks,
                wait=self.wait,
                held=held,
                signatures=(int(dut.signature_a_o.value), int(dut.signature_b_o.value)),
                overfull=overfull,
                fault=int(dut.fault_o.value),
                clock=clock_now(),
            )
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
