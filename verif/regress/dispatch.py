"""Has dvsim do some runs: writes its configuration, starts it, waits for it, ends it."""

import contextlib
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.golden.outputs import write_whole
from triaxis.sim.paths import ROOT
from triaxis.sim.validity import git
from triaxis.verif.regress.definition import Definition, as_test
from triaxis.verif.regress.launchers import Launcher
from triaxis.verif.regress.records import PlannedRun

_DVSIM = Path(sys.executable).with_name("dvsim")
_POLL_SECONDS = 0.25
_COLOUR = re.compile(r"\x1b\[[\d;]*m")
# What dvsim takes to end its jobs when asked to.
_PATIENCE_SECONDS = 15.0


def check_dvsim() -> None:
    """Raise InputError where dvsim is not installed, or will not start here."""
    if not _DVSIM.exists():
        raise InputError("dvsim: not in this Python environment: run `make regress`, which installs it")
    if git("rev-parse", "HEAD") is None:
        raise InputError(f"{ROOT}: no git checkout: dvsim asks for the commit; clone the repository")


@dataclass(frozen=True)
class Dvsim:
    """What dvsim is told of a regression. ``folder``: of the regression.

    ``failing``, ``testplan``: the files of the kept seeds, and of dvsim's view of the testplan. It may be
    called several times; each call has a name.
    """

    definition: Definition
    launcher: Launcher
    folder: Path
    failing: Path
    testplan: Path
    identity: str

    def _scratch(self, name: str) -> Path:
        """Return dvsim's own folder in a call: its logs and reports."""
        return self.folder / "dvsim" / name

    def log(self, name: str) -> Path:
        """Return the file of what dvsim says in a call."""
        return self.folder / f"dvsim-{name}.log"

    def run_log(self, name: str, run: PlannedRun) -> Path:
        """Return the file of what the process of a run said; it need not exist."""
        found = sorted(self._scratch(name).glob(f"**/{run.item}*.{run.seed}/latest/run.log"))
        return found[0] if found else self._scratch(name) / "run.log"

    def run(self, name: str, runs: Sequence[PlannedRun], watch: Callable[[], None]) -> int:
        """Have dvsim do the runs; return its exit code. ``watch`` is called now and then meanwhile.

        However this ends, none of its processes is left.
        """
        tests = self._tests(runs)
        configuration = self.folder / f"dvsim-{name}.hjson"
        write_whole(configuration, self._configuration(tests))
        # What an earlier attempt left there would tell of runs that this one never started.
        shutil.rmtree(self._scratch(name), ignore_errors=True)
        with self.log(name).open("w") as log:
            process = subprocess.Popen(
                self._command(name, configuration, tests),
                cwd=ROOT,
                env=self.launcher.environment(),
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                # A group of its own: an interrupt at the terminal reaches us alone, and all of it ends.
                start_new_session=True,
            )
            try:
                while process.poll() is None:
                    time.sleep(_POLL_SECONDS)
                    watch()
            finally:
                _end(process, self.launcher)
        watch()
        return process.returncode

    def _tests(self, runs: Sequence[PlannedRun]) -> dict[str, list[PlannedRun]]:
        """Return the runs by the name of their test; kept ones of other options than today's get another."""
        tests: dict[str, list[PlannedRun]] = defaultdict(list)
        for run in runs:
            usual = run.options == self.definition.items[run.item].run.options
            name = run.item if usual else f"{run.item}_{run.agent}_{run.pairs}_{run.judged_one_in}"
            tests[name].append(run)
        return tests

    def _configuration(self, tests: Mapping[str, Sequence[PlannedRun]]) -> str:
        """Return the Hjson file for these tests: the definition, cut down to them."""
        content = {
            **self.definition.content,
            "python": sys.executable,
            "job_prefix": self.launcher.prefix,
            "results_folder": str(self.folder),
            "failing_seeds": str(self.failing),
            "identity": self.identity,
            "testplan": str(self.testplan),
            "primary_build_mode": next(iter(tests.values()))[0].config,
            "tests": [as_test(name, runs[0], len(runs)) for name, runs in tests.items()],
            "regressions": [],
        }
        return json.dumps(content, indent=1) + "\n"

    def _command(
        self, name: str, configuration: Path, tests: Mapping[str, Sequence[PlannedRun]]
    ) -> list[str]:
        # However we end, even killed: dvsim is told to, and no simulation goes on.
        setpriv = shutil.which("setpriv")
        return [
            *((setpriv, "--pdeathsig", "TERM") if setpriv else ()),
            str(_DVSIM), str(configuration),
            "--proj-root", str(ROOT), "--scratch-root", str(self._scratch(name)), "--branch", "regress",
            # Local names of an outer dvsim's configuration file are none of ours.
            "--max-parallel", str(self.launcher.jobs), "--max-odirs", "1", "--print-interval", "30",
            "--items", *tests,
            # In the order in which dvsim makes its runs: test by test, seed by seed.
            "--seeds", *(str(run.seed) for runs in tests.values() for run in runs),
        ]  # fmt: skip


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
    lines = [line for line in _COLOUR.sub("", text).splitlines() if line.strip()]
    wanted = [line for line in lines if "ERROR" in line or "Error" in line or "FATAL" in line]
    return (wanted or lines or ["it said nothing"])[-1].strip()
