"""Engines that decide a whole scene at a translation of A: the simulated mesh engine, the bulk checker, the
golden model.

All three skip exactly the facet pairs that a box axis separates by more than the margin, so their counts of
tested and near pairs agree; only the mesh engine skips whole groups and counts cycles.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from triaxis.golden.bulk import bulk_verdicts
from triaxis.golden.judge import judge_in_parallel
from triaxis.host.meshcheck import Decide, FacetPairs, in_order, near_facets

RTL, BULK, GOLDEN = "rtl", "bulk", "golden"
ENGINES = (RTL, BULK, GOLDEN)

# Pairs decided at a time: few where the first near one ends it.
_FEW, _MANY = 1 << 9, 1 << 20

Integers = npt.NDArray[np.int64]
Translation = tuple[int, int, int]


@dataclass(frozen=True)
class SceneRun:
    """What one run did. Each pair was skipped with its group, skipped by its own boxes, or tested.

    A run that stopped at its first near pair left the other pairs out. ``near`` (K, 2): (facet of A, facet
    of B), as numbered in the files. ``cycles``: of the simulated engine, without loading; None for the
    others.
    """

    skipped_in_groups: int
    skipped: int
    tested: int
    near_count: int
    near: FacetPairs
    group_pairs_skipped: int = 0
    group_pairs_opened: int = 0
    cycles: int | None = None


class SceneEngine(Protocol):
    """Two loaded meshes, asked again and again at other translations of A and margins."""

    def run(self, translation: Translation, margin: int, stop_at_first: bool = False) -> SceneRun:
        """Decide all pairs, or go on to the first near one only."""
        ...


class DecidingEngine:
    """The broad phase in NumPy, and a function that decides what is left."""

    def __init__(self, a: Integers, b: Integers, decide: Decide) -> None:
        """Take facets of shape (N, 3, 3), on the grid."""
        self._a, self._b, self._decide = a, b, decide

    def run(self, translation: Translation, margin: int, stop_at_first: bool = False) -> SceneRun:
        """Decide all pairs, or those of the pieces to the first with a near one."""
        tested = 0
        near: list[FacetPairs] = [np.empty((0, 2), np.int64)]
        a, at_once = self._a + np.array(translation), _FEW if stop_at_first else _MANY
        for count, found in near_facets(a, self._b, margin, self._decide, at_once=at_once):
            tested += count
            near.append(found)
            if stop_at_first and len(found):
                break
        pairs = in_order(np.concatenate(near))
        return SceneRun(0, len(self._a) * len(self._b) - tested, tested, len(pairs), pairs)


def scene_engine(name: str, a: Integers, b: Integers, width: int) -> SceneEngine:
    """Return the engine of that name, one of `ENGINES`, with facets (N, 3, 3) loaded."""
    if name == BULK:
        return DecidingEngine(a, b, bulk_verdicts)
    if name == GOLDEN:
        return DecidingEngine(a, b, judge_in_parallel)
    # Only who asks for the simulated engine pays for building it.
    from triaxis.host.engine_scene import MeshEngineScene
    from triaxis.sim.mesh_configuration import MeshConfiguration

    return MeshEngineScene(a, b, MeshConfiguration(width=width, margin_bits=width))
