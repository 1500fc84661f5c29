"""One line for each long run that came to its end: how the core and its environment fared over time."""

import json
import os
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from filelock import FileLock

from triaxis.golden.outputs import make_folder
from triaxis.sim.paths import BUILD

HISTORY = BUILD / "history" / "nightly.jsonl"


@dataclass(frozen=True)
class NightlyRecord:
    """One finished run. ``date``: its end, UTC, ISO 8601; ``kind``: nightly, signoff, ..

    What was not measured is None, never 0.
    """

    date: str
    kind: str
    commit: str | None
    rtl_hash: str
    seed: int
    passed: bool
    pairs: int
    failures: int
    coverage_percent: float | None
    seconds: float
    pairs_per_second: float | None


def now() -> str:
    """Return the time as records hold it."""
    return as_date(datetime.now(UTC).timestamp())


def as_date(seconds: float) -> str:
    """Return a time, seconds since 1970, as records hold it."""
    return datetime.fromtimestamp(seconds, UTC).isoformat(timespec="seconds")


def append_record(record: NightlyRecord, begun: float, path: Path = HISTORY) -> None:
    """Add the line of a run that began at ``begun``, seconds since 1970, unless it is there already.

    One that was cut off before, by a kill, is left alone and ended.
    """
    line = json.dumps(asdict(record)) + "\n"
    make_folder(path.parent)
    with FileLock(path.with_suffix(".lock")), path.open("a+b") as file:
        if any(_is_same(one, record, begun) for one in read_history(path)):
            return
        if file.seek(0, os.SEEK_END):
            file.seek(-1, os.SEEK_END)
            line = line if file.read(1) == b"\n" else "\n" + line
        file.write(line.encode())
        file.flush()
        os.fsync(file.fileno())


def _is_same(one: NightlyRecord, record: NightlyRecord, begun: float) -> bool:
    """Return whether a line is of the very run: of its kind and seed, and ended since it began."""
    return (one.kind, one.seed) == (record.kind, record.seed) and one.date > as_date(begun)


def read_history(path: Path = HISTORY) -> list[NightlyRecord]:
    """Return all whole lines, the oldest first; what a kill cut off is passed over."""
    if not path.exists():
        return []
    found = (_record(line) for line in path.read_text(encoding="utf-8", errors="replace").splitlines())
    return [record for record in found if record is not None]


def _record(line: str) -> NightlyRecord | None:
    try:
        content: dict[str, Any] = json.loads(line)
        return NightlyRecord(**content)
    except (ValueError, TypeError):
        return None
