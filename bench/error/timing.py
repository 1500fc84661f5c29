"""Run times of several things side by side: rounds of all of them follow each other, the best of each counts.

So a slow spell of the machine does not fall on one of them alone, and their ratios mean something.
"""

import gc
import time
from collections.abc import Callable, Sequence
from math import ceil

ROUNDS = 40
# What takes less is repeated within a round, so that what the others left in the caches does not count.
_LEAST_SECONDS = 0.005


def best_times(works: Sequence[Callable[[], object]], rounds: int = ROUNDS) -> list[float]:
    """Return the least seconds that each took over so many rounds, after a first to warm up."""
    for work in works:
        work()
    repeats = [max(1, ceil(_LEAST_SECONDS / max(_seconds(work, 1), 1e-9))) for work in works]
    best = [float("inf")] * len(works)
    collecting = gc.isenabled()
    gc.disable()
    try:
        for _ in range(rounds):
            for number, (work, repeat) in enumerate(zip(works, repeats, strict=True)):
                best[number] = min(best[number], _seconds(work, repeat) / repeat)
    finally:
        if collecting:
            gc.enable()
    return best


def _seconds(work: Callable[[], object], repeat: int) -> float:
    start = time.perf_counter()
    for _ in range(repeat):
        work()
    return time.perf_counter() - start
