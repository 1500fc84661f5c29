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
_ANGLES = np.linspace(0, 2 * np.pi, 16, endpoint=False) + np.pi / 4


@dataclass(frozen=True)
class Label:
    """Text for a point at ``at``, pixels of the figure; rather above it (+1) or below it (-1)."""

    at: tuple[float, float]
    text: str
    colour: str
    side: int = 0


# Left, bottom, right and top of boxes (.., 4), or x and y of points (.., 2).
_Floats = npt.NDArray[np.float64]


def place_labels(axes: Axes, labels: Sequence[Label]) -> None:
    """Write the labels; the figure must have its final layout. Works in points, so at any resolution."""
    figure = axes.get_figure(root=True)
    assert isinstance(figure, Figure)
    scale = 72 / figure.dpi
    extent = axes.get_window_extent()
    frame = np.array([extent.x0, extent.y0, extent.x1, extent.y1]) * scale
    points = np.array([label.at for label in labels]).reshape(-1, 2) * scale
    taken = np.concatenate([points - 5, points + 5], 1)
    for label, point in zip(labels, points, strict=True):
        centre, box = _best_place(label, point, points.mean(0), taken, frame)
        taken = np.concatenate([taken, box[None]])
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
    label: Label, point: _Floats, middle: _Floats, taken: _Floats, frame: _Floats
) -> tuple[_Floats, _Floats]:
    """Return where to put the label's centre, and the box that it covers then."""
    lines = label.text.split("\n")
    half = np.array([max(map(len, lines)) * _CHARACTER, len(lines) * _LINE]) * SMALL / 2
    distance = np.repeat(_DISTANCES, len(_ANGLES))
    angle = np.tile(_ANGLES, len(_DISTANCES))
    direction = np.stack([np.cos(angle), np.sin(angle)], 1)
    centres = point + direction * (distance[:, None] + np.abs(direction) * half)
    boxes = np.concatenate([centres - half, centres + half], 1)
    common = np.minimum(boxes[:, None, 2:], taken[:, 2:]) - np.maximum(boxes[:, None, :2], taken[:, :2])
    covered = common.clip(0).prod(2).sum(1)
    outside = (frame[:2] - boxes[:, :2]).clip(0) + (boxes[:, 2:] - frame[2:]).clip(0)
    inwards = 0.02 * (direction @ (middle - point)).clip(0)
    astray = abs(label.side) * 12 * (1 - label.side * direction[:, 1])
    best = (covered + 20 * outside.sum(1) + distance + inwards + astray).argmin()
    return centres[best], boxes[best]
