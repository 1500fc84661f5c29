"""How figures look, and how they become files: whole or not at all, the same figure the same files.

One style, with A and B, and all else, told apart by colour-blind eyes too.
"""

import io
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from triaxis.golden.outputs import write_whole


@dataclass(frozen=True)
class Style:
    """The look of one triangle."""

    name: str
    colour: str
    marker: str
    marker_size: float
    hollow: bool
    line: str


# Colours of M. Okabe and K. Ito, "Color Universal Design", 2008.
BLACK, ORANGE, SKY, GREEN = "#000000", "#E69F00", "#56B4E9", "#009E73"
BLUE, VERMILION, PURPLE, GREY = "#0072B2", "#D55E00", "#CC79A7", "#6E6E6E"
# A's hollow markers go around B's.
A = Style("A", BLUE, "o", 11, True, "-")
B = Style("B", VERMILION, "s", 6, False, "--")
STYLES = (A, B)
WITNESS, GAP, MARGIN = BLACK, GREEN, GREY
SMALL, NORMAL, LARGE = 8.5, 10, 13

_CHART: dict[Any, Any] = {"axes.spines.top": False, "axes.spines.right": False}


@contextmanager
def chart(inches: tuple[float, float], dpi: int) -> Iterator[Figure]:
    """Give an empty figure to draw charts into while the block runs."""
    with rc_context(_CHART):
        figure = Figure(figsize=inches, dpi=dpi)
        FigureCanvasAgg(figure)
        yield figure


# No date, and fixed names inside.
_METADATA: dict[str, dict[str, Any] | None] = {".png": None, ".svg": {"Date": None}}
_STYLE: dict[Any, Any] = {"svg.hashsalt": "triaxis", "svg.fonttype": "none"}


def drawn(figure: Figure, suffix: str = ".svg") -> bytes:
    """Return what a file of that kind holds: the same for the same figure."""
    content = io.BytesIO()
    with rc_context(_STYLE):
        figure.savefig(content, format=suffix[1:], metadata=_METADATA[suffix])
    return content.getvalue()


def write_figure(figure: Figure, path: Path) -> Path:
    """Write as PNG or SVG, as the name ends; raise InputError where that cannot be done."""
    return write_whole(path, drawn(figure, path.suffix))


def write_figures(figure: Figure, path: Path) -> list[Path]:
    """Write ``path`` with the endings .png and .svg; raise InputError where that cannot be done."""
    return [write_figure(figure, path.with_suffix(suffix)) for suffix in _METADATA]
