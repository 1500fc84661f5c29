"""One run of one test in its own simulator process."""

import contextlib
import json
import os
import re
import shutil
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from cocotb_tools.runner import get_runner

from triaxis.golden.errors import InputError
from triaxis.golden.input_file import read_input
from triaxis.golden.outputs import make_folder
from triaxis.sim.configuration import Configuration
from triaxis.sim.models import (
    asserted,
    bare_build,
    board_build,
    board_pin_build,
    core_build,
    mesh_build,
    mesh_pin_build,
    pin_build,
)
from triaxis.sim.paths import BUILD, DUT
from triaxis.sim.player import PERIOD_NS
from triaxis.sim.simulators import compiled_for
from triaxis.sim.verilate import VCD, Build, library, verilate
from triaxis.verif.testbench.settings import (
    PIN,
    PROGRAM_VARIABLE,
    VERILATOR,
    Block,
    RunSettings,
    coverage_file,
    failure_file,
    limit_file,
    result_file,
)
from triaxis.verif.testbench.trials import Trials
from triaxis.verif.testbench.waves import DUMP, finished

# So many error lines of the log are repeated to the user, and how one is known.
_SHOWN = 5
_MARK = re.compile(r"\bERROR\b|%Error|CRITICAL|[Ee]rror:")
# What Verilator says of an assertion, after the time in picoseconds.
_TIMED = re.compile(r"\[(\d+)\] (%Error.*)")
_BROKEN = re.compile(r"%Error: .*Assertion failed in \S*?(\w+): (.*)")
# Tests whose scenes are the same on the pins, where only the paces of the streams are drawn otherwise.
SAME_ON_PINS = ("MeshRandomTest", "MeshVolumeTest", "MeshGapsTest")


@dataclass(frozen=True)
class BrokenRule:
    """An assertion that failed: its label, what it says, the clock."""

    name: str
    said: str
    clock: int


@dataclass(frozen=True)
class RunResult:
    """What came of a run. Counts are those of the scoreboard; None where it wrote none. ``rule``: the first
    that was broken.
    """

    settings: RunSettings
    passed: bool
    seconds: float
    counts: dict[str, Any] | None
    errors: tuple[str, ...]
    log: Path
    counterexamples: tuple[str, ...] = ()
    waves: Path | None = None
    rule: BrokenRule | None = None

    @property
    def coverage(self) -> Path:
        """Return the run's coverage file; it may not exist."""
        return coverage_file(Path(self.settings.folder))

    @property
    def failing_pairs(self) -> Path | None:
        """Return the file of failing pairs, if the scoreboard wrote one."""
        path = failure_file(Path(self.settings.folder))
        return path if path.exists() else None

    @property
    def waves_command(self) -> str:
        """Return the command that shows the failure in waves."""
        settings = replace(self.settings, agent=PIN, simulator=VERILATOR, soak=False)
        if self.failing_pairs:
            # Of what failed on the core: those pairs alone, each after those before it.
            settings = replace(settings, replay=str(self.failing_pairs))
        elif settings.test in SAME_ON_PINS and (pairs := self._pairs_before) is not None:
            # The scene goes on to its end: one pair more is enough.
            settings = replace(settings, pairs=pairs + 1)
        return f"{settings.replay_command} --waves"

    @property
    def waves_repeat(self) -> bool:
        """Return whether that run takes the same course, not only sends the same at other clocks."""
        settings = self.settings
        same = settings.block is Block.BOARD or settings.agent == PIN or settings.test in SAME_ON_PINS
        return same and not settings.four_state and not self.failing_pairs

    @property
    def _pairs_before(self) -> int | None:
        """Return how many pairs the mesh engine had accounted for before its first failure, where known."""
        failures = self.counts["failures"] if self.counts else ()
        return min((failure["pairs"] for failure in failures if "pairs" in failure), default=None)

    @property
    def first_clock(self) -> int | None:
        """Return the clock of the first failure, None where none is known."""
        clocks = (failure.get("clock") for failure in (self.counts or {}).get("failures", ()))
        known = [clock for clock in clocks if clock is not None]
        return min([*known, *([self.rule.clock] if self.rule else [])], default=None)

    def explain(self) -> str:
        """Return what to tell the user about a failed run, several lines."""
        lines = [f"FAILED {self.settings.test}, {self.settings.config}, seed {self.settings.seed}"]
        lines += [f"  {error}" for error in self.errors]
        lines.append(f"  log:    {self.log}")
        if self.failing_pairs:
            lines.append(f"  pairs:  {self.failing_pairs}")
        lines += [f"  {line}" for line in self.counterexamples]
        doubt = "" if self.waves_repeat else "  # at other clocks, where it may not fail"
        lines.append(f"  waves:  {self.waves_command}{doubt}")
        lines.append(f"  replay: {self.settings.replay_command}")
        return "\n".join(lines)


