"""Work in processes: results in the order of the items."""

from math import sqrt
from operator import neg
from threading import Event, Timer

import pytest

from triaxis.golden.processes import in_processes, results_in_processes, threads


@pytest.mark.parametrize("workers", [1, 2])
def test_results_come_in_order_from_processes_or_here(workers):
    assert list(results_in_processes(neg, range(5), workers=workers)) == [0, -1, -2, -3, -4]


def test_what_one_raises_ends_all():
    told: list[float] = []
    with pytest.raises(ValueError, match="math domain"):
        in_processes(sqrt, [4, -1, 9], told.append)
    assert told == [2.0]


def test_what_ends_threads_begins_nothing_more():
    begun: list[int] = []
    go_on = Event()

    def work(number: int) -> None:
        begun.append(number)
        go_on.wait()

    def interrupted() -> None:
        with threads(1) as pool:
            jobs = [pool.submit(work, number) for number in range(3)]
            while not jobs[0].running():
                pass
            Timer(0.1, go_on.set).start()
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert begun == [0]
