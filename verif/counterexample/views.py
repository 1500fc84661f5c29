"""The views of a counterexample: triangles in space, projections on an axis, two nearest points."""

from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations
from textwrap import wrap

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.patches import Polygon, Rectangle
from matplotlib.ticker import MaxNLocator
from mpl_toolkits.mplot3d import Axes3D
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from triaxis.golden.axes import axis_name, axis_vector
from triaxis.golden.exact import Triangle, Vector, dot, triangle_rank
from triaxis.golden.pairs import Pairs
from triaxis.golden.solver import NearestPoints
from triaxis.host.figures import GAP, MARGIN, NORMAL, SMALL, STYLES, WITNESS, Style
from triaxis.verif.counterexample.labels import Label, place_labels

# A decision narrower than this part of the picture is zoomed in on, until it takes this part of it.
_NARROW, _ZOOMED = 0.03, 0.12
_HEIGHTS = (1.0, 0.0)
# Characters in a line of the title.
_LONGEST_TITLE = 74


@dataclass(frozen=True)
class Projection:
    """Exact projections on an axis.

    ``values`` are those of the vertices of A and of B; ``gap`` is positive where the intervals are
    apart, negative where they overlap; ``inner`` are the two ends that face each other, the lower one
    of the two in the picture first; ``demanded`` is margin * |c|1.
    """

    axis: tuple[int, ...]
    values: tuple[tuple[int, ...], tuple[int, ...]]
    gap: int
    inner: tuple[int, int]
    demanded: int

    @property
    def separates(self) -> bool:
        """Return whether the axis separates by more than the margin."""
        return self.gap > self.demanded


def project(number: int, a: Triangle, b: Triangle, margin: int) -> Projection:
    """Project integer triangles on axis ``number``."""
    vector = axis_vector(number, a, b)
    on_a = tuple(int(dot(vector, vertex)) for vertex in a)
    on_b = tuple(int(dot(vector, vertex)) for vertex in b)
    up, down = (max(on_a), min(on_b)), (max(on_b), min(on_a))
    inner = up if up[1] - up[0] >= down[1] - down[0] else down
    demanded = margin * sum(abs(int(x)) for x in vector)
    return Projection(tuple(int(x) for x in vector), (on_a, on_b), inner[1] - inner[0], inner, demanded)


def draw_axis(axes: Axes, number: int, a: Triangle, b: Triangle, margin: int, whose: str) -> None:
    """Draw the projections of integer triangles on axis ``number``; ``whose``: who named it."""
    found = project(number, a, b, margin)
    # Exact before anything becomes a float: values may have a hundred bits.
    origin = found.inner[0]
    for style, height, values in zip(STYLES, _HEIGHTS, found.values, strict=True):
        low, high = (float(end - origin) for end in (min(values), max(values)))
        axes.plot([low, high], [height, height], style.line, color=style.colour, lw=5, alpha=0.5)
        axes.plot(
            [float(value - origin) for value in values], [height] * 3, style.marker, color=style.colour,
            ms=style.marker_size, mfc="white" if style.hollow else style.colour, zorder=3,
        )  # fmt: skip
    _draw_decision(axes, found)
    _frame_axis(axes, found, float(origin))
    relation = ">" if found.separates else "\N{LESS-THAN OR EQUAL TO}"
    verb = "separates" if found.separates else "does not separate"
    c1 = sum(map(abs, found.axis))
    lines = [
        f"{whose}: axis {number} ({axis_name(number)}), c = {found.axis}",
        f"gap {found.gap} {relation} margin \N{MULTIPLICATION SIGN} |c|1 = {margin} \N{MULTIPLICATION SIGN} "
        f"{c1} = {found.demanded}: {verb}",
    ]
    wrapped = [part for line in lines for part in wrap(line, _LONGEST_TITLE)]
    axes.set_title("\n".join(wrapped), fontsize=NORMAL if wrapped == lines else SMALL, loc="left")
    _label_axis(axes, found, origin)


