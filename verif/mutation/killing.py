"""Playing mutants in two processes: who is found out, by what, after how many pairs.

Short directed runs first, on each target in turn; volume after, for those that survive.
"""

import multiprocessing
import os
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, ThreadPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.sim.paths import DUT
from triaxis.sim.verilate import FAST, QUICK
from triaxis.verif.mesh.script_stimulus import engine_directed, engine_volume
from triaxis.verif.mesh.scripts import EnginePlay
from triaxis.verif.mutation.builds import (
    AnyPlay,
    ElaborationError,
    Killed,
    Library,
    elaboration_hash,
    schema_library,
    temporary,
    with_mutant_library,
)
from triaxis.verif.mutation.catalogue import Catalogue, runtime_numbers
from triaxis.verif.mutation.mutant import ELABORATION, RUNTIME, Mutant
from triaxis.verif.mutation.outcomes import Outcome, Store
from triaxis.verif.mutation.schema import mutated, write_schema
from triaxis.verif.mutation.stimulus import directed, volume
from triaxis.verif.mutation.targets import (
    FULL_PIECES,
    MAIN,
    SMALLEST,
    TARGETS,
    AnyTarget,
    Elaborated,
    EngineTarget,
    elaborated,
    right_latencies,
)

# Bursts of a mutant's volume on each target; the narrowest model is the fastest.
_BURSTS = {MAIN.name: 32}
_OTHER_BURSTS = 4
# Fewer run-time mutants are built one by one: quicker than a build that can hold all.
_FEW = 12

_PACKAGE = "core/triaxis_pkg.sv"

_SAVED_EVERY = 50
_LONGER = 8


@dataclass(frozen=True)
class Setting:
    """What the processes share: plays and libraries by target, numbers, and the RTL."""

    plays: Mapping[str, Sequence[AnyPlay]]
    libraries: Mapping[str, Path]
    numbers: Mapping[str, int]
    targets: tuple[AnyTarget, ...]
    elaborated: Mapping[str, Elaborated]
    dut: Path
    seed: int
    volume: bool


_setting: Setting | None = None
_loaded: dict[str, Library] = {}


def _start(setting: Setting) -> None:
    global _setting
    _setting = setting
    _loaded.clear()
    # Assertions of a mutant report on the standard output, each time.
    silent = os.open(os.devnull, os.O_WRONLY)
    os.dup2(silent, 1)


def _here() -> Setting:
    assert _setting is not None
    return _setting


def targets_of(mutant: Mutant, setting: Setting) -> list[AnyTarget]:
    """Return the targets that elaborate a mutant."""
    return _where(mutant, setting.targets, setting)


def _where(mutant: Mutant, targets: Sequence[AnyTarget], setting: Setting) -> list[AnyTarget]:
    return [
        target
        for target in targets
        if target.mutates(mutant.file)
        and (mutant.needs < 0 or setting.elaborated[target.name].holds(mutant.file, mutant.needs))
    ]


def _judge(mutant: Mutant) -> Outcome:
    """Play one mutant; runs in a process of the pool."""
    setting, start = _here(), time.perf_counter()
    targets = targets_of(mutant, setting)
    if mutant.id in setting.numbers:
        killed = _selected(mutant, targets, setting)
    else:
        killed = _built(mutant, targets, setting)
    return Outcome(
        mutant, killed, tuple(target.name for target in targets), round(time.perf_counter() - start, 3)
    )


def _selected(mutant: Mutant, targets: Sequence[AnyTarget], setting: Setting) -> Killed | None:
    for target in targets:
        if target.name not in _loaded:
            _loaded[target.name] = Library(setting.libraries[target.name], target)
        killed = _loaded[target.name].play(setting.numbers[mutant.id], setting.plays[target.name])
        if killed:
            return killed
    return None


def _built(mutant: Mutant, targets: Sequence[AnyTarget], setting: Setting) -> Killed | None:
    """Build the mutant by itself and play it: first without assertions, which take longer to build."""
    with mutated(setting.dut, mutant) as folder:
        if mutant.file == _PACKAGE and not right_latencies(folder):
            return Killed("LatencyTable", "every width", "triaxis_pkg", "wrong latency", 0)
        quick = _quick(targets, mutant, setting) if mutant.kind == ELABORATION else []
        for assertions in (False, True) if mutant.kind == ELABORATION else (True,):
            for target in (*targets,) if assertions else (*quick, *targets):
                if not (assertions and _told_before(mutant, target, targets)):
                    killed = _alone(target, folder, setting.plays[target.name], assertions)
                    if killed:
                        return killed
        for target in _where(mutant, FULL_PIECES, setting) if mutant.kind == ELABORATION else ():
            killed = _alone(target, folder, setting.plays[target.name], False)
            if killed:
                return killed
    return None


