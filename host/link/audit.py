"""Whether what the board says about a run is enough for a verdict.

The run must be the one that was asked for, and complete: a run that left pairs out cannot pass for clear.
"""

from dataclasses import astuple
from enum import Enum

import numpy as np

from triaxis.host.link.board import BoardRun
from triaxis.host.link.codes import Mode, RunEnd, State
from triaxis.host.link.contradictions import contradiction, must_be
from triaxis.host.link.errors import LinkError

_MEANING = {
    RunEnd.ABORTED: "the run was aborted",
    RunEnd.OVERFLOW: "A leaves the board's coordinates when moved: move less, or use a coarser resolution",
    RunEnd.OVERFULL: "a mesh has more triangles than the board holds",
    RunEnd.BAD_MODE: "the board does not know the mode",
}


class Verdict(Enum):
    """Whether any pair is within the margin."""

    CLEAR = "clear"
    NEAR = "near"


def audit(run: BoardRun) -> Verdict:
    """Return the verdict of a run whose status does not contradict itself; LinkError where there is none."""
    status, request = run.status, run.request
    must_be("state", status.state, State.DONE)
    must_be("run number", status.run, run.number)
    must_be("mode", status.mode, request.mode)
    must_be("pose", (status.x, status.y, status.z), astuple(run.pose))
    must_be("margin", status.margin, request.margin)
    must_be("triangles", (status.count_a, status.count_b), (request.count_a, request.count_b))
    if status.end in _MEANING:
        raise LinkError(f"{_MEANING[RunEnd(status.end)]}; verdict unknown")
    must_be("near pairs received", len(run.near), 0 if request.mode == Mode.COUNT else status.near)
    if (run.near >= (request.count_a, request.count_b)).any():
        raise contradiction("a near pair of triangles that were not loaded")
    if len(np.unique(run.near, axis=0)) != len(run.near):
        raise contradiction("a near pair twice")
    return Verdict.NEAR if status.near else Verdict.CLEAR
