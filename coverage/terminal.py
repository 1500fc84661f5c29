"""Coverage as lines of text."""

from collections.abc import Iterable

from triaxis.coverage.report import ItemReport, ModelReport, percent

_NAMED = 3


def summary_line(reports: Iterable[ModelReport]) -> str:
    """Return one line for all models: bins that met their goals, and their share."""
    every = list(reports)
    hit, total = sum(r.hit for r in every), sum(r.total for r in every)
    return f"{hit} of {total} bins in {len(every)} models, {percent(every):.2f} %"


def coverage_lines(report: ModelReport, everything: bool = True) -> list[str]:
    """Return a line for the model, one for each item, and one for each illegal hit.

    ``everything``: false leaves out complete items.
    """
    lines = [f"{report.model}: {summary_line([report])}"]
    for item in report.items:
        if everything or not item.complete:
            lines.append(f"  {_item_line(item)}")
        lines += [f"    ILLEGAL {i.bin}: hit {i.hits} times; {i.reason}" for i in item.illegal_hits]
    return lines


def _item_line(item: ItemReport) -> str:
    line = f"{item.name:<17} {item.hit:>4} of {item.total:<4}"
    if item.excluded:
        line += f" ({sum(e.bins for e in item.excluded)} excluded)"
    if item.missing:
        more = len(item.missing) - _NAMED
        line += f" missing: {', '.join(item.missing[:_NAMED])}" + (f" and {more} more" if more > 0 else "")
    return line.rstrip()
