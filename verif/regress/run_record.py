"""The result of one run, in a file of its own that is written the moment the run ends."""

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from triaxis.golden.outputs import write_whole
from triaxis.verif.regress.planned_run import PlannedRun, from_dict


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
        content["run"] = from_dict(content["run"])
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
