"""Runs a regression: what failed before first, then what is left of it, and writes its reports."""

import hashlib
import json
import shlex
import time
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path

from filelock import FileLock, Timeout

from triaxis.golden.errors import InputError
from triaxis.golden.outputs import make_folder, write_whole
from triaxis.sim.paths import BUILD, ROOT
from triaxis.verif.regress.coverage_models import has_coverage, illegal_hits, merge_coverage
from triaxis.verif.regress.definition import DEFINITION, NIGHTLY, in_checkout, read_definition, write_view
from triaxis.verif.regress.dispatch import Dvsim, check_dvsim, last_error
from triaxis.verif.regress.failing import NAME as FAILING
from triaxis.verif.regress.failing import FailingSeed, FailingSeeds, few_of_each_bucket
from triaxis.verif.regress.launchers import LOCAL, launcher
from triaxis.verif.regress.one_job import error_file, identity
from triaxis.verif.regress.outcome import Outcome
from triaxis.verif.regress.records import (
    PlannedRun,
    State,
    begin,
    read_record,
    read_records,
    record_file,
    record_of,
    write_record,
    write_state,
)
from triaxis.verif.regress.reports import write_junit, write_report, write_results

FOLDER = BUILD / "regress"


@dataclass(frozen=True)
class Request:
    """What the user wants. ``seed``: None: that of what was left unfinished, or the usual one."""

    regression: str
    seed: int | None = None
    multiplier: float = 1.0
    launcher: str = LOCAL
    jobs: int | None = None
    fresh: bool = False
    definition: Path = DEFINITION
    folder: Path = FOLDER

    @property
    def is_usual(self) -> bool:
        """Return whether it is of the table of tests, and where regressions are: one to be remembered."""
        return (self.definition, self.folder) == (DEFINITION, FOLDER)

    @property
    def usual_seed(self) -> int:
        """Return the seed where none is given: 1, for a nightly regression the date, as 20250131 (UTC)."""
        return int(datetime.now(UTC).strftime("%Y%m%d")) if self.regression == NIGHTLY else 1

    def command(self, seed: int) -> str:
        """Return the command that asks for the same."""
        words = ["triaxis", "regress", "run", self.regression, "--seed", str(seed)]
        words += ["--launcher", self.launcher] if self.launcher != LOCAL else []
        words += ["--seeds-times", str(self.multiplier)] if self.multiplier != 1 else []
        words += ["--definition", in_checkout(self.definition)] if self.definition != DEFINITION else []
        words += ["--folder", in_checkout(self.folder)] if self.folder != FOLDER else []
        return shlex.join(words)


# Shows how many runs are done, of how many in all, as what it gives is called with those that were.
Shown = Callable[[str, int], AbstractContextManager[Callable[[int], None]]]


def regress(request: Request, say: Callable[[str], None], shown: Shown) -> Outcome:
    """Run what is left of the regression, and write its reports; ``say`` is given a line now and then.

    Raise InputError where it cannot start, KeyboardInterrupt where it was stopped; what was done until
    then is kept, and the same call goes on from there.
    """
    # First, so that what cannot be run leaves nothing behind.
    regression = _Regression(request, say, shown)
    try:
        make_folder(request.folder)
        with FileLock(request.folder / f"{request.regression}.lock", blocking=False):
            return regression.run()
    except Timeout as error:
        busy = "a regression is running there: wait for its end, or use another --folder"
        raise InputError(f"{request.folder / request.regression}: {busy}") from error


def _check_folder(folder: Path) -> None:
    for path in (ROOT, folder):
        if any(character.isspace() for character in str(path)):
            raise InputError(f"{path}: has a blank in its name, which make cannot take: use another")
    there = next(path for path in (folder, *folder.parents) if path.exists())
    if not there.is_dir():
        raise InputError(f"{there}: is no folder: give --folder one, or a name that is free")


