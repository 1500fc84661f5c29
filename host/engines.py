"""Engines that decide a whole scene at a translation of A: the simulated mesh engine, the bulk checker, the
golden model. The board is one too: see `triaxis.host.link.board_engine`.

All skip exactly the facet pairs that a box axis separates by more than the margin, so their counts of
tested and near pairs agree; only the mesh engine, simulated or on the board, skips whole groups and counts
cycles.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, fields
from itertools import product
from typing import Protocol

import numpy as np
import numpy.typing as npt

from triaxis.golden.bulk import bulk_verdicts
from triaxis.golden.judge import judge_in_parallel
from triaxis.host.broadphase import FacetTrees
from triaxis.host.scene import Decide, FacetPairs, in_order, near_of
from triaxis.sim.core_engine import CoreError
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.mesh_engine import MeshEngine, Mode, Status, spatial_order

RTL, BULK, GOLDEN = "rtl", "bulk", "golden"
ENGINES = (RTL, BULK, GOLDEN)

# Pairs decided at a time: few where the first near one ends it.
_FEW, _MANY = 1 << 9, 1 << 20

Integers = npt.NDArray[np.int64]
# Told of how much more is done.
Progress = Callable[[int], object]
Translation = tuple[int, int, int]
STILL: Translation = (0, 0, 0)


def unwatched(_: int) -> None:
    """Show no progress."""


@dataclass
class Counts:
    """What runs did. Each pair was skipped with its group, skipped by its own boxes, or tested.

    A run that stopped at its first near pair left the others out. ``cycles``: of the mesh engine, without
    loading; ``certified``: tested pairs that are clear and were shown to be, again, by a certified core or by
    the golden model's check of its certificates; None for engines without.
    """

    skipped_in_groups: int = 0
    skipped: int = 0
    tested: int = 0
    near_count: int = 0
    group_pairs_skipped: int = 0
    group_pairs_opened: int = 0
    cycles: int | None = None
    certified: int | None = None

    def add(self, run: "Counts") -> None:
        """Count a run too."""
        for name in (count.name for count in fields(Counts)):
            if (count := getattr(run, name)) is not None:
                setattr(self, name, (getattr(self, name) or 0) + count)


@dataclass
class SceneRun(Counts):
    """One run. ``near`` (K, 2): (facet of A, facet of B), as numbered in the files, in their order."""

    near: FacetPairs = field(default_factory=lambda: np.empty((0, 2), np.int64))


class SceneEngine(Protocol):
    """Two loaded meshes, asked again and again at other translations of A and margins."""

    def run(self, translation: Translation, margin: int, stop_at_first: bool = False) -> SceneRun:
        """Decide all pairs, or go on to the first near one only."""
        ...


class DecidingEngine:
    """The broad phase in NumPy, and a function that decides what is left.

    ``certifies``: that function has a certificate of each clear.
    """

    def __init__(self, a: Integers, b: Integers, decide: Decide, certifies: bool = False) -> None:
        """Take facets of shape (N, 3, 3), on the grid."""
        self._a, self._b, self._decide, self._certifies = a, b, decide, certifies
        self._trees = FacetTrees(a, b)
        # Found near last time: a pose next to that one is likely to have them near too.
        self._last: FacetPairs = np.empty((0, 2), np.int64)

    def run(self, translation: Translation, margin: int, stop_at_first: bool = False) -> SceneRun:
        """Decide all pairs, or those of the pieces to the first with a near one.

        What was near last time is decided first, where one will do, and counted where it is near again.
        """
        run, move = SceneRun(), np.array(translation, np.int64)
        last, found = iter([(self._last[:, 0], self._last[:, 1])]), [run.near]
        if stop_at_first:
            for count, near in self._decided(last, move, margin, _FEW):
                if len(near):
                    run.tested, run.near_count, found = count, len(near), [near]
        blocks = self._trees.candidates(move, margin, in_order=not stop_at_first)
        if not run.near_count:
            for count, near in self._decided(blocks, move, margin, _FEW if stop_at_first else _MANY):
                run.tested += count
                run.near_count += len(near)
                found.append(near)
                if len(near):
                    self._last = near[:_FEW]
                    if stop_at_first:
                        break
        run.skipped = len(self._a) * len(self._b) - run.tested
        run.near = in_order(np.concatenate(found))
        if self._certifies:
            run.certified = run.tested - run.near_count
        return run

    def _decided(
        self, blocks: Iterator[tuple[Integers, Integers]], move: Integers, margin: int, at_once: int
    ) -> Iterator[tuple[int, FacetPairs]]:
        return near_of(blocks, self._a, self._b, move, margin, self._decide, at_once)


def scene_engine(name: str, a: Integers, b: Integers, width: int) -> SceneEngine:
    """Return the engine of that name, one of `ENGINES`, with facets (N, 3, 3) loaded."""
    if name == BULK:
        return DecidingEngine(a, b, bulk_verdicts)
    if name == GOLDEN:
        return DecidingEngine(a, b, judge_in_parallel, certifies=True)
    return MeshEngineScene(a, b, MeshConfiguration(width=width, margin_bits=width, certified=True))


class MeshEngineScene:
    """The simulated mesh engine. Meshes beyond its depth are split, and run part against part."""

    def __init__(self, a: Integers, b: Integers, configuration: MeshConfiguration) -> None:
        """Build the engine where needed and load it with facets (N, 3, 3), in spatial order."""
        self._engine = MeshEngine(configuration)
        self._a, self._b = (parts_of(mesh, configuration.depth, configuration.group) for mesh in (a, b))
        self._loaded: tuple[int, int] | None = None

    def run(self, translation: Translation, margin: int, stop_at_first: bool = False) -> SceneRun:
        """Run each part of A against each part of B; stopped at the first near pair, no further parts."""
        whole = SceneRun()
        found: list[FacetPairs] = []
        for pair in product(range(len(self._a)), range(len(self._b))):
            run = self._run_parts(pair, translation, margin, stop_at_first)
            whole.add(run)
            found.append(run.near)
            if stop_at_first and run.near_count:
                break
        whole.near = in_order(np.concatenate(found))
        return whole

    def _run_parts(
        self, pair: tuple[int, int], translation: Translation, margin: int, stop_at_first: bool
    ) -> SceneRun:
        a, b = self._a[pair[0]], self._b[pair[1]]
        if pair != self._loaded:
            self._engine.load(a.facets, b.facets)
            self._loaded = pair
        run = self._engine.run(translation, margin, Mode.FIRST if stop_at_first else Mode.ALL)
        complete = run.status == Status.COMPLETE
        if not complete and not (stop_at_first and run.status == Status.FIRST):
            raise CoreError(f"mesh engine: status {run.status.name} at translation {translation}")
        groups_a, groups_b = (-(-len(part.facets) // self._engine.configuration.group) for part in (a, b))
        decided = run.group_pairs_skipped + run.group_pairs_opened
        if complete and decided != groups_a * groups_b:
            raise CoreError(f"mesh engine: {decided} of {groups_a * groups_b} pairs of groups decided")
        near = np.stack([a.numbers[run.near[:, 0]], b.numbers[run.near[:, 1]]], 1)
        opened = run.pairs_skipped + run.tested
        return SceneRun(
            len(a.facets) * len(b.facets) - opened if complete else 0,
            run.pairs_skipped, run.tested, run.near_count, run.group_pairs_skipped, run.group_pairs_opened,
            run.cycles, run.tested - run.near_count if self._engine.configuration.certified else None, near,
        )  # fmt: skip


@dataclass(frozen=True)
class Part:
    """Facets (N, 3, 3) in the order in which they are loaded, and their numbers in the file (N,)."""

    facets: Integers
    numbers: Integers


def parts_of(facets: Integers, depth: int, group: int) -> list[Part]:
    """Return facets (N, 3, 3) as the engine is given them: so many at a time, in spatial order."""
    order = spatial_order(facets, group)
    pieces = (order[start : start + depth] for start in range(0, len(order), depth))
    return [Part(facets[piece], piece) for piece in pieces]
