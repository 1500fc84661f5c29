"""Puts runs together from what all monitors say, free of the simulator."""

from collections.abc import Callable

import numpy as np

from triaxis.verif.mesh.observed import (
    AbortAsked,
    CorePairs,
    Loaded,
    MeshState,
    NearTaken,
    ObservedRun,
    RunAccepted,
    Summary,
)
from triaxis.verif.testbench.batches import ResetSeen

_EMPTY = np.empty((0, 3, 3), np.int64)


class RunMatcher:
    """Follows the meshes and the run that is going on; hands each run on once its summary was taken.

    What belongs to no run is kept in ``stray``, a line each.
    """

    def __init__(self, depth: int, on_run: Callable[[ObservedRun, Summary], None]) -> None:
        """Start with empty meshes and no run. ``depth``: triangles that a mesh holds."""
        self._on_run = on_run
        self._meshes = (MeshState(depth), MeshState(depth))
        self._run: ObservedRun | None = None
        # Whether the last triangle came at the same edge as the run that is about to be seen.
        self._loaded_now = False
        self.accepted = self.triangles = self.resets = self.ended_by_reset = 0
        self.stray: list[str] = []

    @property
    def unfinished(self) -> bool:
        """Return whether a run has no summary yet."""
        return self._run is not None

    def load(self, datum: Loaded) -> None:
        """Follow a load."""
        self.triangles += len(datum.triangles)
        self._meshes[datum.mesh].take(datum)
        if self._run is None:
            self._loaded_now = datum.with_run
            return
        # Accepted at the very edge at which the run was: it belongs to it.
        if not datum.with_run:
            self.stray.append(f"mesh {datum.mesh} was loaded during a run")
        self._show_meshes(self._run)
        self._run.loaded_with_run = True

    def run(self, datum: RunAccepted | AbortAsked) -> None:
        """Begin a run, or note that it is aborted."""
        if isinstance(datum, AbortAsked):
            if self._run is not None:
                self._run.aborts.append(datum.at)
            return
        if self._run is not None:
            self.stray.append("a run was accepted during a run")
        self.accepted += 1
        self._run = ObservedRun(datum, _EMPTY, _EMPTY, (False, False), (False, False))
        self._show_meshes(self._run)
        self._run.loaded_with_run, self._loaded_now = self._loaded_now, False

    def _show_meshes(self, run: ObservedRun) -> None:
        """Let a run have the meshes as they are."""
        a, b = self._meshes
        run.a, run.b = a.triangles, b.triangles
        run.overfull = a.overfull, b.overfull
        run.reloaded = a.reloaded, b.reloaded

    def near(self, datum: NearTaken) -> None:
        """Note near pairs."""
        if self._run is not None:
            self._run.near.append(datum)
        elif len(datum.pairs):
            self.stray.append(f"{len(datum.pairs)} near pairs without a run")

    def core(self, datum: CorePairs) -> None:
        """Note pairs that reached the core."""
        if self._run is not None:
            self._run.reached.append(datum)
        elif len(datum.pairs):
            self.stray.append(f"{len(datum.pairs)} pairs in the core without a run")

    def summary(self, datum: Summary | ResetSeen) -> None:
        """End a run; or forget it and the meshes: a reset empties them."""
        if isinstance(datum, ResetSeen):
            self._reset()
            return
        if self._run is None:
            self.stray.append(f"a summary without a run: status {datum.status}")
            return
        run, self._run = self._run, None
        for mesh in self._meshes:
            mesh.reloaded = False
        self._on_run(run, datum)

    def _reset(self) -> None:
        self.resets += 1
        self.ended_by_reset += self._run is not None
        self._run = None
        for mesh in self._meshes:
            mesh.empty()
