"""The picture of the benchmark: run time a pair against error, for every workload."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import log10

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, NullLocator

from triaxis.bench.error.points import CLOCK_NS, COLLISION, NO_MISS, WIDTHS, Errors
from triaxis.bench.error.running import Measured, WorkloadResult
from triaxis.fpga.board_build import XC7A100T
from triaxis.host.figures import BLACK, BLUE, GREEN, SMALL, VERMILION, chart

_COLLISION, _NO_MISS, _GOLDEN, _PEER, _CALL = BLUE, GREEN, BLACK, VERMILION, "#BBBBBB"
_DPI = 100
_TEXT = 9
# From two nanoseconds on, with room for labels; shares down to one pair in more than there are.
_TIMES, _SHARES = (2.0, 3e9), (2e-5, 1.6)
_LARGEST_TICK, _LABELS = 6, 3e5
# In decades: the room that a label needs, and the distance below which widths share one.
_APART, _JOINED = 0.2, 0.15


@dataclass(frozen=True)
class PlottedPoint:
    """A method on a workload: nanoseconds a pair, without and with calls from Python; a share of errors."""

    label: str
    kernel_ns: float
    run_ns: float
    share: float
    colour: str
    marker: str
    about: bool = False


def figure_of(measured: Measured) -> Figure:
    """Return the picture of a benchmark."""
    results = measured.results
    rows: tuple[tuple[str, Callable[[Errors], float]], ...] = (
        ("missed: share of the pairs that collide", lambda errors: errors.missed_share),
        ("false alarms: share of the pairs that are clear", lambda errors: errors.false_alarm_share),
    )
    with chart((5.6 * len(results) + 0.5, 15.5), _DPI) as figure:
        grid = figure.add_gridspec(
            5, len(results), height_ratios=(1, 0.9, 0.16, 1, 0.9), left=0.045, right=0.99,
            top=0.895, bottom=0.105,
            hspace=0.04, wspace=0.13,
        )  # fmt: skip
        for row, (meaning, share) in enumerate(rows):
            for column, result in enumerate(results):
                upper = figure.add_subplot(grid[3 * row, column])
                lower = figure.add_subplot(grid[3 * row + 1, column], sharex=upper)
                points = points_of(result, share)
                _draw_errors(upper, [point for point in points if point.share > 0])
                _draw_clean(lower, [point for point in points if point.share == 0])
                if column == 0:
                    upper.set_ylabel(meaning, fontsize=_TEXT)
                    lower.set_ylabel("none at all", fontsize=_TEXT)
                if row == 0:
                    collide = f"{result.colliding:,} of {len(result.workload):,} pairs collide"
                    upper.set_title(f"{result.workload.name}\n{collide}", fontsize=12, fontweight="bold")
        _explain(figure, measured)
    return figure


def points_of(result: WorkloadResult, share: Callable[[Errors], float]) -> list[PlottedPoint]:
    """Return all points of a workload, fastest first."""
    points: list[PlottedPoint] = []
    for mode, colour in ((COLLISION, _COLLISION), (NO_MISS, _NO_MISS)):
        core = {p.width: share(p.errors) for p in result.core if p.mode == mode}
        for widths in _joined(core):
            middle = core[widths[len(widths) // 2]]
            about = any(core[width] != middle for width in widths)
            label = f"core, {mode}, W {_range(widths)}"
            points.append(PlottedPoint(label, CLOCK_NS, CLOCK_NS, middle, colour, "o", about))
        finest = next(p for p in result.bulk if p.mode == mode and p.width == WIDTHS[-1])
        label, time = f"bulk checker, {mode}, W {WIDTHS[-1]}", finest.claims_ns
        points.append(PlottedPoint(label, time, time, core[WIDTHS[-1]], colour, "s"))
    points.append(PlottedPoint("golden model", result.golden_ns, result.golden_ns, 0.0, _GOLDEN, "*"))
    for peer in result.peers:
        most = peer.most_kernel_ns
        marker = "D" if most is None else "<"
        points.append(
            PlottedPoint(peer.name, most or peer.kernel_ns, peer.run_ns, share(peer.errors), _PEER, marker)
        )
    return sorted(points, key=lambda point: point.kernel_ns)


def _joined(shares: dict[int, float]) -> list[list[int]]:
    """Return the widths in groups of neighbours whose points would cover each other."""
    groups: list[list[int]] = []
    for width, share in shares.items():
        last = shares[groups[-1][0]] if groups else None
        if last is not None and (share == last or (share > 0 < last and _decades(share, last) < _JOINED)):
            groups[-1].append(width)
        else:
            groups.append([width])
    return groups


def _decades(x: float, y: float) -> float:
    return abs(log10(x) - log10(y))


def _range(widths: Sequence[int]) -> str:
    return str(widths[0]) if len(widths) == 1 else f"{widths[0]}..{widths[-1]}"


def _draw_errors(axes: Axes, points: Sequence[PlottedPoint]) -> None:
    """Draw points with errors: time against share, both by decades; labels in a column of their own."""
    _set_times(axes)
    axes.tick_params(labelbottom=False)
    axes.set_yscale("log")
    axes.set_ylim(*_SHARES)
    axes.yaxis.set_major_formatter(FuncFormatter(lambda share, _: _percent(share)))
    axes.grid(axis="y", color="#EEEEEE")
    points = sorted(points, key=lambda point: -point.share)
    for point, place in zip(points, spread([log10(point.share) for point in points]), strict=True):
        _draw_point(axes, point, point.share)
        label = f"{'about ' if point.about else ''}{_percent(point.share)}  {point.label}"
        axes.annotate(
            label, (max(point.run_ns, point.kernel_ns), point.share), (_LABELS, 10**place),
            va="center", fontsize=SMALL, color=point.colour,
            arrowprops={"arrowstyle": "-", "color": _CALL, "lw": 0.5, "shrinkA": 0, "shrinkB": 4},
        )  # fmt: skip


def spread(places: Sequence[float]) -> list[float]:
    """Return places for labels, from the top down: their points' own, but for the room each needs."""
    top, bottom = log10(_SHARES[1]), log10(_SHARES[0])
    found: list[float] = []
    for number, place in enumerate(places):
        # Room for those that follow.
        lowest = bottom + (len(places) - number) * _APART
        highest = found[-1] - _APART if found else top - _APART / 2
        found.append(min(max(place, lowest), highest))
    return found


