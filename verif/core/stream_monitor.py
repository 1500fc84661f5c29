"""What the monitors of both streams share: gathering beats, waits and resets.

Values are read at a rising edge before it takes effect: a beat moves at an edge where both tvalid
and tready read 1.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, cast

from cocotb.handle import HierarchyObject, LogicObject
from cocotb.triggers import RisingEdge
from cocotb_bus.monitors import BusMonitor

from triaxis.verif.testbench.batches import ResetSeen
from triaxis.verif.testbench.handles import StreamPins

# Beats gathered before they are published together.
_BATCH = 512


@dataclass
class Beats:
    """Beats seen: TDATA, TUSER, and how many clocks each was offered before it moved."""

    data: list[int] = field(default_factory=list)
    user: list[int] = field(default_factory=list)
    waits: list[int] = field(default_factory=list)


class StreamMonitor(BusMonitor):
    """Sees the beats of one AXI4-Stream and publishes them in batches, and resets as they begin."""

    def __init__(
        self,
        dut: HierarchyObject,
        bus: str,
        signals: dict[str, str],
        clock: LogicObject,
        reset_n: LogicObject,
        to_batch: Callable[[Beats], Any],
        publish: Callable[[Any], None],
    ) -> None:
        """``signals`` names tvalid, tready, tdata and tuser; ``to_batch`` makes a batch of beats."""
        self._signals = signals
        self._to_batch = to_batch
        self._beats = Beats()
        self.moved = 0
        self._edge = RisingEdge(clock)
        super().__init__(dut, bus, clock, reset_n=reset_n, callback=publish)

    def flush(self) -> None:
        """Publish the beats gathered so far."""
        if self._beats.data:
            beats, self._beats = self._beats, Beats()
            self._recv(self._to_batch(beats))

    async def _monitor_recv(self) -> None:
        edge = self._edge
        pins = cast(StreamPins, self.bus)
        was_reset = True
        wait = 0
        while True:
            await edge
            if self.in_reset:
                if not was_reset:
                    self.flush()
                    self._recv(ResetSeen())
                was_reset, wait = True, 0
                continue
            was_reset = False
            if not int(pins.tvalid.value):
                continue
            if not int(pins.tready.value):
                wait += 1
                continue
            self._beats.data.append(int(pins.tdata.value))
            self._beats.user.append(int(pins.tuser.value))
            self._beats.waits.append(wait)
            self.moved += 1
            wait = 0
            if len(self._beats.data) == _BATCH:
                self.flush()
