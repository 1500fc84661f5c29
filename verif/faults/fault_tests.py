"""UVM tests with the faults of the replaced design's testbench: the environment must fail each of them."""

from typing import Any

import numpy as np
from cocotb.triggers import RisingEdge
from pyuvm import uvm_factory

from triaxis.sim.packing import COORDINATES
from triaxis.verif.core.base_test import CoreTest
from triaxis.verif.core.env import CoreEnv
from triaxis.verif.core.pin_agents import PATIENCE, SOURCE_BUS, SourceBus, SourceDriver
from triaxis.verif.core.sequences import ArraySequence
from triaxis.verif.core.stimulus.seed_vectors import seed_vectors_as_written
from triaxis.verif.core.uvm_tests import MixedTest, StallsTest
from triaxis.verif.testbench.environment import dut_of
from triaxis.verif.testbench.settings import RunSettings


class WrappingVectorsTest(CoreTest):
    """Sends the seed vectors as they were written: some need 17 bits."""

    async def stimulus(self) -> None:
        """Send them unmoved."""
        pairs = seed_vectors_as_written()
        await self.send(ArraySequence(self.settings, pairs, np.zeros(len(pairs), np.int64)))


class LateBus(SourceBus):
    """Offers each pair without its last vertex, which follows a clock later."""

    def __init__(self, dut: Any, name: str, patience: int, settings: RunSettings) -> None:
        """Know where the last vertex lies."""
        super().__init__(dut, name, patience, settings)
        self._clock_edge = RisingEdge(dut.clk_i)
        self._early = (1 << (COORDINATES - 3) * settings.width) - 1

    async def _driver_send(self, transaction: tuple[int, int], sync: bool = True, **kwargs: Any) -> None:
        if sync:
            await self._clock_edge
        data, user = transaction
        self.pins.tdata.value, self.pins.tuser.value = data & self._early, user
        self.pins.tvalid.value = 1
        await self._clock_edge
        while not int(self.pins.tready.value):
            self.pins.tdata.value = data
            await self._clock_edge


class LateDriver(SourceDriver):
    """Drives the pins late."""

    def start_of_simulation_phase(self) -> None:
        """Take hold of the pins."""
        self.bus = LateBus(dut_of(self), SOURCE_BUS, PATIENCE, self.settings)


class LateOperandTest(StallsTest):
    """Part of each pair comes a clock late, while results are stalled and pairs wait."""

    def build_phase(self) -> None:
        """Put the late driver in the place of the punctual one."""
        super().build_phase()
        uvm_factory().set_type_override_by_type(SourceDriver, LateDriver)


class NothingSentTest(CoreTest):
    """Sends nothing."""

    async def stimulus(self) -> None:
        """Do nothing."""


class BlindEnv(CoreEnv):
    """Connects no monitor to the scoreboard."""

    def connect_phase(self) -> None:
        """Connect the stalls alone."""
        self.source.driver.stalls_ap.connect(self.sink.ready.analysis_export)


class NothingSeenTest(MixedTest):
    """Sends the mixture to a core that nobody watches."""

    def build_phase(self) -> None:
        """Put the blind environment in the place of the watchful one."""
        uvm_factory().set_type_override_by_type(CoreEnv, BlindEnv)
        super().build_phase()
