"""Labels beside points, placed so that they cover neither each other nor the points."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from triaxis.host.figures import SMALL

# Widths of a character and of a line, in units of the font size: a little more than they take.
_CHARACTER, _LINE = 0.6, 1.25
# Directions and distances (points) that are tried, the nearest first.
_DISTANCES = (13, 24, 38, 56, 80)
_DIRECTIONS = np.linspace(0, 2 * np.pi, 16, endpoint=False) + np.pi / 4


@dataclass(frozen=True)
class Label:
    """Text for a point at ``at``, pixels of the figure; rather above it (+1) or below it (-1)."""

    at: tuple[float, float]
    text: str
    colour: str
    side: int = 0


@dataclass(frozen=True)
class _Box:
    left: float
    bottom: float
    right: float
    top: float

    def overlap(self, other: "_Box") -> float:
        """Return the common area."""
        width = min(self.right, other.right) - max(self.left, other.left)
        height = min(self.top, other.top) - max(self.bottom, other.bottom)
        return max(width, 0) * max(height, 0)

    def outside(self, frame: "_Box") -> float:
        """Return by how much this leaves the frame."""
        out_x = max(frame.left - self.left, 0) + max(self.right - frame.right, 0)
        return out_x + max(frame.bottom - self.bottom, 0) + max(self.top - frame.top, 0)


def place_labels(axes: Axes, labels: Sequence[Label]) -> None:
    """Write the labels; the figure must have its final layout. Works in points, so at any resolution."""
    figure = axes.get_figure(root=True)
    assert isinstance(figure, Figure)
    scale = 72 / figure.dpi
    extent = axes.get_window_extent()
    frame = _Box(extent.x0 * scale, extent.y0 * scale, extent.x1 * scale, extent.y1 * scale)
    points = [(label.at[0] * scale, label.at[1] * scale) for label in labels]
    taken = [_Box(x - 5, y - 5, x + 5, y + 5) for x, y in points]
    middle = np.mean(points, axis=0) if points else np.zeros(2)
    for label, point in zip(labels, points, strict=True):
        centre, box = _best_place(label, np.array(point), middle, taken, frame)
        taken.append(box)
        width, height = figure.get_size_inches() * 72
        axes.annotate(
            label.text,
            xy=(point[0] / width, point[1] / height), xycoords="figure fraction",
            xytext=(centre[0] / width, centre[1] / height), textcoords="figure fraction",
            ha="center", va="center", fontsize=SMALL, color=label.colour, annotation_clip=False,
            arrowprops={"arrowstyle": "-", "color": label.colour, "lw": 0.6, "shrinkA": 0, "shrinkB": 4},
            bbox={"boxstyle": "square,pad=0.1", "fc": "white", "ec": "none", "alpha": 0.75},
        )  # fmt: skip


def _best_place(
    label: Label,
    point: npt.NDArray[np.float64],
    middle: npt.NDArray[np.float64],
    taken: Sequence[_Box],
    frame: _Box,
) -> tuple[npt.NDArray[np.float64], _Box]:
    """Return where to put the label's centre, and what it covers then."""
    lines = label.text.split("\n")
    half = np.array([max(map(len, lines)) * _CHARACTER, len(lines) * _LINE]) * SMALL / 2
    outwards = point - middle
    best: tuple[float, npt.NDArray[np.float64], _Box] | None = None
    for distance in _DISTANCES:
        for angle in _DIRECTIONS:
            direction = np.array([np.cos(angle), np.sin(angle)])
            centre = point + direction * (distance + np.abs(direction) * half)
            box = _Box(*(centre - half).tolist(), *(centre + half).tolist())
            covered = sum(box.overlap(other) for other in taken)
            inwards = 0.02 * max(-float(direction @ outwards), 0.0)
            astray = 12 * (1 - label.side * direction[1]) if label.side else 0.0
            cost = covered + 20 * box.outside(frame) + distance + inwards + astray
            if best is None or cost < best[0]:
                best = (cost, centre, box)
    assert best is not None
    return best[1], best[2]
