"""Has dvsim do some runs: writes its configuration, starts it, waits for it, ends it."""

import contextlib
import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from triaxis.golden.errors import InputError
from triaxis.golden.outputs import write_whole
from triaxis.sim.paths import ROOT
from triaxis.sim.validity import git
from triaxis.verif.regress.definition import Definition
from triaxis.verif.regress.launchers import Launcher
from triaxis.verif.regress.records import PlannedRun

_DVSIM = Path(sys.executable).with_name("dvsim")
_POLL_SECONDS = 0.25
_COLOUR = re.compile(r"\x1b\[[\d;]*m")
# What dvsim takes to end its jobs when asked to.
_PATIENCE_SECONDS = 15.0


@dataclass(frozen=True)
class Pass:
    """One call of dvsim. ``folder``: of the regression; ``name``: tells its passes apart."""

    definition: Definition
    launcher: Launcher
    folder: Path
    failing: Path
    testplan: Path
    identity: str
    name: str

    @property
    def scratch(self) -> Path:
        """Return dvsim's own folder: its logs and reports."""
        return self.folder / "dvsim" / self.name

    @property
    def log(self) -> Path:
        """Return the file of what dvsim says."""
        return self.folder / f"dvsim-{self.name}.log"

    def run_log(self, run: PlannedRun) -> Path:
        """Return the file of what the process of a run said; it need not exist."""
        found = sorted(self.scratch.glob(f"**/{run.item}*.{run.seed}/latest/run.log"))
        return found[0] if found else self.scratch / "run.log"


def check_dvsim() -> None:
    """Raise InputError where dvsim is not installed, or will not start here."""
    if not _DVSIM.exists():
        raise InputError("dvsim: not in this Python environment: run `make regress`, which installs it")
    if git("rev-parse", "HEAD") is None:
        raise InputError(f"{ROOT}: no git checkout: dvsim asks for the commit; clone the repository")


@dataclass(frozen=True)
class _Test:
    """A test of the configuration that is written, with its seeds."""

    name: str
    runs: tuple[PlannedRun, ...]


def _tests(runs: Iterable[PlannedRun]) -> list[_Test]:
    """Return the runs in tests; runs of one item with other options, kept from before, get another name."""
    groups: dict[tuple[str, ...], list[PlannedRun]] = {}
    for run in runs:
        groups.setdefault((run.item, run.test, run.config, *run.options), []).append(run)
    tests: list[_Test] = []
    for group in groups.values():
        same = sum(test.runs[0].item == group[0].item for test in tests)
        tests.append(_Test(group[0].item + (f"_{same + 1}" if same else ""), tuple(group)))
    return tests


def _configuration(one: Pass, tests: Sequence[_Test]) -> dict[str, Any]:
    """Return the content of the Hjson file for these tests: that of the definition, cut down to them."""
    changes = {
        "python": sys.executable,
        "job_prefix": one.launcher.prefix,
        "results_folder": str(one.folder),
        "failing_seeds": str(one.failing),
        "identity": one.identity,
        "testplan": str(one.testplan),
        "primary_build_mode": tests[0].runs[0].config,
        "tests": [
            {
                "name": test.name,
                "uvm_test": test.runs[0].test,
                "build_mode": test.runs[0].config,
                "run_opts": list(test.runs[0].options),
                "reseed": len(test.runs),
            }
            for test in tests
        ],
        "regressions": [],
    }
    return one.definition.part(changes)


def _command(one: Pass, configuration: Path, tests: Sequence[_Test]) -> list[str]:
    return [
        sys.executable, "-m", "triaxis.verif.regress.die_with_parent", str(os.getpid()),
        str(_DVSIM), str(configuration),
        "--proj-root", str(ROOT), "--scratch-root", str(one.scratch), "--branch", "regress",
        # Local names of an outer dvsim's configuration file are none of ours.
        "--max-parallel", str(one.launcher.jobs), "--max-odirs", "1", "--print-interval", "30",
        "--items", *(test.name for test in tests),
        # In the order in which dvsim makes its runs: test by test, seed by seed.
        "--seeds", *(str(run.seed) for test in tests for run in test.runs),
    ]  # fmt: skip


def run_pass(one: Pass, runs: Sequence[PlannedRun], watch: Callable[[], None]) -> int:
    """Have dvsim do the runs; return its exit code. ``watch`` is called now and then meanwhile.

    However this ends, none of its processes is left.
    """
    tests = _tests(runs)
    configuration = one.folder / f"dvsim-{one.name}.hjson"
    write_whole(configuration, json.dumps(_configuration(one, tests), indent=1) + "\n")
    with one.log.open("w") as log:
        process = subprocess.Popen(
            _command(one, configuration, tests),
            cwd=ROOT,
            env=one.launcher.environment(),
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=subprocess.STDOUT,
            # A group of its own, so that an interrupt at the terminal reaches us alone, and all of it ends.
            start_new_session=True,
        )
        try:
            while process.poll() is None:
                time.sleep(_POLL_SECONDS)
                watch()
        finally:
            _end(process, one.launcher)
    watch()
    return process.returncode


def _end(process: "subprocess.Popen[bytes]", launcher: Launcher) -> None:
    """End dvsim and everything that it started, gently where it is still there to do so itself."""
    interrupted = process.poll() is None
    if interrupted:
        process.terminate()
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(_PATIENCE_SECONDS)
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    if interrupted or process.returncode < 0:
        launcher.end_jobs()


def last_error(log: Path) -> str:
    """Return the last line of a log that tells of an error, or its last line."""
    text = log.read_text(errors="replace") if log.exists() else ""
    lines = _COLOUR.sub("", text).splitlines()
    wanted = [line for line in lines if "ERROR" in line or "Error" in line or "FATAL" in line]
    found = (wanted or [line for line in lines if line.strip()] or ["it said nothing"])[-1]
    return found.strip()
