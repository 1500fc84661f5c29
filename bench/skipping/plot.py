"""The picture of skipping: what each stage leaves, what that saves, and how the cost grows."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from triaxis.bench.mesh_cycles import CLOCK_MHZ
from triaxis.bench.skipping.run import SceneRow, SkippingResult, Stages
from triaxis.bench.skipping.software import Growth
from triaxis.host import figures as look
from triaxis.host.figures import GREY, LARGE, NORMAL, SMALL

_INCHES, _DPI = (17.0, 13.0), 110
# Where a count of nothing stands on a logarithmic axis.
_NOTHING = 0.5


@dataclass(frozen=True)
class Look:
    """How one thing is drawn."""

    label: str
    colour: str
    marker: str
    hollow: bool = False

    @property
    def face(self) -> str:
        """Return the colour inside the marker."""
        return "white" if self.hollow else self.colour


# What is left of the pairs after each stage.
_LEFT: tuple[tuple[Look, Callable[[Stages], int]], ...] = (
    (Look("all facet pairs: so many cycles without skipping", look.BLACK, "|"), lambda by: by.pairs),
    (Look("left by whole objects", look.SKY, "o", True), lambda by: by.pairs - by.objects),
    (Look("left by groups", look.BLUE, "o"), lambda by: by.pairs - by.before_boxes),
    (Look("left by boxes: the core is asked", look.GREEN, "s"), lambda by: by.tested),
    (Look("left by its axes: near", look.PURPLE, "v"), lambda by: by.near),
)
_CYCLES = Look("cycles of the mesh engine", look.VERMILION, "D")

_ALL = Look("bulk checker, all pairs", look.BLACK, "|")
_OURS = Look("broad phase and bulk checker", look.VERMILION, "D")
_ALONE = Look("broad phase alone", look.ORANGE, "d", True)
_PACKAGES = {
    "FCL OBB": Look("FCL, OBB tree (OBBTree)", look.BLUE, "o"),
    "FCL OBBRSS": Look("FCL, OBBRSS tree", look.SKY, "o", True),
    "FCL AABB": Look("FCL, AABB tree", look.GREEN, "s"),
    "FCL OBBRSS, python-fcl": Look("FCL by python-fcl", look.SKY, "^"),
    "trimesh CollisionManager": Look("trimesh's collision manager", look.PURPLE, "v"),
    "trimesh triangles_tree (rtree)": Look("trimesh's R-tree, boxes only", look.GREY, "x"),
}


def figure_of(result: SkippingResult) -> Figure:
    """Return the picture of a result."""
    with look.chart(_INCHES, _DPI) as figure:
        grid = figure.add_gridspec(
            2, 2, left=0.17, right=0.985, top=0.885, bottom=0.06, hspace=0.48, wspace=0.12,
            height_ratios=(1.1, 1),
        )  # fmt: skip
        hardware, software = result.totals
        figure.text(0.012, 0.968, "Skipping what a scene does not need", fontsize=LARGE + 5, weight="bold")
        figure.text(
            0.012, 0.961,
            f"All scenes, with margins: {hardware.cycles_without_skipping:,} facet pairs in "
            f"{hardware.cycles:,} cycles of the mesh engine, and {hardware.cycles_to_load:,} to load them;\n"
            f"the bulk checker takes {software.seconds_all_pairs:.2f} s alone, "
            f"{software.seconds_behind_boxes:.3f} s behind the broad phase. Every answer is exact, with and "
            "without skipping.",
            fontsize=NORMAL + 1, va="top",
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
    for drawn, left in _LEFT:
        _scatter(axes, [max(left(row.own.pairs_by_stage), _NOTHING) for row in rows], drawn)
    _scatter(axes, [row.own.hardware.cycles for row in rows], _CYCLES)
    for place, row in enumerate(rows):
        at = row.own.hardware
        axes.plot(
            [at.cycles, at.cycles_without_skipping],
            [place, place],
            color=look.VERMILION,
            alpha=0.3,
            linewidth=4,
            zorder=1,
        )
        times = f"{at.cycles_without_skipping / at.cycles:.0f} x"
        axes.text(at.cycles_without_skipping * 1.5, place, times, fontsize=SMALL, va="center")
    _rows(axes, rows, named=True)
    highest = max(row.scene.pairs for row in rows)
    axes.set_xticks([_NOTHING, *(10**k for k in range(0, 8))], ["0", *(f"$10^{k}$" for k in range(0, 8))])
    axes.set_xlim(_NOTHING / 1.5, highest * 8)
    axes.minorticks_off()
    axes.set_xlabel(f"facet pairs, or cycles ({CLOCK_MHZ} of them are a microsecond)", fontsize=NORMAL)
    _title(axes, "Hardware: what each stage leaves, and the cycles it takes", "with each scene's margin")
    axes.legend(loc="upper left", bbox_to_anchor=(-0.4, -0.1), ncols=3, fontsize=SMALL, frameon=False)


def _draw_times(axes: Axes, result: SkippingResult) -> None:
    rows = result.scenes
    _scatter(axes, [row.plain.software.seconds_all_pairs for row in rows], _ALL)
    for name, drawn in _PACKAGES.items():
        places = [(place, run) for place, row in enumerate(rows) for run in row.peers if run.name == name]
        if places:
            _scatter(axes, [run.seconds for _, run in places], drawn, [place for place, _ in places])
    _scatter(axes, [row.plain.software.seconds_behind_boxes for row in rows], _OURS)
    _rows(axes, rows, named=False)
    axes.set_xlabel("seconds of processor time, building of trees included", fontsize=NORMAL)
    absent = [package.name for package in result.packages if package.version is None]
    missing = f"; absent: {', '.join(absent)}" if absent else ""
    _title(axes, "Software: all colliding pairs of facets", f"the same scenes and meshes, margin 0{missing}")
    axes.legend(
        loc="upper left", bbox_to_anchor=(-0.04, -0.1), ncols=3, fontsize=SMALL, frameon=False,
        columnspacing=0.8,
    )  # fmt: skip


def _draw_growth(axes: Axes, growth: Growth, with_legend: bool) -> None:
    points = growth.points
    for name, drawn in _PACKAGES.items():
        runs = [(p.facets, run.seconds) for p in points for run in p.packages if run.name == name]
        if runs:
            _line(axes, runs, drawn, 1)
    alone = [(point.facets, point.seconds_broad_phase) for point in points]
    decided = [(point.facets, point.seconds_with_verdicts) for point in points]
    _line(axes, alone, _ALONE, 1.5)
    _line(axes, decided, _OURS, 2.5)
    slowest = [run.seconds for point in points for run in point.packages]
    lowest = min(seconds for _, seconds in alone) / 2
    highest = 3 * max(*slowest, decided[-1][1], decided[0][1])
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


def _line(axes: Axes, points: Sequence[tuple[int, float]], drawn: Look, width: float) -> None:
    facets, seconds = [facets for facets, _ in points], [seconds for _, seconds in points]
    axes.plot(
        facets, seconds, color=drawn.colour, marker=drawn.marker, markerfacecolor=drawn.face, markersize=5,
        linewidth=width, label=drawn.label,
    )  # fmt: skip


def _draw_slope(axes: Axes, points: Sequence[tuple[int, float]], power: int, highest: float) -> None:
    """Draw what grows like the facets to a power, from the first point to the top."""
    (first, cost), (last, _) = points[0], points[-1]
    end = min(last, first * (0.6 * highest / cost) ** (1 / power))
    axes.plot([first, end], [cost, cost * (end / first) ** power], color=GREY, linestyle=":", linewidth=1)
    label = f"facets$^{{{power}}}$ "
    axes.text(end, cost * (end / first) ** power, label, fontsize=SMALL, color=GREY, ha="right", va="bottom")


def _scatter(axes: Axes, values: Sequence[float], drawn: Look, places: Sequence[int] | None = None) -> None:
    rows = range(len(values)) if places is None else places
    axes.plot(
        values, rows, linestyle="", color=drawn.colour, marker=drawn.marker, markerfacecolor=drawn.face,
        markersize=13 if drawn.marker == "|" else 6.5, markeredgewidth=1.4, label=drawn.label, zorder=3,
    )  # fmt: skip


def _title(axes: Axes, title: str, about: str) -> None:
    axes.set_title(about, fontsize=NORMAL - 0.5, loc="left")
    axes.text(0, 1.065, title, transform=axes.transAxes, fontsize=LARGE, weight="bold", va="bottom")
