"""The core and its wrapper built with coverage counters, and played with stimulus.

Line, branch, expression and toggle counters, one set for each instance. Slower than the bare models by
three orders of magnitude, so thousands of pairs, chosen well, not millions.
"""

import ctypes
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from triaxis.golden.errors import InputError
from triaxis.golden.pairs import Pairs
from triaxis.sim.build import built, content_hash, core_files, rtl_files, run_tool
from triaxis.sim.configuration import Configuration
from triaxis.sim.core_engine import CoreError
from triaxis.sim.packing import COORDINATES
from triaxis.sim.paths import BUILD, DUT, VERIF, mesh_sources, rtl_sources
from triaxis.sim.toolchain import verilator

FOLDER = VERIF / "code_coverage"

# What happens in a clock of a schedule; see core.cpp.
OFFER, TAKE, RESET = 1, 2, 4
# What became of a pair.
DELIVERED, DISCARDED = 1, 2

COUNTERS = (
    "--coverage-line", "--coverage-toggle", "--coverage-expr",
    # Signals of any width: Verilator leaves out those above 256 bits otherwise, and does not say so.
    "--coverage-max-width", "65536",
    # Without it, an instance of a module that is not inlined shares the counters of the first one.
    "--flatten",
)  # fmt: skip
# Older ones count toggles without their direction.
_OLDEST = (5, 48)


@dataclass(frozen=True)
class Model:
    """A module with its parameters, elaborated: what coverage is measured on.

    ``above_core``: it is above the core, on whose files it has no counters.
    """

    name: str
    top: str
    parameters: Mapping[str, int]
    above_core: bool = False


def core_model(configuration: Configuration) -> Model:
    """Return the core in that configuration."""
    return Model(configuration.name, "triaxis_core", configuration.parameters)


def detector_model(width: int) -> Model:
    """Return the combinational wrapper."""
    return Model(f"detector_w{width}", "CollisionDetector", {"W": width})


def _verilate(model: Model, dut: Path) -> list[str]:
    """Return the command that elaborates a model, without what to make of it."""
    return [
        str(verilator().executable), "--top-module", model.top,
        *(f"-G{name}={value}" for name, value in model.parameters.items()), f"-I{dut / 'core'}",
    ]  # fmt: skip


def _sources(model: Model, dut: Path) -> list[Path]:
    core = rtl_sources(dut)
    return [*core, *mesh_sources(dut), FOLDER / "engine.vlt"] if model.above_core else core


def _depends_on(model: Model, dut: Path) -> list[Path]:
    return [*_sources(model, dut), *(rtl_files(dut) if model.above_core else core_files(dut))]


def instrumented_library(
    model: Model, harness: Path, prefix: str, defines: Sequence[str], dut: Path = DUT
) -> Path:
    """Return the shared library of a model with counters and its harness, built where needed."""
    if verilator().version < _OLDEST:
        raise InputError(
            f"code coverage: Verilator {verilator()}: 5.048 or newer is needed; unset VERILATOR to use the "
            "package index's"
        )
    # -Og: little less speed than -O1 for much less compiling.
    make_variables = f"OPT_FAST=-Og OPT_GLOBAL=-Og CXXFLAGS=-I{FOLDER}"
    command = [
        "--cc", *COUNTERS, "--exe", "--build", "-j", "2", "--no-public-flat-rw", "--prefix", prefix,
        "--x-assign", "fast", "--x-initial", "fast", "--output-split", "5000",
        "-CFLAGS", " ".join(["-fPIC -std=c++20", *defines]), "-LDFLAGS", "-shared",
        "-MAKEFLAGS", make_variables,
    ]  # fmt: skip
    sources = [*_sources(model, dut), harness]
    headers = [*sorted(FOLDER.glob("*.h")), *sorted((VERIF / "mutation").glob("*.h"))]
    hashed = [*_depends_on(model, dut), harness, *headers]
    parameters = [f"{name}={value}" for name, value in model.parameters.items()]
    key = content_hash(hashed, str(verilator()), str(dut), *command, *parameters)
    folder = BUILD / "instrumented" / f"{model.name}-{key[:12]}"
    file = f"lib{prefix}.so"

    def make(partial: Path) -> None:
        print(f"building {model.name} with coverage (once) ..", file=sys.stderr, flush=True)
        output = ["--Mdir", str(partial / "obj"), "-o", str(partial / file)]
        run_tool(
            [*_verilate(model, dut), *command, *output, *map(str, sources)],
            partial,
            f"{model.name} with coverage",
        )

    return built(folder, make) / file


def elaborated(model: Model, dut: Path = DUT) -> Path:
    """Return the file in which Verilator describes the elaborated design (JSON)."""
    key = content_hash(_depends_on(model, dut), str(verilator()), str(dut))
    folder = BUILD / "elaborated" / f"{model.name}-{key[:12]}"

    def make(partial: Path) -> None:
        command = ["--json-only", "--prefix", "V", "--Mdir", str(partial)]
        run_tool(
            [*_verilate(model, dut), *command, *map(str, _sources(model, dut))],
            partial,
            f"{model.name}, elaboration",
        )

    return built(folder, make) / "V.tree.json"


