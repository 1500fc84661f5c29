"""The pin tests in a simulator of four states: nothing unknown may reach an output that counts.

Registers without a reset, memories that nothing wrote, and inputs that offer nothing are unknown there; in
Verilator's two states they are numbers, and what reads them too early goes unseen.
"""

import json
import os
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from triaxis.golden.processes import threads
from triaxis.sim.evidence import write_evidence
from triaxis.sim.paths import BUILD, DUT
from triaxis.sim.programs import yosys_version
from triaxis.sim.simulators import ICARUS, icarus_version
from triaxis.sim.validity import Sources, Validity, standing
from triaxis.verif.regress.one_job import unsent
from triaxis.verif.testbench.settings import PIN, TEST_DATA, TEST_MODULES, Block, RunSettings
from triaxis.verif.testbench.simulation import RunResult, build_for, run, run_settings
from triaxis.verif.testbench.table import table
from triaxis.verif.testbench.unknown_values import unknown_file

FOLDER = BUILD / "four_state"
RESULT = FOLDER / "four_state.json"
SOURCES = Sources(("triaxis.verif.regress.four_state", *TEST_MODULES), TEST_DATA)

# Beside the runs of the table: all kinds of pairs in some volume.
_LONG, _LONG_CONFIG, _LONG_PAIRS = "MixedTest", "w16_m0", 10_000
# The board, whose table is of bursts alone: a small one, and few replies.
_BOARD, _BOARD_REPLIES = "board_w8_m0_d16_g4_l2", {"BoardSmokeTest": 20, "BoardResetsTest": 20}
_JOBS = min(2, os.cpu_count() or 1)


def plan(seed: int) -> list[RunSettings]:
    """Return every run of the table on the pins, in each of its configurations; a longer one; the board's."""
    wanted = [(_LONG, _LONG_CONFIG, _LONG_PAIRS)] + [
        (entry.name, config, runs.pairs)
        for entry in table().values()
        for runs in entry.runs
        if runs.agent == PIN and runs.signoff
        for config in runs.configs
    ]
    # The longest of a test and a configuration comes first, and is enough.
    longest = {(test, config): pairs for test, config, pairs in sorted(wanted, key=lambda one: one[2])}
    # Those of the board take longest of all.
    chosen = [((test, _BOARD), replies) for test, replies in _BOARD_REPLIES.items()]
    chosen += sorted(longest.items(), key=lambda one: -one[1])
    return [
        run_settings(test, config, seed, pairs, folder=FOLDER / f"{test}-{config}", simulator=ICARUS)
        for (test, config), pairs in chosen
    ]


@dataclass(frozen=True)
class FourStateResult:
    """What came of the runs, and what of the RTL and the environment they are valid for."""

    runs: tuple[RunResult, ...]
    valid_for: Validity
    changed: bool
    seconds: float

    @property
    def looked(self) -> int:
        """Return how many values of outputs were looked at."""
        return sum(_unknown(run)["looked"] or 0 for run in self.runs)

    @property
    def unknown(self) -> int:
        """Return how many of them were unknown."""
        return sum(_unknown(run)["unknown"] or 0 for run in self.runs)

    @property
    def without_counts(self) -> int:
        """Return how many runs ended before they counted anything."""
        return sum(run.counts is None for run in self.runs)

    def checked(self, block: Block, what: str = "checked") -> int:
        """Return how many pairs of the core, or of scenes, or replies of the board were checked.

        ``what``: another count of the scoreboard, such as the board's clocks.
        """
        return sum(run.counts[what] for run in self.runs if run.counts and run.settings.block is block)

    @property
    def wrong(self) -> int:
        """Return how many answers were wrong."""
        return sum(run.counts["failed"] for run in self.runs if run.counts)

    @property
    def problems(self) -> list[str]:
        """Return what failed, a line each."""
        found = [
            f"{ran.settings.test} in {ran.settings.config} failed: {ran.errors[0]}: "
            f"{ran.settings.replay_command}"
            for ran in self.runs
            if not ran.passed
        ]
        found += [
            f"{ran.settings.test} in {ran.settings.config}: {told}"
            for ran in self.runs
            if ran.passed and (told := unsent(ran))
        ]
        found += [
            f"{ran.settings.test} in {ran.settings.config}: no output was looked at"
            for ran in self.runs
            if ran.passed and not _unknown(ran)["looked"]
        ]
        found += [] if self.runs else ["nothing was run"]
        return found + (["the RTL or its environment changed meanwhile"] if self.changed else [])

    @property
    def summary(self) -> str:
        """Return the result in a line."""
        return (
            f"{self.checked(Block.CORE):,} pairs of the core and {self.checked(Block.MESH):,} of scenes, "
            f"{self.checked(Block.BOARD):,} replies of the board in {self.checked(Block.BOARD, 'clocks'):,} "
            f"clocks, {self.wrong} wrong; "
            f"{self.unknown} of {self.looked:,} values of outputs unknown"
            + (f"; {self.without_counts} of {len(self.runs)} runs ended early" if self.without_counts else "")
        )


def _unknown(result: RunResult) -> dict[str, int | None]:
    try:
        return json.loads(unknown_file(Path(result.settings.folder)).read_text(encoding="utf-8"))
    except FileNotFoundError:
        return {"looked": None, "unknown": None}


def run_four_state(
    seed: int, progress: Callable[[int], None], runs: Sequence[RunSettings] | None = None, dut: Path = DUT
) -> FourStateResult:
    """Run the plan, or other runs, on Icarus Verilog; ``progress`` is told of each run done.

    Raises InputError where that is not installed.
    """
    start, before = time.monotonic(), standing(SOURCES, dut)
    chosen = plan(seed) if runs is None else runs

    def one(settings: RunSettings) -> RunResult:
        result = run(settings, dut)
        progress(1)
        return result

    # One of each first: what is not installed, or does not compile, is one error.
    for settings in {settings.config: settings for settings in chosen}.values():
        build_for(settings, dut)
    with threads(_JOBS) as pool:
        results = tuple(pool.map(one, chosen))
    return FourStateResult(results, before.valid_for, not before.stands, time.monotonic() - start)


def write_result(result: FourStateResult, command: str, path: Path = RESULT) -> Path:
    """Write the result."""
    content: dict[str, Any] = {
        "passed": not result.problems,
        "problems": result.problems,
        "summary": result.summary,
        "command": command,
        "seconds": round(result.seconds, 1),
        "rtl_hash": result.valid_for.rtl_hash,
        "environment_hash": result.valid_for.environment_hash,
        "simulator": icarus_version(),
        "elaborated_by": yosys_version(),
        "runs_without_counts": result.without_counts,
        "pairs": result.checked(Block.CORE),
        "pairs_of_scenes": result.checked(Block.MESH),
        "replies": result.checked(Block.BOARD),
        "board_clocks": result.checked(Block.BOARD, "clocks"),
        "wrong": result.wrong,
        "looked": result.looked,
        "unknown": result.unknown,
        "runs": [
            {
                "test": run.settings.test,
                "config": run.settings.config,
                "seed": run.settings.seed,
                "passed": run.passed,
                "seconds": round(run.seconds, 1),
                "replay": run.settings.replay_command,
                **_unknown(run),
            }
            for run in result.runs
        ],
    }
    return write_evidence(path, content, SOURCES)
