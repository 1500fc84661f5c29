"""What whole scenes cost the mesh engine: cycles counted in RTL simulation, against the numbers of pairs.

Each scene's near pairs are compared with those of the bulk checker behind the broad phase in NumPy.
"""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from fractions import Fraction
from math import ceil
from pathlib import Path
from typing import Any

import numpy as np

from triaxis.bench.harness import FOLDER, Progress, write_result
from triaxis.golden.bulk import bulk_verdicts
from triaxis.host.engines import DecidingEngine, Integers, MeshEngineScene, SceneRun
from triaxis.host.quantise import centred_grid, margin_for, quantise
from triaxis.host.scenes import Scene, machine_scenes, scenes
from triaxis.host.stl import Facets
from triaxis.sim.mesh_configuration import MeshConfiguration

RESULT = FOLDER / "mesh.json"
CONFIGURATION = MeshConfiguration()
CLOCK_MHZ = 100

# The product's demands on 200 x 200 facets, and on scenes in general.
_MOST_WORST, _MOST_NEAR, _MOST_APART, _LEAST_RATIO = 41_000, 100_000, 1_000, 10.0
_FACETS = 200
# Steps that the larger extent of a scene takes of the 2^16 of the grid; the rest is for the centring.
_STEPS = 60_000


@dataclass(frozen=True)
class Bound:
    """At most so many cycles, or at least so many pairs for each."""

    most_cycles: int | None = None
    least_pairs_a_cycle: float | None = None

    def met(self, pairs: int, cycles: int) -> bool:
        """Return whether a run keeps it."""
        if self.most_cycles is not None and cycles > self.most_cycles:
            return False
        return self.least_pairs_a_cycle is None or pairs >= self.least_pairs_a_cycle * cycles

    def __str__(self) -> str:
        """Return it for a table."""
        if self.most_cycles is not None:
            return f"<= {self.most_cycles:,} cycles"
        return f">= {self.least_pairs_a_cycle:g} pairs/cycle"


@dataclass(frozen=True)
class Case:
    """A scene on the grid: facets (N, 3, 3), margin in LSB, and what it may cost."""

    name: str
    a: Integers
    b: Integers
    margin: int
    bound: Bound


@dataclass(frozen=True)
class Row:
    """A scene that was run. ``right``: its near pairs are those of the bulk checker."""

    name: str
    facets_a: int
    facets_b: int
    bound: Bound
    run: SceneRun
    right: bool

    @property
    def pairs(self) -> int:
        """Return the number of facet pairs."""
        return self.facets_a * self.facets_b

    @property
    def cycles(self) -> int:
        """Return the engine's cycles."""
        return self.run.cycles or 0

    @property
    def passed(self) -> bool:
        """Return whether it is right and within its bound."""
        return self.right and self.bound.met(self.pairs, self.cycles)

    @property
    def verdict(self) -> str:
        """Return it in a word."""
        return "WRONG" if not self.right else "reached" if self.passed else "MISSED"


def _tilted(rng: np.random.Generator, side: int) -> Integers:
    """Return large facets that lie across all space, on one side of the plane x + y + z = 0."""
    corner = 20_000 * np.eye(3, dtype=np.int64) - 6_000
    return corner + side * 3_000 + rng.integers(-500, 501, (_FACETS, 3, 3))


def _scattered(rng: np.random.Generator, count: int, place: int) -> Integers:
    """Return small facets all over a block of 20,000 steps about (place, 0, 0)."""
    centres = rng.integers(-10_000, 10_001, (count, 1, 3)) + np.array([place, 0, 0])
    return centres + rng.integers(-300, 301, (count, 3, 3))


