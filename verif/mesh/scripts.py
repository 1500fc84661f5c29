"""Scripts for the mesh engine: what is loaded, run and reset, and what the contract says must come of it.

Near pairs and counters come from the exact checker and the definition of groups, never from the RTL. Only the
clocks of a run, which are part of what the engine promises, are those of the engine without mutants.
"""

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from triaxis.golden.scene import scene_answer
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.mesh_engine import (
    LOAD,
    NEVER,
    RESET,
    RUN,
    UNKNOWN_CLOCKS,
    MeshScript,
    Mode,
    Move,
    Status,
    mesh_step,
)
from triaxis.verif.mesh.expectation import moved, overflows

Triangles = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Expectation:
    """What a run must answer. ``near`` (K, 2): all near pairs as (number in A, in B), in scan order.

    ``tested_to_first``: pairs tested up to and including the first near one.
    """

    status: Status
    group_pairs_skipped: int = 0
    group_pairs_opened: int = 0
    pairs_skipped: int = 0
    tested: int = 0
    tested_to_first: int = 0
    near: Triangles = field(default_factory=lambda: np.zeros((0, 2), np.int64))


def expected_run(
    a: Triangles, b: Triangles, move: Move, margin: int, mode: int, configuration: MeshConfiguration
) -> Expectation:
    """Return what a run of meshes (N, 3, 3) and (M, 3, 3), as loaded, must answer."""
    if mode not in tuple(Mode):
        return Expectation(Status.BAD_MODE)
    if overflows(a, move, configuration.width):
        return Expectation(Status.OVERFLOW)
    if not len(a) or not len(b):
        return Expectation(Status.COMPLETE)
    answer = scene_answer(moved(a, move), b, margin, configuration.group)
    is_near = answer.near[tuple(answer.to_be_tested.T)]
    first = int(np.argmax(is_near)) + 1 if is_near.any() else answer.tested
    return Expectation(
        Status.COMPLETE, answer.group_pairs_skipped, answer.group_pairs_opened, answer.pairs_skipped,
        answer.tested, first, answer.near_pairs,
    )  # fmt: skip


@dataclass(frozen=True)
class EnginePlay:
    """A script, named by the test that sends such scenes and by the family that they are of."""

    test: str
    family: str
    script: MeshScript


@dataclass(frozen=True)
class Traffic:
    """How a step's streams are treated.

    ``stall``: chance in 256 of a clock without valid or ready; ``hold``: clocks before the first near pair is
    taken; ``early``: the next step's first word is offered as soon as can be; ``cut``: reset in that clock
    of the run, or at its end.
    """

    seed: int = 1
    stall: int = 0
    hold: int = 0
    early: bool = False
    cut: int = NEVER


FLOWING = Traffic()


@dataclass
class Script:
    """A play in the making: follows what the engine must hold."""

    configuration: MeshConfiguration
    _meshes: list[Triangles] = field(default_factory=lambda: [np.zeros((0, 3, 3), np.int64)] * 2)
    _overfull: int = 0
    _steps: list[npt.NDArray[np.void]] = field(default_factory=list)
    _triangles: list[Triangles] = field(default_factory=list)
    _near: list[npt.NDArray[np.uint32]] = field(default_factory=list)

    def load(
        self, mesh: int, triangles: Triangles, clear: bool = True, traffic: Traffic = FLOWING
    ) -> "Script":
        """Load triangles (N, 3, 3) into mesh 0 (A) or 1 (B), which is emptied first or not."""
        first = sum(map(len, self._triangles))
        self._triangles.append(triangles)
        before = self._meshes[mesh][: 0 if clear else None]
        whole = np.concatenate([before, triangles])
        over = len(whole) > self.configuration.depth or (not clear and self._overfull >> mesh & 1)
        self._overfull = self._overfull & ~(1 << mesh) | int(over) << mesh
        self._meshes[mesh] = whole[: self.configuration.depth]
        self._step(traffic, kind=LOAD, mesh=mesh, clear=int(clear), first=first, count=len(triangles))
        return self

    def run(
        self,
        move: Move = (0, 0, 0),
        margin: int = 0,
        mode: int = Mode.ALL,
        traffic: Traffic = FLOWING,
        abort_at: int = NEVER,
        abort_clocks: int = 1,
    ) -> "Script":
        """Run; ``abort_at``: in which clock after acceptance, 0 on."""
        expected = self._expected(move, margin, mode)
        near = expected.near.astype(np.uint32)
        if mode == Mode.FIRST:
            near = near[:1]
        elif mode != Mode.ALL:
            near = near[:0]
        found = len(expected.near) if mode != Mode.FIRST else len(near)
        whole = mode != Mode.FIRST or not len(near)
        tested = expected.tested if whole else expected.tested_to_first
        if traffic.cut != NEVER:
            self._forget()
        self._step(
            traffic, kind=RUN, move_x=move[0], move_y=move[1], move_z=move[2], margin=margin, mode=mode,
            abort_at=abort_at, abort_clocks=abort_clocks,
            status=expected.status if whole else Status.FIRST, exact=int(whole),
            group_pairs_skipped=expected.group_pairs_skipped,
            group_pairs_opened=expected.group_pairs_opened, pairs_skipped=expected.pairs_skipped,
            tested=tested, near_count=found, near_first=sum(map(len, self._near)), near_length=len(near),
        )  # fmt: skip
        self._near.append(near)
        return self

    def reset(self) -> "Script":
        """Reset: both meshes are empty then."""
        self._forget()
        self._step(FLOWING, kind=RESET)
        return self

    def play(self, test: str, family: str) -> EnginePlay:
        """Return the play."""
        triangles = np.concatenate([np.zeros((0, 3, 3), np.int64), *self._triangles])
        near = np.concatenate([np.zeros((0, 2), np.uint32), *self._near])
        script = MeshScript(
            np.concatenate(self._steps), np.ascontiguousarray(triangles.reshape(-1, 9), np.int32),
            np.ascontiguousarray(near), np.full(len(self._steps), UNKNOWN_CLOCKS, np.int64),
        )  # fmt: skip
        return EnginePlay(test, family, script)

    def _expected(self, move: Move, margin: int, mode: int) -> Expectation:
        if self._overfull and mode in tuple(Mode):
            return Expectation(Status.OVERFULL)
        return expected_run(self._meshes[0], self._meshes[1], move, margin, mode, self.configuration)

    def _forget(self) -> None:
        self._meshes = [mesh[:0] for mesh in self._meshes]
        self._overfull = 0

    def _step(self, traffic: Traffic, **values: int) -> None:
        held_a, held_b = map(len, self._meshes)
        fixed = {
            "held_a": held_a, "held_b": held_b, "overfull": self._overfull, "seed": traffic.seed,
            "stall": traffic.stall, "hold": traffic.hold, "early": int(traffic.early), "cut": traffic.cut,
        }  # fmt: skip
        self._steps.append(mesh_step(**(fixed | values)))
