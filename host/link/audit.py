"""Whether what the board says about a run is enough for a verdict.

The board's counters must account for every pair: a run that left some out cannot pass for clear.
"""

from dataclasses import astuple
from enum import Enum

import numpy as np

from triaxis.host.link.board import BoardRun
from triaxis.host.link.codes import Mode, RunEnd, State
from triaxis.host.link.errors import LinkError
from triaxis.host.link.messages import Description, Status

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


def audit(run: BoardRun, board: Description) -> Verdict:
    """Return the verdict of a run; raises LinkError where anything about it is not as it must be."""
    status = run.status
    _same("state", status.state, State.DONE)
    _same("run number", status.run, run.number)
    _same("pose", (status.x, status.y, status.z), astuple(run.pose))
    _same("margin", status.margin, run.request.margin)
    _same("triangles", (status.count_a, status.count_b), (run.request.count_a, run.request.count_b))
    if status.end in _MEANING:
        raise LinkError(f"{_MEANING[RunEnd(status.end)]}; verdict unknown")
    _same("near pairs received", len(run.near), 0 if run.request.mode == Mode.COUNT else status.near)
    _check_near(run)
    if status.near > status.tested:
        _fail(f"{status.near} near pairs of {status.tested} tested")
    if status.end == RunEnd.COMPLETE:
        _check_complete(status, board.group)
        return Verdict.NEAR if status.near else Verdict.CLEAR
    if status.end == RunEnd.FIRST and run.request.mode == Mode.FIRST and status.near:
        return Verdict.NEAR
    return _fail(f"engine status {status.end} in mode {run.request.mode} with {status.near} near pairs")


def _check_near(run: BoardRun) -> None:
    counts = (run.request.count_a, run.request.count_b)
    if (run.near >= counts).any():
        _fail("a near pair of triangles that were not loaded")
    if len(np.unique(run.near, axis=0)) != len(run.near):
        _fail("a near pair twice")


def _check_complete(status: Status, group: int) -> None:
    """Every pair was in a skipped group pair, skipped by its boxes, or tested."""
    a, b = status.count_a, status.count_b
    group_pairs = -(-a // group) * -(-b // group)
    _same("group pairs", status.groups_skipped + status.groups_opened, group_pairs)
    opened = status.pairs_skipped + status.tested
    least = max(a * b - status.groups_skipped * group * group, 0)
    most = min(a * b, status.groups_opened * group * group)
    if not least <= opened <= most:
        _fail(f"{opened} pairs skipped or tested, must be {least}..{most}")


def _same(what: str, found: object, wanted: object) -> None:
    if found != wanted:
        _fail(f"{what}: {found}, must be {wanted}")


def _fail(what: str) -> Verdict:
    raise LinkError(f"the board's answer contradicts itself or us: {what}; verdict unknown")
