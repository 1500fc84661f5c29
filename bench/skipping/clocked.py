"""Processor time of work: what else the machine does meanwhile is not in it.

All that is compared here works in one thread.
"""

import time
from collections.abc import Callable
from typing import TypeVar

Result = TypeVar("Result")

# Short work is repeated, so often or for so long, and the least time counts.
_ROUNDS, _SECONDS = 5, 0.1


def clocked(work: Callable[[], Result]) -> tuple[Result, float]:
    """Return what work returns, and the seconds of processor time that it took: the least of some rounds."""
    seconds: list[float] = []
    while True:
        start = time.process_time()
        result = work()
        seconds.append(time.process_time() - start)
        if len(seconds) == _ROUNDS or sum(seconds) > _SECONDS:
            return result, min(seconds)
