"""Mutants under the environment's own tests: which test notices which mutant, after how many pairs.

All run-time mutants of a target are in one library; what is fixed at elaboration needs a library for each.
Either is tried by `run_trials`, test by test, until a test fails.
"""

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import as_completed
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import mkdtemp
from threading import BoundedSemaphore, Event, Lock

from triaxis.golden.errors import InputError
from triaxis.golden.processes import results_in_processes, threads
from triaxis.sim.evidence import Timeline
from triaxis.sim.verilate import QUICK
from triaxis.verif.core.detector_check import first_wrong
from triaxis.verif.mutation.builds import (
    ElaborationError,
    elaboration_hash,
    mutant_library,
    schema_library,
    temporary,
)
from triaxis.verif.mutation.catalogue import Catalogue
from triaxis.verif.mutation.mutant import Mutant
from triaxis.verif.mutation.outcomes import Killed, Store
from triaxis.verif.mutation.record import Place
from triaxis.verif.mutation.schema import mutated, write_schema
from triaxis.verif.mutation.targets import (
    AnyTarget,
    EngineTarget,
    elaborated,
    right_package,
)
from triaxis.verif.testbench.settings import RunSettings
from triaxis.verif.testbench.simulation import run_trials
from triaxis.verif.testbench.trials import Model, Trials, Verdict

# Mutants with a library of their own that a stage tries at a time: that many libraries are on the disk.
_AT_A_TIME = 72
_OF_ALL_KINDS = ("MixedTest", "MeshRandomTest", "BoardMixedTest")
# A model without a mutant, which every test must pass.
_ORIGINAL = "no mutant"

Progress = Callable[[int], None]


@dataclass(frozen=True)
class Stage:
    """One way in which mutants that are left are tried: a target, with assertions or not, and tests.

    ``remark``: what is special about the tests, for the timeline. ``speed``: of libraries with one mutant.
    ``number``: of stages that go on at a time and notice the same mutant the one with the lowest is named.
    """

    target: AnyTarget
    tests: tuple[RunSettings, ...]
    assertions: bool = True
    remark: str = ""
    speed: str = QUICK
    number: int = 0

    @property
    def name(self) -> str:
        """Return the target, and what is special about it here."""
        exact = isinstance(self.target, EngineTarget) and self.target.exact_core
        marks = {
            "exact core": exact,
            "assertions": self.assertions and not self.target.combinational,
            self.remark: self.remark,
        }
        return ", ".join([self.target.name, *(mark for mark, holds in marks.items() if holds)])

    def library(self, dut: Path, folder: Path, unless: str = "") -> Path | None:
        """Return a library of the RTL in a folder; None where it is elaborated to what ``unless`` names."""
        return mutant_library(self.target, dut, folder, self.assertions, unless, self.speed)


