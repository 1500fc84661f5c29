"""The agents on the pins: the input stream's driver, the output stream's ready, a monitor of each.

Values are read at a rising edge before it takes effect, and driven after it: a beat moves at an edge where
both tvalid and tready read 1. Pins are driven through cocotb-bus.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from random import Random
from typing import Any, cast

import numpy as np
import numpy.typing as npt
from cocotb.triggers import RisingEdge
from cocotb_bus.drivers import BitDriver, ValidatedBusDriver
from pyuvm import uvm_agent, uvm_analysis_port, uvm_driver, uvm_monitor, uvm_subscriber

from triaxis.golden.errors import InputError
from triaxis.golden.pairs import check_pairs
from triaxis.sim.packing import pack_data, pack_user, unpack_data, unpack_user
from triaxis.sim.player import HANGS
from triaxis.verif.core.items import FULL_SPEED, BurstItem, Pace, PairBatch, ResetSeen, ResultBatch
from triaxis.verif.testbench.environment import (
    StimulusAgent,
    StreamPins,
    clock_now,
    create,
    dut_of,
    settings_of,
)
from triaxis.verif.testbench.failures import HungError, report_failure
from triaxis.verif.testbench.settings import RunSettings
from triaxis.verif.testbench.unknown_values import withdraw

SOURCE_BUS, SINK_BUS = "s_axis", "m_axis"
SOURCE_SIGNALS = {"tvalid": "tvalid_i", "tready": "tready_o", "tdata": "tdata_i", "tuser": "tuser_i"}
SINK_SIGNALS = {"tvalid": "tvalid_o", "tready": "tready_i", "tdata": "tdata_o", "tuser": "tuser_o"}


class SourceBus(ValidatedBusDriver):
    """Offers beats on an input stream; an offered beat stays until it is accepted or reset.

    ``patience``: clocks out of reset after which a beat that is not accepted fails the test: a hung design
    would keep it waiting for ever.
    """

    _signals = SOURCE_SIGNALS

    def __init__(self, dut: Any, name: str, patience: int, settings: RunSettings) -> None:
        """Start with nothing offered."""
        super().__init__(dut, name, dut.clk_i)
        self._edge = RisingEdge(dut.clk_i)
        self._reset_n = dut.rst_ni
        self._dut, self._stream, self._patience, self._settings = dut, name, patience, settings
        self.pins = cast(StreamPins, self.bus)
        self.pins.tdata.value = 0
        self.pins.tuser.value = 0
        self.idle()

    def set_pace(self, pace: Pace, random: Random) -> None:
        """Offer beats at this pace from now on."""

        def cycles() -> Iterator[tuple[int, int]]:
            while True:
                yield pace.draw(random)

        self.set_valid_generator(cycles() if pace.off else None)

    def idle(self) -> None:
        """Offer nothing until the next beat."""
        withdraw(self._dut, self._stream, self._settings)

    async def _driver_send(self, transaction: tuple[int, int], sync: bool = True, **kwargs: Any) -> None:
        edge, pins = self._edge, self.pins
        if sync:
            await edge
        if not self.on:
            self.idle()
            for _ in range(int(self.off or 0)):
                await edge
            self._next_valids()
        pins.tdata.value, pins.tuser.value = transaction
        pins.tvalid.value = 1
        waited = 0
        await edge
        while not (int(pins.tready.value) and int(self._reset_n.value)):
            # AXI4-Stream wants tvalid low in reset.
            if not int(self._reset_n.value):
                self.idle()
                waited = 0
            elif not int(pins.tvalid.value):
                pins.tdata.value, pins.tuser.value = transaction
                pins.tvalid.value = 1
            elif (waited := waited + 1) > self._patience:
                report_failure(HANGS)
                raise HungError(f"{self._stream}: not accepted in {self._patience} clocks: the design hangs")
            await edge
        # With no generator, `on` is True for good.
        if self.on and self.on is not True:
            self.on -= 1


# Odd, so that tags return only after all others; of as many bits as the widest.
_TAG_STEP = np.uint64(0x9E3779B97F4A9E37)

# Clocks after which a beat that is not accepted means that the core hangs: no pace of results pauses so long.
PATIENCE = 5000

# Beats gathered before they are published together.
_BATCH = 512


@dataclass
class Beats:
    """Beats seen: TDATA, TUSER, the clocks that each was offered before it moved, and the clock of that."""

    data: list[int] = field(default_factory=list)
    user: list[int] = field(default_factory=list)
    waits: list[int] = field(default_factory=list)
    clocks: list[int] = field(default_factory=list)


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
        self.bus = SourceBus(dut_of(self), SOURCE_BUS, PATIENCE, self.settings)

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

    def tags_of(self, item: BurstItem) -> npt.NDArray[np.uint64]:
        """Return the tags (N,) of an item's pairs, and above them what they try.

        No two are alike among the last, and every bit moves.
        """
        count = len(item.pairs)
        numbers = _TAG_STEP * np.arange(self.next_tag, self.next_tag + count, dtype=np.uint64)
        configuration = self.settings.configuration
        self.next_tag += count
        tags = numbers & np.uint64((1 << configuration.tag_bits) - 1)
        if item.attempts is None:
            return tags
        if not configuration.certified:
            raise InputError(f"stimulus: {configuration.name}: only a certified core can try anything")
        return tags | item.attempts.astype(np.uint64) << np.uint64(configuration.tag_bits)

    async def drive(self, item: BurstItem, tags: npt.NDArray[np.uint64]) -> None:
        """Offer the pairs until the last is accepted."""
        configuration = self.settings.configuration
        self.bus.set_pace(item.gaps, self.random)
        data = pack_data(item.pairs.astype(np.int64), configuration.width)
        user = pack_user(item.margins.astype(np.int64), tags, configuration)
        for index, beat in enumerate(zip(data, user, strict=True)):
            await self.bus.send(beat, sync=index == 0)
        # The next item, if there is one now, overwrites this before the next edge.
        self.bus.idle()


class PinMonitor(uvm_monitor):
    """Publishes the beats of one stream, in batches, and resets as they begin: ResetSeen."""

    name_of_bus: str
    signals: dict[str, str]

    def build_phase(self) -> None:
        """Make the analysis port."""
        self.ap = uvm_analysis_port("ap", self)
        self.configuration = settings_of(self).configuration
        self._beats = Beats()

    async def run_phase(self) -> None:
        """Watch the pins at every edge, before it takes effect."""
        dut = dut_of(self)
        edge, reset_n = RisingEdge(dut.clk_i), dut.rst_ni
        names = ("tvalid", "tready", "tdata", "tuser")
        valid, ready, data, user = (getattr(dut, f"{self.name_of_bus}_{self.signals[n]}") for n in names)
        was_reset, wait = True, 0
        while True:
            await edge
            if not int(reset_n.value):
                if not was_reset:
                    self.flush()
                    self.ap.write(ResetSeen())
                was_reset, wait = True, 0
                continue
            was_reset = False
            if not int(valid.value):
                continue
            if not int(ready.value):
                wait += 1
                continue
            self._beats.data.append(int(data.value))
            self._beats.user.append(int(user.value))
            self._beats.waits.append(wait)
            self._beats.clocks.append(clock_now())
            wait = 0
            if len(self._beats.data) == _BATCH:
                self.flush()

    def flush(self) -> None:
        """Publish what was seen so far."""
        if self._beats.data:
            beats, self._beats = self._beats, Beats()
            self.ap.write(self.to_batch(beats))

    def to_batch(self, beats: Beats) -> Any:
        """Return the batch of some beats."""
        raise NotImplementedError


class SourceMonitor(PinMonitor):
    """Publishes accepted pairs: PairBatch."""

    name_of_bus, signals = SOURCE_BUS, SOURCE_SIGNALS

    def to_batch(self, beats: Beats) -> PairBatch:
        """Return the pairs."""
        margins, tags = unpack_user(beats.user, self.configuration)
        pairs = unpack_data(beats.data, self.configuration.width)
        return PairBatch(pairs, margins, tags, np.array(beats.waits, np.int64))


class SourceAgent(StimulusAgent):
    """Feeds pairs into the core and sees what it accepts."""

    driver_kind, monitor_kind = SourceDriver, SourceMonitor


class ReadyDriver(uvm_subscriber):
    """Drives tready at a pace that may be changed at any time, also by writing to it."""

    def build_phase(self) -> None:
        """Start always ready."""
        self.pace = FULL_SPEED
        self.random = Random(f"sink {settings_of(self).seed}")

    def write(self, tt: Pace) -> None:  # pyright: ignore[reportIncompatibleMethodOverride]
        """Take results at this pace from now on."""
        self.pace = tt

    def start_of_simulation_phase(self) -> None:
        """Take hold of the pin."""
        dut = dut_of(self)
        BitDriver(dut.m_axis_tready_i, dut.clk_i).start(self._cycles())

    def _cycles(self) -> Iterator[tuple[int, int]]:
        while True:
            yield self.pace.draw(self.random)


class SinkMonitor(PinMonitor):
    """Publishes results taken: ResultBatch."""

    name_of_bus, signals = SINK_BUS, SINK_SIGNALS

    def to_batch(self, beats: Beats) -> ResultBatch:
        """Return the results."""
        words, tags = np.array(beats.data, np.uint16), np.array(beats.user, np.uint64)
        return ResultBatch(words, tags, np.array(beats.waits, np.int64), np.array(beats.clocks, np.int64))


class SinkAgent(uvm_agent):
    """Takes results from the core."""

    def build_phase(self) -> None:
        """Make the parts."""
        super().build_phase()
        self.ready = create(ReadyDriver, "ready", self)
        self.monitor = create(SinkMonitor, "monitor", self)
