"""A script for the mesh engine: what is loaded, run and reset, and what the contract says must come of it.

Near pairs and counters come from the exact checker and the definition of groups, never from the RTL. Only the
clocks of a run, which are part of what the engine promises, are those of the engine without mutants.
"""

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.mesh_engine import Mode, Move, Status
from triaxis.verif.mutation.engine_expectation import Expectation, expected_run

Triangles = npt.NDArray[np.int64]

LOAD, RUN, RESET = 0, 1, 2
NEVER = -1
# A run ends at its first near pair, or by an abort, whichever the engine sees first.
UNKNOWN_CLOCKS = -1

# In the order of Step in engine.cpp.
_FIELDS = (
    "kind", "mesh", "clear", "first", "count", "held_a", "held_b", "overfull", "move_x", "move_y", "move_z",
    "margin", "mode", "abort_at", "abort_clocks", "status", "exact", "group_pairs_skipped",
    "group_pairs_opened", "pairs_skipped", "tested", "near_count", "near_first", "near_length", "seed",
    "stall", "hold", "early", "cut",
)  # fmt: skip
STEP = np.dtype([(name, np.int64) for name in _FIELDS])


@dataclass(frozen=True)
class EnginePlay:
    """Steps (S,) of `STEP` from a reset on, with the triangles (N, 9) and near pairs (K, 2) they name.

    ``clocks`` (S,): those of each run, UNKNOWN_CLOCKS where it is not known yet.
    """

    test: str
    family: str
    steps: npt.NDArray[np.void]
    triangles: npt.NDArray[np.int32]
    near: npt.NDArray[np.uint32]
    clocks: npt.NDArray[np.int64]


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
    _steps: list[dict[str, int]] = field(default_factory=list)
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
        steps = np.array([tuple(step[name] for name in _FIELDS) for step in self._steps], STEP)
        triangles = np.concatenate([np.zeros((0, 3, 3), np.int64), *self._triangles])
        near = np.concatenate([np.zeros((0, 2), np.uint32), *self._near])
        clocks = np.full(len(steps), UNKNOWN_CLOCKS, np.int64)
        return EnginePlay(
            test, family, steps, np.ascontiguousarray(triangles.reshape(-1, 9), np.int32),
            np.ascontiguousarray(near), clocks,
        )  # fmt: skip

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
            "abort_at": NEVER,
        }  # fmt: skip
        self._steps.append(dict.fromkeys(_FIELDS, 0) | fixed | {k: int(v) for k, v in values.items()})
