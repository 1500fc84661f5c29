"""What a run of the mesh engine must answer, from the exact answer for its scene."""

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from triaxis.golden.scene import scene_answer
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.mesh_engine import Mode, Move, Status
from triaxis.verif.mesh.expectation import moved, overflows

_Numbers = npt.NDArray[np.int64]


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
    near: _Numbers = field(default_factory=lambda: np.zeros((0, 2), np.int64))


def expected_run(
    a: _Numbers, b: _Numbers, move: Move, margin: int, mode: int, configuration: MeshConfiguration
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
