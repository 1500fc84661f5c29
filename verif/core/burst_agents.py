"""Drivers and monitors that work on whole bursts, through a bus-functional model in the simulator.

They take the places of the pin-level ones by factory override (`use_bursts`); agents, sequences and
scoreboard are the same. The model's C++ part, verif/core/burst/burst_bfm.cpp, lives in the simulator
executable, which is this process.
"""

import ctypes
from typing import Any

import numpy as np
import numpy.typing as npt
from cocotb.triggers import ValueChange
from pyuvm import uvm_analysis_port, uvm_factory, uvm_monitor

from triaxis.golden.errors import InputError
from triaxis.golden.pairs import coordinate_range
from triaxis.verif.core.items import FULL_SPEED, BurstItem, Pace, PairBatch, ResetSeen, ResultBatch
from triaxis.verif.core.pin_agents import ReadyDriver, SinkMonitor, SourceDriver, SourceMonitor, check_margins
from triaxis.verif.testbench.environment import bfm_of, settings_of
from triaxis.verif.testbench.failures import HungError

# Runs on and off that are drawn for a pace; the model uses them over and over.
_RUNS = 2048
# How much longer than its paces suggest a burst may take, and what comes on top for its ends.
_BUDGET_FACTOR = 4
_BUDGET_CYCLES = 10_000

Array = npt.NDArray[Any]


def _address(array: Array) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


class BurstBfm:
    """The one that knows the C functions; drivers and monitors know only this."""

    def __init__(self, dut: Any) -> None:
        """Find the functions in this process; ``dut`` is the top level, triaxis_burst_tb."""
        self.wake = ValueChange(dut.wake_i)
        self._library = ctypes.CDLL(None)
        for name in ("burst_accepted", "input_available", "output_available"):
            getattr(self._library, f"triaxis_{name}").restype = ctypes.c_int64
        self._sink_pace = FULL_SPEED

    def set_sink_pace(self, pace: Pace, rng: np.random.Generator) -> None:
        """Take results at this pace from the next clock on."""
        runs = pace.runs(rng, _RUNS)
        self._sink_pace = pace
        self._library.triaxis_sink_pace(_address(runs), ctypes.c_int64(len(runs)))

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
        # Held here: C++ keeps pointers to them while the burst is under way.
        held = (
            np.ascontiguousarray(pairs, np.int32),
            np.ascontiguousarray(margins, np.uint32),
            np.ascontiguousarray(tags, np.uint32),
        )
        runs = gaps.runs(rng, _RUNS)
        duty = min(gaps.duty, self._sink_pace.duty)
        budget = int(_BUDGET_FACTOR * count / duty) + _BUDGET_CYCLES
        self._library.triaxis_burst_start(
            *map(_address, held),
            ctypes.c_int64(count),
            _address(runs),
            ctypes.c_int64(len(runs)),
            ctypes.c_int64(budget),
        )
        while self._library.triaxis_burst_active():
            await self.wake
        accepted = self._library.triaxis_burst_accepted()
        if accepted < count:
            raise HungError(
                f"{accepted} of {count} pairs accepted in {budget} clocks, the budget of this burst:"
                " the core hangs"
            )

    def input_beats(self) -> tuple[PairBatch, bool]:
        """Return the pairs that the input monitor saw accepted, up to the next reset, and whether a reset
        began right after the last.
        """
        count = self._library.triaxis_input_available()
        pairs = np.empty((count, 2, 3, 3), np.int32)
        margins, tags = np.empty(count, np.uint32), np.empty(count, np.uint32)
        waits = np.empty(count, np.uint16)
        reset = self._library.triaxis_input_fetch(
            ctypes.c_int64(count), *map(_address, (pairs, margins, tags, waits))
        )
        return PairBatch(pairs, margins, tags, waits), bool(reset)

    def output_beats(self) -> tuple[ResultBatch, bool]:
        """Return the results that the output monitor saw taken, as `input_beats` does."""
        count = self._library.triaxis_output_available()
        words, tags = np.empty(count, np.uint16), np.empty(count, np.uint32)
        waits = np.empty(count, np.uint16)
        reset = self._library.triaxis_output_fetch(
            ctypes.c_int64(count), *map(_address, (words, tags, waits))
        )
        return ResultBatch(words, tags, waits), bool(reset)


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
        """Offer the pairs until the last is accepted; HungError where that never comes."""
        await self.bfm.send(item.pairs, item.margins, tags, item.gaps, self.rng)


class BurstMonitor(uvm_monitor):
    """Publishes what the model's monitor of one stream saw, whenever the model asks for it."""

    ap: uvm_analysis_port
    moved: int

    def start_of_simulation_phase(self) -> None:
        """Take hold of the model."""
        self.bfm: BurstBfm = bfm_of(self)

    async def run_phase(self) -> None:
        """Fetch when woken."""
        while True:
            await self.bfm.wake
            self.flush()

    def fetch(self) -> tuple[PairBatch | ResultBatch, bool]:
        """Return the beats up to the next reset, and whether a reset began right after them."""
        raise NotImplementedError

    def flush(self) -> None:
        """Publish what was seen so far."""
        reset = True
        while reset:
            batch, reset = self.fetch()
            self.moved += len(batch)
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
