"""Reports of checks as JSON: exact numbers become decimals, of 17 digits."""

import json
from dataclasses import asdict, is_dataclass
from numbers import Rational
from pathlib import Path
from typing import Any

import numpy as np

from triaxis.golden.outputs import write_whole
from triaxis.host.enclosure import Enclosure
from triaxis.host.engines import Counts
from triaxis.host.quantise import Grid

# The clock that times are given for.
_CLOCK_HZ = 100_000_000


def write_report(path: Path, report: dict[str, Any]) -> Path:
    """Write a report of dataclasses, fractions and arrays; raise InputError where that cannot be done."""
    return write_whole(path, json.dumps(report, indent=2, default=_plain) + "\n")


def _plain(value: Any) -> Any:
    if isinstance(value, Rational):
        return float(value)
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, np.ndarray):
        return value.tolist()
    if is_dataclass(value) and not isinstance(value, type):
        return asdict(value)
    raise TypeError(f"{type(value).__name__} in a report")


def milliseconds(cycles: int | None) -> float | None:
    """Return how long the engine takes at 100 MHz; None where no cycles were counted."""
    return None if cycles is None else cycles * 1000 / _CLOCK_HZ


def grid_entry(grid: Grid) -> dict[str, Any]:
    """Return the grid's part of a report."""
    return {"width": grid.width, "resolution": grid.resolution, "offset": grid.offset}


def enclosure_entry(enclosure: Enclosure, surfaces_only: bool) -> dict[str, Any]:
    """Return what is known of insides, and whether nobody wanted to know."""
    return {"surfaces_only": surfaces_only, "enclosure": enclosure}


def counts_entry(counts: Counts, near: str) -> dict[str, Any]:
    """Return what runs did; ``near``: what its near pairs are called there."""
    return {
        "group_pairs_skipped": counts.group_pairs_skipped,
        "group_pairs_opened": counts.group_pairs_opened,
        "pairs_skipped_in_groups": counts.skipped_in_groups,
        "pairs_skipped_by_their_boxes": counts.skipped,
        "pairs_tested": counts.tested,
        "clears_certified": counts.certified,
        near: counts.near_count,
        "cycles": counts.cycles,
        "milliseconds_at_100_MHz": milliseconds(counts.cycles),
    }
