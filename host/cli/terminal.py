"""What commands print: progress, tables, lists of problems."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table


@contextmanager
def progress_bar(title: str, total: int) -> Iterator[Callable[[int], None]]:
    """Show a bar on stderr, on a terminal only; the block calls what it is given with each step's size."""
    console = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(title, total=total)
        yield lambda step: bar.advance(task, step)


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
