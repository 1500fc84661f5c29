"""How the cost of the broad phase, and of other packages, grows with meshes of 10^3 to 10^6 facets."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from triaxis.bench.harness import Progress, clocked
from triaxis.bench.peers.peer import Peer
from triaxis.bench.skipping.scenes import Surfaces
from triaxis.bench.skipping.software import (
    Meeting,
    PeerRun,
    all_pairs,
    ask_peer,
    behind_boxes,
    contradictions,
)
from triaxis.host.broadphase import Work, candidates
from triaxis.host.engines import Integers
from triaxis.host.scene import in_order

SIZES = tuple(round(10 ** (decade / 2)) for decade in range(6, 13))

# At most like N^1.2 in comparisons; in seconds, of larger meshes, caches and the machine's noise come on top.
MOST_COMPARED, MOST_SECONDS = 1.2, 1.3
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
        if len(self.large) > 1 and self.seconds_exponent > MOST_SECONDS:
            found.append(f"{name}: seconds grow like N^{self.seconds_exponent:.2f}")
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
