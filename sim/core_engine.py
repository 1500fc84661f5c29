"""The Verilated core as Python sees it: plays of any traffic, and a function on arrays."""

import ctypes
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from triaxis.golden.errors import ToldError
from triaxis.golden.pairs import VERDICT, Pairs, Verdicts
from triaxis.sim.configuration import Configuration
from triaxis.sim.models import core_build
from triaxis.sim.packing import data_words, user_words
from triaxis.sim.paths import DUT
from triaxis.sim.player import SYMPTOMS, Player
from triaxis.sim.result import decode
from triaxis.sim.verilate import MANY, library

_CHUNK = 1 << 16

# What happens in a clock of a schedule, of which each step is a sum; see core_player.cpp.
OFFER, TAKE, RESET = 1, 2, 4
# What became of a pair.
DELIVERED, DISCARDED = 1, 2

Steps = npt.NDArray[np.uint8]
_FLOWING = np.array([OFFER | TAKE], np.uint8)


class CoreError(ToldError, RuntimeError):
    """A block broke its interface: it hangs, or returns tags out of order."""


class _Traffic(ctypes.Structure):
    _fields_ = (
        ("data", ctypes.c_void_p),
        ("user", ctypes.c_void_p),
        ("count", ctypes.c_int64),
        ("steps", ctypes.c_void_p),
        ("num_steps", ctypes.c_int64),
        ("expected", ctypes.c_void_p),
        ("latency", ctypes.c_int64),
        ("words", ctypes.c_void_p),
        ("states", ctypes.c_void_p),
    )


class _Counts(ctypes.Structure):
    _fields_ = (("checked", ctypes.c_int64), ("clocks", ctypes.c_int64))


@dataclass(frozen=True)
class Sent:
    """What a core is sent: words of TDATA (N, S) and TUSER (N,), by steps (K,), one a clock, repeated."""

    data: npt.NDArray[np.uint8]
    user: npt.NDArray[np.uint64]
    steps: Steps


@dataclass(frozen=True)
class Played:
    """What came of N pairs: result words (N,), whether each was delivered or discarded (N,), what was wrong.

    ``checked``: how many results came back right before; ``clocks``: from the first accepted pair to the last
    result.
    """

    words: npt.NDArray[np.uint16]
    states: npt.NDArray[np.uint8]
    symptom: str
    checked: int
    clocks: int


def core_words(
    pairs: npt.NDArray[np.signedinteger[Any]],
    margins: npt.NDArray[np.integer[Any]],
    tags: npt.NDArray[np.integer[Any]],
    configuration: Configuration,
    steps: Steps = _FLOWING,
    padding: npt.NDArray[np.uint8] | None = None,
) -> Sent:
    """Return pairs (N, 2, 3, 3) with margins, tags and padding (N,) as they are sent; see `data_words`."""
    data = data_words(pairs, configuration.width, padding)
    return Sent(data, user_words(margins, tags, configuration), np.ascontiguousarray(steps, np.uint8))


class CorePlayer(Player):
    """The core of a library."""

    def play(self, sent: Sent, expected: npt.NDArray[np.uint16] | None = None, latency: int = -1) -> Played:
        """Play from reset; end at the first thing that is wrong.

        ``expected`` (N,), ``latency`` in clocks: what must come back. Without, the core is trusted with the
        rules of its streams, and only tags are checked.
        """
        count = len(sent.user)
        words, states = np.zeros(count, np.uint16), np.zeros(count, np.uint8)
        traffic = _Traffic(
            sent.data.ctypes.data, sent.user.ctypes.data, count, sent.steps.ctypes.data, len(sent.steps),
            None if expected is None else expected.ctypes.data, latency, words.ctypes.data,
            states.ctypes.data,
        )  # fmt: skip
        counts = _Counts()
        play = self.library.triaxis_play
        play.argtypes = [ctypes.c_void_p] * 3
        symptom = play(self.model, ctypes.byref(traffic), ctypes.byref(counts))
        return Played(words, states, SYMPTOMS[symptom], counts.checked, counts.clocks)


class RtlEngine:
    """The core in one configuration as a function on arrays, built on first use."""

    def __init__(self, configuration: Configuration, dut: Path = DUT, traced: bool = False) -> None:
        """Build the core where needed, and load it. ``dut``: another folder of RTL with the same files.

        ``traced``: a build that follows its own switching activity; see `triaxis.sim.player.followed`.
        """
        self.configuration = configuration
        build = core_build(configuration, dut)
        self._player = CorePlayer(library(replace(build, traced=True, speed=MANY) if traced else build))
        self.library = self._player.library

    def words(
        self, pairs: npt.NDArray[np.signedinteger[Any]], margins: npt.NDArray[np.integer[Any]]
    ) -> tuple[npt.NDArray[np.uint16], int]:
        """Return the result words of pairs (N, 2, 3, 3) at margins (N,), and the clock cycles.

        Coordinates and margins must be in range: see `triaxis.golden.pairs.check_pairs`.
        """
        tags = np.arange(len(pairs)) & ((1 << self.configuration.tag_bits) - 1)
        if not self.configuration.margin_bits:
            margins = np.zeros(len(pairs), np.uint32)
        self._player.renew()
        played = self._player.play(core_words(pairs, margins, tags, self.configuration))
        if played.symptom:
            raise CoreError(f"core {self.configuration.name}: {played.symptom}")
        return played.words, played.clocks

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


def configuration_for(width: int, margin: int) -> Configuration:
    """Return the core that the command line runs: with margins only where one is asked for.

    Without operand gating, so that the flags are exact for every pair.
    """
    return Configuration(width, width if margin else 0, gating=False)
