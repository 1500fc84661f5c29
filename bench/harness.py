"""What all benchmarks are run with: the timer, steps that survive an interruption, and what they leave.

Times are seconds of processor time of this process: what else the machine does meanwhile is not in them. What
is compared works in one thread. The machine still makes itself felt, by its caches and its clock: so works
are timed in rounds, side by side where their ratio counts, and the best of each is taken.
"""

import json
import shutil
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields
from math import ceil
from pathlib import Path
from timeit import Timer
from typing import Any, Self, TypeVar, cast

from matplotlib.figure import Figure
from rich.console import Console
from rich.table import Table

from triaxis.golden.outputs import write_whole
from triaxis.host.cli import DONE, NO
from triaxis.host.cli.terminal import print_list
from triaxis.host.figures import write_figures
from triaxis.sim.evidence import write_evidence
from triaxis.sim.paths import BUILD
from triaxis.sim.validity import Sources, provenance

FOLDER = BUILD / "bench"
# All of the benchmarks together: what one of them found is of the others' code too.
SOURCES = Sources(
    tuple(
        ".".join(("triaxis.bench", *path.relative_to(Path(__file__).parent).with_suffix("").parts))
        for path in sorted(Path(__file__).parent.rglob("*.py"))
        if "tests" not in path.parts and path.stem != "__init__"
    )
)

# Of what is printed, in columns.
_WIDTH = 170

ROUNDS = 40
# What takes less is repeated within a round, so that what the others left in the caches does not count.
_LEAST_SECONDS = 0.005
# Work by itself is repeated so often, or for so long.
_ALONE_ROUNDS, _ALONE_SECONDS = 5, 0.1

Progress = Callable[[int], None]
Made = TypeVar("Made")


def best_times(works: Sequence[Callable[[], object]], rounds: int = ROUNDS) -> list[float]:
    """Return the least seconds that each took over so many rounds of all, after a first to warm up."""
    timers = [Timer(work, timer=time.process_time) for work in works]
    for timer in timers:
        timer.timeit(1)
    repeats = [max(1, ceil(_LEAST_SECONDS / max(timer.timeit(1), 1e-9))) for timer in timers]
    taken = [
        [timer.timeit(repeat) / repeat for timer, repeat in zip(timers, repeats, strict=True)]
        for _ in range(rounds)
    ]
    return [min(seconds) for seconds in zip(*taken, strict=True)]


def clocked(work: Callable[[], Made]) -> tuple[Made, float]:
    """Return what work returns, and the least seconds that it took in a few rounds by itself."""
    made: list[Made] = []
    seconds: list[float] = []
    while len(seconds) < _ALONE_ROUNDS and sum(seconds) <= _ALONE_SECONDS:
        made.clear()
        start = time.process_time()
        made.append(work())
        seconds.append(time.process_time() - start)
    return made[0], min(seconds)


class Summed:
    """A dataclass of figures that can be added field by field.

    What holds must hold of both; what is not known of one is not known of the sum; names stay.
    """

    def __add__(self, other: Self) -> Self:
        """Return the sums."""
        names = [field.name for field in fields(cast(Any, self))]
        return type(self)(*(_sum(getattr(self, name), getattr(other, name)) for name in names))


def _sum(one: Any, other: Any) -> Any:
    if one is None or other is None:
        return None
    if isinstance(one, bool):
        return one and other
    return one if isinstance(one, str) else one + other


def told(found: Any, *properties: str) -> dict[str, Any]:
    """Return a dataclass as JSON has it: its fields, and these of its properties."""
    return {**asdict(found), **{name: getattr(found, name) for name in properties}}


class StoredSteps:
    """Steps of a long measurement that survive an interruption: each leaves its result for the next run.

    Results are valid for one state of everything that they depend on, named by a key; others are measured
    anew. Once all is done they are removed: a run that nobody interrupted takes up nothing.
    """

    def __init__(self, folder: Path, key: str, progress: Progress) -> None:
        """Take up what is there under ``key``; ``progress`` is told of each step."""
        self._folder, self._key, self._progress = folder, key, progress
        self.taken_up = 0

    def once(self, name: str, make: Callable[[], Any]) -> Any:
        """Return the result of a step, made where it is not there; as JSON gives it back."""
        name = "".join(letter if letter.isalnum() else "-" for letter in name)
        path = self._folder / f"{name}.json"
        try:
            stored = json.loads(path.read_text(encoding="utf-8"))
            fits = stored["key"] == self._key
        except (OSError, ValueError, TypeError, KeyError):
            stored, fits = {}, False
        if fits:
            self.taken_up += 1
        else:
            stored = json.loads(json.dumps({"key": self._key, "result": make()}))
            write_whole(path, json.dumps(stored) + "\n")
        self._progress(1)
        return stored["result"]

    def finish(self) -> None:
        """Remove the results."""
        shutil.rmtree(self._folder, ignore_errors=True)


@dataclass(frozen=True)
class Findings:
    """What a benchmark found: what its file says, and what is shown.

    ``problems``: what must not be, a line each; without any it has passed. ``figures``: by the names of their
    files, beside that of the numbers; ``notes``: lines to be printed.
    """

    command: str
    summary: str
    problems: Sequence[str]
    content: Mapping[str, Any]
    tables: Sequence[Table]
    figures: Mapping[str, Callable[[], Figure]] = field(default_factory=dict)
    notes: Sequence[str] = ()


def report(path: Path, measure: Callable[[], Findings]) -> int:
    """Run a benchmark, show what it found, write it to ``path`` and beside; return the exit status.

    What it is evidence of is the checkout as it was before.
    """
    started, before = time.monotonic(), provenance(SOURCES)
    found = measure()
    seconds = time.monotonic() - started
    content = {
        **asdict(before),
        "command": found.command,
        "passed": not found.problems,
        "problems": list(found.problems),
        "summary": found.summary,
        "seconds": round(seconds, 1),
        **found.content,
    }
    console = Console(width=_WIDTH)
    for shown in found.tables:
        console.print(shown)
    for note in found.notes:
        print(note)
    print_list("PROBLEM", found.problems)
    print(f"{'FAILED' if found.problems else 'PASSED'}: {found.summary}, {seconds:.0f} s")
    print(f"written to {write_evidence(path, content, SOURCES)}")
    for name, draw in found.figures.items():
        for picture in write_figures(draw(), path.with_name(name)):
            print(f"written to {picture}")
    return NO if found.problems else DONE
