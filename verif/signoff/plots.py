"""The plots of a sign-off's page, as SVG text that stands in the page itself."""

import io
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

mpl.use("svg")

_GOOD, _FAIR, _BAD, _PLAIN = "#2f7d4f", "#c9a227", "#b3363b", "#4a6a8a"
_STYLE: dict[Any, Any] = {
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "svg.fonttype": "none",
    "font.family": "sans-serif",
    # The same numbers give the same file.
    "svg.hashsalt": "triaxis",
}


def _drawn(title: str, height: float, draw: Callable[[Axes], None], width: float = 5.7) -> str:
    """Return a figure with one plot as an SVG element, with its title for those who cannot see it."""
    with mpl.rc_context(_STYLE):
        figure = Figure(figsize=(width, height), layout="constrained")
        axes = figure.add_subplot()
        draw(axes)
        axes.set_title(title, loc="left", fontsize=10, fontweight="bold")
        text = io.StringIO()
        figure.savefig(text, format="svg", metadata={"Date": None})
    return text.getvalue()[text.getvalue().index("<svg") :]


def coverage_bars(shares: Mapping[str, float]) -> str:
    """Return horizontal bars of percentages; those below 100 in another colour."""
    names, values = list(shares), list(shares.values())

    def draw(axes: Axes) -> None:
        colours = [_GOOD if value >= 100 else _BAD for value in values]
        bars = axes.barh(names, values, color=colours, height=0.65)
        axes.bar_label(bars, [f"{value:g} %" for value in values], padding=3, fontsize=8)
        axes.set_xlim(0, 115)
        axes.set_xticks(range(0, 101, 25))
        axes.set_xlabel("percent of bins, hit or waived")
        axes.invert_yaxis()

    return _drawn("Coverage", 0.9 + 0.25 * len(names), draw)


def mutants_by_file(files: Mapping[str, tuple[int, int, int]]) -> str:
    """Return stacked bars for each file: killed, equivalent, surviving."""
    names = list(files)

    def draw(axes: Axes) -> None:
        left = [0] * len(names)
        for number, (label, colour) in enumerate(
            (("killed", _GOOD), ("equivalent, proved", _FAIR), ("surviving", _BAD))
        ):
            values = [files[name][number] for name in names]
            axes.barh(names, values, left=left, color=colour, label=label, height=0.65)
            left = [a + b for a, b in zip(left, values, strict=True)]
        axes.set_xlabel("mutants")
        axes.legend(frameon=False, loc="lower right", fontsize=8)
        axes.invert_yaxis()

    return _drawn("Mutants by file", 0.9 + 0.22 * len(names), draw)


def pairs_until_caught(faults: Mapping[str, int | None]) -> str:
    """Return how many pairs each fault took, on a logarithmic scale; None: not caught."""
    names = list(faults)

    def draw(axes: Axes) -> None:
        values = [faults[name] for name in names]
        most = max((value for value in values if value), default=1)
        bars = axes.barh(
            names,
            [most if value is None else max(value, 1) for value in values],
            color=[_BAD if value is None else _PLAIN for value in values],
            height=0.65,
        )
        labels = ["not caught" if value is None else f"{value:,}" for value in values]
        axes.bar_label(bars, labels, padding=3, fontsize=8)
        axes.set_xscale("log")
        axes.set_xlim(0.8, most * 12)
        axes.set_xlabel("pairs until the first wrong answer, or until a rule fired")
        axes.invert_yaxis()

    return _drawn("Faults of the catalogue", 0.9 + 0.25 * len(names), draw)


def time_by_part(seconds: Mapping[str, float]) -> str:
    """Return how long each part took."""
    names, values = list(seconds), list(seconds.values())

    def draw(axes: Axes) -> None:
        bars = axes.barh(names, values, color=_PLAIN, height=0.65)
        axes.bar_label(bars, [f"{value:.0f} s" for value in values], padding=3, fontsize=8)
        axes.set_xlim(0, max(values, default=1) * 1.15)
        axes.set_xlabel("seconds")
        axes.invert_yaxis()

    return _drawn("Time", 0.9 + 0.25 * len(names), draw)


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
