"""Engines that decide a whole scene at a translation of A: the simulated mesh engine, the bulk checker, the
golden model. The board is one too: see `triaxis.host.link.board_engine`.

All skip exactly the facet pairs that a box axis separates by more than the margin, so their counts of
tested and near pairs agree; only the mesh engine, simulated or on the board, skips whole groups and counts
cycles.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, fields
from itertools import product

import numpy as np
import numpy.typing as npt

from triaxis.golden.judge import judge_in_parallel
from triaxis.golden.pairs import Pairs
from triaxis.host.broadphase import FacetTrees, Meetings, Poses
from triaxis.host.scene import Decide, FacetPairs, bulk_near, in_order, near_of
from triaxis.sim.core_engine import CoreError
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.mesh_engine import MeshEngine, Mode, Status, spatial_order

RTL, BULK, GOLDEN = "rtl", "bulk", "golden"
ENGINES = (RTL, BULK, GOLDEN)

# Pairs decided at a time: few, for each pose, where the first near one ends it.
_FEW, _SOME, _MANY = 1 << 9, 1 << 14, 1 << 20
# Pairs of nodes that are followed at a pose in search of a near one, before it is all of them.
_EVER_MORE = (1 << 6, 1 << 10, 1 << 14)
# Of these, at all poses at a time.
_NODES = 1 << 18
# Pairs that are kept as likely to be near next time.
_LAST = 1 << 7
# Poses that the bulk checker is asked about at a time, along a path.
_POSES = 64

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


@dataclass(frozen=True)
class Question:
    """Is anything near at a translation of A? ``likely`` (K, 2): facet pairs that may well be."""

    translation: Translation
    margin: int
    likely: FacetPairs


class SceneEngine(ABC):
    """Two loaded meshes, asked again and again at other translations of A and margins.

    ``at_once``: how many poses are worth asking about in one pass, where some may turn out to be of no use.
    """

    at_once = 1

    @abstractmethod
    def run(self, translation: Translation, margin: int, stop_at_first: bool = False) -> SceneRun:
        """Decide all pairs, or go on to the first near one only."""

    def first_near(self, asked: Sequence[Question]) -> list[SceneRun]:
        """Go on to a first near pair for each question."""
        return [self.run(one.translation, one.margin, stop_at_first=True) for one in asked]


class DecidingEngine(SceneEngine):
    """The broad phase in NumPy, and a function that decides what is left.

    ``certifies``: that function has a certificate of each clear.
    """

    def __init__(
        self, a: Integers, b: Integers, decide: Decide, certifies: bool = False, at_once: int = 1
    ) -> None:
        """Take facets of shape (N, 3, 3), on the grid."""
        self._a, self._b, self._decide, self._certifies = a, b, decide, certifies
        self.at_once = at_once
        self._trees = FacetTrees(a, b)
        # Found near last time: a pose next to that one is likely to have them near too.
        self._last = NO_PAIRS

    def run(self, translation: Translation, margin: int, stop_at_first: bool = False) -> SceneRun:
        """Decide all pairs, or do as `first_near`."""
        if stop_at_first:
            [run] = self.first_near([Question(translation, margin, NO_PAIRS)])
            return run
        run, move = SceneRun(), np.array(translation, np.int64)
        found, blocks = [run.near], self._trees.candidates(move, margin)
        for count, near in near_of(blocks, self._a, self._b, move, margin, self._decide, _MANY):
            run.tested += count
            found.append(near)
        run.near = in_order(np.concatenate(found))
        self._last = some_of(run.near, _LAST) if len(run.near) else self._last
        return self._counted(run)

    def first_near(self, asked: Sequence[Question]) -> list[SceneRun]:
        """Decide pairs at each of some poses until some are near.

        What is likely comes first; where nothing is said to be, what was near last time. Then come those
        whose boxes overlap by most, ever more of them, until they are all there are.
        """
        runs, left = [SceneRun() for _ in asked], np.arange(len(asked))
        poses = Poses(
            np.array([one.translation for one in asked], np.int64).reshape(-1, 3),
            np.array([one.margin for one in asked], np.int64),
        )
        likely = [one.likely if len(one.likely) else self._last for one in asked]
        first = np.concatenate(likely)
        self._decided(runs, poses, [(np.repeat(left, [*map(len, likely)]), first[:, 0], first[:, 1])])
        left = _without_near(runs, left)
        for most in _EVER_MORE:
            left = self._undecided(runs, poses, left, most)
        for number in left:
            blocks = self._trees.candidates(poses.moves[number], int(poses.margins[number]), in_order=False)
            self._decided(runs, poses, ((np.full(len(i), number), i, j) for i, j in blocks), [number])
        if len(near := next((run.near for run in reversed(runs) if len(run.near)), NO_PAIRS)):
            self._last = some_of(near, _LAST)
        return [self._counted(run) for run in runs]

    def _undecided(self, runs: Sequence[SceneRun], poses: Poses, left: Integers, most: int) -> Integers:
        """Decide so many pairs at each pose that is left; return where there are more, and none was near."""
        still = [left[:0]]
        together = max(1, _NODES // most)
        for some in (left[start : start + together] for start in range(0, len(left), together)):
            (pose, i, j), complete = self._trees.some(poses[some], most)
            self._decided(runs, poses, [(some[pose], i, j)], some)
            still.append(_without_near(runs, some[~complete]))
        return np.concatenate(still)

    def _decided(
        self, runs: Sequence[SceneRun], poses: Poses, blocks: Iterable[Meetings], anew: Iterable[int] = ()
    ) -> None:
        """Decide facet pairs at poses, piece by piece, but for poses of which a piece had near ones.

        ``anew``: poses whose pairs that were decided before are among these, and are counted here.
        """
        for number in anew:
            runs[number].tested = 0
        undecided = np.ones(len(runs), bool)
        at_once = min(_FEW * len(runs), _SOME)
        for block in blocks:
            for start in range(0, len(block[0]), at_once):
                pose, i, j = (numbers[start : start + at_once] for numbers in block)
                if not (asked := undecided[pose]).all():
                    pose, i, j = pose[asked], i[asked], j[asked]
                pairs = np.stack([self._a[i] + poses.moves[pose][:, None], self._b[j]], 1)
                near = np.flatnonzero(self._decide(pairs, poses.margins[pose]))
                for number, count in enumerate(np.bincount(pose, minlength=len(runs)).tolist()):
                    runs[number].tested += count
                for number in np.unique(pose[near]).tolist():
                    here = near[pose[near] == number]
                    runs[number].near = in_order(np.stack([i[here], j[here]], 1))
                    undecided[number] = False
            if not undecided.any():
                return

    def _counted(self, run: SceneRun) -> SceneRun:
        run.near_count = len(run.near)
        run.skipped = len(self._a) * len(self._b) - run.tested
        if self._certifies:
            run.certified = run.tested - run.near_count
        return run


def _without_near(runs: Sequence[SceneRun], numbers: Integers) -> Integers:
    return numbers[np.array([not len(runs[number].near) for number in numbers], bool)]


def some_of(pairs: FacetPairs, most: int) -> FacetPairs:
    """Return at most so many facet pairs (K, 2) of K, from all over them."""
    return pairs[:: max(1, -(-len(pairs) // most))]


def _near_with_certificates(pairs: Pairs, margins: Integers) -> npt.NDArray[np.bool_]:
    return judge_in_parallel(pairs, margins)["near"]


def scene_engine(name: str, a: Integers, b: Integers, width: int) -> SceneEngine:
    """Return the engine of that name, one of `ENGINES`, with facets (N, 3, 3) loaded."""
    if name == BULK:
        return DecidingEngine(a, b, bulk_near, at_once=_POSES)
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
