"""The agent of the run stream: sequencer, driver, monitor. A run item is done once its summary was taken."""

from cocotb.triggers import RisingEdge
from pyuvm import uvm_agent, uvm_analysis_port, uvm_driver, uvm_monitor, uvm_sequencer

from triaxis.verif.mesh.handles import mesh_configuration_of
from triaxis.verif.mesh.items import RunItem, RunTraffic
from triaxis.verif.mesh.observed import AbortAsked, RunAccepted
from triaxis.verif.mesh.packing import pack_run, unpack_run
from triaxis.verif.testbench.handles import create, dut_of

# Clocks that a run may take for each pair that the meshes can have, and at least: stalls are included.
_CLOCKS_A_PAIR, _LEAST_CLOCKS = 100, 20_000


class HungRunError(AssertionError):
    """The engine did not end a run within its budget of clocks."""


class RunDriver(uvm_driver):
    """Offers runs, aborts them where the item says so, and waits for their summaries."""

    def build_phase(self) -> None:
        """Make the port that tells how the results are to be taken."""
        self.configuration = mesh_configuration_of(self)
        self.traffic_ap = uvm_analysis_port("traffic_ap", self)
        self.sent = 0

    def start_of_simulation_phase(self) -> None:
        """Take hold of the pins."""
        self.dut = dut_of(self)
        self.dut.s_axis_run_tvalid_i.value = 0
        self.dut.abort_i.value = 0
        self.edge = RisingEdge(self.dut.clk_i)

    async def run_phase(self) -> None:
        """Drive items as they come."""
        while True:
            item: RunItem = await self.seq_item_port.get_next_item()
            self.sent += 1
            self.traffic_ap.write(item.traffic)
            await self.drive(item)
            self.seq_item_port.item_done()

    async def drive(self, item: RunItem) -> None:
        """Offer the run, see it end."""
        dut = self.dut
        if item.traffic.idle_abort:
            dut.abort_i.value = 1
            await self.edge
            dut.abort_i.value = 0
        data, user = pack_run(item.request, self.configuration)
        dut.s_axis_run_tdata_i.value = data
        dut.s_axis_run_tuser_i.value = user
        dut.s_axis_run_tvalid_i.value = 1
        await self.edge
        while not int(dut.s_axis_run_tready_o.value) or not int(dut.rst_ni.value):
            await self.edge
        dut.s_axis_run_tvalid_i.value = 0
        item.clocks = await self._until_done(item.traffic)

    async def _until_done(self, traffic: RunTraffic) -> int:
        dut = self.dut
        limit = _LEAST_CLOCKS + _CLOCKS_A_PAIR * min(self.configuration.depth, 256) ** 2
        for clock in range(limit):
            dut.abort_i.value = int(clock in traffic.aborts)
            await self.edge
            taken = int(dut.m_axis_done_tvalid_o.value) and int(dut.m_axis_done_tready_i.value)
            if taken or not int(dut.rst_ni.value):
                dut.abort_i.value = 0
                return clock + 1
        raise HungRunError(f"no summary in {limit} clocks: the engine hangs")


class RunMonitor(uvm_monitor):
    """Publishes runs that are accepted (RunAccepted) and aborts during them (AbortAsked)."""

    def build_phase(self) -> None:
        """Make the analysis port."""
        self.ap = uvm_analysis_port("ap", self)
        self.configuration = mesh_configuration_of(self)

    async def run_phase(self) -> None:
        """Watch the pins at every edge, before it takes effect."""
        dut = dut_of(self)
        edge = RisingEdge(dut.clk_i)
        clock, idle_abort = 0, False
        while True:
            await edge
            if not int(dut.rst_ni.value):
                idle_abort = False
                continue
            busy, abort = int(dut.busy_o.value), int(dut.abort_i.value)
            if busy:
                if abort:
                    self.ap.write(AbortAsked(clock))
                clock += 1
                continue
            idle_abort |= bool(abort)
            if int(dut.s_axis_run_tvalid_i.value) and int(dut.s_axis_run_tready_o.value):
                data, user = int(dut.s_axis_run_tdata_i.value), int(dut.s_axis_run_tuser_i.value)
                self.ap.write(RunAccepted(unpack_run(data, user, self.configuration), idle_abort))
                clock, idle_abort = 0, False


class RunAgent(uvm_agent):
    """Asks for runs and sees what is accepted."""

    def build_phase(self) -> None:
        """Make the parts."""
        super().build_phase()
        self.sequencer = create(uvm_sequencer, "sequencer", self)
        self.driver = create(RunDriver, "driver", self)
        self.monitor = create(RunMonitor, "monitor", self)

    def connect_phase(self) -> None:
        """Give the driver its items."""
        self.driver.seq_item_port.connect(self.sequencer.seq_item_export)
