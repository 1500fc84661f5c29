"""Pieces of HTML that the pages share: a page of one file, tables, marks."""

from collections.abc import Iterable, Iterator, Sequence
from html import escape

_STYLE = """
:root { color-scheme: light dark; --line: #8884; --good: #2f7d4f; --bad: #b3363b; }
body { font: 15px/1.5 system-ui, sans-serif; max-width: 76rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.5rem; } h2 { font-size: 1.15rem; margin-top: 2.2rem; } h3 { font-size: 1rem; }
summary { cursor: pointer; padding: .15rem 0; }
table { border-collapse: collapse; margin: .4rem 0 1rem; font-size: .85rem; }
td, th { padding: .15rem .9rem .15rem 0; text-align: left; vertical-align: top; }
tr { border-bottom: 1px solid var(--line); }
td.n, th.n { text-align: right; font-variant-numeric: tabular-nums; }
.bad { color: var(--bad); font-weight: 600; } .good { color: var(--good); } .why { opacity: .75; }
.verdict { padding: .8rem 1.2rem; border-left: .5rem solid; margin: 1rem 0; }
.verdict b { font-size: 1.3rem; }
.beside { display: flex; flex-wrap: wrap; gap: 4rem; align-items: flex-start; }
.plots { display: flex; flex-wrap: wrap; gap: 1rem; align-items: flex-start; }
.plots svg { background: #fff; border: 1px solid var(--line); max-width: 100%; height: auto; }
code { font-size: .85em; overflow-wrap: anywhere; }
"""

Cell = str | int | float | None


def page(title: str, body: Iterable[str]) -> str:
    """Return a whole page that needs nothing else."""
    head = (
        "<!doctype html>\n<html lang='en'><head><meta charset='utf-8'>"
        "<meta name='viewport' content='width=device-width'>"
        f"<title>{escape(title)}</title><style>{_STYLE}</style></head><body>\n"
    )
    return head + "".join(body) + "</body></html>\n"


class Marked(str):
    """Text that is HTML already."""

    __slots__ = ()


def mark(text: Cell, good: bool | None) -> Marked:
    """Return text marked as good or bad; None: neither."""
    kind = "" if good is None else "good" if good else "bad"
    return Marked(f"<span class='{kind}'>{escape(_text(text))}</span>")


def code(text: str) -> Marked:
    """Return text as code."""
    return Marked(f"<code>{escape(text)}</code>")


def _text(cell: Cell) -> str:
    if cell is None:
        return "not measured"
    return f"{cell:,}" if isinstance(cell, int | float) else cell


def _cell(cell: Cell) -> str:
    content = cell if isinstance(cell, Marked) else escape(_text(cell))
    return f"<td{' class=n' if isinstance(cell, int | float) else ''}>{content}"


def table(headings: Sequence[str], rows: Iterable[Sequence[Cell]]) -> Iterator[str]:
    """Give a table; numbers stand at the right."""
    yield "<table><tr>" + "".join(f"<th>{escape(heading)}" for heading in headings) + "\n"
    for row in rows:
        yield "<tr>" + "".join(_cell(cell) for cell in row) + "\n"
    yield "</table>\n"


def folded(summary: str, body: Iterable[str], is_open: bool = False) -> Iterator[str]:
    """Give what opens at a click."""
    yield f"<details{' open' if is_open else ''}><summary>{escape(summary)}</summary>\n"
    yield from body
    yield "</details>\n"
