"""The agent of the input stream: sequencer, driver, monitor."""

from random import Random

import numpy as np
from pyuvm import uvm_agent, uvm_analysis_port, uvm_driver, uvm_monitor, uvm_sequencer

from triaxis.golden.errors import InputError
from triaxis.golden.pairs import check_pairs
from triaxis.verif.agents.source_bus import SOURCE_BUS, SOURCE_SIGNALS, SourceBus
from triaxis.verif.agents.stream_monitor import Beats, StreamMonitor
from triaxis.verif.batches import PairBatch
from triaxis.verif.handles import create, dut_of, settings_of
from triaxis.verif.packing import pack_data, pack_user, unpack_data, unpack_user


class SourceDriver(uvm_driver):
    """Drives bursts beat by beat, with consecutive tags."""

    def build_phase(self) -> None:
        """Fetch the settings."""
        self.settings = settings_of(self)
        self.random = Random(f"source {self.settings.seed}")
        self.next_tag = 0

    def start_of_simulation_phase(self) -> None:
        """Take hold of the pins."""
        dut = dut_of(self)
        self.bus = SourceBus(dut, dut.clk_i, dut.rst_ni)

    async def run_phase(self) -> None:
        """Drive items as they come."""
        configuration = self.settings.configuration
        mask = (1 << configuration.tag_bits) - 1
        while True:
            item = await self.seq_item_port.get_next_item()
            self.bus.set_pace(item.pace, self.random)
            tags = (self.next_tag + np.arange(len(item.pairs), dtype=np.int64)) & mask
            self.next_tag += len(item.pairs)
            # What does not fit would wrap: the fault of the testbench that this one replaces.
            check_pairs(item.pairs, configuration.width, "stimulus")
            if item.margins.min(initial=0) < 0 or item.margins.max(initial=0) > configuration.max_margin:
                raise InputError(f"stimulus: margins must be 0..{configuration.max_margin}")
            data = pack_data(item.pairs, configuration.width)
            user = pack_user(item.margins, tags, configuration)
            for index, beat in enumerate(zip(data, user, strict=True)):
                await self.bus.send(beat, sync=index == 0)
            # The next item, if there is one now, overwrites this before the next edge.
            self.bus.idle()
            self.seq_item_port.item_done()


class SourceMonitor(uvm_monitor):
    """Publishes accepted pairs (PairBatch) and resets (ResetSeen)."""

    def build_phase(self) -> None:
        """Make the analysis port."""
        self.ap = uvm_analysis_port("ap", self)
        self.configuration = settings_of(self).configuration

    def start_of_simulation_phase(self) -> None:
        """Take hold of the pins."""
        dut = dut_of(self)
        self.bus = StreamMonitor(
            dut, SOURCE_BUS, SOURCE_SIGNALS, dut.clk_i, dut.rst_ni, self._to_batch, self.ap.write
        )

    def _to_batch(self, beats: Beats) -> PairBatch:
        margins, tags = unpack_user(beats.user, self.configuration)
        pairs = unpack_data(beats.data, self.configuration.width)
        return PairBatch(pairs, margins, tags, np.array(beats.waits, np.int64))


class SourceAgent(uvm_agent):
    """Feeds pairs into the core and sees what it accepts."""

    def build_phase(self) -> None:
        """Make the parts."""
        super().build_phase()
        self.sequencer = create(uvm_sequencer, "sequencer", self)
        self.driver = create(SourceDriver, "driver", self)
        self.monitor = create(SourceMonitor, "monitor", self)

    def connect_phase(self) -> None:
        """Give the driver its items."""
        self.driver.seq_item_port.connect(self.sequencer.seq_item_export)
