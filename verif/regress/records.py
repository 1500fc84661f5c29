"""What a regression leaves in its folder: what it is, how far it came, the result of each of its runs."""

import argparse
import json
import shutil
import time
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from triaxis.golden.outputs import write_whole
from triaxis.verif.testbench.settings import BURST, PIN, RunSettings
from triaxis.verif.testbench.simulation import run_settings


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

    @property
    def key(self) -> str:
        """Return a name for files that tells this run from every other."""
        return f"{self.test}-{self.config}-{self.agent}-{self.pairs}-{self.judged_one_in}-{self.seed}"

    @property
    def options(self) -> tuple[str, ...]:
        """Return the options that all seeds of the run share."""
        return (f"--pairs {self.pairs}", f"--agent {self.agent}", f"--judged {self.judged_one_in}")

    def settings(self, folder: Path) -> RunSettings:
        """Return what the simulation is asked to do, in ``folder``."""
        return run_settings(
            self.test,
            self.config,
            self.seed,
            self.pairs,
            folder=folder,
            agent=self.agent,
            judged_one_in=self.judged_one_in,
        )


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of a run that a test of the Hjson file gives as its run_opts."""
    parser.add_argument("--pairs", type=int, required=True)
    parser.add_argument("--agent", choices=(PIN, BURST), default=BURST)
    parser.add_argument("--judged", type=int, default=1)


def planned_run(content: dict[str, Any]) -> PlannedRun:
    """Return the run that a file holds; raise TypeError or KeyError where it holds none."""
    fields = {name: content[name] for name in PlannedRun.__dataclass_fields__}
    if not all(isinstance(value, str | int) for value in fields.values()):
        raise TypeError("not a run")
    return PlannedRun(**fields)


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
        """Return how many of them the golden model judged as well."""
        return int(self.counts["judged_by_golden_model"]) if self.counts else 0


def record_file(results: Path, run: PlannedRun) -> Path:
    """Return the file of a run's result in the folder of results."""
    return results / f"{run.key}.json"


def write_record(results: Path, record: RunRecord) -> None:
    """Write a result, whole or not at all."""
    write_whole(record_file(results, record.run), json.dumps(asdict(record), indent=1) + "\n")


def read_record(path: Path) -> RunRecord | None:
    """Return a result, None where there is no readable one: the run must then be done again."""
    try:
        content = json.loads(path.read_text())
        content["run"] = planned_run(content["run"])
        content["errors"] = tuple(content["errors"])
        content["counterexamples"] = tuple(content["counterexamples"])
        return RunRecord(**content)
    except (OSError, ValueError, TypeError, KeyError):
        return None


def read_records(results: Path) -> dict[str, RunRecord]:
    """Return all readable results in a folder, by the key of their run."""
    if not results.is_dir():
        return {}
    found = (read_record(path) for path in sorted(results.glob("*.json")))
    return {record.run.key: record for record in found if record is not None}


@dataclass(frozen=True)
class State:
    """A regression that was started. ``started``: when, and when it was continued, seconds since 1970."""

    regression: str
    seed: int
    multiplier: float
    identity: str
    started: tuple[float, ...]
    finished: bool = False

    def continues(self, other: "State") -> bool:
        """Return whether this is what is left of the other: the same runs of the same sources."""
        return not other.finished and not self.differences(other)

    def differences(self, other: "State") -> list[str]:
        """Return in what the other is not the same, in words; empty where it is."""
        found: list[str] = []
        if other.regression != self.regression:
            found.append(f"of the regression {other.regression}")
        if other.seed != self.seed:
            found.append(f"of seed {other.seed}")
        if other.multiplier != self.multiplier:
            found.append(f"of {other.multiplier:g} times the seeds")
        if other.identity != self.identity:
            found.append("of other sources")
        return found

    def seconds(self, records: list[RunRecord], now: float) -> float:
        """Return how long it was worked on: until now, and before each kill until its last result."""
        spans = zip(self.started, (*self.started[1:], None), strict=True)
        total = 0.0
        for begin, after in spans:
            if after is None:
                total += now - begin
            else:
                ends = [r.finished for r in records if begin <= r.finished < after]
                total += max(ends, default=begin) - begin
        return total


def state_file(folder: Path) -> Path:
    """Return the file of the state in the folder of a regression."""
    return folder / "regression.json"


def read_state(folder: Path) -> State | None:
    """Return the state of what is in a folder, None where there is none to go on from."""
    try:
        content = json.loads(state_file(folder).read_text())
        return State(**{**content, "started": tuple(content["started"])})
    except (OSError, ValueError, TypeError, KeyError):
        return None


def write_state(folder: Path, state: State) -> None:
    """Write it, whole or not at all."""
    write_whole(state_file(folder), json.dumps(asdict(state), indent=1) + "\n")


def begin(folder: Path, wanted: State, fresh: bool) -> State:
    """Return the state to work on: what was left unfinished of the same, unless ``fresh``; else a new one.

    What the folder holds of another is moved aside, to where it stays readable until it is replaced in turn.
    """
    before = read_state(folder)
    if before and wanted.continues(before) and not fresh:
        state = replace(before, started=(*before.started, time.time()))
    else:
        set_aside(folder)
        state = replace(wanted, started=(time.time(),))
    write_state(folder, state)
    return state


def previous(folder: Path) -> Path:
    """Return where the regression before this one is kept."""
    return folder.with_name(f"{folder.name}.previous")


def set_aside(folder: Path) -> None:
    """Move a regression to where the previous one is kept."""
    if folder.is_dir():
        shutil.rmtree(previous(folder), ignore_errors=True)
        folder.rename(previous(folder))