def _draw_decision(axes: Axes, found: Projection) -> None:
    """Draw the gap (or the overlap) as a band, and what the margin demands as a bar."""
    low, high = sorted((0.0, float(found.gap)))
    overlap = found.gap < 0
    if not found.gap:
        axes.axvline(0, color=GAP, lw=2, zorder=0)
    axes.axvspan(
        low, high, color=MARGIN if overlap else GAP, alpha=0.18, hatch="xx" if overlap else "", lw=1, zorder=0
    )
    if found.demanded:
        axes.annotate(
            "", xy=(float(found.demanded), 0.5), xytext=(0, 0.5),
            arrowprops={"arrowstyle": "|-|", "color": MARGIN, "lw": 1.5, "shrinkA": 0, "shrinkB": 0},
        )  # fmt: skip


def _frame_axis(axes: Axes, found: Projection, origin: float) -> None:
    """Set the range that is shown: everything, or the neighbourhood of a narrow decision."""
    ends = [float(v - found.inner[0]) for values in found.values for v in values]
    low, high = min(*ends, 0.0), max(*ends, float(found.demanded))
    decision = float(max(abs(found.gap), found.demanded))
    whole = high - low
    zoomed = 0 < decision < _NARROW * whole
    if zoomed:
        centre = found.gap / 2
        low, high = centre - decision / _ZOOMED / 2, centre + decision / _ZOOMED / 2
    room = 0.12 * (high - low) or 1.0
    axes.set_xlim(low - room, high + room)
    axes.set_ylim(-1.1, 2.1)
    axes.set_yticks(_HEIGHTS, [style.name for style in STYLES], fontsize=NORMAL)
    axes.set_xticks([])
    what = "overlap" if found.gap < 0 else "gap"
    text = (f"band: {what}" if found.gap else "line: touching") + (
        "; bar: what the margin demands" if found.demanded else ""
    )
    if zoomed:
        text += f"; zoomed: all spans {whole:.4g}"
    axes.set_xlabel(text, fontsize=SMALL)
    for side in ("top", "right", "left"):
        axes.spines[side].set_visible(False)


def _label_axis(axes: Axes, found: Projection, origin: int) -> None:
    """Label the vertices that are in view with their exact projections."""
    low, high = axes.get_xlim()
    labels: list[Label] = []
    for style, height, values in zip(STYLES, _HEIGHTS, found.values, strict=True):
        for value in sorted(set(values)):
            x = float(value - origin)
            if not low <= x <= high:
                continue
            names = ", ".join(f"{style.name}{i + 1}" for i, other in enumerate(values) if other == value)
            pixel = axes.transData.transform((x, height))
            side = 1 if height > 0 else -1
            labels.append(Label((pixel[0], pixel[1]), f"{names}: {value}", style.colour, side))
    place_labels(axes, labels)


_Points = npt.NDArray[np.float64]
# Never along an axis: what lies one behind the other there is told apart from beside it.
_DIRECTIONS = [(e, a) for e in (16, 26, 36, 46) for a in (-70, -57, -44, -31, -18, 18, 31, 44, 57, 70)]


def draw_scene(axes: Axes3D, pair: Pairs, witness: _Points | None) -> None:
    """Draw a pair (2, 3, 3), and the two points (2, 3) of a witness where there is one."""
    axes.set_proj_type("ortho")
    _frame_scene(axes, pair)
    for style, triangle in zip(STYLES, pair, strict=True):
        _draw_triangle(axes, style, triangle)
    if witness is not None:
        axes.plot(*witness.T, "-", color=WITNESS, lw=2, zorder=9)
        axes.plot(*witness.T, "x", color=WITNESS, ms=9, mew=2, zorder=10)
    axes.view_init(*_clearest(np.unique(pair.reshape(-1, 3), axis=0).astype(np.float64)))


def shapes(pair: Pairs) -> str:
    """Return what A and B are, in words."""
    ranks = {0: "a point", 1: "a segment", 2: "a triangle"}
    both = zip(STYLES, pair.tolist(), strict=True)
    return ", ".join(f"{style.name}: {ranks[triangle_rank(triangle)]}" for style, triangle in both)


