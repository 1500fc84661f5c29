"""Runs a regression: what failed before first, then what is left of it, and writes its reports."""

import hashlib
import json
import shlex
import socket
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path

from filelock import FileLock, Timeout

from triaxis.golden.errors import InputError
from triaxis.golden.outputs import make_folder, write_whole
from triaxis.sim.paths import BUILD, ROOT
from triaxis.verif.regress.coverage_models import merge_coverage
from triaxis.verif.regress.definition import (
    DEFINITION,
    NIGHTLY,
    Definition,
    in_checkout,
    read_definition,
    write_view,
)
from triaxis.verif.regress.dispatch import (
    Pass,
    check_dvsim,
    last_error,
    run_pass,
)
from triaxis.verif.regress.failing import NAME as FAILING
from triaxis.verif.regress.failing import FailingSeed, FailingSeeds, few_of_each_bucket
from triaxis.verif.regress.history import HISTORY, append_record
from triaxis.verif.regress.launchers import LOCAL, Launcher, launcher
from triaxis.verif.regress.one_job import error_file, identity
from triaxis.verif.regress.outcome import Outcome
from triaxis.verif.regress.records import (
    PlannedRun,
    RunRecord,
    State,
    begin,
    read_record,
    read_records,
    read_state,
    record_file,
    write_record,
    write_state,
)
from triaxis.verif.regress.reports import history_record, write_junit, write_report, write_results

FOLDER = BUILD / "regress"
# Seeds multiplied by more than this are a mistake: a regression of months.
MOST_SEEDS_MULTIPLIED = 1000.0


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
    history: Path = HISTORY

    @property
    def failing(self) -> Path:
        """Return the file of the seeds that failed, which all regressions of the folder share."""
        return self.folder / FAILING

    @property
    def is_whole_nightly(self) -> bool:
        """Return whether this is the nightly regression as it is defined, not a part or a multiple of it."""
        usual = (NIGHTLY, DEFINITION, FOLDER, 1.0)
        return (self.regression, self.definition, self.folder, self.multiplier) == usual

    def command(self, seed: int) -> str:
        """Return the command that asks for the same."""
        words = ["triaxis", "regress", "run", self.regression, "--seed", str(seed)]
        words += ["--launcher", self.launcher] if self.launcher != LOCAL else []
        words += ["--seeds-times", str(self.multiplier)] if self.multiplier != 1 else []
        words += ["--definition", in_checkout(self.definition)] if self.definition != DEFINITION else []
        words += ["--folder", in_checkout(self.folder)] if self.folder != FOLDER else []
        return shlex.join(words)


# Told of the runs in all, and of those that are done.
Watch = Callable[[int, int], None]


def regress(request: Request, say: Callable[[str], None], watch: Watch) -> Outcome:
    """Run what is left of the regression, and write its reports; ``say`` is given a line now and then.

    Raise InputError where it cannot start, KeyboardInterrupt where it was stopped; what was done until
    then is kept, and the same call goes on from there.
    """
    folder = request.folder / request.regression
    # First, so that what cannot be run leaves nothing behind.
    regression = _Regression(request, folder, say, watch)
    lock = FileLock(request.folder / f"{request.regression}.lock", blocking=False)
    try:
        make_folder(request.folder)
        with lock:
            return regression.run()
    except Timeout as error:
        busy = "a regression is running there: wait for its end, or use another --folder"
        raise InputError(f"{folder}: {busy}") from error


def usual_seed(name: str) -> int:
    """Return the seed where none is given: 1, for a nightly regression the date, as 20250131 (UTC)."""
    return int(datetime.now(UTC).strftime("%Y%m%d")) if name == NIGHTLY else 1


def _tag(folder: Path) -> str:
    """Return a short name of a folder, for a cluster's jobs: whoever continues there ends what is left."""
    return f"{folder.name}-{hashlib.sha256(str(folder).encode()).hexdigest()[:8]}"


