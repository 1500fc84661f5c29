"""Work on all processors: a process each, interrupts for the first one only, results in order."""

import os
import signal
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from typing import TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")


def in_processes(
    work: Callable[[Item], Result],
    items: Sequence[Item],
    done: Callable[[Result], None] = lambda _: None,
    prepare: Callable[[], object] = lambda: None,
) -> list[Result]:
    """Return what ``work`` makes of each item; ``done`` is told of each result as it comes.

    ``work`` and ``prepare``, which each process calls first, must be functions of modules; a single item, or
    a single processor, is worked on here.
    """
    workers = min(os.cpu_count() or 1, len(items))
    if workers < 2:
        results: list[Result] = []
        for item in items:
            results.append(work(item))
            done(results[-1])
        return results
    pool = ProcessPoolExecutor(workers, get_context("spawn"), initializer=_start, initargs=(prepare,))
    try:
        # Workers start here, and inherit the blocked signal: an interrupt is for this process.
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            futures = [pool.submit(work, item) for item in items]
        finally:
            signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
        for future in as_completed(futures):
            done(future.result())
        return [future.result() for future in futures]
    finally:
        pool.shutdown(cancel_futures=True)


def _start(prepare: Callable[[], object]) -> None:
    """Let a worker finish what it has; PPL's loader, among others, unblocks the signal and handles it."""
    prepare()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
