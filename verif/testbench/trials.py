"""Trials: the same tests on many models of the design, to see which of them a test notices.

A model is a library, and a number where the library holds mutants. The simulator's process forks for each
test, and where the test's run phase begins it forks again for each model that no test has noticed yet. So
every trial is the real test with its sequences, scoreboard and assertions, without a start of the simulator.
It ends at the first failure. What came of it is a line in a file.
"""

import json
import os
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.verif.testbench import failures
from triaxis.verif.testbench.settings import RunSettings, put_into_environment

_VARIABLE = "TRIAXIS_TRIALS"
_PASSED = ""


@dataclass(frozen=True)
class Model:
    """What a trial is of: a name, the library, the number of the mutant that is selected in it.

    ``first``: the test that it meets before all others, "" where that is the first of all.
    """

    name: str
    library: str
    selected: int = 0
    first: str = ""


@dataclass(frozen=True)
class Verdict:
    """What a test said of a model: the symptom, "" where it noticed nothing, and the pairs until then.

    ``trouble``: why it came to no verdict, "" where it did.
    """

    name: str
    test: str
    symptom: str
    pairs: int
    trouble: str = ""


@dataclass(frozen=True)
class Trials:
    """Tests, in the order in which they run, and the models that they run on. ``folder``: of all files."""

    tests: tuple[RunSettings, ...]
    models: tuple[Model, ...]
    folder: Path

    @property
    def results(self) -> Path:
        """Return the file of verdicts: one a line."""
        return self.folder / "verdicts.jsonl"

    @property
    def told(self) -> int:
        """Return the size of that file."""
        return self.results.stat().st_size if self.results.exists() else 0

    def write(self) -> dict[str, str]:
        """Write the plan; return the environment variable that names it."""
        plan = {
            "tests": [asdict(test) for test in self.tests],
            "models": [asdict(one) for one in self.models],
        }
        path = self.folder / "trials.json"
        path.write_text(json.dumps(plan))
        return {_VARIABLE: str(path)}

    @property
    def log(self) -> Path:
        """Return the file with what the last trial said."""
        return self.folder / "trial.log"

    def verdicts(self) -> list[Verdict]:
        """Return all verdicts so far."""
        lines = self.results.read_text().splitlines() if self.results.exists() else []
        return [Verdict(**json.loads(line)) for line in lines]

    @property
    def turns(self) -> list[tuple[RunSettings, tuple[Model, ...]]]:
        """Return the tests in the order in which they run, each with the models that then meet it."""
        early = [(test, tuple(one for one in self.models if one.first == test.test)) for test in self.tests]
        late = [(test, tuple(one for one in self.models if one.first != test.test)) for test in self.tests]
        return [turn for turn in (*early, *late) if turn[1]]

    def unnoticed(self, models: tuple[Model, ...]) -> list[Model]:
        """Return those of some models that no test has noticed so far, nor come to no verdict on."""
        noticed = {verdict.name for verdict in self.verdicts() if verdict.symptom or verdict.trouble}
        return [model for model in models if model.name not in noticed]

    def check(self, log: Path) -> None:
        """Raise InputError unless every test gave a verdict on every model that was left to it."""
        verdicts = {(verdict.name, verdict.test): verdict for verdict in self.verdicts()}
        noticed = {name for (name, _), verdict in verdicts.items() if verdict.symptom}
        for test, models in self.turns:
            for model in models:
                verdict = verdicts.get((model.name, test.test))
                if verdict.trouble if verdict else model.name not in noticed:
                    said = verdict.trouble if verdict else _error_line(log)
                    raise InputError(f"{model.name}: no verdict of {test.test}: {said}")


def _error_line(log: Path) -> str:
    lines = log.read_text(errors="replace").splitlines() if log.exists() else []
    return next((line for line in lines if "ERROR" in line), f"see {log}")


