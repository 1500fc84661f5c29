"""The whole measurement of skipping: scenes in hardware and software, other packages, growth."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from triaxis.bench.harness import Progress
from triaxis.bench.mesh_cycles import CONFIGURATION
from triaxis.bench.peers import MESH_PEERS
from triaxis.bench.peers.peer import Peer, Presence, present
from triaxis.bench.skipping.growth import SIZES, Growth, growth_of
from triaxis.bench.skipping.scenes import SURFACES, SkippingScene, skipping_scenes
from triaxis.bench.skipping.software import Meeting, PeerRun, Saved, ask_peer, contradictions, saved
from triaxis.bench.skipping.stages import Clocks, Stages, Summed, stage_answer
from triaxis.host.engines import Integers, MeshEngineScene

# What skipping must save over all scenes, in cycles for each of which a core without it takes a pair.
LEAST_RATIO = 10.0


@dataclass(frozen=True)
class Hardware(Summed):
    """What the simulated engine takes, and what the core alone takes at one pair a clock.

    ``right``: it skipped, tested and found what the golden model says.
    """

    cycles: int
    cycles_without_skipping: int
    clocks_of_work: Clocks
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
    def totals(self) -> tuple[int, int, Saved]:
        """Return over all scenes, with their margins: pairs, cycles, and what software saves."""
        hardware = [row.own.hardware for row in self.scenes]
        pairs = sum(each.cycles_without_skipping for each in hardware)
        software = sum((row.own.software for row in self.scenes), Saved())
        return pairs, sum(each.cycles for each in hardware), software

    @property
    def problems(self) -> list[str]:
        """Return what is not as it must be, a line each."""
        found = [problem for row in self.scenes for problem in row.problems]
        pairs, cycles, software = self.totals
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
    hardware = Hardware(run.cycles or 0, stages.pairs, golden.clocks, right)
    return AtMargin(stages, hardware, software), golden.near
