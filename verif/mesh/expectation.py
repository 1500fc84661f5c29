"""How a run must end, if nothing aborts it, from its definition."""

import numpy as np

from triaxis.golden.pairs import coordinate_range
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.mesh_engine import Mode, Move, Status
from triaxis.verif.mesh.observed import Integers, ObservedRun


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
