"""Pictures of a stress test: a panel for each family, the knob from easy to impossible, shares in percent."""

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.typing import LineStyleType

from triaxis.bench.stress.measuring import ROUNDING_WIDTH, FamilyResult, SettingResult, StressResult
from triaxis.bench.stress.orders import METHODS, OrderErrors
from triaxis.host import figures as look
from triaxis.host.figures import LARGE, NORMAL, SMALL

_COLOURS = {"SAT": look.BLUE, "Moller": look.ORANGE, "Guigue-Devillers": look.PURPLE}
_MARKERS = {"SAT": "o", "Moller": "^", "Guigue-Devillers": "s"}
_BAND = "#9A9A9A"


@dataclass(frozen=True)
class Curve:
    """A line of a picture: what it shows of a setting, and its look.

    ``filled``: down to 0. ``counted``: what the legend says of it, from all settings together.
    """

    label: str
    share: Callable[[SettingResult], float]
    colour: str
    line: LineStyleType = "-"
    marker: str = ""
    width: float = 1.4
    hollow: bool = False
    filled: bool = False
    counted: Callable[[StressResult], str] | None = None


@dataclass(frozen=True)
class Picture:
    """Curves for every family: ``name`` of its files, and what stands above."""

    name: str
    title: str
    about: str
    axis: str
    curves: tuple[Curve, ...]


def _of_methods(share: Callable[[OrderErrors], float]) -> Iterator[Curve]:
    """Yield a curve for each method; ``share``: what it shows of its errors."""
    for method in METHODS:
        single = method.name.startswith("float32")
        yield Curve(
            method.name, lambda m, name=method.name: share(m.methods[name]), _COLOURS[method.title],
            "--" if single else "-", _MARKERS[method.title], hollow=single,
        )  # fmt: skip


def _missed(measured: SettingResult) -> float:
    return measured.no_miss.misses / measured.no_miss.answers


def _all_missed(result: StressResult) -> str:
    return f"{result.whole.no_miss.misses} of {result.whole.no_miss.answers:,}"


ERRORS = Picture(
    "stress",
    "Wrong answers of triangle tests, as inputs go from easy (left) to impossible (right)",
    "near or clear, in all 72 orders of every pair, against exact verdicts on the coordinates as given; the "
    "core: on what it is given, at its own resolution",
    "wrong answers (%)",
    (
        *_of_methods(lambda errors: errors.wrong_rate),
        Curve(
            "core, as simulated", lambda m: m.core.wrong_rate, look.GREEN, width=4.5,
            counted=lambda result: f"{result.whole.core.wrong} of {result.whole.core.answers:,} wrong",
        ),
        Curve(
            f"no-miss mode at {ROUNDING_WIDTH} bits, missed", _missed, look.BLACK, ":", width=1.8,
            counted=_all_missed,
        ),
    ),
)  # fmt: skip
ORDERS = Picture(
    "stress_orders",
    "Pairs whose answer hangs on the order of their vertices and triangles, from easy (left) to impossible",
    "the same pair in all 72 orders (6 x 6 of the vertices, A and B exchanged): not always the same answer",
    "pairs (%)",
    (
        *_of_methods(lambda errors: errors.changing_rate),
        Curve(
            "core, as simulated", lambda m: m.core.changing_rate, look.GREEN, width=4.5,
            counted=lambda result: f"{result.whole.core.changing_pairs} of {result.whole.core.pairs:,}",
        ),
    ),
)  # fmt: skip
QUANTISATION = Picture(
    "stress_quantisation",
    f"What rounding to {ROUNDING_WIDTH} bits costs, and what the no-miss mode makes of it, from easy (left) "
    "to impossible",
    "the core on rounded coordinates against exact verdicts on the unrounded ones; the no-miss mode has a "
    "margin of 1 LSB, and its band ends at a distance of 2 LSB",
    "answers (%)",
    (
        Curve(
            "clear pairs at most 2 LSB apart: the band", lambda m: m.band_pairs / m.pairs, _BAND, width=0,
            filled=True,
        ),
        Curve(
            "no-miss mode, false alarms", lambda m: m.no_miss.false_alarms / m.no_miss.answers, look.BLUE,
            marker="o",
            counted=lambda r: f"{r.whole.no_miss.false_alarms:,}, {r.whole.beyond_band:,} beyond the band",
        ),
        Curve("no-miss mode, missed collisions", _missed, look.GREEN, width=4.5, counted=_all_missed),
        Curve(
            "without margin, false alarms", lambda m: m.rounded.false_alarms / m.rounded.answers, look.SKY,
            "--", "^", hollow=True,
        ),
        Curve(
            "without margin, missed collisions", lambda m: m.rounded.misses / m.rounded.answers,
            look.VERMILION, "--", "x",
        ),
    ),
)  # fmt: skip
PICTURES = (ERRORS, ORDERS, QUANTISATION)


_INCHES, _DPI = (17.0, 8.6), 110
_ROWS, _COLUMNS = 2, 4
# Below this share, in percent, the axis is linear, down to 0.
_LINEAR = 0.1
_TICKS = (0, 0.1, 1, 10, 100)
# More labels than this stand too close: every second one is left out.
_LABELS = 12


def figure_of(picture: Picture, result: StressResult) -> Figure:
    """Return one of `PICTURES` of a result."""
    with look.chart(_INCHES, _DPI) as figure:
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
        shares = [100 * curve.share(measured) for measured in result.measured]
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
