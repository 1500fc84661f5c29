"""What one simulation run is asked to do, handed from the runner to the simulator process."""

import json
import os
from dataclasses import asdict, dataclass
from enum import StrEnum
from pathlib import Path
from shlex import quote

from triaxis.sim.board_parameters import (
    BoardParameters,
    is_board_configuration,
    parse_board_configuration,
)
from triaxis.sim.configuration import Configuration, parse_configuration
from triaxis.sim.mesh_configuration import (
    MeshConfiguration,
    is_mesh_configuration,
    parse_mesh_configuration,
)
from triaxis.verif.testbench.golden_sample import Share

_VARIABLE = "TRIAXIS_RUN"
_LIBRARY_VARIABLE = "TRIAXIS_LIBRARY"
PROGRAM_VARIABLE = "TRIAXIS_PROGRAM"
PIN, BURST = "pin", "burst"
# Repeats pairs that failed elsewhere: the one test that no plan runs.
REPLAY = "ReplayTest"
VERILATOR = "verilator"
VERBOSITIES = ("none", "low", "medium", "high", "full", "debug")
# Where the tests stand; the simulator's process loads them by name, which no import shows.
CORE_TESTS = ("triaxis.verif.core.uvm_tests", "triaxis.verif.core.solid_tests")
MESH_TESTS = ("triaxis.verif.mesh.uvm_tests", "triaxis.verif.mesh.solid_tests")
ENTRY = "triaxis.verif.testbench.entry"
BOARD_TESTS = (
    "triaxis.verif.board.go_tests",
    "triaxis.verif.board.line_tests",
    "triaxis.verif.board.run_tests",
    "triaxis.verif.board.reset_tests",
)
TEST_MODULES = (ENTRY, *CORE_TESTS, *MESH_TESTS, *BOARD_TESTS)
# What tests read: counterexamples that were kept, and clocks.
TEST_DATA = ("verif/core/kept/*.json", "verif/mesh/*.json")


def width_of(config: str) -> int:
    """Return the coordinate bits of a configuration of the core, the mesh engine or the board."""
    if is_board_configuration(config):
        return parse_board_configuration(config).width
    parse = parse_mesh_configuration if is_mesh_configuration(config) else parse_configuration
    return parse(config).width


class Block(StrEnum):
    """What is under test."""

    CORE = "core"
    MESH = "mesh engine"
    BOARD = "board"


def block_of(config: str) -> Block:
    """Return what a configuration's name says is under test."""
    if is_board_configuration(config):
        return Block.BOARD
    return Block.MESH if is_mesh_configuration(config) else Block.CORE


@dataclass(frozen=True)
class RunSettings:
    """One run: a test by name, its seed, the build, how many pairs, where results go.

    ``agent``: "pin" or "burst". ``judged_one_in``: the share of pairs that the golden model judges
    beside the bulk checker; 1: all. ``soak``: no assertions, coverage samples a part of
    the batches, and the golden model takes new kinds of situations one a batch. ``simulator``: of the
    pins, Verilator or one of sim/simulators.py; a library is always Verilator's. ``waves``: "vcd" or "fst", a
    file of all values; "": none. ``verbosity``: of reports, in UVM's terms.
    """

    test: str
    seed: int
    config: str
    pairs: int
    folder: str
    replay: str = ""
    agent: str = PIN
    judged_one_in: int = 1
    soak: bool = False
    simulator: str = VERILATOR
    waves: str = ""
    verbosity: str = "medium"

    @property
    def four_state(self) -> bool:
        """Return whether the simulator knows of values that are unknown."""
        return self.simulator != VERILATOR

    @property
    def time_limit(self) -> float:
        """Return the seconds of the processor after which the run is ended: many times what it should take.

        Pin by pin, and where the golden model judges all, a pair takes up to a millisecond. Of the board in
        four states half a million clocks take ten minutes.
        """
        if self.block is Block.BOARD:
            return (7200 if self.four_state else 600) + self.pairs
        slow = self.agent == PIN or self.judged_one_in == 1
        return 300 + self.pairs * (1.0 if self.four_state else 1e-2 if slow else 2e-4)

    @property
    def share(self) -> Share:
        """Return what the golden model judges."""
        return Share(self.judged_one_in, 1) if self.soak else Share(self.judged_one_in)

    @property
    def configuration(self) -> Configuration:
        """Return the parameters of the core under test."""
        return parse_configuration(self.config)

    @property
    def block(self) -> Block:
        """Return what is under test; ``pairs`` are those of scenes, or replies of the board."""
        return block_of(self.config)

    @property
    def width(self) -> int:
        """Return the coordinate bits of what is under test."""
        return width_of(self.config)

    @property
    def mesh_configuration(self) -> MeshConfiguration:
        """Return the parameters of the mesh engine under test."""
        return parse_mesh_configuration(self.config)

    @property
    def board_parameters(self) -> BoardParameters:
        """Return the parameters of the board under test."""
        return parse_board_configuration(self.config)

    @property
    def replay_command(self) -> str:
        """Return the command that repeats exactly this run."""
        pins = self.agent == PIN and self.block is not Block.BOARD
        options = "" if pins else f" --agent {self.agent}"
        options += "" if self.judged_one_in == 1 else f" --judged {self.judged_one_in}"
        options += " --soak" if self.soak else ""
        options += f" --simulator {self.simulator}" if self.four_state else ""
        # What a run of any test has kept is sent again by one alone.
        test = REPLAY if self.replay else self.test
        what = f"--replay {quote(self.replay)}" if self.replay else f"--pairs {self.pairs}"
        return f".venv/bin/triaxis sim {test} --seed {self.seed} --config {self.config} {what}{options}"

    def to_environment(self, library: Path | None = None) -> dict[str, str]:
        """Return the environment variables that carry these settings, and what library is under test."""
        return {_VARIABLE: json.dumps(asdict(self)), _LIBRARY_VARIABLE: str(library or "")}


def from_environment() -> RunSettings:
    """Return the settings that the runner put into the environment."""
    return RunSettings(**json.loads(os.environ[_VARIABLE]))


def put_into_environment(settings: RunSettings) -> None:
    """Put other settings into the environment of this process."""
    os.environ |= {_VARIABLE: json.dumps(asdict(settings))}


def library_from_environment() -> str:
    """Return the library of what is under test, "" where that is driven on its pins."""
    return os.environ[_LIBRARY_VARIABLE]


def program_from_environment() -> str:
    """Return the name of the build of the simulator."""
    return os.environ.get(PROGRAM_VARIABLE, "")


def result_file(folder: Path) -> Path:
    """Return the file into which the scoreboard writes its counts."""
    return folder / "scoreboard.json"


def counters_file(folder: Path) -> Path:
    """Return the file into which a build with counters of code coverage writes them."""
    return folder / "counters.dat"


def coverage_file(folder: Path) -> Path:
    """Return the file into which the coverage subscriber writes its counts."""
    return folder / "coverage.json"


def limit_file(folder: Path) -> Path:
    """Return the file that says where a run was when its `time_limit` struck; else it is empty."""
    return folder / "limit.txt"


def failure_file(folder: Path) -> Path:
    """Return the file into which the scoreboard writes failing pairs."""
    return folder / "failing_pairs.npz"
