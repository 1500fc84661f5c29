"""Two meshes on the board, from facets in the files' order to near pairs in the same."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from triaxis.golden.pairs import coordinate_range
from triaxis.host.link.audit import Verdict, audit
from triaxis.host.link.board import Board, BoardRun
from triaxis.host.link.codes import Mesh, Mode
from triaxis.host.link.errors import LinkError, SessionLostError
from triaxis.host.link.messages import Pose, Status
from triaxis.host.spatial_order import spatial_order

# Frames that come late may undo a session; so many in a row are no accident.
_ATTEMPTS = 3


@dataclass(frozen=True)
class BoardCheck:
    """A verdict, and the audited status behind it. ``near``: facet numbers (i of A, j of B), sorted."""

    verdict: Verdict
    status: Status
    near: npt.NDArray[np.int64]


def check_on_board(
    board: Board,
    a: npt.NDArray[np.int64],
    b: npt.NDArray[np.int64],
    margin: int,
    pose: Pose,
    mode: Mode,
    progress: Callable[[int], None] | None = None,
) -> BoardCheck:
    """Decide facets A (N, 3, 3), moved by ``pose``, against B (M, 3, 3), all on the board's grid.

    ``board``: after `Board.hello`. ``progress`` is told of facets loaded. Raises LinkError where the meshes
    do not fit the board, or no verdict can be had.
    """
    check_fit(board, a, b, margin, pose)
    group = board.description.group
    order_a, order_b = spatial_order(a, group), spatial_order(b, group)
    run = _run(board, a[order_a], b[order_b], margin, pose, mode, progress)
    verdict = audit(run)
    near = np.stack([order_a[run.near[:, 0]], order_b[run.near[:, 1]]], 1)
    return BoardCheck(verdict, run.status, near[np.lexsort((near[:, 1], near[:, 0]))])


def _run(
    board: Board,
    a: npt.NDArray[np.int64],
    b: npt.NDArray[np.int64],
    margin: int,
    pose: Pose,
    mode: Mode,
    progress: Callable[[int], None] | None,
) -> BoardRun:
    """Load and run, in a new session where the first one or two were lost."""
    attempt = 1
    while True:
        try:
            board.load(Mesh.A, a, progress)
            board.load(Mesh.B, b, progress)
            board.move(pose)
            return board.run(mode, margin)
        except SessionLostError:
            if attempt == _ATTEMPTS:
                raise
        attempt += 1
        board.hello()


def check_fit(
    board: Board, a: npt.NDArray[np.int64], b: npt.NDArray[np.int64], margin: int, pose: Pose
) -> None:
    """Raise LinkError where the board is too small for the meshes, the margin or the move."""
    is_ = board.description
    for name, mesh in (("A", a), ("B", b)):
        if len(mesh) > is_.depth:
            raise LinkError(
                f"{name}: {len(mesh)} facets: the board holds {is_.depth} a mesh; split or simplify it"
            )
    if margin >= 1 << is_.margin_bits:
        raise LinkError(
            f"margin {margin}: the board's has {is_.margin_bits} bits, at most {(1 << is_.margin_bits) - 1}; "
            "use a coarser resolution or a smaller clearance"
        )
    low, high = coordinate_range(is_.width)
    moved = a + np.array([pose.x, pose.y, pose.z])
    for name, mesh in (("A", a), ("B", b), ("A when moved", moved)):
        if mesh.min() < low or mesh.max() > high:
            raise LinkError(
                f"{name}: coordinates {mesh.min()}..{mesh.max()}: the board's have {is_.width} bits, {low}.."
                f"{high}; use a coarser resolution"
            )
