"""Scenes whose skipping is measured: solids on the engine's grid, and which of them meet."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

import numpy as np

from triaxis.bench.mesh_cycles import on_filled_grid
from triaxis.host.machine_scenes import machine_scenes, machine_solids
from triaxis.host.scene_engines import Integers
from triaxis.host.scenes import scenes, tool, vise
from triaxis.host.stl import Facets

# Where the whole machine is taken, in mm of its Z axis: with the head up, and down at the carousel.
_HEADS = (0, -250)


@dataclass(frozen=True)
class SkippingScene:
    """Pairs of solids that may meet, facets (N, 3, 3) and (M, 3, 3) in LSB, and a margin in LSB.

    ``real``: from files of real machines and parts, which are no part of the product.
    """

    name: str
    meetings: tuple[tuple[Integers, Integers], ...]
    margin: int
    real: bool = False

    @property
    def facets(self) -> tuple[int, int]:
        """Return how many facets the first and the second solids have, each meeting counted."""
        return sum(len(a) for a, _ in self.meetings), sum(len(b) for _, b in self.meetings)

    @property
    def pairs(self) -> int:
        """Return how many facet pairs there are."""
        return sum(len(a) * len(b) for a, b in self.meetings)


def skipping_scenes(data: Path | None) -> list[SkippingScene]:
    """Return all scenes; those of real meshes where ``data`` is their folder."""
    cutter, fixture = tool(), vise()
    high = cutter + np.array([0, 0, 200])
    made = [_scene(scene.name, [scene.a, scene.b]) for scene in scenes()]
    made.append(_scene("tool 200 mm above the workpiece", [high, fixture]))
    if data is None:
        return made
    close = [_scene(scene.name, [scene.a, scene.b], real=True) for scene in machine_scenes(data)]
    machines = [
        _scene(f"whole machine at Z = {z} mm", list(machine_solids(data, z).values()), real=True)
        for z in _HEADS
    ]
    return [*made, *close, *machines]


def _scene(name: str, solids: Sequence[Facets], real: bool = False) -> SkippingScene:
    """Return a scene in which every two of the solids meet; of each two the larger is A."""
    placed, margin = on_filled_grid(name, solids)
    meetings = tuple((a, b) if len(a) >= len(b) else (b, a) for a, b in combinations(placed, 2))
    return SkippingScene(name, meetings, margin, real)
