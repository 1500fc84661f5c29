"""What all benchmarks are run with: the timer, steps that survive an interruption, the writer of results.

Times are seconds of processor time of this process: what else the machine does meanwhile is not in them. What
is compared works in one thread. The machine still makes itself felt, by its caches and its clock: so works
are timed in rounds, side by side where their ratio counts, and the best of each is taken.
"""

import gc
import json
import shutil
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from math import ceil
from pathlib import Path
from typing import Any, TypeVar

from triaxis.golden.outputs import write_whole
from triaxis.sim.evidence import write_evidence
from triaxis.sim.paths import BUILD
from triaxis.sim.validity import Provenance, Sources

FOLDER = BUILD / "bench"
# All of the benchmarks together: what one of them found is of the others' code too.
SOURCES = Sources(
    tuple(
        ".".join(("triaxis.bench", *path.relative_to(Path(__file__).parent).with_suffix("").parts))
        for path in sorted(Path(__file__).parent.rglob("*.py"))
        if "tests" not in path.parts and path.stem != "__init__"
    )
)

ROUNDS = 40
# What takes less is repeated within a round, so that what the others left in the caches does not count.
_LEAST_SECONDS = 0.005
# Work by itself is repeated so often, or for so long.
_ALONE_ROUNDS, _ALONE_SECONDS = 5, 0.1

Progress = Callable[[int], None]
Made = TypeVar("Made")


def best_times(works: Sequence[Callable[[], object]], rounds: int = ROUNDS) -> list[float]:
    """Return the least seconds that each took over so many rounds of all, after a first to warm up."""
    for work in works:
        work()
    repeats = [max(1, ceil(_LEAST_SECONDS / max(_seconds(work, 1), 1e-9))) for work in works]
    best = [float("inf")] * len(works)
    collecting = gc.isenabled()
    gc.disable()
    try:
        for _ in range(rounds):
            for number, (work, repeat) in enumerate(zip(works, repeats, strict=True)):
                best[number] = min(best[number], _seconds(work, repeat) / repeat)
    finally:
        if collecting:
            gc.enable()
    return best


def _seconds(work: Callable[[], object], repeat: int) -> float:
    start = time.process_time()
    for _ in range(repeat):
        work()
    return time.process_time() - start


def clocked(work: Callable[[], Made]) -> tuple[Made, float]:
    """Return what work returns, and the least seconds that it took in a few rounds by itself."""
    made: list[Made] = []
    seconds: list[float] = []
    while len(seconds) < _ALONE_ROUNDS and sum(seconds) <= _ALONE_SECONDS:
        made.clear()
        seconds.append(_seconds(lambda: made.append(work()), 1))
    return made[0], min(seconds)


class StoredSteps:
    """Steps of a long measurement that survive an interruption: each leaves its result for the next run.

    Results are valid for one state of everything that they depend on, named by a key; others are measured
    anew. Once all is done they are removed: a run that nobody interrupted takes up nothing.
    """

    def __init__(self, folder: Path, key: str, progress: Progress) -> None:
        """Take up what is there under ``key``; ``progress`` is told of each step."""
        self._folder, self._key, self._progress = folder, key, progress
        self.taken_up = 0

    def once(self, name: str, make: Callable[[], Mapping[str, Any]]) -> dict[str, Any]:
        """Return the result of a step, made where it is not there; as JSON gives it back."""
        path = self._folder / f"{file_name(name)}.json"
        result = self._stored(path)
        if result is None:
            write_whole(path, json.dumps({"key": self._key, "result": make()}) + "\n")
            result = self._stored(path)
            assert result is not None
        else:
            self.taken_up += 1
        self._progress(1)
        return result

    def _stored(self, path: Path) -> dict[str, Any] | None:
        try:
            content = json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return None
        fits = isinstance(content, dict) and content.get("key") == self._key
        return content.get("result") if fits else None

    def finish(self) -> None:
        """Remove the results."""
        shutil.rmtree(self._folder, ignore_errors=True)


def file_name(name: str) -> str:
    """Return a name as a file's: without what folders or shells would take for something else."""
    return "".join(letter if letter.isalnum() else "-" for letter in name)


def write_result(
    path: Path,
    command: str,
    problems: Sequence[str],
    summary: str,
    seconds: float,
    content: Mapping[str, Any],
    before: Provenance | None = None,
) -> Path:
    """Write what a benchmark found, whole or not at all; passed where there are no problems.

    ``before``: the checkout's state before the run, where that takes long; else it is taken now.
    """
    return write_evidence(
        path,
        {
            **({} if before is None else asdict(before)),
            "command": command,
            "passed": not problems,
            "problems": list(problems),
            "summary": summary,
            "seconds": round(seconds, 1),
            **content,
        },
        SOURCES,
    )
