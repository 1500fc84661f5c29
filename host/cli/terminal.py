"""What commands print: progress, tables, lists of problems."""

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

# Seconds between two lines of progress in a log.
_SELDOM = 60.0


@contextmanager
def progress_bar(title: str, total: int) -> Iterator[Callable[[int], None]]:
    """Show how far a block is on stderr; it calls what it is given with each step's size.

    A bar on a terminal; elsewhere, in a log, a line a minute.
    """
    console = Console(stderr=True)
    if not console.is_terminal:
        yield _logged(console, title, total)
        return
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task(title, total=total)
        yield lambda step: bar.advance(task, step)


def _logged(console: Console, title: str, total: int) -> Callable[[int], None]:
    done, said = 0, time.monotonic()

    def step(size: int) -> None:
        nonlocal done, said
        done += size
        if time.monotonic() - said >= _SELDOM:
            said = time.monotonic()
            console.print(f"{title}: {done:,} of {total:,}", highlight=False)

    return step


def table(title: str | None, headings: Iterable[str], text: int = 1) -> Table:
    """Return a table without rows, of which the first ``text`` columns hold text, the others numbers."""
    made = Table(title=title)
    for place, heading in enumerate(headings):
        made.add_column(heading, justify="left" if place < text else "right")
    return made


def print_list(title: str, lines: Sequence[str], shown: int | None = None, where: str = "") -> None:
    """Print a line each, the first ``shown`` of them, and ``where`` the others are."""
    for line in lines[:shown]:
        print(f"{title} {line}")
    if shown is not None and len(lines) > shown:
        print(f"{title} .. and {len(lines) - shown} more, {where}")
