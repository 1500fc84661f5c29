"""Coverage as one HTML page that needs nothing else: every bin with its count, goal and exclusion."""

from collections.abc import Iterator
from html import escape
from pathlib import Path
from typing import Any

from triaxis.coverage.counts import Counts, CoverageDatabase
from triaxis.coverage.cover_model import CoverItem, CoverModel, Hits
from triaxis.coverage.html import page
from triaxis.coverage.report import ItemReport, ModelReport, percent, report
from triaxis.coverage.terminal import summary_line
from triaxis.golden.outputs import write_whole


def write_page(path: Path, database: CoverageDatabase, title: str = "Functional coverage") -> None:
    """Write the page, whole or not at all; raise InputError where that cannot be done."""
    write_whole(path, page(title, _body(database, title)))


def _body(database: CoverageDatabase, title: str) -> Iterator[str]:
    reports = [(model, counts, report(model, counts)) for model, counts in database]
    total = [r for _, _, r in reports]
    yield f"<h1>{escape(title)}</h1>\n"
    yield f"<p>{escape(summary_line(total))}</p>\n<table><tr><th>model<th>bins<th>goals met<th>%<th>illegal\n"
    for one in total:
        hits = sum(len(item.illegal_hits) for item in one.items)
        yield f"<tr><td><a href='#{escape(one.model)}'>{escape(one.model)}</a><td class=n>{one.total}"
        yield f"<td class=n>{one.hit}<td class='n {_mark(one.complete)}'>{percent([one]):.2f}"
        yield f"<td class='n {_mark(not hits)}'>{hits}\n"
    yield "</table>\n"
    for model, counts, one in reports:
        yield from _model(model, counts, one)


def _mark(good: bool) -> str:
    return "good" if good else "bad"


def _model(model: CoverModel[Any], counts: Counts, found: ModelReport) -> Iterator[str]:
    yield f"<h2 id='{escape(model.name)}'>{escape(model.name)}</h2>\n"
    yield f"<p class=why>definition {model.hash[:16]}</p>\n"
    for item, item_report in zip(model.items, found.items, strict=True):
        yield from _item(item, counts.hits[item.name], item_report)


def _item(item: CoverItem[Any], hits: Hits, found: ItemReport) -> Iterator[str]:
    yield f"<details{'' if found.complete else ' open'}><summary><b>{escape(item.name)}</b>: "
    yield f"{escape(item.meaning)}. <span class={_mark(found.complete)}>{found.hit} of {found.total}</span>"
    yield "</summary>\n<table><tr><th>bin<th>hits<th>goal<th>\n"
    for one, count, goal in zip(item.bins, hits.tolist(), item.goals.tolist(), strict=True):
        if one.exclusion is None:
            state = "" if count >= goal else "<span class=bad>missing</span>"
            yield f"<tr><td>{escape(one.name)}<td class=n>{count}<td class=n>{goal}<td>{state}\n"
    yield "</table>\n"
    if found.excluded:
        yield from _exclusions(item, hits, found)
    yield "</details>\n"


def _exclusions(item: CoverItem[Any], hits: Hits, found: ItemReport) -> Iterator[str]:
    """Give each reason once, with the bins that it takes out; a hit of an illegal one stands out."""
    yield "<table><tr><th>excluded<th>hits<th>bins<th>why\n"
    for group in found.excluded:
        kind, illegal = group.exclusion.kind.value, item.illegal
        bins = [
            (one.name, count, bool(illegal[n]))
            for n, (one, count) in enumerate(zip(item.bins, hits.tolist(), strict=True))
            if one.exclusion is group.exclusion
        ]
        wrong = group.hits > 0 and any(is_illegal for _, _, is_illegal in bins)
        yield f"<tr><td>{kind}<td class='n {_mark(not wrong)}'>{group.hits}"
        yield f"<td><details{' open' if wrong else ''}><summary>{len(bins)}</summary>"
        for name, count, is_illegal in bins:
            if count and is_illegal:
                yield f"<span class=bad>{escape(name)}: {count} hits</span><br>"
            else:
                yield f"{escape(name)}<br>"
        yield f"</details><td>{escape(group.exclusion.reason)}"
        yield f" <span class=why>{escape(group.exclusion.test)}</span>\n"
    yield "</table>\n"
