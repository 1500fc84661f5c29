"""Asking software which facets of two meshes collide, and what it takes: our own, and packages.

Our own is the bulk checker, on all facet pairs and behind the broad phase.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from operator import add

import numpy as np

from triaxis.bench.harness import Progress, Summed, clocked
from triaxis.bench.peers.peer import Peer
from triaxis.bench.skipping.scenes import Surfaces
from triaxis.host.broadphase import Work, all_candidates, candidates, in_order
from triaxis.host.engines import Integers
from triaxis.host.scene import bulk_near, near_of

# What a package finds.
BOXES, FACETS = "pairs of boxes", "colliding facets"

# Pairs decided at a time, such that they stay in the processor's cache.
_AT_ONCE = 1 << 14


@dataclass(frozen=True)
class Found:
    """All near pairs of two meshes, (K, 2): (facet of A, of B), in order; what it took to find them.

    ``boxes``: comparisons of two boxes; ``tested``: pairs that were decided by the bulk checker.
    """

    near: Integers
    boxes: int
    tested: int


def all_pairs(a: Integers, b: Integers, margin: int) -> Found:
    """Decide all pairs of facets (N, 3, 3) and (M, 3, 3), coordinates and margin in LSB."""
    numbers, step = np.arange(len(b)), max(1, _AT_ONCE // max(1, len(b)))
    rows = (np.arange(start, min(start + step, len(a))) for start in range(0, len(a), step))
    return _decided(a, b, margin, ((np.repeat(row, len(b)), np.tile(numbers, len(row))) for row in rows))


def behind_boxes(a: Integers, b: Integers, margin: int) -> Found:
    """Decide the pairs that the broad phase leaves; the near ones are the same."""
    work = Work()
    found = _decided(a, b, margin, candidates(a, b, margin, work))
    return replace(found, boxes=work.compared)


def _decided(a: Integers, b: Integers, margin: int, blocks: Iterable[tuple[Integers, Integers]]) -> Found:
    """Decide pairs of facets, given as their numbers (K,) in A and in B, block by block."""
    small = (
        (i[start : start + _AT_ONCE], j[start : start + _AT_ONCE])
        for i, j in blocks
        for start in range(0, len(i), _AT_ONCE)
    )
    tested, near = 0, [np.empty((0, 2), np.int64)]
    for count, found in near_of(small, a, b, np.zeros(3, np.int64), margin, bulk_near):
        tested += count
        near.append(found)
    return Found(np.concatenate(near), 0, tested)


@dataclass(frozen=True)
class Saved(Summed):
    """Seconds of processor time with and without skipping, of pairs of solids, and what was done with it.

    ``right``: both find the near pairs of the golden model.
    """

    seconds_behind_boxes: float = 0.0
    seconds_all_pairs: float = 0.0
    boxes_compared: int = 0
    pairs_tested: int = 0
    right: bool = True


def saved(a: Integers, b: Integers, margin: int, exact: Integers) -> Saved:
    """Measure both in one run; ``exact``: the near pairs (K, 2), in order."""
    skipped, seconds = clocked(lambda: behind_boxes(a, b, margin))
    complete, all_seconds = clocked(lambda: all_pairs(a, b, margin))
    right = all(np.array_equal(in_order(found.near), exact) for found in (skipped, complete))
    return Saved(seconds, all_seconds, skipped.boxes, skipped.tested, right)


@dataclass(frozen=True)
class Meeting:
    """Two meshes, facets (N, 3, 3) and (M, 3, 3) in LSB, and the pairs that collide exactly: (K, 2)."""

    a: Integers
    b: Integers
    near: Integers


@dataclass(frozen=True)
class PeerRun(Summed):
    """What a package did about some pairs of meshes, in all.

    Seconds of processor time: to build its trees, and to ask. Comparisons of two bounding volumes, of two
    triangles; None where it does not tell. ``found``: different pairs that it returned; ``missed``,
    ``extra``: against the exact answer.
    """

    name: str
    build_seconds: float
    ask_seconds: float
    volumes_compared: int | None
    triangles_compared: int | None
    finds: str
    found: int
    missed: int
    extra: int

    @property
    def seconds(self) -> float:
        """Return the time of all of it."""
        return self.build_seconds + self.ask_seconds


def contradictions(where: str, runs: Iterable[PeerRun]) -> list[str]:
    """Return a line for each that compared boxes, which doubles do exactly here, and found others than we."""
    return [
        f"{where}: {run.name} misses {run.missed} pairs of boxes that we find, and finds {run.extra} others"
        for run in runs
        if run.finds == BOXES and run.missed + run.extra > 0
    ]


def ask_peer(peer: Peer, meetings: Sequence[Meeting]) -> PeerRun:
    """Ask a package about all meetings, one after the other."""
    return reduce(add, (_ask(peer, meeting) for meeting in meetings))


def _ask(peer: Peer, meeting: Meeting) -> PeerRun:
    reals = meeting.a.astype(np.float64), meeting.b.astype(np.float64)
    question, build_seconds = clocked(lambda: peer.load(*reals))
    pairs, ask_seconds = clocked(question.ask)
    found, exact = _numbers(pairs, meeting), _numbers(_exact(peer, meeting), meeting)
    return PeerRun(
        peer.name,
        build_seconds,
        ask_seconds,
        *question.count(),
        BOXES if peer.boxes_only else FACETS,
        len(found),
        len(np.setdiff1d(exact, found, assume_unique=True)),
        len(np.setdiff1d(found, exact, assume_unique=True)),
    )


def _exact(peer: Peer, meeting: Meeting) -> Integers:
    return all_candidates(meeting.a, meeting.b, 0) if peer.boxes_only else meeting.near


def _numbers(pairs: Integers, meeting: Meeting) -> Integers:
    """Return a number for each different pair, ascending."""
    return np.unique(pairs[:, 0] * len(meeting.b) + pairs[:, 1])


SIZES = tuple(round(10 ** (decade / 2)) for decade in range(6, 13))

# At most like N^1.2, in comparisons; seconds are shown, of larger meshes, and no verdict depends on them.
MOST_COMPARED = 1.2
_SECONDS_FROM = 9_000
# A package that took longer than this is asked about no larger meshes.
_PATIENCE = 2.0
# Up to this size, all pairs are decided too.
_ALL_PAIRS = 4_000


@dataclass(frozen=True)
class GrowthPoint:
    """One pair of meshes.

    ``facets``: the mean of the two. Seconds of the broad phase alone, and with exact verdicts on what it
    leaves. ``same_as_all_pairs``: the near pairs are those among all pairs; None where too many to try.
    """

    facets: int
    seconds_broad_phase: float
    seconds_with_verdicts: float
    boxes_compared: int
    pairs_left: int
    near: int
    same_as_all_pairs: bool | None
    packages: tuple[PeerRun, ...]


@dataclass(frozen=True)
class Growth:
    """All sizes of one kind of surfaces. Exponents: cost grows like facets to this power."""

    surfaces: Surfaces
    points: tuple[GrowthPoint, ...]

    @property
    def compared_exponent(self) -> float:
        """Return that of comparisons of boxes."""
        return exponent([(point.facets, point.boxes_compared) for point in self.points])

    @property
    def large(self) -> list[GrowthPoint]:
        """Return the meshes whose times are worth a judgement."""
        return [point for point in self.points if point.facets >= _SECONDS_FROM]

    @property
    def seconds_exponent(self) -> float:
        """Return that of the time of the broad phase, for larger meshes where there are such."""
        chosen = self.large if len(self.large) > 1 else self.points
        return exponent([(point.facets, point.seconds_broad_phase) for point in chosen])

    @property
    def problems(self) -> list[str]:
        """Return what is not as it must be, a line each."""
        name = self.surfaces.name
        found: list[str] = []
        for point in self.points:
            where = f"{name}, {point.facets} facets"
            if point.same_as_all_pairs is False:
                found.append(f"{where}: not the near pairs of all pairs")
            found += contradictions(where, point.packages)
        if len(self.points) > 1 and self.compared_exponent > MOST_COMPARED:
            found.append(f"{name}: comparisons grow like N^{self.compared_exponent:.2f}")
        return found


def exponent(points: Sequence[tuple[float, float]]) -> float:
    """Return the slope of the straight line that fits (size, cost) best on logarithmic scales."""
    size, cost = np.log(np.array(points, float)).T
    return float(np.polyfit(size, cost, 1)[0])


def growth_of(
    surfaces: Surfaces, seed: int, peers: Sequence[Peer], progress: Progress, sizes: Sequence[int] = SIZES
) -> Growth:
    """Measure surfaces at all sizes; ``progress`` is told of each."""
    points: list[GrowthPoint] = []
    asked = list(peers)
    for size in sizes:
        a, b = surfaces.make(size, np.random.default_rng([seed, size]))
        point = _point(a, b, asked)
        points.append(point)
        slow = {run.name for run in point.packages if run.seconds > _PATIENCE}
        asked = [peer for peer in asked if peer.name not in slow]
        progress(1)
    return Growth(surfaces, tuple(points))


def _point(a: Integers, b: Integers, peers: Sequence[Peer]) -> GrowthPoint:
    def boxes_alone() -> tuple[Work, int]:
        work = Work()
        return work, sum(len(i) for i, _ in candidates(a, b, 0, work))

    (work, left), seconds = clocked(boxes_alone)
    decided, decided_seconds = clocked(lambda: behind_boxes(a, b, 0))
    near = in_order(decided.near)
    same = None
    if max(len(a), len(b)) <= _ALL_PAIRS:
        same = np.array_equal(near, in_order(all_pairs(a, b, 0).near))
    runs = tuple(ask_peer(peer, [Meeting(a, b, near)]) for peer in peers)
    facets = (len(a) + len(b)) // 2
    return GrowthPoint(facets, seconds, decided_seconds, work.compared, left, len(near), same, runs)
