"""One line for each long run that came to its end: how the core and its environment fared over time."""

import json
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path

from filelock import FileLock

from triaxis.golden.outputs import make_folder, write_whole
from triaxis.sim.paths import BUILD

HISTORY = BUILD / "history" / "nightly.jsonl"


@dataclass(frozen=True)
class NightlyRecord:
    """One finished run. ``date``: its end, UTC, ISO 8601; ``kind``: the regression.

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
    """Add the line of a run that began at ``begun``, seconds since 1970, unless it is there already."""
    make_folder(path.parent)
    with FileLock(path.with_suffix(".lock")):
        if any(_is_same(one, record, begun) for one in read_history(path)):
            return
        lines = _lines(path)
        write_whole(path, "\n".join([*lines, json.dumps(asdict(record))]) + "\n")


def _is_same(one: NightlyRecord, record: NightlyRecord, begun: float) -> bool:
    """Return whether a line is of the very run: of its kind and seed, and ended since it began."""
    return (one.kind, one.seed) == (record.kind, record.seed) and one.date > as_date(begun)


def read_history(path: Path = HISTORY) -> list[NightlyRecord]:
    """Return all whole lines, the oldest first; a damaged one is passed over."""
    return [record for line in _lines(path) if (record := _record(line)) is not None]


def _lines(path: Path) -> list[str]:
    return path.read_text(encoding="utf-8", errors="replace").splitlines() if path.exists() else []


def _record(line: str) -> NightlyRecord | None:
    try:
        return NightlyRecord(**json.loads(line))
    except (ValueError, TypeError):
        return None
