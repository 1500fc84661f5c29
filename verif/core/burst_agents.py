"""Drivers and monitors that work on whole bursts, through the bus-functional model of a library.

They take the places of the pin-level ones by factory override (`use_bursts`); agents, sequences and
scoreboard are the same. The model, sim/core_player.cpp, runs hundreds of thousands of clocks a second beside
a simulator that has nothing in it; a pin needs Python at each clock.
"""

import sys
from typing import Any

import numpy as np
import numpy.typing as npt
from cocotb.triggers import Event
from pyuvm import uvm_analysis_port, uvm_factory, uvm_monitor

from triaxis.golden.errors import InputError
from triaxis.golden.pairs import coordinate_range
from triaxis.sim.core_engine import CorePlayer, Progress
from triaxis.sim.player import HANGS
from triaxis.verif.core.items import FULL_SPEED, BurstItem, Pace, PairBatch, ResetSeen, ResultBatch
from triaxis.verif.core.pin_agents import ReadyDriver, SinkMonitor, SourceDriver, SourceMonitor, check_margins
from triaxis.verif.testbench.environment import bfm_of, settings_of
from triaxis.verif.testbench.failures import HungError, report_failure
from triaxis.verif.testbench.fast_model import FastModel

# Runs on and off that are drawn for a pace; the model uses them over and over.
_RUNS = 2048
# How much longer than its paces suggest a burst may take, and what comes on top for its ends.
_BUDGET_FACTOR = 4
_BUDGET_CYCLES = 10_000
_SWITCH_SECONDS = 2e-4

Array = npt.NDArray[Any]


class BurstBfm(FastModel[CorePlayer]):
    """The core's model: it is busy while a burst is under way."""

    def __init__(self) -> None:
        """Nobody is told of anything yet."""
        super().__init__(CorePlayer)
        # The simulator's thread waits so long at most for the interpreter's lock, which checks hold for long.
        sys.setswitchinterval(_SWITCH_SECONDS)
        self.monitors: list[BurstMonitor] = []
        self._over = Event()
        self._bursting = False
        self._accepted = 0
        self._sink_pace = FULL_SPEED

    @property
    def busy(self) -> bool:
        """Return whether a burst is under way."""
        return self._bursting

    def follow(self, progress: Progress) -> None:
        """Have the monitors publish; tell the driver where its burst is over."""
        self._accepted = progress.accepted
        for monitor in self.monitors:
            monitor.flush()
        if self._bursting and not progress.active:
            self._bursting = False
            self._over.set()

    def set_sink_pace(self, pace: Pace, rng: np.random.Generator) -> None:
        """Take results at this pace from the next clock on."""
        self._sink_pace = pace
        self.player.set_pace(pace.runs(rng, _RUNS))

    async def send(
        self, pairs: Array, margins: Array, tags: Array, gaps: Pace, rng: np.random.Generator
    ) -> None:
        """Offer pairs (N, 2, 3, 3) at margins (N,) with tags (N,) until the last is accepted.

        Raises HungError where that takes far longer than the paces of both sides explain.
        """
        count = len(pairs)
        if pairs.shape != (count, 2, 3, 3) or margins.shape != (count,) or tags.shape != (count,):
            raise InputError(
                f"burst: pairs {pairs.shape}, margins {margins.shape}, tags {tags.shape}: must be "
                "(N, 2, 3, 3), (N,), (N,)"
            )
        if not count:
            return
        duty = min(gaps.duty, self._sink_pace.duty)
        budget = int(_BUDGET_FACTOR * count / duty) + _BUDGET_CYCLES
        self.player.start(pairs, margins, tags, gaps.runs(rng, _RUNS), budget)
        self._bursting = True
        self._over.clear()
        self.wake()
        await self._over.wait()
        if self._accepted < count:
            report_failure(HANGS)
            raise HungError(
                f"{self._accepted} of {count} pairs accepted in {budget} clocks, the budget of this burst:"
                " the core hangs"
            )

    def input_beats(self) -> tuple[PairBatch, bool]:
        """Return the pairs that the input monitor saw accepted, up to the next reset, and whether a reset
        began right after the last.
        """
        *arrays, reset = self.player.input_beats()
        return PairBatch(*arrays), reset

    def output_beats(self) -> tuple[ResultBatch, bool]:
        """Return the results that the output monitor saw taken, as `input_beats` does."""
        *arrays, reset = self.player.output_beats()
        return ResultBatch(*arrays), reset


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

    async def drive(self, item: BurstItem, tags: npt.NDArray[np.uint64]) -> None:
        """Offer the pairs until the last is accepted; HungError where that never comes."""
        await self.bfm.send(item.pairs, item.margins, tags, item.gaps, self.rng)


class BurstMonitor(uvm_monitor):
    """Publishes what the model's monitor of one stream saw, whenever the model asks for it."""

    ap: uvm_analysis_port

    def start_of_simulation_phase(self) -> None:
        """Take hold of the model."""
        self.bfm: BurstBfm = bfm_of(self)
        self.bfm.monitors.append(self)

    async def run_phase(self) -> None:
        """Wait to be asked."""

    def fetch(self) -> tuple[PairBatch | ResultBatch, bool]:
        """Return the beats up to the next reset, and whether a reset began right after them."""
        raise NotImplementedError

    def flush(self) -> None:
        """Publish what was seen so far."""
        reset = True
        while reset:
            batch, reset = self.fetch()
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
    for pins, bursts in (
        (SourceDriver, BurstSourceDriver),
        (SourceMonitor, BurstSourceMonitor),
        (SinkMonitor, BurstSinkMonitor),
        (ReadyDriver, BurstReadyDriver),
    ):
        uvm_factory().set_type_override_by_type(pins, bursts)
