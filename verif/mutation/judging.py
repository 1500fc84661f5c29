"""What becomes of each mutant of a catalogue: in which order they are tried, on what, and by how long tests.

Short tests first, on each target in turn, mutants of the core beside those of the mesh engine; longer tests
and volume after, for those that survive. Mutants that an earlier run noticed are tried there alone, and
everywhere where that is in vain.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import MappingProxyType

from triaxis.sim.evidence import Timeline
from triaxis.sim.paths import DUT
from triaxis.sim.verilate import MANY
from triaxis.verif.mutation.catalogue import Catalogue, runtime_numbers
from triaxis.verif.mutation.killing import Hunt, Progress, Stage
from triaxis.verif.mutation.mutant import Mutant
from triaxis.verif.mutation.outcomes import Killed, Outcome, Store
from triaxis.verif.mutation.record import Place
from triaxis.verif.mutation.targets import (
    FULL_PIECES,
    SMALLEST,
    TARGETS,
    AnyTarget,
    BoardTarget,
    EngineTarget,
    Target,
)

# Fewer run-time mutants are built one by one: quicker than a build that can hold all.
_FEW = 12
# Times the pairs of a short test, where those close to a decision are wanted.
_LONGER = 8

Steps = list[Callable[[], None]]


def _directed(hunt: Hunt, targets: Sequence[AnyTarget], of_core: bool) -> None:
    """Try all mutants with the short tests: those of the core beside those of the mesh engine."""
    runtime, others = _split(hunt)
    boards = [target for target in targets if isinstance(target, BoardTarget)]
    engines = [t for t in targets if isinstance(t, EngineTarget) and t not in boards]
    cores = [target for target in targets if not isinstance(target, EngineTarget)]

    def selected(target: AnyTarget) -> Callable[[], None]:
        return partial(hunt.selected, Stage(target, target.tests(hunt.seed)), runtime)

    def built(target: AnyTarget) -> Callable[[], None]:
        tests = target.tests(hunt.seed)[: target.quick_tests]
        return partial(hunt.built, Stage(target, tests, False), others)

    # What takes least to build first.
    quick = [replace(target, exact_core=True) for target in engines]
    lanes: list[Steps] = [
        [*map(selected, cores), *map(built, (SMALLEST,) if of_core else ()), *map(built, cores)],
        [*map(selected, engines), *map(built, quick), *map(built, engines)],
        [*map(selected, boards), *map(built, boards)],
    ]
    hunt.beside(lanes, len(lanes))


def _remaining(hunt: Hunt, targets: Sequence[AnyTarget], of_core: bool, volume: bool) -> None:
    """Try the few that are left, on models that take longer to build and with longer tests.

    Most of them survive everything, so little is lost by not waiting for one stage with the next. With volume
    those that are not shown to be equivalent.
    """
    _, others = _split(hunt)
    steps: Steps = []
    for target in targets:
        if not target.combinational:
            stage = Stage(target, target.tests(hunt.seed), speed=target.speed, number=len(steps))
            steps.append(partial(hunt.built, stage, others))
    # Only pairs close to a decision on a long axis show a piece that is cut.
    for target in FULL_PIECES if of_core else ():
        stage = Stage(target, target.tests(hunt.seed, _LONGER), False, "longer", number=len(steps))
        steps.append(partial(hunt.built, stage, others))
    lanes: list[Steps] = [[step] for step in steps]
    # What volume shows in the first configuration of a block, where it is quick, is not asked in the others.
    runtime, others = _split(hunt, hunt.excused)
    for kind in (Target, EngineTarget, BoardTarget) if volume else ():
        lane: Steps = []
        for target in (target for target in targets if type(target) is kind):
            stage = Stage(target, target.volume(hunt.seed), remark="volume", speed=MANY, number=len(steps))
            if stage.tests:
                lane += [partial(hunt.selected, stage, runtime), partial(hunt.built, stage, others)]
        lanes.append(lane)
    hunt.beside(lanes, hunt.jobs)


def _split(hunt: Hunt, excused: frozenset[str] = frozenset()) -> tuple[list[Mutant], list[Mutant]]:
    """Return the mutants that one library holds, and the others."""
    wanted = [one for one in hunt.left if one.id not in excused]
    return [m for m in wanted if m.id in hunt.numbers], [m for m in wanted if m.id not in hunt.numbers]


def judge(
    catalogue: Catalogue,
    seed: int,
    jobs: int,
    timeline: Timeline,
    excused: frozenset[str] = frozenset(),
    dut: Path = DUT,
    targets: tuple[AnyTarget, ...] = TARGETS,
    fresh: bool = False,
    with_volume: bool = True,
    progress: Progress = lambda _: None,
    order: Mapping[str, Place] = MappingProxyType({}),
    settled: Mapping[str, Killed | None] = MappingProxyType({}),
) -> list[Outcome]:
    """Return what becomes of each mutant of a catalogue.

    ``excused``: mutants listed as equivalent, which get one test, and no volume. ``order``: where to try
    mutants first. ``settled``: those that are not played, with how they were killed, if they were. Raises
    InputError where the RTL without a mutant does not pass, or does not build.
    """
    store = Store(catalogue, dut, seed, fresh)
    known = {*store.killed, *store.surviving, *(store.excused & excused), *settled}
    todo = [one for one in catalogue.mutants if one.id not in known]
    progress(len(catalogue.mutants) - len(todo))
    left = catalogue.only({one.id for one in todo})
    numbers = runtime_numbers(left.mutants)
    if len(numbers) <= _FEW:
        numbers = {}
    hunt = Hunt(left, numbers, dut, seed, jobs, store, excused, order, progress, timeline)
    wanted = [target for target in targets if any(target.mutates(one.file) for one in todo)]
    # Whatever ends a long run, what it found out is kept.
    try:
        of_core = any(one.file.startswith("core/") for one in todo)
        for again in (False, True):
            if again:
                hunt.forget_order()
            _directed(hunt, wanted, of_core)
            _remaining(hunt, wanted, of_core, with_volume)
        if with_volume:
            # Those that are excused were tried by one test alone.
            survived = {one.id for one in todo} - store.killed.keys()
            store.surviving |= survived - excused
            store.excused |= survived & excused
    finally:
        store.save()
    progress(sum(one.id not in store.killed for one in todo))
    return [
        Outcome(
            one,
            settled[one.id] if one.id in settled else store.killed.get(one.id),
            tuple(t.name for t in targets if hunt.holds(t, one)),
        )
        for one in catalogue.mutants
    ]
