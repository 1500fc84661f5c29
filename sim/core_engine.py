"""The Verilated core as Python sees it: a bus-functional model of its streams, and a function on arrays."""

import ctypes
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from triaxis.golden.errors import InputError, ToldError
from triaxis.golden.pairs import VERDICT, Pairs, Verdicts
from triaxis.sim.configuration import Configuration
from triaxis.sim.models import core_build, lockstep_build
from triaxis.sim.paths import DUT
from triaxis.sim.player import SYMPTOMS, Player
from triaxis.sim.result import decode
from triaxis.sim.verilate import FAST, MANY, SAIF, library

_CHUNK = 1 << 16
# Clocks that the last results of a burst may take once nothing stalls them: far above any latency.
_DRAIN = 128
# Clocks in a burst at full speed that are not of its pairs: far more than there can be.
_SLACK = 1000

Array = npt.NDArray[Any]
_ALWAYS = np.zeros(0, np.uint16)


class CoreError(ToldError, RuntimeError):
    """A block broke its interface: it hangs, or returns tags out of order."""


class _Burst(ctypes.Structure):
    _fields_ = (
        ("pairs", ctypes.c_void_p),
        ("margins", ctypes.c_void_p),
        ("tags", ctypes.c_void_p),
        ("count", ctypes.c_int64),
        ("runs", ctypes.c_void_p),
        ("num_runs", ctypes.c_int64),
        ("budget", ctypes.c_int64),
    )


class _Progress(ctypes.Structure):
    _fields_ = tuple(
        (name, ctypes.c_int64) for name in ("accepted", "active", "asserted", "clock", "first", "last")
    )


@dataclass(frozen=True)
class Progress:
    """How far a core is: pairs of its burst that were accepted, whether the burst goes on, all clocks so far.

    ``asserted``: an assertion has failed. ``symptom``: what else is wrong, "" where nothing is.
    ``streaming``: clocks from the first pair that was accepted to the last result.
    """

    accepted: int
    active: bool
    asserted: bool
    clock: int
    streaming: int
    symptom: str


class CorePlayer(Player):
    """The core of a library behind a bus-functional model; in reset at first."""

    def watch(self, watched: bool) -> None:
        """Monitor the input stream, or do not: it costs time."""
        self.library.triaxis_watch(self.model, int(watched))

    def set_pace(self, runs: npt.NDArray[np.uint16]) -> None:
        """Take results by a pattern of clocks on and off, alternating, repeated; empty: always."""
        self.library.triaxis_pace(self.model, _address(runs), ctypes.c_int64(len(runs)))

    def set_reset(self, active: bool) -> None:
        """Assert reset, or release it, between two edges."""
        self.library.triaxis_reset(self.model, int(active))

    def start(self, pairs: Array, margins: Array, tags: Array, runs: Array, budget: int) -> None:
        """Begin to offer pairs (N, 2, 3, 3) with margins (N,) and tags (N,).

        ``runs``: clocks on and off, as in `set_pace`. ``budget``: clocks after which it is given up.
        """
        # Held here: C++ keeps pointers to them while the burst is under way.
        self._held = (
            np.ascontiguousarray(pairs, np.int32), np.ascontiguousarray(margins, np.uint32),
            np.ascontiguousarray(tags, np.uint64),
        )  # fmt: skip
        burst = _Burst(
            *(array.ctypes.data for array in self._held), len(pairs), runs.ctypes.data, len(runs), budget
        )
        self.library.triaxis_start(self.model, ctypes.byref(burst))

    def run(self, clocks: int) -> Progress:
        """Run for so many clocks at most: to the end of the burst, or until beats are to be fetched.

        Also until an assertion fails for the first time.
        """
        progress = _Progress()
        symptom = self.library.triaxis_run(self.model, ctypes.c_int64(clocks), ctypes.byref(progress))
        return Progress(
            progress.accepted, bool(progress.active), bool(progress.asserted), progress.clock,
            progress.last - progress.first + 1, SYMPTOMS[symptom],
        )  # fmt: skip

    def input_beats(self) -> tuple[Array, Array, Array, Array, bool]:
        """Return pairs, margins, tags and waits of what was accepted up to the next reset.

        And whether one follows. Waits are the clocks that each was offered before.
        """
        count = self._available("input")
        arrays = (
            np.empty((count, 2, 3, 3), np.int32), np.empty(count, np.uint32), np.empty(count, np.uint64),
            np.empty(count, np.uint16),
        )  # fmt: skip
        return *arrays, self._fetch("input", count, arrays)

    def output_beats(self) -> tuple[Array, Array, Array, Array, bool]:
        """Return words, tags, waits and clocks of the results that were taken, as `input_beats` does.

        Clocks are those of the model before the one at which each was taken.
        """
        count = self._available("output")
        arrays = (
            np.empty(count, np.uint16), np.empty(count, np.uint64), np.empty(count, np.uint16),
            np.empty(count, np.int64),
        )  # fmt: skip
        return *arrays, self._fetch("output", count, arrays)

    def _available(self, side: str) -> int:
        available = getattr(self.library, f"triaxis_{side}_available")
        available.restype = ctypes.c_int64
        return available(self.model)

    def _fetch(self, side: str, count: int, arrays: tuple[Array, ...]) -> bool:
        fetch = getattr(self.library, f"triaxis_{side}_fetch")
        return bool(fetch(self.model, ctypes.c_int64(count), *map(_address, arrays)))


