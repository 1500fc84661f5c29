"""The whole measurement of skipping: scenes in hardware and software, other packages, growth."""

import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from triaxis.bench.harness import FOLDER, SOURCES, Progress, write_result
from triaxis.bench.mesh_cycles import CLOCK_MHZ, CONFIGURATION
from triaxis.bench.peers import MESH_PEERS
from triaxis.bench.peers.peer import MeshPeer, Presence, present
from triaxis.bench.skipping.growth import MOST_COMPARED, MOST_SECONDS, SIZES, Growth, growths
from triaxis.bench.skipping.scenes import SURFACES, SkippingScene, skipping_scenes
from triaxis.bench.skipping.software import Meeting, PeerRun, Saved, ask_peer, contradiction, saved
from triaxis.bench.skipping.stages import Clocks, Stages, Summed, stage_answer
from triaxis.host.engines import Integers, MeshEngineScene
from triaxis.sim.validity import Provenance, provenance

RESULT = FOLDER / "skipping.json"

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
class AtMargin:
    """A scene at one margin, in LSB; sums over its pairs of solids."""

    margin: int
    pairs_by_stage: Stages
    hardware: Hardware
    software: Saved

    def __add__(self, other: "AtMargin") -> "AtMargin":
        """Return the sums at the same margin."""
        stages = self.pairs_by_stage + other.pairs_by_stage
        hardware, software = self.hardware + other.hardware, self.software + other.software
        return AtMargin(self.margin, stages, hardware, software)


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
        hardware = [at.hardware for at in last]
        pairs = sum(each.cycles_without_skipping for each in hardware)
        return pairs, sum(each.cycles for each in hardware), software

    @property
    def problems(self) -> list[str]:
        """Return what is not as it must be, a line each."""
        found = [problem for row in self.scenes for problem in _scene_problems(row)]
        pairs, cycles, software = self.totals
        if pairs < LEAST_RATIO * cycles:
            found.append(f"scenes: {pairs} pairs in {cycles} cycles: less than {LEAST_RATIO:g} a cycle")
        if software.seconds_behind_boxes > software.seconds_all_pairs:
            found.append("scenes: the broad phase makes the bulk checker slower")
        return found + [problem for growth in self.growth for problem in growth.problems]


def _scene_problems(row: SceneRow) -> list[str]:
    found = [contradiction(row.scene.name, run) for run in row.peers if run.contradicts]
    for at in row.at:
        name = f"{row.scene.name}, margin {at.margin}"
        pairs, hardware = at.pairs_by_stage.pairs, at.hardware
        if pairs != row.scene.pairs:
            found.append(f"{name}: stages account for {pairs} of {row.scene.pairs} pairs")
        if not hardware.right:
            found.append(f"{name}: the mesh engine skips or finds other pairs than the golden model")
        if not at.software.right:
            found.append(f"{name}: the broad phase loses or adds near pairs")
        if hardware.cycles > pairs:
            cost = f"{hardware.cycles} cycles for {pairs} pairs"
            found.append(f"{name}: {cost}: skipping costs more than it saves")
    return found


def run_skipping(
    seed: int,
    data: Path | None,
    progress: Progress,
    peers: Sequence[MeshPeer] = MESH_PEERS,
    sizes: Sequence[int] = SIZES,
) -> SkippingResult:
    """Measure everything; ``progress`` is told of each of `steps`. ``data``: the folder of real meshes."""
    start, made_of = time.monotonic(), provenance(SOURCES)
    there, packages = present(peers)
    asked = [peer for peer, _ in there]
    rows: list[SceneRow] = []
    for scene in skipping_scenes(data):
        rows.append(measure_scene(scene, asked))
        progress(1)
    growth = tuple(growths(seed, asked, progress, sizes))
    seconds = time.monotonic() - start
    return SkippingResult(made_of, seed, data is not None, tuple(packages), tuple(rows), growth, seconds)


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
            measured, near = _measured(a, b, margin, engine)
            at[margin] = at[margin] + measured if margin in at else measured
            if margin == 0:
                meetings.append(Meeting(a, b, near))
    return SceneRow(scene, tuple(at.values()), tuple(ask_peer(peer, meetings) for peer in peers))


def _measured(a: Integers, b: Integers, margin: int, engine: MeshEngineScene) -> tuple[AtMargin, Integers]:
    """Return what was measured, and the near pairs (K, 2) by the golden model."""
    golden, run = stage_answer(a, b, margin, CONFIGURATION), engine.run((0, 0, 0), margin)
    stages, counted = golden.stages, (run.skipped_in_groups, run.skipped, run.tested)
    right = counted == (stages.before_boxes, stages.boxes, stages.tested)
    right = right and np.array_equal(run.near, golden.near)
    software = saved(a, b, margin, golden.near)
    software = replace(software, right=software.right and software.pairs_tested == stages.tested)
    hardware = Hardware(run.cycles or 0, stages.pairs, golden.clocks, right)
    return AtMargin(margin, stages, hardware, software), golden.near


def summary(result: SkippingResult) -> str:
    """Return what was found, in a line."""
    pairs, cycles, software = result.totals
    exponents = ", ".join(
        f"{growth.surfaces.name} {growth.compared_exponent:.2f}" for growth in result.growth
    )
    return (
        f"{pairs:,} facet pairs in {cycles:,} cycles ({pairs / cycles:.0f} a cycle); bulk checker "
        f"{software.seconds_all_pairs:.2f} s alone, {software.seconds_behind_boxes:.3f} s behind the broad "
        f"phase; comparisons grow with exponents {exponents}"
    )


def write_numbers(result: SkippingResult) -> Path:
    """Write build/bench/skipping.json, whole or not at all."""
    pairs, cycles, software = result.totals
    content = {
        "seed": result.seed,
        "real_meshes": result.real_meshes,
        "engine": CONFIGURATION.name,
        "clock_mhz": CLOCK_MHZ,
        "times": "seconds of processor time, one thread, least of several rounds",
        "bounds": {
            "least_pairs_a_cycle": LEAST_RATIO,
            "most_comparison_exponent": MOST_COMPARED,
            "most_seconds_exponent": MOST_SECONDS,
        },
        "totals": {
            "pairs": pairs,
            "cycles": cycles,
            "seconds_all_pairs": software.seconds_all_pairs,
            "seconds_behind_boxes": software.seconds_behind_boxes,
        },
        "packages": [asdict(package) for package in result.packages],
        "scenes": [_scene(row) for row in result.scenes],
        "growth": [_growth(growth) for growth in result.growth],
    }
    command = f"triaxis bench skipping --seed {result.seed}"
    return write_result(
        RESULT, command, result.problems, summary(result), result.seconds, content, result.provenance
    )


def _scene(row: SceneRow) -> dict[str, Any]:
    return {
        "name": row.scene.name,
        "real": row.scene.real,
        "meetings": [[len(a), len(b)] for a, b in row.scene.meetings],
        "pairs": row.scene.pairs,
        "at_margins": [{**asdict(at), "tested": at.pairs_by_stage.tested} for at in row.at],
        "packages_at_margin_0": [asdict(run) for run in row.peers],
    }


def _growth(growth: Growth) -> dict[str, Any]:
    return {
        "surfaces": growth.surfaces.name,
        "about": growth.surfaces.about,
        "comparison_exponent": growth.compared_exponent,
        "seconds_exponent": growth.seconds_exponent,
        "points": [asdict(point) for point in growth.points],
    }
