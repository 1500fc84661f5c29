"""Drivers and monitors that work on whole bursts, through the bus-functional model.

They take the places of the pin-level ones by factory override (`use_bursts`); agents, sequences and
scoreboard are the same.
"""

import numpy as np
import numpy.typing as npt
from pyuvm import uvm_analysis_port, uvm_factory, uvm_monitor

from triaxis.golden.pairs import coordinate_range
from triaxis.verif.core.burst_bfm import BurstBfm
from triaxis.verif.core.items import BurstItem, Pace
from triaxis.verif.core.sink_agent import ReadyDriver, SinkMonitor
from triaxis.verif.core.source_agent import SourceDriver, SourceMonitor, check_margins
from triaxis.verif.testbench.batches import PairBatch, ResetSeen, ResultBatch
from triaxis.verif.testbench.handles import bfm_of, settings_of


class BurstSourceDriver(SourceDriver):
    """Hands bursts to the bus-functional model."""

    def start_of_simulation_phase(self) -> None:
        """Take hold of the model."""
        self.bfm: BurstBfm = bfm_of(self)
        self.rng = np.random.default_rng([self.settings.seed, *b"source"])

    def check(self, item: BurstItem) -> None:
        """Raise InputError for what does not fit; the fast way for whole bursts."""
        low, high = coordinate_range(self.settings.configuration.width)
        if item.pairs.min(initial=0) < low or item.pairs.max(initial=0) > high:
            # Says which coordinate it is.
            super().check(item)
        check_margins(item, self.settings.configuration.max_margin)

    async def drive(self, item: BurstItem, tags: npt.NDArray[np.int64]) -> None:
        """Offer the pairs until the last is accepted; HungBurstError where that never comes."""
        await self.bfm.send(item.pairs, item.margins, tags, item.gaps, self.rng)


class BurstMonitor(uvm_monitor):
    """Publishes what the model's monitor of one stream saw, whenever the model asks for it."""

    ap: uvm_analysis_port

    def start_of_simulation_phase(self) -> None:
        """Take hold of the model."""
        self.bfm: BurstBfm = bfm_of(self)
        self._moved = 0

    async def run_phase(self) -> None:
        """Fetch when woken."""
        while True:
            await self.bfm.wake
            self.flush()

    def fetch(self) -> tuple[PairBatch | ResultBatch, bool]:
        """Return the beats up to the next reset, and whether a reset began right after them."""
        raise NotImplementedError

    @property
    def moved(self) -> int:
        """Return how many beats were fetched."""
        return self._moved

    def flush(self) -> None:
        """Publish what was seen so far."""
        reset = True
        while reset:
            batch, reset = self.fetch()
            self._moved += len(batch)
            if len(batch):
                self.ap.write(batch)
            if reset:
                self.ap.write(ResetSeen())


class BurstSourceMonitor(BurstMonitor, SourceMonitor):
    """Publishes accepted pairs and resets."""

    def fetch(self) -> tuple[PairBatch, bool]:
        """Fetch pairs."""
        return self.bfm.input_beats()


class BurstSinkMonitor(BurstMonitor, SinkMonitor):
    """Publishes results and resets."""

    def fetch(self) -> tuple[ResultBatch, bool]:
        """Fetch results."""
        return self.bfm.output_beats()


class BurstReadyDriver(ReadyDriver):
    """Sets the pace at which the model takes results."""

    def start_of_simulation_phase(self) -> None:
        """Take hold of the model."""
        self.bfm: BurstBfm = bfm_of(self)
        self.rng = np.random.default_rng([settings_of(self).seed, *b"sink"])

    def write(self, tt: Pace) -> None:
        """Take results at this pace from now on."""
        super().write(tt)
        self.bfm.set_sink_pace(tt, self.rng)


def use_bursts() -> None:
    """Make the factory give the burst drivers and monitors in place of the pin-level ones."""
    factory = uvm_factory()
    factory.set_type_override_by_type(SourceDriver, BurstSourceDriver)
    factory.set_type_override_by_type(SourceMonitor, BurstSourceMonitor)
    factory.set_type_override_by_type(SinkMonitor, BurstSinkMonitor)
    factory.set_type_override_by_type(ReadyDriver, BurstReadyDriver)
