"""The whole measurement of skipping: scenes in hardware and software, other packages, growth."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from triaxis.bench.mesh_cycles import CONFIGURATION
from triaxis.bench.skipping.asking import Meeting, PeerRun, Presence, ask_peer, contradiction, presence
from triaxis.bench.skipping.growth import SIZES, Growth, growths
from triaxis.bench.skipping.peers import MESH_PEERS
from triaxis.bench.skipping.peers.mesh_peer import MeshPeer
from triaxis.bench.skipping.scenes import SkippingScene, skipping_scenes
from triaxis.bench.skipping.software import Saved, saved
from triaxis.bench.skipping.stages import Clocks, StageAnswer, Stages, stage_answer
from triaxis.bench.skipping.surfaces import SURFACES
from triaxis.host.engine_scene import MeshEngineScene
from triaxis.host.scene_engines import Integers
from triaxis.sim.provenance import Provenance, provenance

# What skipping must save over all scenes, in cycles for each of which a core without it takes a pair.
LEAST_RATIO = 10.0


@dataclass(frozen=True)
class AtMargin:
    """A scene at one margin, in LSB; sums over its pairs of solids.

    ``cycles``: of the simulated engine. ``engine_right``: it skipped, tested and found what the golden model
    says. ``software_right``: the broad phase left the same pairs to test, and the same ones are near.
    """

    margin: int
    stages: Stages
    clocks: Clocks
    cycles: int
    software: Saved
    engine_right: bool
    software_right: bool

    def __add__(self, other: "AtMargin") -> "AtMargin":
        """Return the sums."""
        return AtMargin(
            self.margin,
            self.stages + other.stages,
            self.clocks + other.clocks,
            self.cycles + other.cycles,
            self.software + other.software,
            self.engine_right and other.engine_right,
            self.software_right and other.software_right,
        )

    @property
    def cycles_without(self) -> int:
        """Return what the core alone takes at one pair a clock."""
        return self.stages.pairs


@dataclass(frozen=True)
class SceneRow:
    """A scene, without margin and with its own, and what the packages did about it without margin."""

    scene: SkippingScene
    at: tuple[AtMargin, ...]
    peers: tuple[PeerRun, ...]


@dataclass(frozen=True)
class SkippingResult:
    """All that was measured."""

    provenance: Provenance
    seed: int
    real_meshes: bool
    packages: tuple[Presence, ...]
    scenes: tuple[SceneRow, ...]
    growth: tuple[Growth, ...]
    seconds: float

    @property
    def totals(self) -> tuple[int, int, Saved]:
        """Return over all scenes, with their margins: pairs, cycles, and what software saves."""
        last = [row.at[-1] for row in self.scenes]
        software = sum((at.software for at in last), Saved())
        return sum(at.cycles_without for at in last), sum(at.cycles for at in last), software

    @property
    def problems(self) -> list[str]:
        """Return what is not as it must be, a line each."""
        found = [problem for row in self.scenes for problem in _scene_problems(row)]
        pairs, cycles, software = self.totals
        if pairs < LEAST_RATIO * cycles:
            found.append(f"scenes: {pairs} pairs in {cycles} cycles: less than {LEAST_RATIO:g} a cycle")
        if software.with_skipping > software.without:
            found.append("scenes: the broad phase makes the bulk checker slower")
        return found + [problem for growth in self.growth for problem in growth.problems]


def _scene_problems(row: SceneRow) -> list[str]:
    found = [contradiction(row.scene.name, run) for run in row.peers if run.contradicts]
    for at in row.at:
        name = f"{row.scene.name}, margin {at.margin}"
        if at.stages.pairs != row.scene.pairs:
            found.append(f"{name}: stages account for {at.stages.pairs} of {row.scene.pairs} pairs")
        if not at.engine_right:
            found.append(f"{name}: the mesh engine skips or finds other pairs than the golden model")
        if not at.software_right:
            found.append(f"{name}: the broad phase loses or adds near pairs")
        if at.cycles > at.cycles_without:
            found.append(
                f"{name}: {at.cycles} cycles for {at.cycles_without} pairs: skipping costs more than it saves"
            )
    return found


def run_skipping(
    seed: int,
    data: Path | None,
    progress: Callable[[int], None],
    peers: Sequence[MeshPeer] = MESH_PEERS,
    sizes: Sequence[int] = SIZES,
) -> SkippingResult:
    """Measure everything; ``progress`` is told of each of `steps`. ``data``: the folder of real meshes."""
    start, made_of = time.monotonic(), provenance()
    packages = tuple(presence(peer) for peer in peers)
    present = [peer for peer, found in zip(peers, packages, strict=True) if found.version is not None]
    rows: list[SceneRow] = []
    for scene in skipping_scenes(data):
        rows.append(measure_scene(scene, present))
        progress(1)
    growth = tuple(growths(seed, present, progress, sizes))
    seconds = time.monotonic() - start
    return SkippingResult(made_of, seed, data is not None, packages, tuple(rows), growth, seconds)


def steps(data: Path | None, sizes: Sequence[int] = SIZES) -> int:
    """Return how many steps a run takes."""
    return len(skipping_scenes(data)) + len(SURFACES) * len(sizes)


def measure_scene(scene: SkippingScene, peers: Sequence[MeshPeer]) -> SceneRow:
    """Measure a scene at margin 0 and at its own."""
    at: dict[int, AtMargin] = {}
    meetings: list[Meeting] = []
    for a, b in scene.meetings:
        engine = MeshEngineScene(a, b, CONFIGURATION)
        for margin in sorted({0, scene.margin}):
            golden = stage_answer(a, b, margin, CONFIGURATION)
            measured = _measured(a, b, margin, golden, engine)
            at[margin] = at[margin] + measured if margin in at else measured
            if margin == 0:
                meetings.append(Meeting(a, b, golden.near))
    return SceneRow(scene, tuple(at.values()), tuple(ask_peer(peer, meetings) for peer in peers))


def _measured(
    a: Integers, b: Integers, margin: int, golden: StageAnswer, engine: MeshEngineScene
) -> AtMargin:
    run = engine.run((0, 0, 0), margin)
    counted = run.skipped_in_groups, run.skipped, run.tested
    stages = golden.stages
    engine_right = counted == (stages.before_boxes, stages.boxes, stages.tested)
    software, near = saved(a, b, margin)
    return AtMargin(
        margin,
        stages,
        golden.clocks,
        run.cycles or 0,
        software,
        engine_right and np.array_equal(run.near, golden.near),
        software.same and software.tested == stages.tested and np.array_equal(near, golden.near),
    )