def _percent(share: float) -> str:
    percent = 100 * share
    return f"{percent:.0f} %" if percent >= 10 else f"{percent:.2g} %"


def _draw_clean(axes: Axes, points: Sequence[PlottedPoint]) -> None:
    """Draw points without errors, which logarithms have no place for: one line each, by time."""
    _set_times(axes)
    axes.set_facecolor("#F4F8F4")
    axes.set_ylim(len(points) + 0.2 if points else 1, -0.8)
    axes.yaxis.set_major_locator(NullLocator())
    axes.set_xlabel("time a pair", loc="left", fontsize=_TEXT)
    for row, point in enumerate(points):
        _draw_point(axes, point, row)
        end = (max(point.run_ns, point.kernel_ns), row)
        axes.annotate(
            point.label, end, (7, 0), textcoords="offset points", va="center", fontsize=SMALL,
            color=point.colour,
        )  # fmt: skip


def _draw_point(axes: Axes, point: PlottedPoint, height: float) -> None:
    if point.run_ns > point.kernel_ns:
        axes.plot([point.kernel_ns, point.run_ns], [height, height], color=_CALL, lw=1.6, zorder=1)
    axes.plot(
        [point.kernel_ns], [height], point.marker, color=point.colour, markersize=7, zorder=3, clip_on=False
    )


def _set_times(axes: Axes) -> None:
    axes.tick_params(labelsize=_TEXT)
    axes.set_xscale("log")
    axes.set_xlim(*_TIMES)
    axes.set_xticks([10.0**k for k in range(1, _LARGEST_TICK + 1)])
    axes.xaxis.set_major_formatter(FuncFormatter(lambda ns, _: _duration(ns)))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.axvline(CLOCK_NS, color="#DDE7EF", lw=6, zorder=0)


def _duration(ns: float) -> str:
    for unit, size in (("ms", 1e6), ("us", 1e3)):
        if ns >= size:
            return f"{ns / size:g} {unit}"
    return f"{ns:g} ns"


def _explain(figure: Figure, measured: Measured) -> None:
    figure.suptitle(
        "Do two triangles collide? Run time a pair against error, on float32 triangles as they are",
        x=0.045, y=0.985, ha="left", fontsize=17, fontweight="bold",
    )  # fmt: skip
    kinds = (
        ("o", _COLLISION, "core, collision mode: margin 0, one pair a clock at 100 MHz"),
        ("o", _NO_MISS, "core, no-miss mode: margin 1 covers the rounding to the grid"),
        ("s", _COLLISION, "bulk checker, one thread"),
        ("*", _GOLDEN, "golden model, one thread: rational, is the truth here"),
        ("D", _PEER, "other packages, one thread"),
    )
    handles: list[Line2D] = [
        Line2D([], [], marker=marker, color=colour, linestyle="", label=label)
        for marker, colour, label in kinds
    ]
    handles.append(Line2D([], [], color=_CALL, lw=1.6, label="the call from Python, not counted as kernel"))
    figure.legend(
        handles=handles, loc="upper left", bbox_to_anchor=(0.04, 0.973), ncols=3, frameon=False, fontsize=10
    )
    blocks = "   ".join(
        f"W {width}: {measured.dsps[width, COLLISION]} / {measured.dsps[width, NO_MISS]}" for width in WIDTHS
    )
    absent = f"   Not installed: {', '.join(measured.absent)}." if measured.absent else ""
    lines = (
        f"DSP48E1 of the core, collision / no-miss (the XC7A100T has {XC7A100T.dsps}):   {blocks}",
        "The core works on the finest power-of-two grid of W bits that holds the scene. "
        "What it gets wrong is the rounding to that grid:",
        "in no-miss mode never a miss, and false alarms only within two grid steps. "
        "Colliding includes touching; no triangle is degenerate.",
        "The truth are exact rational verdicts on the same coordinates. "
        f"Pointing left: less than this, hidden by the noise of its call. Seed {measured.seed}.{absent}",
    )
    figure.text(0.045, 0.012, "\n".join(lines), fontsize=10.5, va="bottom", linespacing=1.5)
