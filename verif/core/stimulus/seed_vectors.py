"""The fifteen hand-written vectors of the design that this core replaces (seed_vectors.csv).

Their coordinates reach 33,293, beyond 16 signed bits: there they silently wrapped. Here they are
moved by a common offset, which changes no verdict.
"""

import csv
from pathlib import Path

import numpy as np
import numpy.typing as npt

from triaxis.golden.errors import InputError
from triaxis.golden.pairs import Pairs, coordinate_range

_FILE = Path(__file__).with_name("seed_vectors.csv")
_POINTS = ("A1", "A2", "A3", "B1", "B2", "B3")
# Brings 2,219..33,293 (and z, 0..5,000) into 16 signed bits.
_OFFSET = np.array([-16384, -16384, 0])


def _columns(points: tuple[str, ...]) -> npt.NDArray[np.int64]:
    with _FILE.open(newline="") as file:
        rows = list(csv.DictReader(file))
    return np.array(
        [[[int(row[f"{point}_{axis}"]) for axis in "xyz"] for point in points] for row in rows],
        np.int64,
    )


def seed_vectors_as_written() -> Pairs:
    """Return the fifteen pairs where they were: (15, 2, 3, 3). They need 17 bits."""
    return _columns(_POINTS).reshape(-1, 2, 3, 3)


def seed_vectors(width: int) -> Pairs:
    """Return the fifteen pairs, moved into range: (15, 2, 3, 3). All are clear.

    Raises InputError where the width cannot hold them.
    """
    pairs = (_columns(_POINTS) + _OFFSET).reshape(-1, 2, 3, 3)
    low, high = coordinate_range(width)
    if pairs.min() < low or pairs.max() > high:
        raise InputError(f"seed vectors: width {width} is too small: at least 16 bits are needed")
    return pairs


def seed_normals() -> npt.NDArray[np.int64]:
    """Return what the vectors hand in as normals of A and B, which are points: (15, 2, 3)."""
    return _columns(("NA", "NB"))