def run_settings(
    test: str,
    configuration: Configuration | str,
    seed: int,
    pairs: int,
    replay: str = "",
    folder: Path | None = None,
    agent: str = PIN,
    judged_one_in: int = 1,
    soak: bool = False,
    simulator: str = VERILATOR,
    waves: str = "",
    verbosity: str = "medium",
) -> RunSettings:
    """Return the settings of a run, in its usual folder unless another is named.

    ``configuration``: also by its name, as those of the mesh engine are given.
    """
    config = configuration if isinstance(configuration, str) else configuration.name
    on = agent if simulator == VERILATOR else simulator
    usual = BUILD / "runs" / f"{test}-{config}-{on}-{seed}"
    return RunSettings(
        test,
        seed,
        config,
        pairs,
        str(folder or usual),
        replay,
        agent,
        judged_one_in,
        soak,
        simulator,
        waves,
        verbosity,
    )


def in_clocks(line: str) -> tuple[str, BrokenRule | None]:
    """Return what a line says with the clock, as scoreboards have it, in the place of an assertion's
    picoseconds; and the rule that it says was broken.
    """
    timed = _TIMED.match(line)
    if not timed:
        return line, None
    clock, broken = int(timed[1]) // (1000 * PERIOD_NS), _BROKEN.match(timed[2])
    rule = BrokenRule(broken[1], broken[2], clock) if broken else None
    return f"clock {clock}: {timed[2]}", rule


def errors_in(log: Path) -> tuple[tuple[str, ...], BrokenRule | None]:
    """Return the first error lines of a log, of the scoreboard, of assertions, of Python; and the first rule
    that they say was broken.
    """
    if not log.exists():
        return ("the simulator wrote no log",), None
    found: dict[str, BrokenRule | None] = {}
    with log.open(errors="replace") as lines:
        for line in lines:
            text, rule = in_clocks(line.strip())
            if _MARK.search(text):
                found.setdefault(text, rule)
            if len(found) == _SHOWN:
                break
    none = "no error line in the log: the simulator ended early"
    return tuple(found) or (none,), next(filter(None, found.values()), None)


def _limit_struck(settings: RunSettings) -> str:
    return (
        f"ended after {int(settings.time_limit)} s of the processor, the limit of such a run: the machine is "
        f"too slow, or the run hangs, in {limit_file(Path(settings.folder))}"
    )


def _builds(settings: RunSettings) -> tuple[Callable[[Path], Build], Callable[[Path], Build]]:
    """Return what makes a library and what makes a simulator of the RTL in a folder."""
    match settings.block:
        case Block.BOARD:
            board = settings.board_parameters
            return partial(board_build, board), partial(board_pin_build, board)
        case Block.MESH:
            mesh = settings.mesh_configuration
            return partial(mesh_build, mesh), partial(mesh_pin_build, mesh)
        case _:
            core = settings.configuration
            return partial(core_build, core), partial(pin_build, core)


def model_of(settings: RunSettings, dut: Path = DUT) -> Build | None:
    """Return the library that a run drives; None where it drives pins of the simulator itself."""
    if settings.agent == PIN:
        return None
    build = _builds(settings)[0](dut)
    return build if settings.soak else asserted(build)


def program_of(settings: RunSettings, dut: Path = DUT) -> Build:
    """Return the simulator that a run lives in: empty, where what is under test is a library."""
    if settings.agent != PIN:
        return bare_build()
    build = _builds(settings)[1](dut)
    return replace(build, trace=VCD) if settings.waves else build


def build_for(settings: RunSettings, dut: Path = DUT) -> tuple[Path, Path | None]:
    """Return the folder of the simulator that a run needs, and its library if any, built where needed."""
    model = model_of(settings, dut)
    if settings.simulator != VERILATOR:
        return compiled_for(settings.simulator, program_of(settings, dut)), None
    return verilate(program_of(settings, dut)), library(model) if model else None


