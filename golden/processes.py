"""Work on all processors: a process each, interrupts for the first one only, results in order.

Or threads, for what waits for other programs.
"""

import os
import signal
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import closing, contextmanager
from multiprocessing import get_context
from typing import TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")


def results_in_processes(
    work: Callable[[Item], Result],
    items: Sequence[Item],
    workers: int | None = None,
) -> Generator[Result]:
    """Yield what ``work`` makes of each item, in order; all are begun with the first, unless this is closed.

    ``work`` must be a function of a module; a single item, or a single one of ``workers``, as many as there
    are processors, is worked on here.
    """
    workers = min(workers or os.cpu_count() or 1, len(items))
    if workers < 2:
        yield from map(work, items)
        return
    pool = ProcessPoolExecutor(workers, get_context("spawn"), initializer=_start)
    try:
        # Workers start here, and inherit the blocked signal: an interrupt is for this process.
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            results = pool.map(work, items)
        finally:
            signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
        yield from results
    finally:
        pool.shutdown(cancel_futures=True)


def in_processes(
    work: Callable[[Item], Result],
    items: Sequence[Item],
    done: Callable[[Result], None] = lambda _: None,
) -> list[Result]:
    """Return all of `results_in_processes`; ``done`` is told of each."""
    found: list[Result] = []
    with closing(results_in_processes(work, items)) as results:
        for result in results:
            done(result)
            found.append(result)
    return found


@contextmanager
def threads(workers: int) -> Generator[ThreadPoolExecutor]:
    """Provide threads; whatever ends the block, nothing more is begun, and what was begun is waited for."""
    pool = ThreadPoolExecutor(workers)
    try:
        yield pool
    finally:
        pool.shutdown(cancel_futures=True)


def _start() -> None:
    """Let a worker finish what it has; whatever it loaded by then may handle the signal."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
