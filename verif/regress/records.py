"""What a regression leaves in its folder: how far it came, and the result of each of its runs."""

import json
import os
import shutil
import socket
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from datetime import UTC, datetime
from itertools import pairwise
from pathlib import Path
from typing import Any

from triaxis.golden.errors import InputError
from triaxis.golden.outputs import write_whole
from triaxis.verif.testbench.settings import RunSettings
from triaxis.verif.testbench.simulation import run_settings


def as_date(seconds: float) -> str:
    """Return a time, seconds since 1970, as reports hold it: UTC, ISO 8601."""
    return datetime.fromtimestamp(seconds, UTC).isoformat(timespec="seconds")


@dataclass(frozen=True)
class PlannedRun:
    """A test in a configuration with a seed; ``item``: the test of the Hjson file that it comes from."""

    item: str
    test: str
    config: str
    seed: int
    pairs: int
    agent: str
    judged_one_in: int

    def __str__(self) -> str:
        """Return it as people are told of it."""
        return f"{self.test} in {self.config}, seed {self.seed}"

    @property
    def key(self) -> str:
        """Return a name for files that tells this run from every other."""
        return f"{self.test}-{self.config}-{self.agent}-{self.pairs}-{self.judged_one_in}-{self.seed}"

    @property
    def options(self) -> tuple[str, ...]:
        """Return the options that all seeds of the run share, as run_opts of the Hjson file."""
        return (f"--pairs {self.pairs}", f"--agent {self.agent}", f"--judged {self.judged_one_in}")

    def settings(self, regression: Path) -> RunSettings:
        """Return what the simulation is asked to do, in the folder of a regression."""
        folder, judged = regression / "runs" / self.key, self.judged_one_in
        return run_settings(
            self.test, self.config, self.seed, self.pairs, "", folder, self.agent, judged_one_in=judged
        )


def planned_run(content: dict[str, Any]) -> PlannedRun:
    """Return the run that a file holds; raise TypeError where it holds none."""
    if not all(isinstance(value, str | int) for value in content.values()):
        raise TypeError("not a run")
    return PlannedRun(**content)


@dataclass(frozen=True)
class RunRecord:
    """How a run ended. Times are in seconds since 1970.

    ``counts`` are those of the scoreboard, None where it wrote none; ``job``: the number that Slurm or LSF
    gave it, None where it ran locally; ``log`` and ``folder``: where its simulation left its files.
    ``silent``: it left no result of its own: killed, out of time, not built; that says nothing of its seed.
    """

    run: PlannedRun
    identity: str
    passed: bool
    errors: tuple[str, ...]
    counterexamples: tuple[str, ...]
    counts: dict[str, Any] | None
    started: float
    finished: float
    host: str
    job: str | None
    log: str
    folder: str
    replay: str
    silent: bool = False
    # The command that shows the failure in waves, where there is one.
    waves: str = ""

    @property
    def seconds(self) -> float:
        """Return how long it took."""
        return self.finished - self.started

    @property
    def checked(self) -> int:
        """Return how many pairs were checked, as far as is known."""
        return int(self.counts["checked"]) if self.counts else 0

    @property
    def judged(self) -> int:
        """Return how many of them the golden model judged as well: none of the board's replies."""
        return int(self.counts.get("judged_by_golden_model", 0)) if self.counts else 0


def record_of(
    run: PlannedRun,
    regression: Path,
    identity: str,
    started: float,
    errors: tuple[str, ...],
    passed: bool = False,
    counts: dict[str, Any] | None = None,
    counterexamples: tuple[str, ...] = (),
    silent: bool = False,
    log: Path | None = None,
    waves: str = "",
) -> RunRecord:
    """Return the record of a run that has just ended."""
    settings = run.settings(regression)
    return RunRecord(
        run,
        identity,
        passed,
        errors,
        counterexamples,
        counts,
        started,
        time.time(),
        socket.gethostname(),
        os.environ.get("SLURM_JOB_ID") or os.environ.get("LSB_JOBID"),
        str(log or Path(settings.folder) / "simulation.log"),
        settings.folder,
        settings.replay_command,
        silent,
        waves,
    )


