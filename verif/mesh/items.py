"""Sequence items of the engine: a mesh to be loaded, a run to be asked for."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt
from pyuvm import uvm_sequence_item

from triaxis.sim.mesh_engine import Mode, Move
from triaxis.verif.core.items import FULL_SPEED, Pace


class LoadItem(uvm_sequence_item):
    """Triangles (N, 3, 3) for mesh 0 (A) or 1 (B), with gaps; more than fit are allowed.

    ``clear``: the mesh is emptied first. On the pins it need not be: then they are appended.
    """

    def __init__(
        self,
        mesh: int,
        triangles: npt.NDArray[np.integer[Any]],
        gaps: Pace = FULL_SPEED,
        clear: bool = True,
        name: str = "load",
    ) -> None:
        """Hold the triangles."""
        super().__init__(name)
        self.mesh = mesh
        self.triangles = triangles
        self.gaps = gaps
        self.clear = clear


@dataclass(frozen=True)
class RunRequest:
    """What a run is asked for: ``mode`` may be 3, which is refused."""

    translation: Move = (0, 0, 0)
    margin: int = 0
    mode: int = int(Mode.ALL)


@dataclass(frozen=True)
class RunTraffic:
    """How a run's streams are treated. ``aborts``: clocks after its acceptance at which it is aborted.

    ``idle_abort``: abort is high for a clock before the run is offered, when there is none to abort.
    """

    near: Pace = FULL_SPEED
    done: Pace = FULL_SPEED
    aborts: tuple[int, ...] = ()
    idle_abort: bool = False


class RunItem(uvm_sequence_item):
    """A run, and how its streams are treated.

    ``clocks``: from its acceptance until its summary was offered, or taken; the driver's answer.
    """

    def __init__(self, request: RunRequest, traffic: RunTraffic | None = None, name: str = "run") -> None:
        """Hold the request."""
        super().__init__(name)
        self.request = request
        self.traffic = traffic or RunTraffic()
        self.clocks = 0


@dataclass(frozen=True)
class Scene:
    """A whole scene: meshes to load, None where the one that is there stays, and the runs on them.

    ``gaps``: on loading. ``early``: the first run is offered together with the last mesh's triangles, and
    takes what is there when the engine accepts it.
    """

    a: npt.NDArray[np.int64] | None
    b: npt.NDArray[np.int64] | None
    runs: tuple[tuple[RunRequest, RunTraffic], ...]
    gaps: Pace = FULL_SPEED
    early: bool = False
    kind: str = field(default="", compare=False)

    @property
    def pairs(self) -> int:
        """Return how many pairs both meshes have, 0 where one of them stays."""
        return 0 if self.a is None or self.b is None else len(self.a) * len(self.b)
