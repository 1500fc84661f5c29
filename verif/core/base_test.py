"""What all tests of the core share: its environment, and the end of the test."""

import numpy as np
from pyuvm import uvm_sequence

from triaxis.coverage.core_coverage import CoreCoverage
from triaxis.golden.bulk import bulk_facts
from triaxis.verif.core.burst_agents import BurstBfm, use_bursts
from triaxis.verif.core.checking import Checker
from triaxis.verif.core.env import CoreEnv
from triaxis.verif.core.expectation import expected_words
from triaxis.verif.core.items import FULL_SPEED, BurstItem, Pace, PairBatch, ResultBatch
from triaxis.verif.core.stimulus.families import FAMILIES, mixed
from triaxis.verif.testbench.environment import EnvironmentTest, ItemsSequence, create
from triaxis.verif.testbench.trials import in_trials

# Clocks in which a result too many would show: more than any latency.
_SURPLUS_CYCLES = 64
# Clocks that the last results may take once nothing stalls them, in steps: far above latency and queue.
_DRAIN_STEPS, _DRAIN_CYCLES = 50, 40


class CoreTest(EnvironmentTest):
    """Resets the core, runs `stimulus`, waits for the last result."""

    outputs = {  # noqa: RUF012 (never changed)
        "s_axis_tready_o": None,
        "m_axis_tvalid_o": None,
        "m_axis_tdata_o": "m_axis_tvalid_o",
        "m_axis_tuser_o": "m_axis_tvalid_o",
    }

    def build_phase(self) -> None:
        """Make the environment."""
        super().build_phase()
        self.env = create(CoreEnv, "env", self)
        if in_trials():
            self._warm_up()

    def _warm_up(self) -> None:
        """Load, compile and compute what is made once in a process: each trial is a process of its own."""
        configuration = self.settings.configuration
        made = mixed(np.random.default_rng(1), len(FAMILIES), configuration.width, configuration.max_margin)
        words = expected_words(bulk_facts(made.pairs, made.margins), configuration)
        tags, waits = np.zeros(len(made), np.uint64), np.zeros(len(made), np.uint16)
        checker = Checker(configuration, on_checked=CoreCoverage(configuration).sample)
        checker.check(
            PairBatch(made.pairs, made.margins, tags, waits),
            ResultBatch(words, tags, waits, np.arange(len(made))),
        )
        assert not checker.failed, checker.failures[0].message

    def fast_model(self) -> BurstBfm:
        """Return the burst model."""
        use_bursts()
        return BurstBfm()

    async def traffic(self) -> None:
        """Run `stimulus`; wait for the last result."""
        await self.stimulus()
        await self.drain()
        scoreboard = self.env.scoreboard
        scoreboard.sent, scoreboard.resets_sent = self.env.source.driver.next_tag, self.resets

    async def send(self, sequence: uvm_sequence) -> None:
        """Run a sequence on the input agent."""
        await sequence.start(self.env.source.sequencer)

    async def send_item(self, item: BurstItem) -> None:
        """Send one item on the input agent."""
        await self.send(ItemsSequence([item]))

    def set_stalls(self, pace: Pace) -> None:
        """Take results at this pace from now on."""
        self.env.sink.ready.write(pace)

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
