"""The plots of a sign-off's page, as SVG text that stands in the page itself."""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from triaxis.host.figures import drawn

mpl.use("svg")

_GOOD, _FAIR, _BAD, _PLAIN = "#2f7d4f", "#c9a227", "#b3363b", "#4a6a8a"
_STYLE: dict[Any, Any] = {
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "font.family": "sans-serif",
}


def _drawn(title: str, height: float, draw: Callable[[Axes], None], width: float = 5.7) -> str:
    """Return a figure with one plot as an SVG element, with its title for those who cannot see it."""
    with mpl.rc_context(_STYLE):
        figure = Figure(figsize=(width, height), layout="constrained")
        axes = figure.add_subplot()
        draw(axes)
        axes.set_title(title, loc="left", fontsize=10, fontweight="bold")
        text = drawn(figure).decode()
    return text[text.index("<svg") :]


def _bars(
    title: str,
    measured: str,
    rows: Mapping[str, float],
    labels: Sequence[str],
    colours: Sequence[str],
    limits: tuple[float, float],
    scale: str = "linear",
) -> str:
    """Return horizontal bars, each with its label behind it."""

    def draw(axes: Axes) -> None:
        bars = axes.barh(list(rows), list(rows.values()), color=colours, height=0.65)
        axes.bar_label(bars, labels, padding=3, fontsize=8)
        axes.set_xscale(scale)
        axes.set_xlim(*limits)
        axes.set_xlabel(measured)
        axes.invert_yaxis()

    return _drawn(title, 0.9 + 0.25 * len(rows), draw)


def coverage_bars(shares: Mapping[str, float]) -> str:
    """Return bars of percentages; those below 100 in another colour."""
    labels = [f"{value:g} %" for value in shares.values()]
    colours = [_GOOD if value >= 100 else _BAD for value in shares.values()]
    return _bars("Coverage", "percent of bins, hit or waived", shares, labels, colours, (0, 115))


def mutants_by_file(files: Mapping[str, tuple[int, int, int]]) -> str:
    """Return stacked bars for each file: killed, equivalent, surviving."""
    kinds = (("killed", _GOOD), ("equivalent, proved", _FAIR), ("surviving", _BAD))

    def draw(axes: Axes) -> None:
        for number, (label, colour) in enumerate(kinds):
            values = [counts[number] for counts in files.values()]
            left = [sum(counts[:number]) for counts in files.values()]
            axes.barh(list(files), values, left=left, color=colour, label=label, height=0.65)
        axes.set_xlabel("mutants")
        axes.legend(frameon=False, loc="lower right", fontsize=8)
        axes.invert_yaxis()

    return _drawn("Mutants by file", 0.9 + 0.22 * len(files), draw)


def pairs_until_caught(faults: Mapping[str, int | None]) -> str:
    """Return how many pairs each fault took, on a logarithmic scale; None: not caught."""
    most = max(filter(None, faults.values()), default=1)
    rows = {name: most if pairs is None else max(pairs, 1) for name, pairs in faults.items()}
    labels = ["not caught" if pairs is None else f"{pairs:,}" for pairs in faults.values()]
    colours = [_BAD if pairs is None else _PLAIN for pairs in faults.values()]
    measured = "pairs until the first wrong answer, or until an assertion failed"
    return _bars("Faults of the catalogue", measured, rows, labels, colours, (0.8, most * 12), "log")


def time_by_part(pieces: Mapping[str, tuple[float, float, float]]) -> str:
    """Return bars from the begin to the end of each piece, labelled with the processor's seconds of it."""

    def draw(axes: Axes) -> None:
        begins, ends, processor = zip(*pieces.values(), strict=True) if pieces else ((), (), ())
        widths = [end - begin for begin, end in zip(begins, ends, strict=True)]
        colours = [_FAIR if name.startswith(" ") else _PLAIN for name in pieces]
        bars = axes.barh(list(pieces), widths, left=begins, color=colours, height=0.65)
        axes.bar_label(bars, [f"{value:.0f} s" for value in processor], padding=3, fontsize=8)
        axes.set_xlim(0, max(ends, default=1) * 1.15)
        axes.set_xlabel("seconds; beside each bar, those of the processor for all that went on meanwhile")
        axes.invert_yaxis()

    return _drawn("Time", 0.9 + 0.22 * len(pieces), draw, width=9.0)


def trend(
    title: str, label: str, dates: Sequence[str], values: Sequence[float | None], from_zero: bool = True
) -> str:
    """Return a line over nightly runs, oldest first; a gap where a value is missing.

    ``from_zero``: the scale begins at 0; otherwise just below the values, where small losses matter.
    """
    known = [value for value in values if value is not None] or [0.0]
    bottom = 0.0 if from_zero else math.floor(min(known)) - 1
    top = max(known) + 0.1 * ((max(known) - bottom) or 1)

    def draw(axes: Axes) -> None:
        places = list(range(len(dates)))
        drawn = [float("nan") if value is None else value for value in values]
        axes.plot(places, drawn, marker="o", markersize=4, color=_PLAIN, linewidth=1.3)
        step = -(-len(dates) // 7)
        axes.set_xticks(places[::step], dates[::step], rotation=30, ha="right", fontsize=7)
        axes.set_ylabel(label)
        axes.set_ylim(bottom, top)
        axes.grid(axis="y", alpha=0.3)

    return _drawn(title, 2.3, draw, width=4.2)
