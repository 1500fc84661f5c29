"""How far a regression has come: which one it is, and when it was worked on."""

import json
import shutil
import time
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from triaxis.golden.outputs import write_whole
from triaxis.verif.regress.run_record import RunRecord


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
