"""Run times of our own software, in one thread of this process: the bulk checker, the golden model."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from triaxis.bench.error.core_points import OnGrid, margins_of
from triaxis.bench.error.timing import best_times
from triaxis.bench.error.truth import exact_triangle
from triaxis.bench.error.workloads import Workload
from triaxis.golden.bulk import bulk_facts
from triaxis.golden.bulk_claims import bulk_claims
from triaxis.golden.claim_check import claims_prove_clear
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


def collision_work(rounded: OnGrid, chosen: npt.NDArray[np.int64]) -> Callable[[], npt.NDArray[np.int8]]:
    """Return what asks the bulk checker whether the chosen pairs collide, without copying them."""
    pairs, margins = np.ascontiguousarray(rounded.pairs[chosen], np.int32), np.zeros(len(chosen), np.uint32)
    return lambda: bulk_claims(pairs, margins)


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
    chosen = np.unique(np.linspace(0, len(a) - 1, min(len(a), _JUDGED)).astype(np.int64))
    pairs = [(exact_triangle(a[i]), exact_triangle(b[i])) for i in chosen]

    def work() -> None:
        for x, y in pairs:
            judge(x, y, 0)

    return best_times([work], _GOLDEN_ROUNDS)[0] * 1e9 / len(pairs)
