"""One run of one test in its own simulator process."""

import contextlib
import dataclasses
import json
import os
import shutil
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from triaxis.golden.errors import InputError
from triaxis.golden.input_file import read_input
from triaxis.golden.outputs import make_folder
from triaxis.sim.configuration import Configuration
from triaxis.sim.models import bare_build, burst_build, mesh_build, mesh_pin_build, pin_build
from triaxis.sim.paths import BUILD, DUT
from triaxis.sim.verilate import Build, verilate
from triaxis.verif.testbench.settings import BURST, PIN, RunSettings, coverage_file, failure_file, result_file

# How often an error line of the log is repeated to the user.
_SHOWN = 5


@dataclass(frozen=True)
class RunResult:
    """What came of a run. Counts are those of the scoreboard; None where it wrote none."""

    settings: RunSettings
    passed: bool
    seconds: float
    counts: dict[str, Any] | None
    errors: tuple[str, ...]
    log: Path
    counterexamples: tuple[str, ...] = ()

    @property
    def coverage(self) -> Path:
        """Return the run's coverage file; it may not exist."""
        return coverage_file(Path(self.settings.folder))

    @property
    def failing_pairs(self) -> Path | None:
        """Return the file of failing pairs, if the scoreboard wrote one."""
        path = failure_file(Path(self.settings.folder))
        return path if path.exists() else None

    def explain(self) -> str:
        """Return what to tell the user about a failed run, several lines."""
        lines = [f"FAILED {self.settings.test}, {self.settings.config}, seed {self.settings.seed}"]
        lines += [f"  {error}" for error in self.errors]
        lines.append(f"  log:    {self.log}")
        if self.failing_pairs:
            lines.append(f"  pairs:  {self.failing_pairs}")
        lines += [f"  {line}" for line in self.counterexamples]
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
) -> RunSettings:
    """Return the settings of a run, in its usual folder unless another is named.

    ``configuration``: also by its name, as those of the mesh engine are given.
    """
    config = configuration if isinstance(configuration, str) else configuration.name
    usual = BUILD / "runs" / f"{test}-{config}-{agent}-{seed}"
    return RunSettings(test, seed, config, pairs, str(folder or usual), replay, agent, judged_one_in, soak)


def _errors(log: Path) -> tuple[str, ...]:
    """Return the first error lines of a log: those of the scoreboard, of assertions, of Python."""
    if not log.exists():
        return ("the simulator wrote no log",)
    found: list[str] = []
    for line in log.read_text(errors="replace").splitlines():
        if "ERROR" in line or "%Error" in line or "CRITICAL" in line or "Error:" in line:
            text = line.strip()
            if text not in found:
                found.append(text)
    return tuple(found[:_SHOWN]) or ("no error line in the log: the simulator ended early",)


def build_of(settings: RunSettings, dut: Path = DUT) -> Build:
    """Return the program that simulates a run."""
    if settings.of_mesh_engine:
        return mesh_pin_build(settings.mesh_configuration, dut) if settings.agent == PIN else bare_build()
    if settings.agent == BURST:
        return burst_build(settings.configuration, dut, with_assertions=not settings.soak)
    return pin_build(settings.configuration, dut)


def build_for(settings: RunSettings, dut: Path = DUT) -> Path:
    """Return the folder of the simulator executable that a run needs, built where needed."""
    if settings.of_mesh_engine and settings.agent != PIN:
        # What the run loads; here so that it counts as a build.
        verilate(mesh_build(settings.mesh_configuration, dut))
    return verilate(build_of(settings, dut))


def run(settings: RunSettings, dut: Path = DUT) -> RunResult:
    """Build where needed, simulate, and say how it went. Never raises for a failing test."""
    from cocotb_tools.runner import get_runner

    folder = Path(settings.folder)
    # The pairs to be replayed may lie in the very folder that is about to be emptied.
    replay = read_input(Path(settings.replay)) if settings.replay else None
    shutil.rmtree(folder, ignore_errors=True)
    if folder.exists():
        raise InputError(f"{folder}: cannot empty this folder: remove it, or make it writable")
    make_folder(folder)
    # After what can be refused at once: a build takes a minute.
    build = build_for(settings, dut)
    if replay is not None:
        kept = folder / "replayed_pairs.npz"
        kept.write_bytes(replay)
        settings = dataclasses.replace(settings, replay=str(kept))
    log, results = folder / "simulation.log", folder / "results.xml"
    runner = get_runner("verilator")
    start = time.monotonic()
    ended_well = False
    # The runner raises, or exits, where the simulator ends badly; the results file tells more of tests.
    with contextlib.suppress(SystemExit, RuntimeError):
        runner.test(
            hdl_toplevel=build_of(settings).top,
            hdl_toplevel_lang="verilog",
            test_module="triaxis.verif.testbench.entry",
            test_filter=f"{settings.test}$",
            seed=settings.seed,
            build_dir=build,
            test_dir=folder,
            results_xml=str(results),
            log_file=log,
            extra_env={
                **settings.to_environment(dut),
                "COCOTB_ANSI_OUTPUT": "0",
                "COCOTB_LOG_LEVEL": os.environ.get("COCOTB_LOG_LEVEL", "WARNING"),
                # A crash must end the process: the solver's loader would fork a debugger, which hangs.
                "CYSIGNALS_CRASH_NDEBUG": "1",
                # For a quick start: no rewriting of assert statements, no threads for linear algebra.
                "COCOTB_REWRITE_ASSERTION_FILES": "",
                "OPENBLAS_NUM_THREADS": "1",
            },
        )
        ended_well = True
    seconds = time.monotonic() - start
    counts = _counts(result_file(folder))
    passed = ended_well and _passed(results) and counts is not None and counts["failed"] == 0
    return RunResult(settings, passed, seconds, counts, () if passed else _errors(log), log)


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