def record_file(regression: Path, run: PlannedRun) -> Path:
    """Return the file of a run's result in the folder of a regression."""
    return regression / "results" / f"{run.key}.json"


def write_record(regression: Path, record: RunRecord) -> None:
    """Write a result, whole or not at all."""
    write_whole(record_file(regression, record.run), json.dumps(asdict(record), indent=1) + "\n")


def read_record(path: Path) -> RunRecord | None:
    """Return a result, None where there is no readable one: the run must then be done again."""
    try:
        content = json.loads(path.read_text())
        lists = {key: tuple(content[key]) for key in ("errors", "counterexamples")}
        return RunRecord(**{**content, **lists, "run": planned_run(content["run"])})
    except (OSError, ValueError, TypeError, KeyError, AttributeError):
        return None


def read_records(regression: Path) -> dict[str, RunRecord]:
    """Return all readable results in the folder of a regression, by the key of their run."""
    found = map(read_record, sorted((regression / "results").glob("*.json")))
    return {record.run.key: record for record in found if record is not None}


@dataclass(frozen=True)
class State:
    """A regression that was started. ``started``: when, and when it was continued, seconds since 1970."""

    seed: int
    multiplier: float
    identity: str
    started: tuple[float, ...] = ()
    finished: bool = False

    def differences(self, other: "State") -> str:
        """Return in words what runs, or on what sources, the other is of; empty where of the same."""
        words = {
            "seed": f"of seed {other.seed}",
            "multiplier": f"of {other.multiplier:g} times the seeds",
            "identity": "of other sources",
        }
        return ", ".join(text for name, text in words.items() if getattr(self, name) != getattr(other, name))

    def seconds(self, records: list[RunRecord], now: float) -> float:
        """Return how long it was worked on: until now, and before each kill until its last result."""
        total = now - self.started[-1]
        for begun, after in pairwise(self.started):
            ends = (record.finished for record in records if begun <= record.finished < after)
            total += max(ends, default=begun) - begun
        return total


def state_file(regression: Path) -> Path:
    """Return the file of the state in the folder of a regression."""
    return regression / "regression.json"


def read_state(regression: Path) -> State | None:
    """Return the state of what is in a folder, None where there is none to go on from."""
    try:
        content = json.loads(state_file(regression).read_text())
        return State(**{**content, "started": tuple(content["started"])})
    except (OSError, ValueError, TypeError, KeyError):
        return None


def write_state(regression: Path, state: State) -> None:
    """Write it, whole or not at all."""
    write_whole(state_file(regression), json.dumps(asdict(state), indent=1) + "\n")


def begin(
    regression: Path, wanted: State, say: Callable[[str], None], any_seed: bool = False, fresh: bool = False
) -> State:
    """Return the state to work on: what was left unfinished of the same, unless ``fresh``; else a new one.

    ``any_seed``: what is left may be of any seed. What the folder holds of another is moved to where it stays
    readable until it is replaced in turn.
    """
    for folder in (regression, previous(regression)):
        if folder.is_dir() and any(folder.iterdir()) and not state_file(folder).exists():
            raise InputError(f"{folder}: holds no regression, and is not removed: use another --folder")
    left = read_state(regression)
    if left and not left.finished and not fresh:
        same = replace(wanted, seed=left.seed) if any_seed else wanted
        if not (differences := same.differences(left)):
            state = replace(left, started=(*left.started, time.time()))
            write_state(regression, state)
            return state
        say(f"not continued: the unfinished regression there is {differences}")
    if regression.is_dir():
        shutil.rmtree(previous(regression), ignore_errors=True)
        regression.rename(previous(regression))
    state = replace(wanted, started=(time.time(),))
    write_state(regression, state)
    return state


def previous(regression: Path) -> Path:
    """Return where the regression before this one is kept."""
    return regression.with_name(f"{regression.name}.previous")
