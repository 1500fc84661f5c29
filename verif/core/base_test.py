"""What all tests of the core share: its environment, and the end of the test."""

import cocotb
from pyuvm import uvm_sequence

from triaxis.verif.core.burst_agents import BurstBfm, use_bursts
from triaxis.verif.core.env import CoreEnv
from triaxis.verif.core.items import FULL_SPEED, BurstItem, Pace
from triaxis.verif.testbench.environment import EnvironmentTest, ItemsSequence, create
from triaxis.verif.testbench.failures import HungError

# Clocks without a beat on either stream after which the core is taken to hang: no pace pauses so long.
_PATIENCE_CYCLES = 5000
# Clocks in which a result too many would show: more than any latency.
_SURPLUS_CYCLES = 64
# Clocks that the last results may take once nothing stalls them, in steps: far above latency and queue.
_DRAIN_STEPS, _DRAIN_CYCLES = 50, 40


class CoreTest(EnvironmentTest):
    """Resets the core, runs `stimulus`, waits for the last result."""

    def build_phase(self) -> None:
        """Make the environment."""
        super().build_phase()
        self.env = create(CoreEnv, "env", self)

    def fast_model(self) -> BurstBfm:
        """Return the burst model."""
        use_bursts()
        return BurstBfm()

    async def traffic(self) -> None:
        """Run `stimulus` under a watchdog; wait for the last result."""
        watchdog = cocotb.start_soon(self.watch())
        await self.stimulus()
        await self.drain()
        watchdog.cancel()
        self.env.scoreboard.sent = self.env.source.driver.next_tag

    async def send(self, sequence: uvm_sequence) -> None:
        """Run a sequence on the input agent."""
        await sequence.start(self.env.source.sequencer)

    async def send_item(self, item: BurstItem) -> None:
        """Send one item on the input agent."""
        await self.send(ItemsSequence([item]))

    def set_stalls(self, pace: Pace) -> None:
        """Take results at this pace from now on."""
        self.env.sink.ready.write(pace)

    async def watch(self) -> None:
        """Fail the test where nothing moves any more: a hung core would keep it waiting for ever.

        A burst has a budget of its own instead: what its monitors saw is fetched at its end.
        """
        if not self.on_pins:
            return
        monitors = (self.env.source.monitor, self.env.sink.monitor)
        before = -1
        while (moved := sum(monitor.moved for monitor in monitors)) != before:
            before = moved
            await self.clocks(_PATIENCE_CYCLES)
        raise HungError(f"no beat moved in {_PATIENCE_CYCLES} clocks: the core hangs")

    async def drain(self) -> None:
        """Wait for the last result, without stalls; what is missing then is for the scoreboard."""
        self.set_stalls(FULL_SPEED)
        for _ in range(_DRAIN_STEPS):
            await self.clocks(_DRAIN_CYCLES)
            self.env.flush()
            if self.env.scoreboard.matcher.outstanding == 0:
                break
        await self.clocks(_SURPLUS_CYCLES)
        self.env.flush()
