"""The bare Verilated core as a function on arrays."""

import ctypes
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from triaxis.golden.errors import ToldError
from triaxis.golden.pairs import VERDICT, Pairs, Verdicts
from triaxis.sim.build import library
from triaxis.sim.configuration import Configuration
from triaxis.sim.paths import DUT
from triaxis.sim.result import decode

_CHUNK = 1 << 16


class CoreError(ToldError, RuntimeError):
    """The core broke its interface: it hangs, or returns tags out of order."""


class RtlEngine:
    """The core in one configuration, built on first use."""

    def __init__(self, configuration: Configuration, dut: Path = DUT, traced: bool = False) -> None:
        """Build the core where needed, and load it. ``dut``: another folder of RTL with the same files.

        ``traced``: a build that follows its own switching activity; see `followed`.
        """
        self.configuration = configuration
        self.library = ctypes.CDLL(str(library(configuration, dut, traced)))
        self._run = self.library.triaxis_run
        self._run.restype = ctypes.c_int64
        self._run.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int64, ctypes.c_void_p]

    def words(
        self, pairs: npt.NDArray[np.integer[Any]], margins: npt.NDArray[np.integer[Any]]
    ) -> tuple[npt.NDArray[np.uint16], int]:
        """Return the result words of pairs (N, 2, 3, 3) at margins (N,), and the clock cycles.

        Coordinates and margins must be in range: see `triaxis.golden.pairs.check_pairs`. Arrays of int32
        and uint32 are taken without a copy.
        """
        pairs = np.ascontiguousarray(pairs, np.int32)
        unsigned = np.ascontiguousarray(margins, np.uint32)
        results = np.zeros(len(pairs), np.uint16)
        cycles = self._run(pairs.ctypes.data, unsigned.ctypes.data, len(pairs), results.ctypes.data)
        if cycles < 0:
            reason = "it hangs" if cycles == -1 else "a tag comes back wrong"
            raise CoreError(f"core {self.configuration.name}: {reason}")
        return results, int(cycles)

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


@contextmanager
def followed(library: ctypes.CDLL, file: Path) -> Iterator[None]:
    """Write what toggles in the model of a traced build while the block runs to a file: SAIF, at 100 MHz."""
    file.parent.mkdir(parents=True, exist_ok=True)
    library.triaxis_trace.restype = None
    library.triaxis_trace(str(file).encode())
    try:
        yield
    finally:
        library.triaxis_trace(b"")


def configuration_for(width: int, margin: int) -> Configuration:
    """Return the core that the command line runs: with margins only where one is asked for.

    Without operand gating, so that the flags are exact for every pair.
    """
    return Configuration(width, width if margin else 0, gating=False)
