"""The agent of the input stream: sequencer, driver, monitor."""

from random import Random

import numpy as np
import numpy.typing as npt
from pyuvm import uvm_agent, uvm_analysis_port, uvm_driver, uvm_monitor, uvm_sequencer

from triaxis.golden.errors import InputError
from triaxis.golden.pairs import check_pairs
from triaxis.sim.packing import pack_data, pack_user, unpack_data, unpack_user
from triaxis.verif.core.items import BurstItem
from triaxis.verif.core.source_bus import SOURCE_BUS, SOURCE_SIGNALS, SourceBus
from triaxis.verif.core.stream_monitor import Beats, StreamMonitor
from triaxis.verif.testbench.batches import PairBatch
from triaxis.verif.testbench.handles import create, dut_of, settings_of


def check_margins(item: BurstItem, largest: int) -> None:
    """Raise InputError unless the margins of an item are 0..largest."""
    if len(item.margins) and not 0 <= item.margins.min() <= item.margins.max() <= largest:
        raise InputError(f"stimulus: margins must be 0..{largest}")


class SourceDriver(uvm_driver):
    """Drives bursts beat by beat; publishes the stalls that items ask for."""

    def build_phase(self) -> None:
        """Fetch the settings."""
        self.settings = settings_of(self)
        self.stalls_ap = uvm_analysis_port("stalls_ap", self)
        self.random = Random(f"source {self.settings.seed}")
        self.next_tag = 0

    def start_of_simulation_phase(self) -> None:
        """Take hold of the pins."""
        dut = dut_of(self)
        self.bus = SourceBus(dut, dut.clk_i, dut.rst_ni)

    async def run_phase(self) -> None:
        """Drive items as they come."""
        while True:
            item: BurstItem = await self.seq_item_port.get_next_item()
            self.check(item)
            if item.stalls is not None:
                self.stalls_ap.write(item.stalls)
            await self.drive(item, self.tags_of(item))
            self.seq_item_port.item_done()

    def check(self, item: BurstItem) -> None:
        """Raise InputError for what does not fit: it would wrap, the fault of the replaced testbench."""
        configuration = self.settings.configuration
        check_pairs(item.pairs, configuration.width, "stimulus")
        check_margins(item, configuration.max_margin)

    def tags_of(self, item: BurstItem) -> npt.NDArray[np.int64]:
        """Return the tags (N,) of an item's pairs."""
        count = len(item.pairs)
        tags = self.next_tag + np.arange(count) if item.tags is None else item.tags.astype(np.int64)
        self.next_tag += count
        return tags & ((1 << self.settings.configuration.tag_bits) - 1)

    async def drive(self, item: BurstItem, tags: npt.NDArray[np.int64]) -> None:
        """Offer the pairs until the last is accepted."""
        configuration = self.settings.configuration
        self.bus.set_pace(item.gaps, self.random)
        data = pack_data(item.pairs.astype(np.int64), configuration.width)
        user = pack_user(item.margins.astype(np.int64), tags, configuration)
        for index, beat in enumerate(zip(data, user, strict=True)):
            await self.bus.send(beat, sync=index == 0)
        # The next item, if there is one now, overwrites this before the next edge.
        self.bus.idle()


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

    @property
    def moved(self) -> int:
        """Return how many pairs were seen."""
        return self.bus.moved

    def flush(self) -> None:
        """Publish what was seen so far."""
        self.bus.flush()

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
