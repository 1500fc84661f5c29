"""The picture of a counterexample: the triangles in space, and the view that shows the decision.

Where an axis is claimed, by the core or by the golden model, the projections on it; where the pair is
near, two nearest points.
"""

from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D

from triaxis.golden.axes import first_separating
from triaxis.golden.judge import judge
from triaxis.golden.pairs import NO_AXIS
from triaxis.host.figures import LARGE, NORMAL, write_figure
from triaxis.sim.result import NEAR
from triaxis.verif.counterexample.finding import Counterexample
from triaxis.verif.counterexample.views import (
    draw_axis,
    draw_scene,
    draw_witness,
    label_scene,
    label_witness,
    points_of,
    shapes,
)

_INCHES = (13.0, 7.2)
_DPI = 110
_LONGEST = 150


def draw(counterexample: Counterexample, path: Path) -> None:
    """Draw into a file, ``.png`` or ``.svg``: whole or not at all. Raises InputError where it cannot."""
    write_figure(_figure(counterexample), path)


def _figure(counterexample: Counterexample) -> Figure:
    pair, margin = counterexample.stream.pair, counterexample.stream.margin
    a, b = pair.tolist()
    nearest = judge(a, b, margin).witness
    figure = Figure(figsize=_INCHES, dpi=_DPI)
    canvas = FigureCanvasAgg(figure)
    _write_header(figure, counterexample)
    scene = figure.add_axes((0.02, 0.04, 0.48, 0.7), projection="3d")
    assert isinstance(scene, Axes3D)
    witness = None
    if nearest is not None:
        witness = np.array([[float(x) for x in point] for point in points_of(nearest, a, b)])
    draw_scene(scene, pair, witness)
    marked = "; x: nearest points" if nearest is not None else ""
    figure.text(0.05, 0.79, shapes(pair) + marked, fontsize=NORMAL)
    views = _axes_to_show(counterexample)
    places = _places(len(views) + (nearest is not None))
    panels = [figure.add_axes(place) for place in places]
    for panel, (number, whose) in zip(panels, views, strict=False):
        draw_axis(panel, number, a, b, margin, whose)
    if nearest is not None:
        draw_witness(panels[-1], pair, margin, nearest)
    canvas.draw()
    # These need the final layout.
    label_scene(scene, pair)
    if nearest is not None:
        label_witness(panels[-1], pair, nearest)
    return figure


def _axes_to_show(counterexample: Counterexample) -> list[tuple[int, str]]:
    """Return the axes that were claimed, each with who claims it."""
    stream, said = counterexample.stream, counterexample.claim
    exact = int(first_separating(stream.pairs[-1:], stream.margins[-1:])[0])
    if said is not None and said == exact:
        return [(exact, "claimed, and right")]
    views = [] if said is None else [(said, "core claims")]
    if exact != NO_AXIS:
        # A core without the edge x box axes is right to say near where only they separate.
        views.append(
            (exact, "separates, but is not in this core" if counterexample.right & NEAR else "right")
        )
    return views


def _places(count: int) -> list[tuple[float, float, float, float]]:
    """Return (left, bottom, width, height) of the views on the right, from the top."""
    if count == 1:
        return [(0.56, 0.22, 0.41, 0.44)]
    return [(0.56, 0.53, 0.41, 0.22), (0.56, 0.08, 0.41, 0.3)]


def _write_header(figure: Figure, counterexample: Counterexample) -> None:
    """Write what is wrong, what the core said, and what is right."""
    stream = counterexample.stream
    title = f"{counterexample.configuration.name}, margin {stream.margin}: the core "
    title += counterexample.symptom.description
    figure.text(0.03, 0.955, title, fontsize=LARGE, weight="bold")
    lines = [f"core said: {counterexample.core_said}", f"right is:    {counterexample.right_answer}"]
    if len(stream) > 1:
        before = f"only after: {stream.describe().rpartition('; then ')[0]}"
        lines.append(before if len(before) <= _LONGEST else before[: _LONGEST - 3] + " ..")
    figure.text(0.03, 0.94, "\n".join(lines), fontsize=NORMAL, va="top", linespacing=1.5)
