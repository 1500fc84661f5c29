"""Figures as files: PNG and SVG, whole or not at all; the same figure gives the same files."""

import io
from pathlib import Path
from typing import Any

from matplotlib import rc_context
from matplotlib.figure import Figure

from triaxis.golden.whole_files import write_whole

# No date, and fixed names inside.
_METADATA: dict[str, dict[str, Any] | None] = {"png": None, "svg": {"Date": None}}
_STYLE: dict[Any, Any] = {"svg.hashsalt": "triaxis", "svg.fonttype": "none"}


def write_figure(figure: Figure, path: Path) -> list[Path]:
    """Write ``path`` with the endings .png and .svg; raise InputError where that cannot be done."""
    written: list[Path] = []
    for suffix, metadata in _METADATA.items():
        content = io.BytesIO()
        with rc_context(_STYLE):
            figure.savefig(content, format=suffix, metadata=metadata)
        written.append(write_whole(path.with_suffix(f".{suffix}"), content.getvalue()))
    return written
