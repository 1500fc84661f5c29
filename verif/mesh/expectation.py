"""How a run must end, if nothing aborts it; whether lists of pairs are what is due."""

import numpy as np
import numpy.typing as npt

from triaxis.golden.pairs import coordinate_range
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.mesh_engine import Mode, Move, Status
from triaxis.verif.mesh.items import Integers, ObservedRun


def moved(triangles: Integers, translation: Move) -> Integers:
    """Return triangles (N, 3, 3) moved by a translation."""
    return triangles + np.array(translation, np.int64)


def overflows(triangles: Integers, translation: Move, width: int) -> bool:
    """Return whether any coordinate of triangles (N, 3, 3), moved, leaves the width."""
    low, high = coordinate_range(width)
    there = moved(triangles, translation)
    return bool(len(there)) and bool(there.min() < low or there.max() > high)


def expected_status(run: ObservedRun, configuration: MeshConfiguration) -> Status:
    """Return the status that is due; COMPLETE also where mode first may stop earlier."""
    if run.request.mode not in list(Mode):
        return Status.BAD_MODE
    if any(run.overfull):
        return Status.OVERFULL
    if overflows(run.a, run.request.translation, configuration.width):
        return Status.OVERFLOW
    return Status.COMPLETE


def begins(whole: Integers, part: Integers) -> bool:
    """Return whether pairs (N, 2) begin with pairs (K, 2)."""
    return len(part) <= len(whole) and bool((whole[: len(part)] == part).all())


def first_of(mask: npt.NDArray[np.bool_]) -> tuple[int, int]:
    """Return the first pair of a mask (N, M) that is set."""
    i, j = np.argwhere(mask)[0]
    return int(i), int(j)


def difference(found: Integers, due: Integers) -> str:
    """Return where two lists of pairs part, in words."""
    common = min(len(found), len(due))
    unlike = np.flatnonzero((found[:common] != due[:common]).any(1))
    at = int(unlike[0]) if len(unlike) else common
    here = [str(tuple(pairs[at].tolist())) if at < len(pairs) else "none" for pairs in (found, due)]
    return f"number {at} is {here[0]}, {here[1]} is due; {len(found)} and {len(due)} in all"