@dataclass(frozen=True)
class Stimulus:
    """What a core is played with: pairs (N, 2, 3, 3), margins (N,), tags (N,), padding (N,), steps (K,).

    ``padding`` is what TDATA holds above the coordinates, a byte of which the bits that exist are used.
    ``steps`` are the clocks of a schedule, over and over: sums of OFFER, TAKE and RESET.
    """

    pairs: Pairs
    margins: npt.NDArray[np.int64]
    tags: npt.NDArray[np.int64]
    padding: npt.NDArray[np.uint8]
    steps: npt.NDArray[np.uint8]


@dataclass(frozen=True)
class Played:
    """What became of N pairs: result words (N,), and whether each was delivered or discarded (N,)."""

    words: npt.NDArray[np.uint16]
    states: npt.NDArray[np.uint8]
    clocks: int


def _data_words(stimulus: Stimulus, width: int, size: int) -> npt.NDArray[np.uint8]:
    """Return TDATA for each pair, as bytes (N, size) as the model holds them."""
    count = len(stimulus.pairs)
    flat = stimulus.pairs.reshape(count, COORDINATES)
    bits = ((flat[:, :, None] >> np.arange(width)) & 1).astype(np.uint8).reshape(count, COORDINATES * width)
    unused = -bits.shape[1] % 8
    padding = (stimulus.padding[:, None] >> np.arange(unused, dtype=np.uint8)) & 1
    packed = np.packbits(np.concatenate([bits, padding], 1), axis=1, bitorder="little")
    return np.pad(packed, ((0, 0), (0, size - packed.shape[1])))


class InstrumentedCore:
    """The core in one configuration with coverage counters, built on first use."""

    def __init__(self, configuration: Configuration, dut: Path = DUT) -> None:
        """Build the core where needed, and load it. ``dut``: another folder of RTL with the same files."""
        self.configuration = configuration
        defines = [f"-DMARGIN_BITS={configuration.margin_bits}"]
        model = core_model(configuration)
        library = ctypes.CDLL(str(instrumented_library(model, FOLDER / "core.cpp", "Vcore", defines, dut)))
        library.triaxis_data_bytes.restype = ctypes.c_int64
        self._data_bytes = int(library.triaxis_data_bytes())
        self._cover: Any = library.triaxis_cover
        self._cover.restype = ctypes.c_int64
        pointer, number = ctypes.c_void_p, ctypes.c_int64
        self._cover.argtypes = [pointer, pointer, number, pointer, number, pointer, pointer, ctypes.c_char_p]

    def play(self, stimulus: Stimulus, file: Path) -> Played:
        """Play the stimulus from reset; write the coverage to ``file``."""
        count = len(stimulus.pairs)
        data = np.ascontiguousarray(_data_words(stimulus, self.configuration.width, self._data_bytes))
        user = (stimulus.tags << self.configuration.margin_bits) | stimulus.margins
        user = np.ascontiguousarray(user, np.uint64)
        steps = np.ascontiguousarray(stimulus.steps, np.uint8)
        words, states = np.zeros(count, np.uint16), np.zeros(count, np.uint8)
        clocks = self._cover(
            data.ctypes.data, user.ctypes.data, count, steps.ctypes.data, len(steps),
            words.ctypes.data, states.ctypes.data, str(file).encode(),
        )  # fmt: skip
        if clocks < 0:
            reason = "it hangs" if clocks == -1 else "a result is unexpected or has a wrong tag"
            raise CoreError(f"core {self.configuration.name}: {reason}")
        return Played(words, states, int(clocks))


class InstrumentedDetector:
    """The combinational wrapper with coverage counters, built on first use."""

    def __init__(self, width: int, dut: Path = DUT) -> None:
        """Build the wrapper where needed, and load it."""
        self._width = width
        model = detector_model(width)
        library = ctypes.CDLL(str(instrumented_library(model, FOLDER / "detector.cpp", "Vdetector", [], dut)))
        self._cover: Any = library.triaxis_cover_detector
        self._cover.restype = None
        self._cover.argtypes = [ctypes.c_void_p, ctypes.c_int64, ctypes.c_void_p, ctypes.c_char_p]

    def play(self, pairs: Pairs, normals: npt.NDArray[np.int64], file: Path) -> npt.NDArray[np.bool_]:
        """Return CollisionOccurs for pairs (N, 2, 3, 3) with given normals (N, 2, 3); write the coverage."""
        count, mask = len(pairs), (1 << self._width) - 1
        inputs = np.concatenate([pairs.reshape(count, COORDINATES), normals.reshape(count, 6)], 1) & mask
        inputs = np.ascontiguousarray(inputs, np.int64)
        collides = np.zeros(count, np.uint8)
        self._cover(inputs.ctypes.data, count, collides.ctypes.data, str(file).encode())
        return collides.astype(np.bool_)