def _frame_scene(axes: Axes3D, pair: Pairs) -> None:
    """Show a cube around the pair: the same scale along x, y and z."""
    low, high = pair.reshape(-1, 3).min(0), pair.reshape(-1, 3).max(0)
    half = max(0.6 * float((high - low).max()), 1.0)
    for k, name in enumerate("xyz"):
        centre = float(low[k] + high[k]) / 2
        getattr(axes, f"set_{name}lim")(centre - half, centre + half)
        getattr(axes, f"set_{name}label")(name, fontsize=NORMAL)
        getattr(axes, f"{name}axis").set_major_locator(MaxNLocator(4, integer=True))
    axes.tick_params(labelsize=SMALL - 1.5, colors="#555555")
    axes.set_box_aspect((1, 1, 1))


def _draw_triangle(axes: Axes3D, style: Style, triangle: npt.NDArray[np.int64]) -> None:
    """Draw the face, the edges and the vertices: a segment keeps its edges, a point its vertices."""
    corners = triangle.astype(np.float64)
    axes.add_collection3d(Poly3DCollection([corners], facecolor=style.colour, alpha=0.25, edgecolor="none"))
    _draw_corners(axes, style, corners)


def _draw_corners(axes: Axes, style: Style, corners: _Points) -> None:
    """Draw the edges and the vertices of a triangle (3, 3), or seen along a coordinate (3, 2)."""
    axes.plot(*corners[[0, 1, 2, 0]].T, style.line, color=style.colour, lw=2.1)
    axes.plot(
        *corners.T, style.marker, color=style.colour, ms=style.marker_size,
        mfc="none" if style.hollow else style.colour, mew=1.8,
    )  # fmt: skip


def _names(pair: Pairs) -> dict[tuple[int, ...], list[str]]:
    """Return what the vertices at each place of a pair (2, 3, K) are called."""
    where: dict[tuple[int, ...], list[str]] = {}
    for style, triangle in zip(STYLES, pair.tolist(), strict=True):
        for index, vertex in enumerate(triangle):
            where.setdefault(tuple(vertex), []).append(f"{style.name}{index + 1}")
    return where


def _clearest(points: _Points) -> tuple[int, int]:
    """Return the (elevation, azimuth) from which the nearest two of the points (N, 3) are furthest apart."""
    scored = [(_separation(points, *direction), direction) for direction in _DIRECTIONS]
    return max(scored, key=lambda entry: entry[0])[1]


def _separation(points: _Points, elevation: int, azimuth: int) -> float:
    e, a = np.radians([elevation, azimuth])
    right = np.array([-np.sin(a), np.cos(a), 0])
    up = np.array([-np.sin(e) * np.cos(a), -np.sin(e) * np.sin(a), np.cos(e)])
    seen = points @ np.stack([right, up], 1)
    size = np.ptp(points, axis=0).max() or 1.0
    apart = [float(np.linalg.norm(p - q)) for p, q in combinations(seen, 2)]
    # Points further apart than this are told apart anyway: then the whole counts.
    return min(min(apart, default=0.0) / size, 0.25) + 0.001 * sum(apart) / size


def label_scene(axes: Axes3D, pair: Pairs) -> None:
    """Label the vertices with their coordinates; the figure must have been drawn once."""
    place_labels(axes, [_vertex_label(axes, vertex, names) for vertex, names in _names(pair).items()])


def _vertex_label(axes: Axes3D, vertex: tuple[int, ...], names: list[str]) -> Label:
    homogeneous = axes.get_proj() @ np.array([*vertex, 1.0])
    seen = homogeneous[:2] / homogeneous[3]
    pixel = axes.transData.transform(seen)
    owners = {name[0] for name in names}
    colour = next(s.colour for s in STYLES if s.name in owners) if len(owners) == 1 else WITNESS
    return Label((pixel[0], pixel[1]), f"{', '.join(names)}\n{vertex}", colour)


# Characters of a fraction that is written in full.
_LONGEST_NUMBER = 10


def points_of(nearest: NearestPoints, a: Triangle, b: Triangle) -> tuple[list[Fraction], list[Fraction]]:
    """Return the two nearest points that the weights name."""
    return _point(nearest.weights_a, a), _point(nearest.weights_b, b)


def _point(weights: Vector, triangle: Triangle) -> list[Fraction]:
    return [Fraction(dot(weights, [vertex[k] for vertex in triangle])) for k in range(3)]