def _planned() -> Trials | None:
    path = os.environ.get(_VARIABLE)
    if not path:
        return None
    plan = json.loads(Path(path).read_text())
    tests = tuple(RunSettings(**test) for test in plan["tests"])
    return Trials(tests, tuple(Model(**model) for model in plan["models"]), Path(path).parent)


def in_trials() -> bool:
    """Return whether this is a process of trials: what is made before the run phase then serves many."""
    return _planned() is not None


# The models that meet the test of this process.
_meeting: tuple[Model, ...] = ()


def next_test(settings: RunSettings) -> RunSettings:
    """Return the settings of the one test to run: those given, or where trials are planned each in turn.

    Returns once in a process for each test; the process that called ends when all have ended.
    """
    trials = _planned()
    if trials is None:
        return settings
    # An interrupt ends all of these processes at once.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    status = 0
    for test, models in trials.turns:
        if not trials.unnoticed(models):
            continue
        child = os.fork()
        if not child:
            global _meeting
            _meeting = models
            put_into_environment(test)
            return test
        status = os.waitpid(child, 0)[1]
        if status:
            break
    os._exit(1 if status else 0)


def next_model(test: str, model: Model) -> Model:
    """Return the model that a test runs on: the one given, or where trials are planned each in turn.

    Returns once in a process for each model; the process that called ends when all have ended.
    """
    trials = _planned()
    if trials is None:
        return model
    for one in trials.unnoticed(_meeting):
        before = trials.told
        child = os.fork()
        if not child:
            _begin(trials, one, test)
            return one
        status = os.waitpid(child, 0)[1]
        if trials.told == before:
            _tell(trials, Verdict(one.name, test, "", 0, f"{_said(status)}: see {trials.log}"))
    os._exit(0)


def _said(status: int) -> str:
    if not os.WIFSIGNALED(status):
        return f"exit status {os.waitstatus_to_exitcode(status)}"
    number = os.WTERMSIG(status)
    if number in (signal.SIGXCPU, signal.SIGKILL):
        return "killed: it had no memory, or no more time of the processor"
    return f"killed by {signal.Signals(number).name}"


def _begin(trials: Trials, model: Model, test: str) -> None:
    """Make this process that of a trial."""
    # Of the last trial alone: assertions report each time.
    os.dup2(os.open(trials.log, os.O_WRONLY | os.O_CREAT | os.O_TRUNC), 1)

    def conclude(symptom: str, pairs: int) -> None:
        _tell(trials, Verdict(model.name, test, symptom, pairs))
        os._exit(0)

    failures.listen(conclude)
    global _trouble

    def give_up(said: str) -> None:
        _tell(trials, Verdict(model.name, test, "", 0, said))

    _trouble = give_up


def _tell(trials: Trials, verdict: Verdict) -> None:
    with trials.results.open("a") as file:
        file.write(json.dumps(asdict(verdict)) + "\n")


def _say(said: str) -> None:
    """Say why the tests cannot run, before any model is tried."""
    os.write(2, f"ERROR {said}\n".encode())


# What a process does that comes to no verdict, before it ends.
_trouble: Callable[[str], None] = _say


@contextmanager
def concluding_trial() -> Iterator[None]:
    """Conclude a trial with the end of its test, or with the error that ends it; do nothing in other runs.

    Only what a test asserts is a verdict. Whatever else ends it speaks of the environment or the machine, and
    ends its process here: that of a simulator which was forked could not end by itself.
    """
    try:
        yield
    except BaseException as raised:
        error = _first_error() or raised
        said = f"{type(error).__name__}: {error}"
        if isinstance(error, AssertionError):
            failures.report_failure(said)
        if _planned() is not None:
            # A full disk must not keep it from ending.
            try:
                _trouble(said)
            finally:
                os._exit(1)
        raise
    failures.report_failure(_PASSED)


def _first_error() -> BaseException | None:
    """Return what ended the test, where that was in a task of its own: the test itself is not told."""
    from cocotb import _test_manager as manager

    running = manager._current_test
    return running.exception() if running else None
