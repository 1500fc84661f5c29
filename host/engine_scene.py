"""The simulated mesh engine with a whole scene loaded, whatever the size of the meshes."""

from dataclasses import dataclass
from itertools import product

import numpy as np

from triaxis.host.meshcheck import in_order
from triaxis.host.scene_engines import Integers, SceneRun, Translation
from triaxis.host.spatial_order import spatial_order
from triaxis.sim.core_engine import CoreError
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.mesh_engine import MeshEngine, Mode, Status


class MeshEngineScene:
    """The simulated mesh engine. Meshes beyond its depth are split, and run part against part."""

    def __init__(self, a: Integers, b: Integers, configuration: MeshConfiguration) -> None:
        """Build the engine where needed and load it with facets (N, 3, 3), in spatial order."""
        self._engine = MeshEngine(configuration)
        self._a = _parts(a, configuration)
        self._b = _parts(b, configuration)
        self._loaded: tuple[int, int] | None = None

    def run(self, translation: Translation, margin: int, stop_at_first: bool = False) -> SceneRun:
        """Run each part of A against each part of B; stopped at the first near pair, no further parts."""
        runs: list[SceneRun] = []
        for pair in product(range(len(self._a)), range(len(self._b))):
            runs.append(self._run_parts(pair, translation, margin, stop_at_first))
            if stop_at_first and runs[-1].near_count:
                break
        return SceneRun(
            sum(run.skipped_in_groups for run in runs),
            sum(run.skipped for run in runs),
            sum(run.tested for run in runs),
            sum(run.near_count for run in runs),
            in_order(np.concatenate([run.near for run in runs])),
            sum(run.group_pairs_skipped for run in runs),
            sum(run.group_pairs_opened for run in runs),
            sum(run.cycles or 0 for run in runs),
        )

    def _run_parts(
        self, pair: tuple[int, int], translation: Translation, margin: int, stop_at_first: bool
    ) -> SceneRun:
        a, b = self._a[pair[0]], self._b[pair[1]]
        if pair != self._loaded:
            self._engine.load(a.facets, b.facets)
            self._loaded = pair
        run = self._engine.run(translation, margin, Mode.FIRST if stop_at_first else Mode.ALL)
        complete = run.status == Status.COMPLETE
        if not complete and not (stop_at_first and run.status == Status.FIRST):
            raise CoreError(f"mesh engine: status {run.status.name} at translation {translation}")
        groups_a, groups_b = (-(-len(part.facets) // self._engine.configuration.group) for part in (a, b))
        decided = run.group_pairs_skipped + run.group_pairs_opened
        if complete and decided != groups_a * groups_b:
            raise CoreError(f"mesh engine: {decided} of {groups_a * groups_b} pairs of groups decided")
        near = np.stack([a.numbers[run.near[:, 0]], b.numbers[run.near[:, 1]]], 1)
        opened = run.pairs_skipped + run.tested
        return SceneRun(
            len(a.facets) * len(b.facets) - opened if complete else 0,
            run.pairs_skipped,
            run.tested,
            run.near_count,
            near,
            run.group_pairs_skipped,
            run.group_pairs_opened,
            run.cycles,
        )


@dataclass(frozen=True)
class _Part:
    """Facets (N, 3, 3) in the order in which they are loaded, and their numbers in the file (N,)."""

    facets: Integers
    numbers: Integers


def _parts(facets: Integers, configuration: MeshConfiguration) -> list[_Part]:
    order = spatial_order(facets, configuration.group)
    starts = range(0, len(order), configuration.depth)
    pieces = (order[start : start + configuration.depth] for start in starts)
    return [_Part(facets[piece], piece) for piece in pieces]
