"""Pictures of a stress test: a panel for each family, the knob from easy to impossible, errors in percent."""

import re
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from triaxis.bench.stress.curves import Curve, Picture
from triaxis.bench.stress.run import FamilyResult, StressResult
from triaxis.host.figure_style import LARGE, NORMAL, SMALL
from triaxis.host.saved_figure import write_figures

_INCHES, _DPI = (17.0, 8.6), 110
_ROWS, _COLUMNS = 2, 4
# Below this share, in percent, the axis is linear, down to 0.
_LINEAR = 0.1
_TICKS = (0, 0.1, 1, 10, 100)
# More labels than this stand too close: every second one is left out.
_LABELS = 12


def draw(folder: Path, picture: Picture, result: StressResult) -> list[Path]:
    """Draw into ``folder``, as PNG and as SVG, each whole or not at all; return the files."""
    return write_figures(_figure(picture, result), folder / f"{picture.name}.png")


def _figure(picture: Picture, result: StressResult) -> Figure:
    figure = Figure(figsize=_INCHES, dpi=_DPI)
    FigureCanvasAgg(figure)
    figure.text(0.02, 0.955, picture.title, fontsize=LARGE + 3, weight="bold")
    figure.text(0.02, 0.925, picture.about, fontsize=NORMAL + 1)
    panels = figure.subplots(
        _ROWS, _COLUMNS, gridspec_kw={"hspace": 0.58, "wspace": 0.2, "left": 0.05, "right": 0.985,
                                      "bottom": 0.105, "top": 0.825},
    ).reshape(-1)  # fmt: skip
    for number, (axes, family) in enumerate(zip(panels, result.families, strict=False)):
        _draw_family(axes, picture, family)
        if number % _COLUMNS == 0:
            axes.set_ylabel(picture.axis, fontsize=NORMAL)
    legend = panels[-1]
    legend.axis("off")
    legend.legend(
        handles=[_handle(curve, result) for curve in picture.curves],
        loc="upper left", bbox_to_anchor=(-0.06, 1.12), fontsize=NORMAL + 0.5, frameon=False,
        handlelength=3.2, labelspacing=0.75,
    )  # fmt: skip
    legend.text(
        -0.03, -0.3,
        f"{result.pairs:,} pairs at each setting, in 72 orders each; seed {result.seed}.\n"
        f"Below {_LINEAR} % the scale is linear, down to 0.\n"
        "float32 holds 24-bit coordinates exactly,\n53-bit ones rounded.",
        fontsize=SMALL, transform=legend.transAxes,
    )  # fmt: skip
    return figure


def _draw_family(axes: Axes, picture: Picture, result: FamilyResult) -> None:
    settings = result.family.settings
    places = list(range(len(settings)))
    for curve in picture.curves:
        shares = curve.shares(result)
        if curve.filled:
            axes.fill_between(places, shares, color=curve.colour, alpha=0.35, linewidth=0)
            continue
        axes.plot(
            places, shares, color=curve.colour, linestyle=curve.line, linewidth=curve.width,
            marker=curve.marker, markersize=4.5, markerfacecolor="white" if curve.hollow else curve.colour,
            zorder=3 if curve.marker else 2.5, clip_on=False,
        )  # fmt: skip
    axes.set_yscale("symlog", linthresh=_LINEAR, linscale=0.5)
    axes.set_ylim(0, 100)
    axes.set_yticks(_TICKS, [f"{tick:g}" for tick in _TICKS])
    axes.minorticks_off()
    step = len(places) // _LABELS + 1
    # Counted from the last, which is the hardest.
    shown = places[::-1][::step][::-1]
    axes.set_xticks(shown, [_typeset(settings[place].label) for place in shown])
    axes.set_xlim(-0.3, len(places) - 0.7)
    axes.grid(alpha=0.3)
    axes.tick_params(labelsize=SMALL)
    family = result.family
    axes.set_title(_typeset(family.about), fontsize=NORMAL, loc="left")
    axes.text(0, 1.13, family.name, fontsize=NORMAL + 2, weight="bold", transform=axes.transAxes, va="bottom")
    axes.set_xlabel(family.knob, fontsize=NORMAL)


def _typeset(label: str) -> str:
    return re.sub(r"(\d+)\^(-?\d+)", r"$\1^{\2}$", label)


def _handle(curve: Curve, result: StressResult) -> Line2D | Patch:
    label = curve.label if curve.counted is None else f"{curve.label}:\n{curve.counted(result)}"
    if curve.filled:
        return Patch(color=curve.colour, alpha=0.35, label=label)
    return Line2D(
        [], [], color=curve.colour, linestyle=curve.line, linewidth=curve.width, marker=curve.marker,
        markerfacecolor="white" if curve.hollow else curve.colour, label=label,
    )  # fmt: skip