def _quick(targets: Sequence[AnyTarget], mutant: Mutant, setting: Setting) -> list[AnyTarget]:
    """Return what a mutant is built as first, for it takes least: the smallest core, engines without one."""
    engines = [replace(target, exact_core=True) for target in targets if isinstance(target, EngineTarget)]
    return [*_where(mutant, (SMALLEST,), setting), *engines]


def _told_before(mutant: Mutant, target: AnyTarget, targets: Sequence[AnyTarget]) -> bool:
    """Return whether a target without assertions has no more to tell where assertions are looked at."""
    return not target.assertions and (
        mutant.kind == ELABORATION or (target.combinational and len(targets) > 1)
    )


def _alone(
    target: AnyTarget, folder: Path, plays: Sequence[AnyPlay], assertions: bool, optimise: str = QUICK
) -> Killed | None:
    found: list[Killed | None] = []

    def use(library: Library) -> None:
        found.append(library.play(0, plays))

    original = _original_hash(target, assertions)
    try:
        with_mutant_library(target, folder, use, assertions, optimise, original)
    except ElaborationError as error:
        return Killed("elaboration", "", target.name, _first_line(str(error)), 0)
    # Where the mutant is elaborated to what the original is, nothing can show it.
    return found[0] if found else None


@cache
def _original_hash(target: AnyTarget, assertions: bool) -> str:
    return elaboration_hash(target, _here().dut, assertions)


def _first_line(message: str) -> str:
    """Return an error without the path of the copy in which it was found."""
    line = message.splitlines()[0] if message else "refused"
    words = [word if "/" not in word else word.rpartition("/")[2] for word in line.split()]
    return " ".join(words)[:160]


def _more(mutant: Mutant) -> Outcome:
    """Play the volume to one that survived; runs in a process of the pool."""
    setting, start = _here(), time.perf_counter()
    targets = targets_of(mutant, setting)
    killed = None
    with mutated(setting.dut, mutant) as folder:
        for target in targets:
            plays, optimise = _volume(target)
            killed = _alone(target, folder, plays, mutant.kind == RUNTIME, optimise)
            if killed:
                break
    return Outcome(
        mutant, killed, tuple(target.name for target in targets), round(time.perf_counter() - start, 3)
    )


@cache
def _volume(target: AnyTarget) -> tuple[Sequence[AnyPlay], str]:
    """Return the volume of a target, and how to compile for it."""
    setting = _here()
    if isinstance(target, EngineTarget):
        return measured(target, engine_volume(target.configuration, setting.seed), setting.dut), QUICK
    bursts = _BURSTS.get(target.name, _OTHER_BURSTS)
    return list(volume(target, setting.seed, bursts)), FAST


def measured(target: EngineTarget, plays: Sequence[EnginePlay], dut: Path) -> Sequence[EnginePlay]:
    """Fill in the clocks that the engine without mutants needs; InputError where it breaks the contract."""
    found: list[Killed | None] = []

    with_mutant_library(target, dut, lambda library: found.append(library.play(0, plays)))
    if found[0] is not None:
        wrong = found[0]
        raise InputError(f"{target.name}: {wrong.symptom} in {wrong.test} ({wrong.family}): the RTL is wrong")
    return plays