def run(settings: RunSettings, dut: Path = DUT, model: Path | None = None) -> RunResult:
    """Build where needed, simulate, and say how it went. Never raises for a failing test.

    ``model``: another library of what is under test than the usual one.
    """
    folder = Path(settings.folder)
    # The pairs to be replayed may lie in the very folder that is about to be emptied.
    replay = read_input(Path(settings.replay)) if settings.replay else None
    shutil.rmtree(folder, ignore_errors=True)
    if folder.exists():
        raise InputError(f"{folder}: cannot empty this folder: remove it, or make it writable")
    make_folder(folder)
    # After what can be refused at once: a build takes a minute.
    program, usual = build_for(settings, dut) if model is None else (verilate(program_of(settings)), model)
    if replay is not None:
        kept = folder / "replayed_pairs.npz"
        kept.write_bytes(replay)
        settings = replace(settings, replay=str(kept))
    start = time.monotonic()
    ended_well = _simulate(settings, program, settings.to_environment(usual), folder)
    seconds = time.monotonic() - start
    counts, log = _counts(result_file(folder)), _log(folder)
    passed = ended_well and _passed(_results(folder)) and counts is not None and counts["failed"] == 0
    errors, rule = ((), None) if passed else errors_in(log)
    if limit_file(folder).exists() and limit_file(folder).stat().st_size:
        errors = (_limit_struck(settings), *errors)
    result = RunResult(settings, passed, seconds, counts, errors, log, rule=rule)
    if not settings.waves:
        return result
    return replace(result, waves=finished(folder, settings, result.first_clock))


def run_trials(trials: Trials) -> None:
    """Let tests that need the same simulator run on models, until each was noticed or all tests have run.

    Raises InputError where one came to no verdict.
    """
    first = trials.tests[0]
    environment = {**first.to_environment(), **trials.write()}
    _simulate(first, verilate(program_of(first)), environment, trials.folder)
    trials.check(_log(trials.folder))


def _log(folder: Path) -> Path:
    return folder / "simulation.log"


def _results(folder: Path) -> Path:
    return folder / "results.xml"


def _simulate(settings: RunSettings, program: Path, environment: dict[str, str], folder: Path) -> bool:
    """Run the simulator; return whether it ended well."""
    # The runner raises, or exits, where the simulator ends badly; the results file tells more of tests.
    with contextlib.suppress(SystemExit, RuntimeError):
        get_runner(settings.simulator).test(
            hdl_toplevel=program_of(settings).top,
            hdl_toplevel_lang="verilog",
            test_module="triaxis.verif.testbench.entry",
            seed=settings.seed,
            build_dir=program,
            test_dir=folder,
            results_xml=str(_results(folder)),
            test_args=["--trace", "--trace-file", DUMP] if settings.waves else [],
            log_file=_log(folder),
            extra_env={
                **environment,
                PROGRAM_VARIABLE: program.name,
                "COCOTB_ANSI_OUTPUT": "0",
                "COCOTB_LOG_LEVEL": os.environ.get(
                    "COCOTB_LOG_LEVEL", "DEBUG" if settings.verbosity == "debug" else "WARNING"
                ),
                # What the environment asserts is never left out.
                "PYTHONOPTIMIZE": "",
                # For a quick start: no rewriting of assert statements, no threads for linear algebra.
                "COCOTB_REWRITE_ASSERTION_FILES": "",
                "OPENBLAS_NUM_THREADS": "1",
            },
        )
        return True
    return False


def _counts(path: Path) -> dict[str, Any] | None:
    """Return the scoreboard's counts, None where it wrote none."""
    try:
        return json.loads(path.read_text())
    except (OSError, ValueError):
        return None


def _passed(results: Path) -> bool:
    """Return whether exactly one test ran, and passed."""
    # Imported here, in the process that runs and not in the one that is run: that one starts for each test.
    from junitparser import JUnitXml, JUnitXmlError

    try:
        cases = [case for suite in JUnitXml.fromfile(str(results)) for case in suite]
    except (OSError, JUnitXmlError, SyntaxError):
        return False
    return len(cases) == 1 and cases[0].is_passed
