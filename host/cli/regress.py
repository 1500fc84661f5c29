"""``triaxis regress``: a regression on dvsim, here or on a cluster."""

import argparse
import time
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from triaxis.golden.errors import InputError
from triaxis.verif.regress.definition import DEFINITION, in_checkout
from triaxis.verif.regress.failing import FailingSeeds
from triaxis.verif.regress.junit import NAME as JUNIT
from triaxis.verif.regress.launchers import LAUNCHERS, LOCAL
from triaxis.verif.regress.outcome import Outcome
from triaxis.verif.regress.report_page import NAME as REPORT
from triaxis.verif.regress.results_file import NAME as RESULTS
from triaxis.verif.regress.run import FOLDER, MOST_SEEDS_MULTIPLIED, Request, regress

PASSED, FAILED = 0, 1
_SHOWN = 20
_SECONDS_BETWEEN_LINES = 60.0


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the command."""
    parser = commands.add_parser(
        "regress",
        help="run a regression on dvsim",
        description="Run a regression of verif/regress/triaxis_sim_cfg.hjson on dvsim: seeds that failed "
        "before first, then the rest. One that was interrupted or killed is continued by the same command: "
        "what passed on the same sources and with the same seed is not run again. Writes results.json, "
        "report.html, junit.xml and the merged coverage into build/regress/NAME/. Seeds that failed are kept "
        "in build/regress/failing.json until they pass on other sources; smoke replays at most three of each "
        "kind of failure, nightly all of them.",
        epilog="Exit codes: 0 passed, 1 failed, 2 error, 130 interrupted.",
    )
    parser.add_argument(
        "regression", metavar="NAME", nargs="?", default="smoke", help="smoke or nightly (smoke)"
    )
    parser.add_argument("--launcher", choices=LAUNCHERS, default=LOCAL, help="where runs go (local)")
    parser.add_argument(
        "--seed", type=int,
        help="what all seeds follow from (1; nightly: the date; continued: that of what is continued)",
    )  # fmt: skip
    parser.add_argument("--jobs", type=int, metavar="N", help="runs at a time (local: one for each core)")
    parser.add_argument("--fresh", action="store_true", help="start anew, continue nothing")
    parser.add_argument(
        "--forget", action="store_true",
        help="run nothing: forget all seeds that failed before, those found flaky too, and say which",
    )  # fmt: skip
    parser.add_argument(
        "--seeds-times", type=float, default=1.0, metavar="X",
        help="run X times as many seeds of each test, at least one: 5 for a weekend (1)",
    )  # fmt: skip
    parser.add_argument(
        "--definition", type=Path, default=DEFINITION, metavar="FILE.hjson", help="another file"
    )
    parser.add_argument(
        "--folder", type=Path, default=FOLDER, metavar="DIR",
        help="where all is written; a cluster's nodes must share it (build/regress)",
    )  # fmt: skip
    parser.set_defaults(run=run)


def _request(options: argparse.Namespace) -> Request:
    if options.seed is not None and options.seed < 0:
        raise InputError(f"seed {options.seed}: must not be negative")
    if options.jobs is not None and options.jobs < 1:
        raise InputError(f"jobs {options.jobs}: must be at least 1")
    if not 0 < options.seeds_times <= MOST_SEEDS_MULTIPLIED:
        raise InputError(
            f"seeds-times {options.seeds_times}: must be above 0, and at most {MOST_SEEDS_MULTIPLIED:.0f}"
        )
    return Request(
        regression=options.regression,
        seed=options.seed,
        multiplier=options.seeds_times,
        launcher=options.launcher,
        jobs=options.jobs,
        fresh=options.fresh,
        definition=options.definition.resolve(),
        folder=options.folder.resolve(),
    )


class _Progress:
    """Shows how many runs are done: as a bar on a terminal, elsewhere as a line now and then."""

    def __init__(self, bar: Progress, name: str) -> None:
        self._bar, self._task = bar, bar.add_task(name, total=None)
        self._shown, self._at = 0, time.monotonic()

    def __call__(self, total: int, done: int) -> None:
        self._bar.update(self._task, total=total, completed=done)
        late = time.monotonic() - self._at > _SECONDS_BETWEEN_LINES
        if not self._bar.console.is_terminal and late and done > self._shown:
            print(f"{done} of {total} runs done", flush=True)
            self._shown, self._at = done, time.monotonic()


def run(options: argparse.Namespace) -> int:
    """Run the regression and print what came of it."""
    request = _request(options)
    if options.forget:
        return _forget(request)
    console = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        outcome = regress(request, lambda line: print(line, flush=True), _Progress(bar, request.regression))
    _print(outcome)
    return FAILED if outcome.problems else PASSED


def _forget(request: Request) -> int:
    forgotten = FailingSeeds(request.failing).forget() if request.failing.exists() else []
    for seed in forgotten:
        print(f"forgotten: {seed.run.test} in {seed.run.config}, seed {seed.run.seed}: {seed.bucket}")
    print(f"{len(forgotten)} failing seeds forgotten, none is left in {in_checkout(request.failing)}")
    return PASSED


def _print(outcome: Outcome) -> None:
    for bucket in outcome.buckets:
        first = bucket.records[0]
        print(f"{len(bucket.records)} x {bucket.message}")
        for line in (*first.errors[:1], *first.counterexamples[:1]):
            print(f"  {line}")
        print(f"  log:    {first.log}\n  replay: {first.replay}")
    for seed in outcome.fixed:
        print(f"fixed: {seed.run.test} in {seed.run.config}, seed {seed.run.seed} failed before and passes")
    for problem in outcome.shortfalls[:_SHOWN]:
        print(f"PROBLEM {problem}")
    if len(outcome.shortfalls) > _SHOWN:
        print(f".. and {len(outcome.shortfalls) - _SHOWN} more: see {RESULTS}")
    print(f"{'FAILED' if outcome.problems else 'PASSED'}: {outcome.summary}")
    files = ", ".join((RESULTS, REPORT, JUNIT, "coverage.html"))
    print(f"written to {in_checkout(outcome.folder)}: {files}")
