"""Engines that decide a whole scene at a translation of A: the simulated mesh engine, the bulk checker, the
golden model. The board is one too: see `triaxis.host.link.board_engine`.

All skip exactly the facet pairs that a box axis separates by more than the margin, so their counts of
tested and near pairs agree; only the mesh engine, simulated or on the board, skips whole groups and counts
cycles.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field, fields
from itertools import product

import numpy as np
import numpy.typing as npt

from triaxis.golden.judge import judge_in_parallel
from triaxis.golden.pairs import Pairs
from triaxis.host.broadphase import FacetTrees, in_order
from triaxis.host.group_pairs import group_pair_sizes, have_pairs
from triaxis.host.scene import Decide, FacetPairs, bulk_near, near_of
from triaxis.sim.core_engine import CoreError
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.mesh_engine import MeshEngine, Mode, Status, spatial_order

RTL, BULK, GOLDEN = "rtl", "bulk", "golden"
ENGINES = (RTL, BULK, GOLDEN)

# Pairs that are kept as likely to be near next time.
_LAST = 1 << 7
# Pairs decided at a time where the first near one ends it, by others than the bulk checker.
_FEW = 1 << 9

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


NO_PAIRS: FacetPairs = np.empty((0, 2), np.int64)


class SceneEngine(ABC):
    """Two loaded meshes, asked again and again at other translations of A and margins."""

    @abstractmethod
    def run(self, translation: Translation, margin: int, stop_at_first: bool = False) -> SceneRun:
        """Decide all pairs, or go on to the first near one only."""

    def first_near(self, translation: Translation, margin: int, likely: FacetPairs) -> SceneRun:
        """Go on to a first near pair; ``likely`` (K, 2) are facet pairs that may well be."""
        del likely
        return self.run(translation, margin, stop_at_first=True)


class DecidingEngine(SceneEngine):
    """The broad phase, and a function that decides what is left.

    ``certifies``: that function has a certificate of each clear.
    """

    # Pairs decided at a time: many, as the golden model starts processes for them.
    _at_once = 1 << 20

    def __init__(self, a: Integers, b: Integers, decide: Decide, certifies: bool = False) -> None:
        """Take facets of shape (N, 3, 3), on the grid."""
        self._a, self._b, self._decide, self._certifies = a, b, decide, certifies
        self._trees = FacetTrees(a, b)
        # Found near last time: a pose next to that one is likely to have them near too.
        self._last = NO_PAIRS

    def run(self, translation: Translation, margin: int, stop_at_first: bool = False) -> SceneRun:
        """Decide all pairs, or do as `first_near`."""
        if stop_at_first:
            return self.first_near(translation, margin, NO_PAIRS)
        run, move = SceneRun(), np.array(translation, np.int64)
        found, blocks = [NO_PAIRS], self._trees.candidates(move, margin, block=self._at_once)
        for count, near in near_of(blocks, self._a, self._b, move, margin, self._decide):
            run.tested += count
            found.append(near)
        run.near = np.concatenate(found)
        return self._counted(run)

    def first_near(self, translation: Translation, margin: int, likely: FacetPairs) -> SceneRun:
        """Decide what is likely, or where nothing is said to be, what was near last time; then all."""
        run, move = SceneRun(), np.array(translation, np.int64)
        run.near, run.tested = self._first_near(move, margin, likely if len(likely) else self._last)
        return self._counted(run)

    def _first_near(self, move: Integers, margin: int, likely: FacetPairs) -> tuple[FacetPairs, int]:
        """Return what `FacetTrees.first_near` does."""
        before = iter([(likely[:, 0], likely[:, 1])] if len(likely) else ())
        for blocks in (before, self._trees.candidates(move, margin, block=_FEW)):
            tested = 0
            for count, near in near_of(blocks, self._a, self._b, move, margin, self._decide):
                tested += count
                if len(near):
                    return near, tested
        return NO_PAIRS, tested

    def _counted(self, run: SceneRun) -> SceneRun:
        run.near, run.near_count = in_order(run.near), len(run.near)
        self._last = some_of(run.near, _LAST) if len(run.near) else self._last
        run.skipped = len(self._a) * len(self._b) - run.tested
        if self._certifies:
            run.certified = run.tested - run.near_count
        return run


def some_of(pairs: FacetPairs, most: int) -> FacetPairs:
    """Return at most so many facet pairs (K, 2) of K, from all over them."""
    return pairs[:: max(1, -(-len(pairs) // most))]


class BulkEngine(DecidingEngine):
    """The broad phase and the bulk checker."""

    # They stay in the processor's cache.
    _at_once = 1 << 14

    def __init__(self, a: Integers, b: Integers) -> None:
        """Take facets of shape (N, 3, 3), on the grid."""
        super().__init__(a, b, bulk_near)

    def _first_near(self, move: Integers, margin: int, likely: FacetPairs) -> tuple[FacetPairs, int]:
        return self._trees.first_near(move, margin, likely)


def _near_with_certificates(pairs: Pairs, margins: Integers) -> npt.NDArray[np.bool_]:
    return judge_in_parallel(pairs, margins)["near"]


def scene_engine(name: str, a: Integers, b: Integers, width: int) -> SceneEngine:
    """Return the engine of that name, one of `ENGINES`, with facets (N, 3, 3) loaded."""
    if name == BULK:
        return BulkEngine(a, b)
    if name == GOLDEN:
        return DecidingEngine(a, b, _near_with_certificates, certifies=True)
    return MeshEngineScene(a, b, MeshConfiguration(width=width, margin_bits=width, certified=True))


class MeshEngineScene(SceneEngine):
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
        if not run.near_count == len(run.near) <= run.tested:
            told = f"{run.near_count} near pairs of {run.tested} tested, tells of {len(run.near)}"
            raise CoreError(f"mesh engine: counts {told}")
        sizes = group_pair_sizes(len(a.facets), len(b.facets), self._engine.configuration.group)
        decided, group_pairs = run.group_pairs_skipped + run.group_pairs_opened, sum(n for _, n in sizes)
        if complete and decided != group_pairs:
            raise CoreError(f"mesh engine: {decided} of {group_pairs} pairs of groups decided")
        opened, groups = run.pairs_skipped + run.tested, run.group_pairs_opened
        if complete and not have_pairs(groups, opened, sizes):
            raise CoreError(f"mesh engine: {opened} pairs in {groups} pairs of groups decided")
        near = np.stack([a.numbers[run.near[:, 0]], b.numbers[run.near[:, 1]]], 1)
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
