"""The agent of the output stream: ready driver and monitor."""

from collections.abc import Iterator
from random import Random

import numpy as np
from cocotb.handle import LogicObject
from cocotb_bus.drivers import BitDriver
from pyuvm import uvm_agent, uvm_analysis_port, uvm_monitor, uvm_subscriber

from triaxis.verif.core.items import FULL_SPEED, Pace
from triaxis.verif.core.stream_monitor import Beats, StreamMonitor
from triaxis.verif.testbench.batches import ResultBatch
from triaxis.verif.testbench.handles import create, dut_of, settings_of

SINK_BUS = "m_axis"
SINK_SIGNALS = {
    "tvalid": "tvalid_o",
    "tready": "tready_i",
    "tdata": "tdata_o",
    "tuser": "tuser_o",
}


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
        ready: LogicObject = dut.m_axis_tready_i
        BitDriver(ready, dut.clk_i).start(self._cycles())

    def _cycles(self) -> Iterator[tuple[int, int]]:
        while True:
            yield self.random.randint(1, self.pace.on), self.random.randint(0, self.pace.off)


class SinkMonitor(uvm_monitor):
    """Publishes results taken (ResultBatch) and resets (ResetSeen)."""

    def build_phase(self) -> None:
        """Make the analysis port."""
        self.ap = uvm_analysis_port("ap", self)

    def start_of_simulation_phase(self) -> None:
        """Take hold of the pins."""
        dut = dut_of(self)
        self.bus = StreamMonitor(
            dut, SINK_BUS, SINK_SIGNALS, dut.clk_i, dut.rst_ni, self._to_batch, self.ap.write
        )

    @property
    def moved(self) -> int:
        """Return how many results were seen."""
        return self.bus.moved

    def flush(self) -> None:
        """Publish what was seen so far."""
        self.bus.flush()

    @staticmethod
    def _to_batch(beats: Beats) -> ResultBatch:
        return ResultBatch(
            np.array(beats.data, np.uint16),
            np.array(beats.user, np.int64),
            np.array(beats.waits, np.int64),
        )


class SinkAgent(uvm_agent):
    """Takes results from the core."""

    def build_phase(self) -> None:
        """Make the parts."""
        super().build_phase()
        self.ready = create(ReadyDriver, "ready", self)
        self.monitor = create(SinkMonitor, "monitor", self)
