"""The input stream's pins, driven through cocotb-bus.

Values are read at a rising edge before it takes effect, and driven after it.
"""

from collections.abc import Iterator
from random import Random
from typing import Any, cast

from cocotb.handle import HierarchyObject, LogicObject
from cocotb.triggers import RisingEdge
from cocotb_bus.drivers import ValidatedBusDriver

from triaxis.verif.core.items import Pace
from triaxis.verif.testbench.handles import StreamPins

SOURCE_BUS = "s_axis"
SOURCE_SIGNALS = {
    "tvalid": "tvalid_i",
    "tready": "tready_o",
    "tdata": "tdata_i",
    "tuser": "tuser_i",
}


class SourceBus(ValidatedBusDriver):
    """Offers beats on the input stream; an offered beat stays until it is accepted or reset."""

    _signals = SOURCE_SIGNALS

    def __init__(self, dut: HierarchyObject, clock: LogicObject, reset_n: LogicObject) -> None:
        """Start with nothing offered."""
        super().__init__(dut, SOURCE_BUS, clock)
        self._edge = RisingEdge(clock)
        self._reset_n = reset_n
        self.pins = cast(StreamPins, self.bus)
        self.pins.tvalid.value = 0
        self.pins.tdata.value = 0
        self.pins.tuser.value = 0

    def set_pace(self, pace: Pace, random: Random) -> None:
        """Offer beats at this pace from now on."""

        def cycles() -> Iterator[tuple[int, int]]:
            while True:
                yield random.randint(1, pace.on), random.randint(0, pace.off)

        self.set_valid_generator(cycles() if pace.off else None)

    def idle(self) -> None:
        """Offer nothing until the next beat."""
        self.pins.tvalid.value = 0

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
        await edge
        while not (int(pins.tready.value) and int(self._reset_n.value)):
            # AXI4-Stream wants tvalid low in reset.
            pins.tvalid.value = int(self._reset_n.value)
            await edge
        # With no generator, `on` is True for good.
        if self.on and self.on is not True:
            self.on -= 1
