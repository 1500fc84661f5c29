"""The whole measurement of skipping: scenes in hardware and software, other packages, growth.

What each stage of the mesh engine skips is counted by the golden model in facet pairs. The stages are those
of docs/mesh-engine.md. The first splits in two: objects whose boxes are apart as a whole, and groups of A
that are apart from the whole of B. The last splits by the axis that decides, as numbered in docs/theory.md,
section 2. A pair counts where it is skipped first.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import reduce
from itertools import product
from operator import add
from pathlib import Path

import numpy as np

from triaxis.bench.harness import Progress, Summed
from triaxis.bench.mesh_cycles import CONFIGURATION
from triaxis.bench.peers import MESH_PEERS
from triaxis.bench.peers.peer import Peer, Presence, present
from triaxis.bench.skipping.scenes import SURFACES, SkippingScene, skipping_scenes
from triaxis.bench.skipping.software import (
    SIZES,
    Growth,
    Meeting,
    PeerRun,
    Saved,
    ask_peer,
    contradictions,
    growth_of,
    saved,
)
from triaxis.golden.bulk import bulk_verdicts
from triaxis.golden.pairs import NO_AXIS
from triaxis.golden.scene import SceneAnswer, scene_answer
from triaxis.host.broadphase import in_order
from triaxis.host.engines import Integers, MeshEngineScene, parts_of
from triaxis.sim.mesh_configuration import MeshConfiguration

# The first axes of their kinds behind the three box axes; see `triaxis.golden.axes`.
_NORMALS, _EDGES, _EDGE_BOXES = 3, 5, 14


@dataclass(frozen=True)
class Stages(Summed):
    """How many facet pairs each stage skips, and how many are near: together all of them."""

    objects: int = 0
    rows: int = 0
    groups: int = 0
    boxes: int = 0
    normals: int = 0
    edges: int = 0
    edge_boxes: int = 0
    near: int = 0

    @property
    def before_boxes(self) -> int:
        """Return how many pairs are skipped with their objects or groups, whose own boxes nobody compares."""
        return self.objects + self.rows + self.groups

    @property
    def tested(self) -> int:
        """Return how many pairs no box decides: the core is asked about them."""
        return self.normals + self.edges + self.edge_boxes + self.near

    @property
    def pairs(self) -> int:
        """Return the number of all pairs."""
        return self.before_boxes + self.boxes + self.tested


@dataclass(frozen=True)
class StageAnswer:
    """What skipping does to a pair of solids. ``near`` (K, 2): (facet of A, of B), by number."""

    stages: Stages
    near: Integers


def stage_answer(a: Integers, b: Integers, margin: int, engine: MeshConfiguration) -> StageAnswer:
    """Return what is skipped of facets (N, 3, 3) and (M, 3, 3), loaded as the engine is, at a margin in LSB.

    Meshes beyond its depth are loaded in parts; a part is an object of its own.
    """
    stages, near = Stages(), [np.empty((0, 2), np.int64)]
    parts = (parts_of(mesh, engine.depth, engine.group) for mesh in (a, b))
    for in_a, in_b in product(*parts):
        answer = scene_answer(in_a.facets, in_b.facets, margin, engine.group)
        i, j = answer.to_be_tested.T
        verdicts = bulk_verdicts(np.stack([in_a.facets[i], in_b.facets[j]], 1), margin)
        stages += _stages(answer, verdicts["axis"])
        i, j = answer.near_pairs.T
        near.append(np.stack([in_a.numbers[i], in_b.numbers[j]], 1))
    return StageAnswer(stages, in_order(np.concatenate(near)))


def _stages(answer: SceneAnswer, axis: Integers) -> Stages:
    """Return the counts; ``axis`` (T,) decides the pairs that are tested."""
    count_a, count_b = answer.boxes_apart.shape
    apart_a = np.repeat(answer.rows_apart, answer.group)[:count_a]
    in_rows = int(apart_a.sum()) * count_b
    objects = in_rows if answer.rows_apart.all() else 0
    return Stages(
        objects,
        in_rows - objects,
        int(answer.in_groups_apart.sum()) - in_rows,
        answer.pairs_skipped,
        int(((axis >= _NORMALS) & (axis < _EDGES)).sum()),
        int(((axis >= _EDGES) & (axis < _EDGE_BOXES)).sum()),
        int((axis >= _EDGE_BOXES).sum()),
        int((axis == NO_AXIS).sum()),
    )


# What skipping must save over all scenes, in cycles for each of which a core without it takes a pair.
LEAST_RATIO = 10.0


@dataclass(frozen=True)
class Hardware(Summed):
    """What the simulated engine takes, and what the core alone takes at one pair a clock.

    ``cycles_to_load``: beside ``cycles``, to load all that it is asked about, a facet a clock; parts of
    meshes beyond its depth as often as they are needed. ``right``: it skipped, tested and found what the
    golden model says.
    """

    cycles: int
    cycles_to_load: int
    cycles_without_skipping: int
    right: bool


@dataclass(frozen=True)
class AtMargin(Summed):
    """A scene at one margin: sums over its pairs of solids."""

    pairs_by_stage: Stages
    hardware: Hardware
    software: Saved


@dataclass(frozen=True)
class SceneRow:
    """A scene by margin in LSB: 0 and its own; what the packages did about it without margin."""

    scene: SkippingScene
    at: dict[int, AtMargin]
    peers: tuple[PeerRun, ...]

    @property
    def plain(self) -> AtMargin:
        """Return it without margin."""
        return self.at[0]

    @property
    def own(self) -> AtMargin:
        """Return it with its own margin."""
        return self.at[self.scene.margin]

    @property
    def problems(self) -> list[str]:
        """Return what is not as it must be, a line each."""
        found = contradictions(self.scene.name, self.peers)
        for margin, at in self.at.items():
            pairs, hardware = at.pairs_by_stage.pairs, at.hardware
            checks = (
                (pairs == self.scene.pairs, f"stages account for {pairs} of {self.scene.pairs} pairs"),
                (hardware.right, "the mesh engine skips or finds other pairs than the golden model"),
                (at.software.right, "the broad phase loses or adds near pairs"),
                (
                    hardware.cycles <= pairs,
                    f"{hardware.cycles} cycles for {pairs} pairs: skipping costs more than it saves",
                ),
            )
            found += [f"{self.scene.name}, margin {margin}: {what}" for right, what in checks if not right]
        return found


@dataclass(frozen=True)
class SkippingResult:
    """All that was measured."""

    seed: int
    real_meshes: bool
    packages: list[Presence]
    scenes: list[SceneRow]
    growth: list[Growth]

    @property
    def totals(self) -> tuple[Hardware, Saved]:
        """Return over all scenes, with their margins, what the engine takes, and what software saves."""
        return (
            reduce(add, (row.own.hardware for row in self.scenes)),
            reduce(add, (row.own.software for row in self.scenes)),
        )

    @property
    def problems(self) -> list[str]:
        """Return what is not as it must be, a line each."""
        found = [problem for row in self.scenes for problem in row.problems]
        hardware, software = self.totals
        pairs, cycles = hardware.cycles_without_skipping, hardware.cycles + hardware.cycles_to_load
        if pairs < LEAST_RATIO * cycles:
            found.append(f"scenes: {pairs} pairs in {cycles} cycles: less than {LEAST_RATIO:g} a cycle")
        if software.seconds_behind_boxes > software.seconds_all_pairs:
            found.append("scenes: the broad phase makes the bulk checker slower")
        return found + [problem for growth in self.growth for problem in growth.problems]


def run_skipping(
    seed: int,
    data: Path | None,
    progress: Progress,
    peers: Sequence[Peer] = MESH_PEERS,
    sizes: Sequence[int] = SIZES,
) -> SkippingResult:
    """Measure everything; ``progress`` is told of each scene and size.

    ``data``: the folder of real meshes.
    """
    there, packages = present(peers)
    asked = [peer for peer, _ in there]
    rows: list[SceneRow] = []
    for scene in skipping_scenes(data):
        rows.append(measure_scene(scene, asked))
        progress(1)
    growth = [growth_of(surfaces, seed, asked, progress, sizes) for surfaces in SURFACES]
    return SkippingResult(seed, data is not None, packages, rows, growth)


def measure_scene(scene: SkippingScene, peers: Sequence[Peer]) -> SceneRow:
    """Measure a scene at margin 0 and at its own."""
    at: dict[int, AtMargin] = {}
    meetings: list[Meeting] = []
    for a, b in scene.meetings:
        engine = MeshEngineScene(a, b, CONFIGURATION)
        for margin in sorted({0, scene.margin}):
            measured, near = _at_margin(a, b, margin, engine)
            at[margin] = at[margin] + measured if margin in at else measured
            if margin == 0:
                meetings.append(Meeting(a, b, near))
    return SceneRow(scene, at, tuple(ask_peer(peer, meetings) for peer in peers))


def _at_margin(a: Integers, b: Integers, margin: int, engine: MeshEngineScene) -> tuple[AtMargin, Integers]:
    """Return what was measured, and the near pairs (K, 2) by the golden model."""
    golden, run = stage_answer(a, b, margin, CONFIGURATION), engine.run((0, 0, 0), margin)
    stages, counted = golden.stages, (run.skipped_in_groups, run.skipped, run.tested)
    right = counted == (stages.before_boxes, stages.boxes, stages.tested)
    right = right and np.array_equal(run.near, golden.near)
    software = saved(a, b, margin, golden.near)
    software = replace(software, right=software.right and software.pairs_tested == stages.tested)
    hardware = Hardware(run.cycles or 0, _facets_loaded(a, b), stages.pairs, right)
    return AtMargin(stages, hardware, software), golden.near


def _facets_loaded(a: Integers, b: Integers) -> int:
    parts = (parts_of(mesh, CONFIGURATION.depth, CONFIGURATION.group) for mesh in (a, b))
    return sum(len(one.facets) + len(other.facets) for one, other in product(*parts))