class _Regression:
    """One call: what it works on."""

    def __init__(self, request: Request, folder: Path, say: Callable[[str], None], watch: Watch) -> None:
        check_dvsim()
        for path in (ROOT, request.folder):
            if any(character.isspace() for character in str(path)):
                raise InputError(f"{path}: has a blank in its name, which make cannot take: use another")
        there = next(path for path in (request.folder, *request.folder.parents) if path.exists())
        if not there.is_dir():
            raise InputError(f"{there}: is no folder: give --folder one, or a name that is free")
        self._request, self._folder, self._say, self._watch = request, folder, say, watch
        self._definition: Definition = read_definition(request.definition)
        self._regression = self._definition.regression(request.regression)
        self._identity = identity()
        self._launcher: Launcher = launcher(request.launcher, f"triaxis-{_tag(folder)}", request.jobs)
        self._failing = FailingSeeds(request.failing)
        self._results = folder / "results"

    def run(self) -> Outcome:
        """Run it, and write everything."""
        request, state = self._request, self._begin()
        planned = self._definition.plan(request.regression, state.seed, state.multiplier)
        # Left over by a regression that was killed together with its dvsim.
        self._launcher.end_jobs()
        replayed = self._kept_seeds()
        kept = sum(self._done(run) for run in planned)
        if kept:
            self._say(f"continuing: {kept} of {len(planned)} runs passed before")
        write_view(self._testplan, list(self._definition.items.values()))
        whole = json.dumps(self._definition.content, indent=1)
        write_whole(self._request.folder / DEFINITION.name, whole + "\n")
        first = [seed.run for seed in replayed]
        everything = list({run.key: run for run in (*first, *planned)}.values())
        if first:
            self._say(f"replaying {len(first)} seed{'s' * (len(first) > 1)} that failed before")
        self._pass("replay", first, everything)
        keys = {run.key for run in first}
        self._pass("main", [run for run in planned if run.key not in keys], everything)
        outcome = self._outcome(state, planned, everything, replayed, kept)
        self._write(outcome)
        return outcome

    @property
    def _testplan(self) -> Path:
        return self._request.folder / "testplan.hjson"

    def _begin(self) -> State:
        request = self._request
        usual = usual_seed(request.regression) if request.seed is None else request.seed
        wanted = State(request.regression, usual, request.multiplier, self._identity, ())
        before = read_state(self._folder)
        if before and not before.finished and not request.fresh:
            same_seed = replace(wanted, seed=before.seed) if request.seed is None else wanted
            if differences := same_seed.differences(before):
                self._say(f"not continued: what was left unfinished is {', '.join(differences)}")
            else:
                wanted = same_seed
        return begin(self._folder, wanted, request.fresh)

    def _kept_seeds(self) -> list[FailingSeed]:
        """Return the seeds to be replayed: those that the definition still has a test for.

        All of them only at night: others take a few of each bucket, those of the fewest pairs.
        """
        seeds, items = self._failing.read(), self._definition.items
        known = [s for s in seeds if s.run.item in items and items[s.run.item].config == s.run.config]
        if len(known) < len(seeds):
            self._say(f"{len(seeds) - len(known)} kept seeds not replayed: their tests are not in this file")
        if self._request.regression == NIGHTLY:
            return known
        taken = few_of_each_bucket(known)
        if len(taken) < len(known):
            self._say(f"{len(known) - len(taken)} kept seeds put off: {NIGHTLY} replays them all")
        return taken

    def _done(self, run: PlannedRun) -> bool:
        record = read_record(record_file(self._results, run))
        return record is not None and record.passed and record.identity == self._identity

    def _pass(self, name: str, runs: Sequence[PlannedRun], everything: Sequence[PlannedRun]) -> None:
        """Have dvsim do those of the runs that have not passed yet."""
        missing = [run for run in runs if not self._done(run)]
        if not missing:
            return
        # A failure of an earlier attempt must not pass for one of this; it stays readable beside it.
        for path in (record_file(self._results, run) for run in missing):
            if path.exists():
                path.replace(path.with_suffix(".before"))
        one = Pass(
            self._definition,
            self._launcher,
            self._folder,
            self._failing.path,
            self._testplan,
            self._identity,
            name,
        )
        begun = time.time()

        def watch() -> None:
            done = sum(record_file(self._results, run).exists() for run in everything)
            self._watch(len(everything), done)

        code = run_pass(one, missing, watch)
        if code < 0:
            raise InputError(f"dvsim was killed (signal {-code}): the same command goes on from here")
        if identity() != self._identity:
            raise InputError("the RTL or its environment changed during the regression: start it again")
        self._account_for(one, missing, begun)

    def _account_for(self, one: Pass, runs: Sequence[PlannedRun], begun: float) -> None:
        """Write a failed result for each run that left none: killed, out of time, or its build failed."""
        silent = [run for run in runs if not record_file(self._results, run).exists()]
        reasons = {run.key: self._why_silent(one, run) for run in silent}
        if silent and len(silent) == len(runs) and not any(reasons.values()):
            raise InputError(f"dvsim started no run: {last_error(one.log)} (log: {one.log})")
        for run in silent:
            reason = reasons[run.key] or f"not started: {last_error(one.log)}"
            settings = run.settings(self._folder / "runs" / run.key)
            record = RunRecord(
                run,
                self._identity,
                False,
                (f"ERROR {reason}",),
                (),
                None,
                begun,
                time.time(),
                socket.gethostname(),
                None,
                str(one.run_log(run)),
                settings.folder,
                settings.replay_command,
                silent=True,
            )
            write_record(self._results, record)

    def _why_silent(self, one: Pass, run: PlannedRun) -> str:
        """Return why a run left no result, empty where it was not even started."""
        failed_build = error_file(self._folder, run.config)
        if failed_build.exists():
            return failed_build.read_text().strip()
        log = one.run_log(run)
        if not log.exists():
            return ""
        return f"killed, or ended by the limit against hanging, which decides nothing: {last_error(log)}"

    def _outcome(
        self,
        state: State,
        planned: Sequence[PlannedRun],
        everything: Sequence[PlannedRun],
        replayed: Sequence[FailingSeed],
        kept: int,
    ) -> Outcome:
        found = read_records(self._results)
        records = [found[run.key] for run in everything if run.key in found]
        passed = [(record.run.config, Path(record.folder)) for record in records if record.passed]
        coverage = merge_coverage(self._folder, (run.config for run in planned), passed)
        keys = {run.key for run in everything}
        flaky = [seed for seed in self._failing.read() if seed.flaky and seed.run.key in keys]
        return Outcome(
            self._regression,
            state,
            self._folder,
            self._request.command(state.seed),
            self._launcher.kind,
            tuple(planned),
            tuple(records),
            tuple(replayed),
            tuple(flaky),
            kept,
            tuple(coverage),
            state.seconds(records, time.time()),
        )

    def _write(self, outcome: Outcome) -> None:
        """Write the reports, the history, last that it is finished: a kill repeats them."""
        write_junit(outcome)
        write_results(outcome)
        # Last of them: it links the others.
        write_report(outcome)
        if self._request.is_whole_nightly:
            append_record(history_record(outcome), outcome.state.started[0], self._request.history)
        write_state(self._folder, replace(outcome.state, finished=True))