def draw_witness(axes: Axes, pair: Pairs, margin: int, nearest: NearestPoints) -> None:
    """Draw a pair (2, 3, 3) and its nearest points; the title gives them and their distance."""
    a, b = pair.tolist()
    points = points_of(nearest, a, b)
    u, v = _shown(pair, points)
    for style, triangle in zip(STYLES, pair, strict=True):
        corners = triangle[:, [u, v]].astype(np.float64)
        axes.add_patch(Polygon(corners, closed=True, fc=style.colour, ec="none", alpha=0.2))
        _draw_corners(axes, style, corners)
    seen = np.array([[float(p[u]), float(p[v])] for p in points])
    axes.plot(*seen.T, "-", color=WITNESS, lw=1.5, zorder=4)
    axes.plot(*seen.T, "x", color=WITNESS, ms=10, mew=2, zorder=5)
    if margin:
        corner = seen[0] - margin
        axes.add_patch(
            Rectangle(tuple(corner), 2 * margin, 2 * margin, fill=False, ec=MARGIN, ls=":", lw=1.8)
        )
    axes.set_aspect("equal")
    _frame_witness(axes, pair[:, :, [u, v]], seen, margin)
    axes.set_xlabel("xyz"[u], fontsize=NORMAL)
    axes.set_ylabel("xyz"[v], fontsize=NORMAL)
    axes.tick_params(labelsize=SMALL)
    for ruler in (axes.xaxis, axes.yaxis):
        ruler.set_major_locator(MaxNLocator(5, integer=True))
    square = "; dotted: all within the margin of the first" if margin else ""
    axes.set_title(
        f"nearest points (x) {_text(points[0])}, {_text(points[1])}\n"
        f"distance {_number(nearest.distance)} \N{LESS-THAN OR EQUAL TO} margin {margin}{square}",
        fontsize=NORMAL, loc="left",
    )  # fmt: skip


def _frame_witness(axes: Axes, corners: Pairs, seen: npt.NDArray[np.float64], margin: int) -> None:
    """Show the triangles, and the square around the first point: at least one step above and below."""
    all_points = np.concatenate([corners.reshape(-1, 2), seen, seen[:1] - margin, seen[:1] + margin])
    centre, half = (all_points.min(0) + all_points.max(0)) / 2, np.ptp(all_points, axis=0) / 2
    # The same scale along both, and the whole place used.
    extent = axes.get_window_extent()
    shape = np.array([extent.width, extent.height]) / extent.height
    half = shape * max(1.35 * float((half / shape).max()), 1.5)
    axes.set_xlim(centre[0] - half[0], centre[0] + half[0])
    axes.set_ylim(centre[1] - half[1], centre[1] + half[1])


def label_witness(axes: Axes, pair: Pairs, nearest: NearestPoints) -> None:
    """Label the vertices by name; the figure must have been drawn once."""
    u, v = _shown(pair, points_of(nearest, *pair.tolist()))
    labels: list[Label] = []
    for at, names in _names(pair[:, :, [u, v]]).items():
        pixel = axes.transData.transform(at)
        labels.append(Label((pixel[0], pixel[1]), ", ".join(names), WITNESS))
    place_labels(axes, labels)


def _shown(pair: Pairs, points: tuple[list[Fraction], list[Fraction]]) -> tuple[int, int]:
    """Return the two coordinates to show: that of the distance if there is one, then the widest."""
    gaps = [abs(x - y) for x, y in zip(*points, strict=True)]
    spread = np.ptp(pair.reshape(-1, 3), axis=0).tolist()
    first = sorted(range(3), key=lambda k: (-gaps[k], -spread[k], k))[:1]
    rest = sorted({0, 1, 2} - set(first), key=lambda k: (-spread[k], k))[:1]
    u, v = sorted([*first, *rest])
    return u, v


def _text(point: list[Fraction]) -> str:
    return f"({', '.join(map(_number, point))})"


def _number(value: Fraction) -> str:
    """Return the fraction, or some digits of one that is too long."""
    exact = str(value)
    return exact if len(exact) <= _LONGEST_NUMBER else f"~{float(value):.6g}"