def _libraries(
    catalogue: Catalogue, numbers: Mapping[str, int], dut: Path, targets: Sequence[AnyTarget], jobs: int
) -> dict[str, Path]:
    def made(target: AnyTarget) -> Path:
        with temporary("dut-") as whole:
            folder = whole / "dut"
            extra = write_schema(catalogue, numbers, dut, folder, target)
            return schema_library(target, folder, extra, max(1, jobs // 2))

    with ThreadPoolExecutor(min(jobs, 2)) as pool:
        return {target.name: path for target, path in zip(targets, pool.map(made, targets), strict=True)}


def judge(
    catalogue: Catalogue,
    seed: int,
    jobs: int,
    pairs: int,
    excused: frozenset[str] = frozenset(),
    dut: Path = DUT,
    targets: tuple[AnyTarget, ...] = TARGETS,
    fresh: bool = False,
    with_volume: bool = True,
    progress: Callable[[int], None] = lambda _: None,
) -> list[Outcome]:
    """Return what becomes of each mutant of a catalogue.

    ``excused``: mutants recorded as equivalent, which get no volume. Raises InputError where the RTL
    without a mutant does not pass, or does not build.
    """
    store = Store(dut, seed, pairs, fresh)
    known = {m.id: outcome for m in catalogue.mutants if (outcome := store.get(m, "directed"))}
    todo = [mutant for mutant in catalogue.mutants if mutant.id not in known]
    progress(len(known))
    targets = _wanted(targets, todo)
    played = (*targets, *_wanted((SMALLEST, *FULL_PIECES), todo))
    plays = _directed(played, todo, seed, pairs, jobs, dut)
    numbers = runtime_numbers(todo)
    if len(numbers) <= _FEW:
        numbers = {}
    libraries: dict[str, Path] = {}
    if numbers:
        libraries = _libraries(catalogue, runtime_numbers(catalogue.mutants), dut, targets, jobs)
        numbers = runtime_numbers(catalogue.mutants)
    setting = Setting(
        plays, libraries, numbers, targets,
        {target.name: elaborated(target, dut) for target in played}, dut, seed, with_volume,
    )  # fmt: skip
    if libraries:
        _check_original(setting)
    # Whatever ends a long run, what it found out is kept.
    try:
        for outcome in _in_processes(_judge, todo, setting, jobs, progress):
            known[outcome.mutant.id] = outcome
            store.put(outcome, "directed")
            if len(known) % _SAVED_EVERY == 0:
                store.save()
    finally:
        store.save()
    survivors = [
        outcome.mutant
        for outcome in known.values()
        if outcome.killed is None and outcome.targets and outcome.mutant.id not in excused
    ]
    if with_volume:
        for mutant in survivors:
            if outcome := store.get(mutant, "volume"):
                known[mutant.id] = outcome
        left = [mutant for mutant in survivors if store.get(mutant, "volume") is None]
        for outcome in _in_processes(_more, left, setting, jobs, lambda _: None):
            known[outcome.mutant.id] = outcome
            store.put(outcome, "volume")
        store.save()
    return [known[mutant.id] for mutant in catalogue.mutants]


def _wanted(targets: Sequence[AnyTarget], mutants: Sequence[Mutant]) -> tuple[AnyTarget, ...]:
    """Return the targets in which some of the mutants are looked for."""
    files = {mutant.file for mutant in mutants}
    return tuple(target for target in targets if any(map(target.mutates, files)))


def _directed(
    targets: Sequence[AnyTarget], mutants: Sequence[Mutant], seed: int, pairs: int, jobs: int, dut: Path
) -> dict[str, Sequence[AnyPlay]]:
    """Return the short plays by target, with all that is expected of them."""
    engines = [target for target in targets if isinstance(target, EngineTarget)]
    with ThreadPoolExecutor(jobs) as pool:
        made = pool.map(
            lambda target: measured(target, engine_directed(target.configuration, seed), dut), engines
        )
        plays: dict[str, Sequence[AnyPlay]] = dict(
            zip((target.name for target in engines), made, strict=True)
        )
    # Only pairs close to a decision on a long axis show a piece that is cut.
    longer = FULL_PIECES if any(mutant.kind == ELABORATION for mutant in mutants) else ()
    for target in targets:
        if not isinstance(target, EngineTarget):
            found = directed(target, seed, _LONGER * pairs if target in longer else pairs)
            # Once, not in each process.
            for play in found:
                _ = play.expected, play.inputs if target.combinational else play.sent
            plays[target.name] = found
    return plays


def _check_original(setting: Setting) -> None:
    """Raise InputError unless the builds with mutants, none selected, answer as they must."""
    with _processes(setting, 1) as pool:
        try:
            wrong = pool.submit(_original).result()
        except BrokenProcessPool as error:
            raise InputError(
                "the builds with mutants crash, none selected: wrong RTL or generator"
            ) from error
    if wrong is not None:
        raise InputError(
            f"{wrong.target}, no mutant selected: {wrong.symptom} in {wrong.test} ({wrong.family}): the RTL "
            "is wrong, or mutants change it unselected"
        )


def _original() -> Killed | None:
    setting = _here()
    for target in setting.targets:
        killed = Library(setting.libraries[target.name], target).play(0, setting.plays[target.name])
        if killed:
            return killed
    return None


def _in_processes(
    work: Callable[[Mutant], Outcome],
    mutants: Sequence[Mutant],
    setting: Setting,
    jobs: int,
    progress: Callable[[int], None],
) -> Iterator[Outcome]:
    if not mutants:
        return
    running: dict[Future[Outcome], Mutant] = {}
    with _processes(setting, jobs) as pool:
        try:
            # No more at a time than there are processes: a process that dies played one of them.
            for mutant in mutants:
                running[pool.submit(work, mutant)] = mutant
                # The last one has none after it: then all are waited for.
                while len(running) == jobs or (mutant is mutants[-1] and running):
                    for future in wait(running, return_when=FIRST_COMPLETED).done:
                        outcome = future.result()
                        del running[future]
                        progress(1)
                        yield outcome
        except BrokenProcessPool as error:
            names = ", ".join(sorted(mutant.id for mutant in running.values()))
            raise InputError(f"a process died that played one of {names}: play each with --mutant") from error


def _processes(setting: Setting, jobs: int) -> ProcessPoolExecutor:
    context = multiprocessing.get_context("fork")
    return ProcessPoolExecutor(jobs, mp_context=context, initializer=_start, initargs=(setting,))