class _Regression:
    """One call: what it works on."""

    def __init__(self, request: Request, say: Callable[[str], None], shown: Shown) -> None:
        check_dvsim()
        _check_folder(request.folder)
        self._request, self._say, self._shown = request, say, shown
        self._folder = request.folder / request.regression
        self._definition = read_definition(request.definition)
        self._regression = self._definition.regression(request.regression)
        self._identity = identity()
        self._failing = FailingSeeds(request.folder / FAILING)
        self._testplan = request.folder / "testplan.hjson"
        # Of a cluster's jobs: whoever continues in this folder ends what is left of them.
        tag = hashlib.sha256(str(self._folder).encode()).hexdigest()[:8]
        self._launcher = launcher(request.launcher, f"triaxis-{request.regression}-{tag}", request.jobs)
        self._dvsim = Dvsim(
            self._definition, self._launcher, self._folder, self._failing.path, self._testplan, self._identity
        )

    def run(self) -> Outcome:
        """Run it, and write everything."""
        request = self._request
        seed = request.usual_seed if request.seed is None else request.seed
        wanted = State(seed, request.multiplier, self._identity)
        state = begin(self._folder, wanted, self._say, any_seed=request.seed is None, fresh=request.fresh)
        planned = self._definition.plan(request.regression, state.seed, state.multiplier)
        # Left over by a regression that was killed together with its dvsim.
        self._launcher.end_jobs()
        replayed = self._kept_seeds()
        kept = sum(map(self._done, planned))
        if kept:
            self._say(f"continuing: {kept} of {len(planned)} runs passed before")
        write_view(self._testplan, list(self._definition.items.values()))
        whole = json.dumps(self._definition.content, indent=1)
        write_whole(request.folder / DEFINITION.name, whole + "\n")
        first = {seed.run.key: seed.run for seed in replayed}
        everything = list((first | {run.key: run for run in planned}).values())
        if first:
            self._say(f"replaying {len(first)} seed{'s' * (len(first) > 1)} that failed before")
        with self._shown(request.regression, len(everything)) as progress:
            self._pass("replay", list(first.values()), progress)
            self._pass("main", [run for run in planned if run.key not in first], progress)
        outcome = self._outcome(state, planned, everything, replayed, kept)
        self._write(outcome)
        return outcome

    def _kept_seeds(self) -> list[FailingSeed]:
        """Return the seeds to be replayed: those that the definition still has a test for.

        All of them only at night: others take a few of each bucket, those of the fewest pairs.
        """
        seeds = self._failing.read()
        tests = {(item.run.item, item.run.test, item.run.config) for item in self._definition.items.values()}
        known = [seed for seed in seeds if (seed.run.item, seed.run.test, seed.run.config) in tests]
        if len(known) < len(seeds):
            self._say(f"{len(seeds) - len(known)} kept seeds not replayed: this definition has no such tests")
        taken = known if self._request.regression == NIGHTLY else few_of_each_bucket(known)
        if len(taken) < len(known):
            self._say(f"{len(known) - len(taken)} kept seeds not replayed now: {NIGHTLY} replays them all")
        return taken

    def _done(self, run: PlannedRun) -> bool:
        record = read_record(record_file(self._folder, run))
        if record is None or not record.passed or record.identity != self._identity:
            return False
        return has_coverage(run.config, Path(record.folder))

    def _pass(self, name: str, runs: Sequence[PlannedRun], progress: Callable[[int], None]) -> None:
        """Have dvsim do those of the runs that have not passed yet."""
        missing = [run for run in runs if not self._done(run)]
        progress(len(runs) - len(missing))
        if not missing:
            return
        # A failure of an earlier attempt must not pass for one of this.
        for run in missing:
            for path in (record_file(self._folder, run), error_file(self._folder, run.config)):
                path.unlink(missing_ok=True)
        begun, done = time.time(), 0

        def watch() -> None:
            nonlocal done
            before, done = done, sum(record_file(self._folder, run).exists() for run in missing)
            progress(done - before)

        code = self._dvsim.run(name, missing, watch)
        if code < 0:
            raise InputError(f"dvsim was killed (signal {-code}): the same command goes on from here")
        if identity() != self._identity:
            raise InputError("the RTL or its environment changed during the regression: start it again")
        self._account_for(name, missing, begun)

    def _account_for(self, name: str, runs: Sequence[PlannedRun], begun: float) -> None:
        """Write a failed result for each run that left none: killed, out of time, or its build failed."""
        dvsim_log = self._dvsim.log(name)
        reasons = {
            run: self._why_silent(name, run) for run in runs if not record_file(self._folder, run).exists()
        }
        if len(reasons) == len(runs) and not any(reasons.values()):
            raise InputError(f"dvsim started no run: {last_error(dvsim_log)} (log: {dvsim_log})")
        for run, reason in reasons.items():
            error = f"ERROR {reason or f'not started: {last_error(dvsim_log)}'}"
            log = self._dvsim.run_log(name, run)
            record = record_of(run, self._folder, self._identity, begun, (error,), silent=True, log=log)
            write_record(self._folder, record)

    def _why_silent(self, name: str, run: PlannedRun) -> str:
        """Return why a run left no result, empty where it was not even started."""
        failed_build, log = error_file(self._folder, run.config), self._dvsim.run_log(name, run)
        if failed_build.exists():
            return failed_build.read_text().strip()
        if log.exists():
            return f"killed, or ended by its time limit, which says nothing of the design: {last_error(log)}"
        return ""

    def _outcome(
        self,
        state: State,
        planned: Sequence[PlannedRun],
        everything: Sequence[PlannedRun],
        replayed: Sequence[FailingSeed],
        kept: int,
    ) -> Outcome:
        found = read_records(self._folder)
        records = [found[run.key] for run in everything if run.key in found]
        passed = [(record.run.config, Path(record.folder)) for record in records if record.passed]
        keys = {run.key for run in everything}
        uncovered = self._regression.uncovered
        covered = dict.fromkeys(run.config for run in planned if run.config not in uncovered)
        return Outcome(
            self._regression,
            state,
            self._folder,
            self._request.command(state.seed),
            self._launcher.kind,
            planned,
            records,
            replayed,
            [seed for seed in self._failing.read() if seed.flaky and seed.run.key in keys],
            kept,
            merge_coverage(self._folder, covered, passed),
            state.seconds(records, time.time()),
            illegal_hits((config, run) for config, run in passed if config not in covered),
        )

    def _write(self, outcome: Outcome) -> None:
        """Write the reports, last that it is finished: a kill repeats them."""
        write_junit(outcome)
        write_results(outcome)
        # Last of them: it links the others.
        write_report(outcome)
        write_state(self._folder, replace(outcome.state, finished=True))
