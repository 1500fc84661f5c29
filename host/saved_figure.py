"""Figures as files, whole or not at all; the same figure gives the same files."""

import io
from pathlib import Path
from typing import Any

from matplotlib import rc_context
from matplotlib.figure import Figure

from triaxis.golden.outputs import write_whole

# No date, and fixed names inside.
_METADATA: dict[str, dict[str, Any] | None] = {".png": None, ".svg": {"Date": None}}
_STYLE: dict[Any, Any] = {"svg.hashsalt": "triaxis", "svg.fonttype": "none"}


def write_figure(figure: Figure, path: Path) -> Path:
    """Write as PNG or SVG, as the name ends; raise InputError where that cannot be done."""
    content = io.BytesIO()
    with rc_context(_STYLE):
        figure.savefig(content, format=path.suffix[1:], metadata=_METADATA[path.suffix])
    return write_whole(path, content.getvalue())


def write_figures(figure: Figure, path: Path) -> list[Path]:
    """Write ``path`` with the endings .png and .svg; raise InputError where that cannot be done."""
    return [write_figure(figure, path.with_suffix(suffix)) for suffix in _METADATA]
