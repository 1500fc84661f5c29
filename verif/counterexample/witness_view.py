"""Two nearest points of a near pair, seen along one coordinate, with the square that the margin allows."""

from fractions import Fraction

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.patches import Polygon, Rectangle
from matplotlib.ticker import MaxNLocator

from triaxis.golden.exact import Triangle, Vector, dot
from triaxis.golden.pairs import Pairs
from triaxis.golden.solver import NearestPoints
from triaxis.host.figure_style import MARGIN, NORMAL, SMALL, STYLES, WITNESS
from triaxis.verif.counterexample.labels import Label, place_labels

# Characters of a fraction that is written in full.
_LONGEST = 10


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
        axes.plot(*corners[[0, 1, 2, 0]].T, style.line, color=style.colour, lw=2)
        axes.plot(
            *corners.T, style.marker, color=style.colour, ms=style.marker_size,
            mfc="none" if style.hollow else style.colour, mew=1.5,
        )  # fmt: skip
    seen = np.array([[float(p[u]), float(p[v])] for p in points])
    axes.plot(*seen.T, "-", color=WITNESS, lw=1.5, zorder=4)
    axes.plot(*seen.T, "x", color=WITNESS, ms=10, mew=2, zorder=5)
    if margin:
        corner = seen[0] - margin
        axes.add_patch(
            Rectangle(tuple(corner), 2 * margin, 2 * margin, fill=False, ec=MARGIN, ls=":", lw=1.8)
        )
    axes.set_aspect("equal")
    _frame(axes, pair[:, :, [u, v]], seen, margin)
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


def _frame(axes: Axes, corners: Pairs, seen: npt.NDArray[np.float64], margin: int) -> None:
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
    where: dict[tuple[int, int], list[str]] = {}
    for style, triangle in zip(STYLES, pair.tolist(), strict=True):
        for index, vertex in enumerate(triangle):
            where.setdefault((vertex[u], vertex[v]), []).append(f"{style.name}{index + 1}")
    labels: list[Label] = []
    for at, names in where.items():
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
    return exact if len(exact) <= _LONGEST else f"~{float(value):.6g}"
