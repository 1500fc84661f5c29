"""A peer on a workload: its errors, and its time a pair, apart from what a call from Python costs.

That cost is measured on the same call with the second triangle moved far away, which every test of triangles
finds in its first steps; it is taken off, and told. So what is called kernel here is a little less than that.
The bulk checker's time on the same pairs is measured between the rounds of the peer's.
"""

import time
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from triaxis.bench.error.core_points import OnGrid
from triaxis.bench.error.errors import Errors, count_errors
from triaxis.bench.error.own_points import collision_work
from triaxis.bench.error.peers.peer import Peer
from triaxis.bench.error.timing import ROUNDS, best_times
from triaxis.bench.error.truth import Truth
from triaxis.bench.error.workloads import Workload

# Pairs that are timed; all are judged.
TIMED = 4000
# A second triangle moved so far that no pair of any workload meets.
_FAR = np.float32(2**20)


@dataclass(frozen=True)
class PeerPoint:
    """Errors, and nanoseconds a pair: of the whole run, of calls alone, and to make the package's objects.

    ``name``, ``version`` and ``call`` are the peer's. ``bulk_ns``: the bulk checker's, in collision mode on
    the finest grid, on the same pairs in the same rounds. ``noise_ns``: by how much the bests of the first
    and of the second half of the rounds differ, of the run or of the calls.
    """

    name: str
    distribution: str
    version: str
    call: str
    errors: Errors
    run_ns: float
    overhead_ns: float
    load_ns: float
    bulk_ns: float
    noise_ns: float

    @property
    def kernel_ns(self) -> float:
        """Return what is left of the run when calls are taken off."""
        return max(0.0, self.run_ns - self.overhead_ns)

    @property
    def most_kernel_ns(self) -> float | None:
        """Return what the kernel is less than, where noise hides it; None where it does not."""
        return self.kernel_ns + self.noise_ns if self.kernel_ns <= self.noise_ns else None

    @property
    def times_bulk(self) -> float:
        """Return how many times the bulk checker's time that is."""
        return self.kernel_ns / self.bulk_ns


def peer_point(peer: Peer, version: str, workload: Workload, finest: OnGrid, truth: Truth) -> PeerPoint:
    """Return a peer's errors and times on a workload; ``finest``: the same pairs on the finest grid."""
    a, b = workload.a, workload.b
    start = time.perf_counter()
    ask = peer.load(a, b)
    load = time.perf_counter() - start
    errors = count_errors(ask(), truth)
    chosen = timed_rows(len(a))
    run = peer.load(a[chosen], b[chosen])
    # A batch has one call for all of its pairs.
    calls = peer.load(a[:1], b[:1]) if peer.batched else peer.load(a[chosen], b[chosen] + _FAR)
    works = [run, calls, collision_work(finest, chosen)]
    halves = np.array([best_times(works, ROUNDS // 2) for _ in range(2)]) * 1e9 / len(chosen)
    run_ns, calls_ns, bulk_ns = halves.min(0).tolist()
    return PeerPoint(
        peer.name,
        peer.distribution,
        version,
        peer.call,
        errors,
        run_ns,
        calls_ns,
        load * 1e9 / len(a),
        bulk_ns,
        float(np.ptp(halves, axis=0)[:2].max()),
    )


def timed_rows(count: int) -> npt.NDArray[np.int64]:
    """Return which of so many pairs are timed: evenly spread."""
    return np.unique(np.linspace(0, count - 1, min(count, TIMED)).astype(np.int64))
