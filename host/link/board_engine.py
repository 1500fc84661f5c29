"""The board as an engine: two meshes, from facets in the files' order to near pairs in the same."""

import numpy as np

from triaxis.golden.pairs import coordinate_range
from triaxis.host.broadphase import in_order
from triaxis.host.engines import Integers, Progress, SceneEngine, SceneRun, Translation, unwatched
from triaxis.host.link.audit import BoardRun, audit, contradiction
from triaxis.host.link.board import Board
from triaxis.host.link.exchange import LinkError, SessionLostError
from triaxis.host.link.messages import NO_ZONES, Description, Flag, Mesh, Mode, Pose, RunEnd, Status
from triaxis.sim.mesh_engine import spatial_order

# Frames that come late may undo a session; so many in a row are no accident.
_ATTEMPTS = 3


def check_depth(name: str, mesh: Integers, board: Description) -> None:
    """Raise LinkError where a mesh, of a name, has more facets than the board holds."""
    if len(mesh) > board.depth:
        raise LinkError(
            f"{name}: {len(mesh)} facets: the board holds {board.depth} a mesh; split or simplify it"
        )


class BoardEngine(SceneEngine):
    """A board that is asked about two meshes again and again. ``status``: of the last run, audited.

    A clear run makes the board's output say go, until the next run or command.
    """

    status: Status

    def __init__(
        self, board: Board, a: Integers, b: Integers, mode: Mode = Mode.ALL, progress: Progress = unwatched
    ) -> None:
        """Take facets (N, 3, 3) on the board's grid, which are loaded when they are first asked about.

        ``board``: after `Board.hello`. ``mode``: of runs that do not stop at the first near pair.
        ``progress`` is told of facets loaded.
        """
        self._board, self._a, self._b, self._mode, self._progress = board, a, b, mode, progress
        group = board.description.group
        self._order_a, self._order_b = spatial_order(a, group), spatial_order(b, group)
        self._loaded = False

    def run(self, translation: Translation, margin: int, stop_at_first: bool = False) -> SceneRun:
        """Decide all pairs, or go on to the first near one only.

        Raises LinkError where the meshes do not fit the board, or no verdict can be had.
        """
        pose, mode = Pose(*translation), Mode.FIRST if stop_at_first else self._mode
        self._check_fit(pose, margin)
        run = self._run(pose, margin, mode)
        audit(run)
        status = self.status = run.status
        opened = status.pairs_skipped + status.tested
        near = in_order(np.stack([self._order_a[run.near[:, 0]], self._order_b[run.near[:, 1]]], 1))
        return SceneRun(
            # What a run that stopped early has left out was not skipped.
            len(self._a) * len(self._b) - opened if status.end == RunEnd.COMPLETE else 0,
            status.pairs_skipped, status.tested, status.near, status.groups_skipped, status.groups_opened,
            status.cycles, status.tested - status.near if self._board.description.certifies else None, near,
        )  # fmt: skip

    def permit(
        self, translation: Translation, margin: int, hold: int, zones: tuple[int, int] = NO_ZONES
    ) -> bool:
        """Return whether a pose is clear; if so go stands, or begins, for ``hold`` milliseconds more.

        ``zones``: margins of slow and warn, where nothing must be that is asked about. Raises LinkError as
        `run` does, where the board finds something there, and where go is not said although all is clear. A
        session that was lost is not begun again: the machine has stopped.
        """
        pose = Pose(*translation)
        self._check_fit(pose, max(margin, *zones))
        self.load()
        run = self._board.run(Mode.FIRST, margin, pose, hold=hold, zones=zones)
        audit(run)
        self.status = run.status
        if run.status.near:
            return False
        if found := run.status.flags & run.request.asked:
            raise contradiction(f"something in zones that it must be beyond: {Flag(found).name}")
        if not run.status.flags & Flag.GO:
            raise LinkError(
                "the board says stop although the segment is clear: the time of the one before was over, or "
                "the line was disturbed; the machine has stopped: begin anew"
            )
        return True

    @property
    def says_go(self) -> bool:
        """Return whether the output said go when last heard of."""
        return hasattr(self, "status") and bool(self.status.flags & Flag.GO)

    def load(self) -> None:
        """Load both meshes, where they are not."""
        if not self._loaded:
            self._board.load(Mesh.A, self._a[self._order_a], self._progress)
            self._board.load(Mesh.B, self._b[self._order_b], self._progress)
        self._loaded = True

    def _run(self, pose: Pose, margin: int, mode: Mode, attempts: int = _ATTEMPTS) -> BoardRun:
        """Load and run, in a new session where the first one or two were lost."""
        try:
            self.load()
            return self._board.run(mode, margin, pose)
        except SessionLostError:
            self._loaded = False
            if attempts == 1:
                raise
        self._board.take_again()
        return self._run(pose, margin, mode, attempts - 1)

    def _check_fit(self, pose: Pose, margin: int) -> None:
        """Raise LinkError where the board is too small for the meshes, the margin or the move."""
        board = self._board.description
        for name, mesh in (("A", self._a), ("B", self._b)):
            check_depth(name, mesh, board)
        if margin >= 1 << board.margin_bits:
            most = (1 << board.margin_bits) - 1
            raise LinkError(
                f"margin {margin}: the board's has {board.margin_bits} bits, at most {most}; use a coarser "
                "resolution or a smaller clearance"
            )
        low, high = coordinate_range(board.width)
        moved = self._a + np.array([pose.x, pose.y, pose.z])
        for name, mesh in (("A", self._a), ("B", self._b), ("A when moved", moved)):
            if mesh.min() < low or mesh.max() > high:
                raise LinkError(
                    f"{name}: coordinates {mesh.min()}..{mesh.max()}: the board's have {board.width} bits, "
                    f"{low}..{high}; use a coarser resolution"
                )
