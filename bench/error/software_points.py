"""Run times of software on a workload, in one thread: the bulk checker, the golden model, other packages.

What a call of a package from Python costs is measured on the same call with the second triangle moved far
away, which every test of triangles finds in its first steps; it is taken off, and told. So what is called
kernel here is a little less than that. The bulk checker's time on the same pairs is measured between the
rounds of the package's.
"""

from dataclasses import dataclass

import numpy as np

from triaxis.bench.error.points import Errors, OnGrid, count_errors, margins_of, spread_rows
from triaxis.bench.error.truth import Truth, exact_triangle
from triaxis.bench.error.workloads import Workload
from triaxis.bench.harness import ROUNDS, best_times, clocked
from triaxis.bench.peers.peer import Peer
from triaxis.golden.bulk import bulk_claims, bulk_facts
from triaxis.golden.certificate import claims_prove_clear
from triaxis.golden.judge import judge
from triaxis.golden.pairs import NO_AXIS

# Pairs of the golden model, at some 200 microseconds each.
_JUDGED = 400
_GOLDEN_ROUNDS = 3


@dataclass(frozen=True)
class BulkPoint:
    """Nanoseconds a pair at one width and margin: of verdicts with axes alone, and of all facts for coverage.

    ``clear``: pairs that it calls clear; ``unproven``: those of them whose axis does not separate them by
    `claims_prove_clear`, which shares nothing with it. ``differs``: pairs on which the two disagree.
    """

    width: int
    mode: str
    claims_ns: float
    facts_ns: float
    clear: int
    unproven: int
    differs: int


def bulk_point(rounded: OnGrid, width: int, mode: str) -> BulkPoint:
    """Return the bulk checker's times on a workload, and whether its axes prove what they claim."""
    pairs = np.ascontiguousarray(rounded.pairs, np.int32)
    margins = margins_of(rounded, mode).astype(np.uint32)
    claims_s, facts_s = best_times([lambda: bulk_claims(pairs, margins), lambda: bulk_facts(pairs, margins)])
    claims = bulk_claims(pairs, margins)
    clear = claims != NO_AXIS
    proven = claims_prove_clear(pairs[clear], margins[clear], claims[clear])
    each = 1e9 / len(pairs)
    differs = int((claims != bulk_facts(pairs, margins).claim).sum())
    unproven = int((~proven).sum())
    return BulkPoint(width, mode, claims_s * each, facts_s * each, int(clear.sum()), unproven, differs)


def golden_ns(workload: Workload) -> float:
    """Return the nanoseconds a pair that the golden model takes, certificates and their check included."""
    a, b = workload.a, workload.b
    pairs = [(exact_triangle(a[i]), exact_triangle(b[i])) for i in spread_rows(len(a), _JUDGED)]

    def work() -> None:
        for x, y in pairs:
            judge(x, y, 0)

    return best_times([work], _GOLDEN_ROUNDS)[0] * 1e9 / len(pairs)


# Pairs that are timed; all are judged.
TIMED = 4000
# A second triangle moved so far that no pair of any workload meets.
_FAR = 2.0**20


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
    # As most packages take them: the same numbers.
    a, b = workload.a.astype(np.float64), workload.b.astype(np.float64)
    question, load = clocked(lambda: peer.load(a, b))
    chosen = spread_rows(len(a), TIMED)
    run = peer.load(a[chosen], b[chosen])
    # A batch has one call for all of its pairs.
    calls = peer.load(a[:1], b[:1]) if peer.batched else peer.load(a[chosen], b[chosen] + _FAR)
    pairs, margins = np.ascontiguousarray(finest.pairs[chosen], np.int32), np.zeros(len(chosen), np.uint32)
    works = [run.ask, calls.ask, lambda: bulk_claims(pairs, margins)]
    halves = np.array([best_times(works, ROUNDS // 2) for _ in range(2)]) * 1e9 / len(chosen)
    run_ns, calls_ns, bulk_ns = halves.min(0).tolist()
    return PeerPoint(
        peer.name,
        peer.distribution,
        version,
        peer.call,
        count_errors(question.ask(), truth),
        run_ns,
        calls_ns,
        load * 1e9 / len(a),
        bulk_ns,
        float(np.ptp(halves, axis=0)[:2].max()),
    )