def _address(array: Array) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


class RtlEngine:
    """The core in one configuration as a function on arrays, built on first use."""

    def __init__(
        self, configuration: Configuration, dut: Path = DUT, traced: bool = False, plain: bool = False
    ) -> None:
        """Build the core where needed, and load it. ``dut``: another folder of RTL with the same files.

        ``traced``: a build that follows its own switching activity; see `triaxis.sim.player.followed`.
        ``plain``: one with Verilator's own arithmetic, to compare with.
        """
        self.configuration = configuration
        build = replace(core_build(configuration, dut), plain=plain)
        self._player = CorePlayer(library(replace(build, trace=SAIF, speed=MANY) if traced else build))
        self.library = self._player.library

    def words(
        self, pairs: npt.NDArray[np.signedinteger[Any]], margins: npt.NDArray[np.integer[Any]]
    ) -> tuple[npt.NDArray[np.uint16], int]:
        """Return the result words of pairs (N, 2, 3, 3) at margins (N,), and the clock cycles.

        Coordinates and margins must be in range: see `triaxis.golden.pairs.check_pairs`.
        """
        return streamed(self._player, self.configuration, pairs, margins)

    def verdicts(
        self,
        pairs: Pairs,
        margins: npt.NDArray[np.int64],
        progress: Callable[[int], None] | None = None,
    ) -> Verdicts:
        """Return the core's verdicts; ``progress`` is told how many pairs were done."""
        verdicts = np.zeros(len(pairs), VERDICT)
        for start in range(0, len(pairs), _CHUNK):
            chunk = slice(start, start + _CHUNK)
            verdicts[chunk] = decode(self.words(pairs[chunk], margins[chunk])[0])
            if progress:
                progress(len(verdicts[chunk]))
        return verdicts


class LockstepEngine:
    """Cores of one configuration in lockstep as a function on arrays, built on first use.

    Two to three times as fast as one, and longer in building: for millions of pairs. Only widths whose words
    fit 64 bits: up to 20.
    """

    WIDEST = 20

    def __init__(self, configuration: Configuration, speed: str = FAST) -> None:
        """Build them where needed, and load them. ``speed``: of the code, where little is to be run."""
        if configuration.width > self.WIDEST:
            raise InputError(f"W = {configuration.width}: cores in lockstep have at most {self.WIDEST}")
        self.configuration = configuration
        self._library: Any = ctypes.CDLL(str(library(replace(lockstep_build(configuration), speed=speed))))
        self._library.triaxis_lockstep.restype = ctypes.c_int64

    def words(
        self, pairs: npt.NDArray[np.signedinteger[Any]], margins: npt.NDArray[np.integer[Any]]
    ) -> tuple[npt.NDArray[np.uint16], int]:
        """Return result words and clocks as `RtlEngine.words` does; each core gets a part of them.

        Raises CoreError where a core hangs, returns tags out of order, or is not in step with the others.
        """
        held = np.ascontiguousarray(pairs, np.int32), np.ascontiguousarray(margins, np.uint32)
        words = np.empty(len(pairs), np.uint16)
        count = ctypes.c_int64(len(pairs))
        clocks = self._library.triaxis_lockstep(*map(_address, held), count, _address(words))
        if clocks < 0:
            raise CoreError(f"core {self.configuration.name}: in lockstep: hangs, or wrong tag")
        return words, clocks


def streamed(
    player: CorePlayer, configuration: Configuration, pairs: Array, margins: Array, selected: int = 0
) -> tuple[npt.NDArray[np.uint16], int]:
    """Return the result words of pairs (N, 2, 3, 3) at margins (N,) at full speed from reset, and the clocks.

    ``selected``: the number of the mutant, of a library that holds any.

    Raises CoreError where the core hangs, or returns tags out of order.
    """
    words: list[npt.NDArray[np.uint16]] = []
    player.renew(selected)
    player.watch(False)
    player.run(1)
    player.set_reset(False)
    tag_mask = np.uint64((1 << configuration.tag_bits) - 1)
    clocks = 0
    for start in range(0, len(pairs), _CHUNK):
        some = pairs[start : start + _CHUNK]
        tags = np.arange(start, start + len(some), dtype=np.uint64) & tag_mask
        player.start(some, margins[start : start + _CHUNK], tags, _ALWAYS, len(some) + _SLACK)
        player.run(len(some) + _SLACK)
        at = player.run(_DRAIN)
        came, came_tags, *_ = player.output_beats()
        wrong = at.symptom or ("" if len(came) == len(some) else "hangs")
        if wrong or not np.array_equal(came_tags, tags):
            raise CoreError(f"core {configuration.name}: {wrong or 'wrong tag'}")
        clocks = at.streaming
        words.append(came)
    return np.concatenate([np.zeros(0, np.uint16), *words]), clocks


def configuration_for(width: int, margin: int) -> Configuration:
    """Return the core that the command line runs: with margins only where one is asked for.

    Without operand gating, so that the flags are exact for every pair.
    """
    return Configuration(width, width if margin else 0, gating=False)