def _made_cases() -> Iterator[Case]:
    """Yield the scenes that are made for their cost alone."""
    rng = np.random.default_rng(1)
    below, above, depth = _tilted(rng, -1), _tilted(rng, 1), CONFIGURATION.depth
    yield Case("nothing skippable, nothing near", below, above, 0, Bound(most_cycles=_MOST_WORST))
    yield Case("nothing skippable, all near", below, above, 9_000, Bound(most_cycles=_MOST_NEAR))
    apart = Bound(most_cycles=_MOST_APART)
    yield Case("apart", _scattered(rng, _FACETS, -15_000), _scattered(rng, _FACETS, 15_000), 100, apart)
    yield Case(
        "apart, full memories", _scattered(rng, depth, -15_000), _scattered(rng, depth, 15_000), 100, apart
    )


def on_filled_grid(name: str, solids: Sequence[Facets]) -> tuple[list[Integers], int]:
    """Return solids on the engine's grid, which they fill, and a margin, in LSB, of 1/400 of their extent."""
    extent = max(float(np.ptp(np.concatenate(solids).reshape(-1, 3), 0).max()), 1e-6)
    resolution = Fraction(ceil(extent * 10_000 / _STEPS), 10_000)
    grid = centred_grid(list(solids), resolution, CONFIGURATION.width)
    margin = margin_for(Fraction(extent / 400).limit_denominator(1000), grid)
    return [quantise(solid, grid, name) for solid in solids], margin


def _close_case(scene: Scene) -> Case:
    (a, b), margin = on_filled_grid(scene.name, [scene.a, scene.b])
    return Case(scene.name, a, b, margin, Bound(least_pairs_a_cycle=_LEAST_RATIO))


def cases(data: Path | None) -> list[Case]:
    """Return all scenes; those of real meshes where ``data`` is their folder."""
    close = [*scenes(), *(machine_scenes(data) if data else ())]
    return [*_made_cases(), *(_close_case(scene) for scene in close)]


def _run(case: Case) -> Row:
    run = MeshEngineScene(case.a, case.b, CONFIGURATION).run((0, 0, 0), case.margin)
    exact = DecidingEngine(case.a, case.b, bulk_verdicts).run((0, 0, 0), case.margin)
    right = np.array_equal(run.near, exact.near) and run.tested == exact.tested
    return Row(case.name, len(case.a), len(case.b), case.bound, run, right)


def bench_mesh(chosen: list[Case], progress: Progress) -> list[Row]:
    """Run all scenes; ``progress`` is told of each."""
    rows: list[Row] = []
    for case in chosen:
        rows.append(_run(case))
        progress(1)
    return rows


def write_rows(rows: list[Row], data_present: bool, seconds: float) -> Path:
    """Write build/bench/mesh.json, whole or not at all."""
    failed = [row for row in rows if not row.passed]
    pairs, cycles = sum(row.pairs for row in rows), sum(row.cycles for row in rows)
    content = {
        "engine": CONFIGURATION.name,
        "clock_mhz": CLOCK_MHZ,
        "real_meshes": data_present,
        "scenes": [_scene(row) for row in rows],
    }
    return write_result(
        RESULT,
        "triaxis bench mesh",
        [f"{row.name}: {row.verdict}, {row.cycles:,} cycles, {row.bound}" for row in failed],
        f"{len(rows)} scenes, {pairs:,} pairs, {cycles:,} cycles",
        seconds,
        content,
    )


def _scene(row: Row) -> dict[str, Any]:
    return {
        "name": row.name,
        "facets": [row.facets_a, row.facets_b],
        "pairs": row.pairs,
        "cycles": row.cycles,
        "milliseconds": row.cycles / CLOCK_MHZ / 1000,
        "group_pairs_skipped": row.run.group_pairs_skipped,
        "group_pairs_opened": row.run.group_pairs_opened,
        "pairs_skipped_in_groups": row.run.skipped_in_groups,
        "pairs_skipped_by_boxes": row.run.skipped,
        "tested": row.run.tested,
        "near": row.run.near_count,
        "right": row.right,
        "bound": asdict(row.bound),
        "passed": row.passed,
    }