class Hunt:
    """Tries mutants stage by stage; knows what became of them so far."""

    def __init__(
        self, catalogue: Catalogue, numbers: Mapping[str, int], dut: Path, seed: int, jobs: int,
        store: Store, excused: frozenset[str], order: Mapping[str, Place], progress: Progress,
        timeline: Timeline,
    ) -> None:  # fmt: skip
        """Know what the store knows. ``numbers``: of the mutants that are tried in one library; ``order``:
        where some of them are tried, and nowhere else until `forget_order`.
        """
        self.excused, self.timeline = excused, timeline
        self.left = [one for one in catalogue.mutants if one.id not in store.killed]
        self._order = order
        self._trials: Counter[str] = Counter()
        self.catalogue, self.numbers, self.dut, self.seed, self.jobs = catalogue, numbers, dut, seed, jobs
        self.store, self.killed, self._progress = store, store.killed, progress
        self._elaborated: dict[str, frozenset[tuple[str, int]]] = {}
        self._libraries: dict[str, Path] = {}
        self._tried: set[tuple[str, str]] = set()
        # Compilers and simulators at a time, of all stages that go on.
        self._slots = BoundedSemaphore(jobs)
        # Nothing more is tried: something went wrong, or the run was interrupted.
        self._ended = Event()
        self._noticed_by: dict[str, int] = {}
        self._noticing = Lock()

    def holds(self, target: AnyTarget, mutant: Mutant) -> bool:
        """Return whether a target elaborates a mutant."""
        if not target.mutates(mutant.file):
            return False
        if target.name not in self._elaborated:
            self._elaborated[target.name] = elaborated(target, self.dut)
        return mutant.needs < 0 or (mutant.file, mutant.needs) in self._elaborated[target.name]

    def forget_order(self) -> None:
        """Leave those that were tried in one place alone, in vain, to all that there are."""
        self.left = [one for one in self.left if one.id in self._order and one.id not in self.killed]
        self._order = {}

    def alive(self, stage: Stage, mutants: Iterable[Mutant]) -> list[Mutant]:
        """Return those that a stage is to try: its target elaborates them, and nothing has noticed them."""
        return [
            one
            for one in mutants
            if one.id not in self.killed
            and (one.id not in self._order or self._order[one.id].stage == stage.name)
            and self.holds(stage.target, one)
        ]

    def _model(self, mutant: str, library: Path, selected: int = 0) -> Model:
        place = self._order.get(mutant)
        return Model(mutant, str(library), selected, place.test if place else "")

    def beside(self, lanes: Iterable[Iterable[Callable[[], None]]], at_once: int) -> None:
        """Do what is in each lane in its order, so many lanes at a time: one alone keeps all processors busy
        only while it has much to try.
        """

        def run(lane: Iterable[Callable[[], None]]) -> None:
            for step in lane:
                if self._ended.is_set():
                    return
                step()

        with threads(at_once) as pool:
            try:
                for done in as_completed([pool.submit(run, lane) for lane in lanes]):
                    done.result()
            except BaseException:
                self._ended.set()
                raise

    def selected(self, stage: Stage, mutants: Sequence[Mutant]) -> None:
        """Try run-time mutants, all in one library."""
        alive = self.alive(stage, mutants)
        if not alive:
            return
        library = self._library(stage.target)
        models = [self._model(mutant.id, library, self.numbers[mutant.id]) for mutant in alive]
        original = Model(_ORIGINAL, str(library))
        with self.timeline.span(f"{stage.name}: {len(alive)} in one library"):
            self._try(stage, models, original, set(), beside=True)

    def built(self, stage: Stage, mutants: Sequence[Mutant]) -> None:
        """Try mutants that need a library each; one that is elaborated to what the original is needs none.

        For those that are shown to be equivalent the evidence is a proof, made in the same run; to try them
        holds the proof against something else, and once in each configuration is enough for that. What a
        configuration is built with besides, the core or what stands in for it, or assertions, is no part of
        what is proved.
        """
        alive = [one for one in self.alive(stage, mutants) if (one.id, stage.target.name) not in self._tried]
        if not alive:
            return
        self._tried |= {(one.id, stage.target.name) for one in alive if one.id in self.excused}
        with self.timeline.span(f"{stage.name}: {len(alive)} built"):
            self._build(stage, alive)

    def _build(self, stage: Stage, alive: Sequence[Mutant]) -> None:
        original = elaboration_hash(stage.target, self.dut, stage.assertions)
        with temporary() as whole, threads(self.jobs) as pool:
            healthy = Model(_ORIGINAL, str(stage.library(self.dut, whole / "original")))
            passed: set[str] = set()
            for start in range(0, len(alive), _AT_A_TIME):
                if self._ended.is_set():
                    return
                with temporary() as folder:
                    jobs = [
                        pool.submit(self._own_library, stage, mutant, original, folder / str(number))
                        for number, mutant in enumerate(alive[start : start + _AT_A_TIME])
                    ]
                    models = [model for job in jobs if (model := job.result())]
                    self._try(stage, models, healthy, passed)

    def _own_library(self, stage: Stage, mutant: Mutant, original: str, folder: Path) -> Model | None:
        if self._ended.is_set():
            return None
        with self._slots, mutated(self.dut, mutant) as dut:
            if not right_package(dut, mutant.file):
                self._notice(
                    mutant.id, Killed("right_package", Path(mutant.file).stem, "wrong value", 0), stage
                )
                return None
            try:
                library = stage.library(dut, folder, original)
            except ElaborationError as error:
                said = _first_line(str(error))
                self._notice(mutant.id, Killed("elaboration", stage.target.name, said, 0), stage)
                return None
        if library is None:
            # As good as a trial in vain: it took a run of Verilator.
            self._trials[mutant.id] += 1
            return None
        return self._model(mutant.id, library)

    def _library(self, target: AnyTarget) -> Path:
        if target.name not in self._libraries:
            with self.timeline.span(f"{target.name}: library built"), temporary() as whole:
                extra = write_schema(self.catalogue, self.numbers, self.dut, whole / "dut", target)
                self._libraries[target.name] = schema_library(target, whole / "dut", extra, self.jobs)
        return self._libraries[target.name]

    def _notice(self, name: str, killed: Killed, stage: Stage) -> None:
        if name == _ORIGINAL:
            raise InputError(
                f"{killed.target}, no mutant selected: {killed.symptom} in {killed.test}: the RTL is wrong, "
                "or mutants change it unselected"
            )
        with self._noticing:
            known = name in self.killed
            if not known or stage.number < self._noticed_by.get(name, 0):
                self.killed[name] = replace(killed, stage=stage.name, trial=self._trials[name] + 1)
                self._noticed_by[name] = stage.number
            if not known:
                self._progress(1)

    def _try(
        self, stage: Stage, models: Sequence[Model], original: Model, passed: set[str], beside: bool = False
    ) -> None:
        """Let the tests run on the models, in as many simulators as there are jobs.

        What a test notices counts where the original passes it. ``passed``: the tests of which that is known.
        The original runs ``beside`` the models, or, with the others that notice something, afterwards: on a
        slow model those are few of all tests.
        """
        if self._ended.is_set():
            return
        if stage.target.combinational:
            self._ask_wrapper(stage, [original, *models])
            return
        # Those that are shown to be equivalent are tried all the same, but by one test.
        excused = [model for model in models if model.name in self.excused]
        others = [model for model in models if model.name not in self.excused]
        brief = tuple(test for test in stage.tests if test.test in _OF_ALL_KINDS) or stage.tests
        shares = [([original] if beside else [], stage.tests)]
        shares += [(others[number :: self.jobs], stage.tests) for number in range(self.jobs)]
        with temporary() as folder:
            verdicts: list[Verdict] = []
            # Whatever ends a long run, what it found out is kept.
            try:
                self._simulate(folder, [*shares, (excused, brief)], verdicts)
                noticing = {verdict.test for verdict in verdicts if verdict.symptom} - passed
                tests = tuple(test for test in stage.tests if test.test in noticing and not beside)
                self._simulate(folder, [([original], tests)] if tests else [], verdicts)
                self._note(stage, [verdict for verdict in verdicts if verdict.name == _ORIGINAL])
            finally:
                of_original = [one for one in verdicts if one.name == _ORIGINAL]
                passed |= {one.test for one in of_original if not (one.symptom or one.trouble)}
                self._note(stage, [one for one in verdicts if one.test in passed or not one.symptom])
                self.store.save()

    def _note(self, stage: Stage, verdicts: Iterable[Verdict]) -> None:
        for verdict in verdicts:
            if verdict.symptom:
                said, name = _first_line(verdict.symptom), stage.target.name
                self._notice(verdict.name, Killed(verdict.test, name, said, verdict.pairs), stage)
            else:
                self._trials[verdict.name] += 1

    def _simulate(
        self, folder: Path, shares: Sequence[tuple[list[Model], tuple[RunSettings, ...]]],
        verdicts: list[Verdict],
    ) -> None:  # fmt: skip
        """Run each share of the models with its tests; add what came of it, whatever ends this."""
        trials: list[Trials] = []
        for share, tests in shares:
            if share:
                place = Path(mkdtemp(dir=folder))
                there = tuple(replace(test, folder=str(place)) for test in tests)
                trials.append(Trials(there, tuple(share), place))
        try:
            with threads(self.jobs) as pool:
                list(pool.map(self._run, trials))
        finally:
            verdicts += [verdict for done in trials for verdict in done.verdicts()]

    def _run(self, trials: Trials) -> None:
        with self._slots:
            run_trials(trials)

    def _ask_wrapper(self, stage: Stage, models: Sequence[Model]) -> None:
        width = stage.target.configuration.width
        asked = [(self.seed, width, Path(model.library), model.selected) for model in models]
        with closing(results_in_processes(_first_wrong, asked, self.jobs)) as answers:
            for model, pairs in zip(models, answers, strict=True):
                if pairs:
                    killed = Killed("check_detector", stage.target.name, "wrong answer", pairs)
                    self._notice(model.name, killed, stage)


def _first_wrong(asked: tuple[int, int, Path, int]) -> int | None:
    return first_wrong(*asked)


def _first_line(message: str) -> str:
    """Return an error without the path of the copy in which it was found."""
    line = message.splitlines()[0] if message else "refused"
    words = [word if "/" not in word else word.rpartition("/")[2] for word in line.split()]
    return " ".join(words)[:160]
