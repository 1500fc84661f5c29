"""The agent of the load stream: sequencer, driver, monitor."""

from random import Random

import numpy as np
from cocotb.triggers import RisingEdge
from pyuvm import uvm_agent, uvm_analysis_port, uvm_driver, uvm_monitor, uvm_sequencer

from triaxis.golden.errors import InputError
from triaxis.golden.pairs import coordinate_range
from triaxis.verif.core.items import Pace
from triaxis.verif.mesh.handles import mesh_configuration_of
from triaxis.verif.mesh.items import LoadItem
from triaxis.verif.mesh.observed import Loaded
from triaxis.verif.mesh.packing import pack_triangle, unpack_triangle
from triaxis.verif.testbench.handles import create, dut_of, settings_of

_NO_TRIANGLES = np.empty((0, 3, 3), np.int64)


class LoadDriver(uvm_driver):
    """Offers triangles one by one."""

    def build_phase(self) -> None:
        """Fetch the settings."""
        self.configuration = mesh_configuration_of(self)
        self.random = Random(f"load {settings_of(self).seed}")
        self.sent = 0

    def start_of_simulation_phase(self) -> None:
        """Take hold of the pins."""
        self.dut = dut_of(self)
        self.dut.s_axis_load_tvalid_i.value = 0
        self.edge = RisingEdge(self.dut.clk_i)

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
        on = 0
        for data, user in beats:
            on -= 1
            if item.gaps.off and on < 1:
                on = self.random.randint(1, item.gaps.on)
                await self._pause(item.gaps)
            await self._send(data, user)
        self.dut.s_axis_load_tvalid_i.value = 0

    async def _pause(self, gaps: Pace) -> None:
        self.dut.s_axis_load_tvalid_i.value = 0
        for _ in range(self.random.randint(0, gaps.off)):
            await self.edge

    async def _send(self, data: int, user: int) -> None:
        dut = self.dut
        dut.s_axis_load_tdata_i.value = data
        dut.s_axis_load_tuser_i.value = user
        dut.s_axis_load_tvalid_i.value = 1
        await self.edge
        while not int(dut.s_axis_load_tready_o.value) or not int(dut.rst_ni.value):
            await self.edge


class LoadMonitor(uvm_monitor):
    """Publishes what the engine was loaded with, beat by beat: Loaded."""

    def build_phase(self) -> None:
        """Make the analysis port."""
        self.ap = uvm_analysis_port("ap", self)
        self.width = mesh_configuration_of(self).width

    async def run_phase(self) -> None:
        """Watch the pins at every edge, before it takes effect."""
        dut = dut_of(self)
        edge = RisingEdge(dut.clk_i)
        valid, ready, reset_n = dut.s_axis_load_tvalid_i, dut.s_axis_load_tready_o, dut.rst_ni
        while True:
            await edge
            if not int(valid.value) or not int(ready.value) or not int(reset_n.value):
                continue
            user = int(dut.s_axis_load_tuser_i.value)
            clear = bool(user & 2)
            triangle = unpack_triangle(int(dut.s_axis_load_tdata_i.value), self.width)[None]
            run = int(dut.s_axis_run_tvalid_i.value) and int(dut.s_axis_run_tready_o.value)
            self.ap.write(Loaded(user & 1, clear, _NO_TRIANGLES if clear else triangle, bool(run)))


class LoadAgent(uvm_agent):
    """Loads meshes and sees what is accepted."""

    def build_phase(self) -> None:
        """Make the parts."""
        super().build_phase()
        self.sequencer = create(uvm_sequencer, "sequencer", self)
        self.driver = create(LoadDriver, "driver", self)
        self.monitor = create(LoadMonitor, "monitor", self)

    def connect_phase(self) -> None:
        """Give the driver its items."""
        self.driver.seq_item_port.connect(self.sequencer.seq_item_export)
