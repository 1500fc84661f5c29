"""The core that follows its own switching activity, as a function on arrays.

Every signal is looked at twice a clock, so thousands of pairs, not millions.
"""

import ctypes
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from triaxis.bench.activity.traced_build import FOLDER, TracedBuild, traced_library
from triaxis.golden.pairs import Pairs
from triaxis.sim.configuration import Configuration
from triaxis.sim.core_engine import CoreError
from triaxis.sim.paths import DUT, SIM


class TracedCore:
    """The core in one configuration, built on first use."""

    def __init__(self, configuration: Configuration, dut: Path = DUT) -> None:
        """Build the core where needed, and load it. ``dut``: another folder of RTL with the same files."""
        self.configuration = configuration
        build = TracedBuild(
            configuration.name, "triaxis_core", "Vcore", configuration.parameters,
            {
                "WIDTH": configuration.width,
                "MARGIN_BITS": configuration.margin_bits,
                "TAG_BITS": configuration.tag_bits,
            },
            (FOLDER / "core.cpp", SIM / "core_harness.cpp"),
        )  # fmt: skip
        library = ctypes.CDLL(str(traced_library(build, dut)))
        self._trace: Any = library.triaxis_trace
        self._trace.restype = ctypes.c_int64
        pointer = ctypes.c_void_p
        self._trace.argtypes = [pointer, pointer, ctypes.c_int64, pointer, ctypes.c_char_p]

    def run(self, pairs: Pairs, margins: npt.NDArray[np.int64], file: Path) -> npt.NDArray[np.uint16]:
        """Send pairs (N, 2, 3, 3) with margins (N,), one a clock; return the result words (N,).

        What toggled is written to ``file`` as SAIF, at 100 MHz.
        """
        file.parent.mkdir(parents=True, exist_ok=True)
        words = np.ascontiguousarray(pairs, np.int32)
        unsigned = np.ascontiguousarray(margins, np.uint32)
        results = np.zeros(len(pairs), np.uint16)
        clocks = self._trace(
            words.ctypes.data, unsigned.ctypes.data, len(pairs), results.ctypes.data, str(file).encode()
        )
        if clocks < 0:
            raise CoreError(f"core {self.configuration.name}: it hangs, or a tag comes back wrong")
        return results
