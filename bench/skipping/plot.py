"""The picture of skipping: what each stage leaves, what that saves, and how the cost grows."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from triaxis.bench.mesh_cycles import CLOCK_MHZ
from triaxis.bench.skipping.growth import Growth, Point
from triaxis.bench.skipping.run import AtMargin, SceneRow, SkippingResult
from triaxis.host.figure_style import LARGE, NORMAL, SMALL

_INCHES, _DPI = (17.0, 13.0), 110
_STYLE: dict[Any, Any] = {
    "font.family": "sans-serif",
    "axes.spines.top": False,
    "axes.spines.right": False,
}
# Where a count of nothing stands on a logarithmic axis.
_NOTHING = 0.5
_GREY = "#6E6E6E"


@dataclass(frozen=True)
class _Look:
    """How one thing is drawn. Colours of M. Okabe and K. Ito, "Color Universal Design", 2008."""

    label: str
    colour: str
    marker: str
    hollow: bool = False

    @property
    def face(self) -> str:
        return "white" if self.hollow else self.colour


@dataclass(frozen=True)
class _Left:
    """What is left of the pairs after a stage."""

    look: _Look
    count: Callable[[AtMargin], int]


_LEFT = (
    _Left(
        _Look("all facet pairs: so many cycles without skipping", "#000000", "|"), lambda at: at.stages.pairs
    ),
    _Left(
        _Look("left by whole objects", "#56B4E9", "o", True),
        lambda at: at.stages.pairs - at.stages.objects,
    ),
    _Left(_Look("left by groups", "#0072B2", "o"), lambda at: at.stages.pairs - at.stages.before_boxes),
    _Left(_Look("left by boxes: the core is asked", "#009E73", "s"), lambda at: at.stages.tested),
    _Left(_Look("left by its axes: near", "#CC79A7", "v"), lambda at: at.stages.near),
    _Left(_Look("cycles of the mesh engine", "#D55E00", "D"), lambda at: at.cycles),
)

_ALL = _Look("bulk checker, all pairs", "#000000", "|")
_OURS = _Look("broad phase and bulk checker", "#D55E00", "D")
_ALONE = _Look("broad phase alone", "#E69F00", "d", True)
_PACKAGES = {
    "FCL OBB": _Look("FCL, OBB tree (OBBTree)", "#0072B2", "o"),
    "FCL OBBRSS": _Look("FCL, OBBRSS tree", "#56B4E9", "o", True),
    "FCL AABB": _Look("FCL, AABB tree", "#009E73", "s"),
    "FCL OBBRSS, python-fcl": _Look("FCL by python-fcl", "#56B4E9", "^"),
    "trimesh CollisionManager": _Look("trimesh's collision manager", "#CC79A7", "v"),
    "trimesh triangles_tree (rtree)": _Look("trimesh's R-tree, boxes only", "#6E6E6E", "x"),
}


def figure_of(result: SkippingResult) -> Figure:
    """Return the picture of a result."""
    with rc_context(_STYLE):
        figure = Figure(figsize=_INCHES, dpi=_DPI)
        FigureCanvasAgg(figure)
        grid = figure.add_gridspec(
            2,
            2,
            left=0.17,
            right=0.985,
            top=0.895,
            bottom=0.06,
            hspace=0.48,
            wspace=0.12,
            height_ratios=(1.1, 1),
        )
        pairs, cycles, software = result.totals
        figure.text(0.012, 0.968, "Skipping what a scene does not need", fontsize=LARGE + 5, weight="bold")
        figure.text(
            0.012, 0.944,
            f"All scenes, with margins: {pairs:,} facet pairs in {cycles:,} cycles of the mesh engine; "
            f"the bulk checker takes {software.without:.2f} s alone, {software.with_skipping:.3f} s behind "
            "the broad phase. Every answer is exact, with and without skipping.",
            fontsize=NORMAL + 1,
        )  # fmt: skip
        _draw_stages(figure.add_subplot(grid[0, 0]), result.scenes)
        _draw_times(figure.add_subplot(grid[0, 1]), result)
        for column, growth in enumerate(result.growth[:2]):
            _draw_growth(figure.add_subplot(grid[1, column]), growth, bool(column))
    return figure


def _name(row: SceneRow) -> str:
    return f"{row.scene.name}\n{row.scene.pairs:,} pairs"


def _rows(axes: Axes, rows: Sequence[SceneRow], named: bool) -> None:
    axes.set_yticks(range(len(rows)), [_name(row) if named else "" for row in rows], fontsize=SMALL - 1)
    axes.set_ylim(len(rows) - 0.4, -0.6)
    axes.set_xscale("log")
    axes.grid(axis="x", alpha=0.25)
    axes.tick_params(axis="y", length=0)


def _draw_stages(axes: Axes, rows: Sequence[SceneRow]) -> None:
    for left in _LEFT:
        values = [max(left.count(row.at[-1]), _NOTHING) for row in rows]
        _scatter(axes, values, left.look)
    for place, row in enumerate(rows):
        at = row.at[-1]
        axes.plot(
            [at.cycles, at.cycles_without], [place, place], color="#D55E00", alpha=0.3, linewidth=4, zorder=1
        )
        axes.text(
            at.cycles_without * 1.5,
            place,
            f"{at.cycles_without / at.cycles:.0f} x",
            fontsize=SMALL,
            va="center",
        )
    _rows(axes, rows, named=True)
    highest = max(row.scene.pairs for row in rows)
    axes.set_xlim(_NOTHING / 1.5, highest * 8)
    axes.set_xticks([_NOTHING, *(10**k for k in range(0, 8))], ["0", *(f"$10^{k}$" for k in range(0, 8))])
    axes.set_xlim(_NOTHING / 1.5, highest * 8)
    axes.minorticks_off()
    axes.set_xlabel(f"facet pairs, or cycles ({CLOCK_MHZ} of them are a microsecond)", fontsize=NORMAL)
    _title(axes, "Hardware: what each stage leaves, and the cycles it takes", "with each scene's margin")
    axes.legend(loc="upper left", bbox_to_anchor=(-0.4, -0.1), ncols=3, fontsize=SMALL, frameon=False)


def _draw_times(axes: Axes, result: SkippingResult) -> None:
    rows = result.scenes
    _scatter(axes, [row.at[0].software.without for row in rows], _ALL)
    for name, look in _PACKAGES.items():
        places = [(place, run) for place, row in enumerate(rows) for run in row.peers if run.name == name]
        if places:
            _scatter(axes, [run.seconds for _, run in places], look, [place for place, _ in places])
    _scatter(axes, [row.at[0].software.with_skipping for row in rows], _OURS)
    _rows(axes, rows, named=False)
    axes.set_xlabel("seconds of processor time, building of trees included", fontsize=NORMAL)
    absent = [package.name for package in result.packages if package.version is None]
    missing = f"; absent: {', '.join(absent)}" if absent else ""
    _title(axes, "Software: all colliding pairs of facets", f"the same scenes and meshes, margin 0{missing}")
    axes.legend(
        loc="upper left",
        bbox_to_anchor=(-0.04, -0.1),
        ncols=3,
        fontsize=SMALL,
        frameon=False,
        columnspacing=0.8,
    )


def _draw_growth(axes: Axes, growth: Growth, with_legend: bool) -> None:
    points = growth.points
    for name, look in _PACKAGES.items():
        runs = [(p.facets, run.seconds) for p in points for run in p.peers if run.name == name]
        if runs:
            _line(axes, runs, look, 1)
    alone, decided = ([(p.facets, seconds(p)) for p in points] for seconds in (_alone_seconds, _seconds))
    _line(axes, alone, _ALONE, 1.5)
    _line(axes, decided, _OURS, 2.5)
    slowest = [run.seconds for point in points for run in point.peers]
    lowest, highest = (
        min(seconds for _, seconds in alone) / 2,
        3 * max(*slowest, decided[-1][1], decided[0][1]),
    )
    for power in (1, 2):
        _draw_slope(axes, decided, power, highest)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_ylim(lowest, highest)
    axes.grid(alpha=0.25)
    axes.set_xlabel("facets of each mesh", fontsize=NORMAL)
    axes.set_ylabel("seconds of processor time", fontsize=NORMAL)
    exponents = (
        f"comparisons grow like facets$^{{{growth.compared_exponent:.2f}}}$, "
        f"seconds like facets$^{{{growth.seconds_exponent:.2f}}}$"
    )
    _title(axes, f"Growth: {growth.surfaces.name}", f"{growth.surfaces.about}; {exponents}")
    if with_legend:
        axes.legend(loc="upper left", fontsize=SMALL, frameon=False)


def _alone_seconds(point: Point) -> float:
    return point.seconds


def _seconds(point: Point) -> float:
    return point.decided_seconds


def _line(axes: Axes, points: Sequence[tuple[int, float]], look: _Look, width: float) -> None:
    facets, seconds = [facets for facets, _ in points], [seconds for _, seconds in points]
    axes.plot(
        facets,
        seconds,
        color=look.colour,
        marker=look.marker,
        markerfacecolor=look.face,
        markersize=5,
        linewidth=width,
        label=look.label,
    )


def _draw_slope(axes: Axes, points: Sequence[tuple[int, float]], power: int, highest: float) -> None:
    """Draw what grows like the facets to a power, from the first point to the top."""
    (first, cost), (last, _) = points[0], points[-1]
    end = min(last, first * (0.6 * highest / cost) ** (1 / power))
    axes.plot([first, end], [cost, cost * (end / first) ** power], color=_GREY, linestyle=":", linewidth=1)
    label = f"facets$^{{{power}}}$ "
    axes.text(end, cost * (end / first) ** power, label, fontsize=SMALL, color=_GREY, ha="right", va="bottom")


def _scatter(axes: Axes, values: Sequence[float], look: _Look, places: Sequence[int] | None = None) -> None:
    rows = range(len(values)) if places is None else places
    axes.plot(
        values,
        rows,
        linestyle="",
        color=look.colour,
        marker=look.marker,
        markerfacecolor=look.face,
        markersize=13 if look.marker == "|" else 6.5,
        markeredgewidth=1.4,
        label=look.label,
        zorder=3,
    )


def _title(axes: Axes, title: str, about: str) -> None:
    axes.set_title(about, fontsize=NORMAL - 0.5, loc="left")
    axes.text(0, 1.065, title, transform=axes.transAxes, fontsize=LARGE, weight="bold", va="bottom")
