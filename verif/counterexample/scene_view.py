"""The two triangles in space, from where their vertices are easiest to tell apart."""

from itertools import combinations

import numpy as np
import numpy.typing as npt
from matplotlib.ticker import MaxNLocator
from mpl_toolkits.mplot3d import Axes3D
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from triaxis.golden.exact import triangle_rank
from triaxis.golden.pairs import Pairs
from triaxis.host.figure_style import NORMAL, SMALL, STYLES, WITNESS, Style
from triaxis.verif.counterexample.labels import Label, place_labels

_Points = npt.NDArray[np.float64]
# Never along an axis: what lies one behind the other there is told apart from beside it.
_DIRECTIONS = [(e, a) for e in (16, 26, 36, 46) for a in (-70, -57, -44, -31, -18, 18, 31, 44, 57, 70)]


def draw_scene(axes: Axes3D, pair: Pairs, witness: _Points | None) -> None:
    """Draw a pair (2, 3, 3), and the two points (2, 3) of a witness where there is one."""
    axes.set_proj_type("ortho")
    _frame(axes, pair)
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


def _frame(axes: Axes3D, pair: Pairs) -> None:
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
    around = corners[[0, 1, 2, 0]]
    axes.plot(*around.T, style.line, color=style.colour, lw=2.2)
    axes.plot(
        *corners.T, style.marker, color=style.colour, ms=style.marker_size,
        mfc="none" if style.hollow else style.colour, mew=2,
    )  # fmt: skip


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
    where: dict[tuple[int, ...], list[str]] = {}
    for style, triangle in zip(STYLES, pair.tolist(), strict=True):
        for index, vertex in enumerate(triangle):
            where.setdefault(tuple(vertex), []).append(f"{style.name}{index + 1}")
    place_labels(axes, [_label(axes, vertex, names) for vertex, names in where.items()])


def _label(axes: Axes3D, vertex: tuple[int, ...], names: list[str]) -> Label:
    homogeneous = axes.get_proj() @ np.array([*vertex, 1.0])
    seen = homogeneous[:2] / homogeneous[3]
    pixel = axes.transData.transform(seen)
    owners = {name[0] for name in names}
    colour = next(s.colour for s in STYLES if s.name in owners) if len(owners) == 1 else WITNESS
    return Label((pixel[0], pixel[1]), f"{', '.join(names)}\n{vertex}", colour)
