"""``triaxis bench mesh``: cycles of each scene on the mesh engine, in RTL simulation, against its pairs.

Each scene's near pairs are compared with those of the bulk checker behind the broad phase in NumPy. Two zones
around the margin are asked about in the same run, and in runs of their own.
"""

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from fractions import Fraction
from math import ceil
from pathlib import Path
from typing import Any

import numpy as np

from triaxis.bench import harness
from triaxis.bench.harness import Findings, Progress, report
from triaxis.host.cli.terminal import progress_bar, table
from triaxis.host.engines import BULK, Integers, MeshEngineScene, SceneRun, parts_of, scene_engine
from triaxis.host.quantise import centred_grid, margin_for, quantise
from triaxis.host.scenes import Scene, machine_scenes, mesh_data, scenes
from triaxis.host.stl import Facets
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.mesh_engine import MeshEngine, Mode

# As it stands on the board.
CONFIGURATION = MeshConfiguration(certified=True)
CLOCK_MHZ = 100

# The product's demands on 200 x 200 facets, in cycles, and on scenes in general, in pairs a cycle.
_MOST_WORST, _MOST_NEAR, _MOST_APART, _LEAST_RATIO = 41_000, 100_000, 1_000, 10
_FACETS = 200
# Steps that the larger extent of a scene takes of the 2^16 of the grid; the rest is for the centring.
_STEPS = 60_000


@dataclass(frozen=True)
class Case:
    """A scene on the grid: facets (N, 3, 3), margin in LSB, and the cycles that it may take."""

    name: str
    a: Integers
    b: Integers
    margin: int
    most_cycles: int


# Slow and warn, in margins: 2, 8 and 14 mm are usual. One run may take so many cycles more than the widest
# zone alone: in each zone as many pairs are asked again as were on their way, 66, and the last ends that much
# later.
_ZONES, _MOST_MORE = (4, 7), 256


@dataclass(frozen=True)
class Zoned:
    """Cycles of a run with zones, of runs with the margin, slow and warn alone; whether they say the same."""

    together: int
    alone: tuple[int, int, int]
    right: bool

    @property
    def more(self) -> int:
        """Return how many cycles the one takes more than the widest zone alone."""
        return self.together - self.alone[-1]


@dataclass(frozen=True)
class Row:
    """A scene that was run. ``right``: its near pairs are those of the bulk checker; ``zoned``: None where
    the meshes are run in parts.
    """

    case: Case
    run: SceneRun
    right: bool
    zoned: Zoned | None

    @property
    def pairs(self) -> int:
        """Return the number of facet pairs."""
        return len(self.case.a) * len(self.case.b)

    @property
    def cycles(self) -> int:
        """Return the engine's cycles."""
        return self.run.cycles or 0

    @property
    def verdict(self) -> str:
        """Return in a word whether it is right and within its bound."""
        if not self.right or (self.zoned and not self.zoned.right):
            return "WRONG"
        met = self.cycles <= self.case.most_cycles
        return "reached" if met and (not self.zoned or self.zoned.more <= _MOST_MORE) else "MISSED"

    @property
    def passed(self) -> bool:
        """Return whether it is right and within its bound."""
        return self.verdict == "reached"


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
    yield Case("nothing skippable, nothing near", below, above, 0, _MOST_WORST)
    yield Case("nothing skippable, all near", below, above, 9_000, _MOST_NEAR)
    for name, count in (("apart", _FACETS), ("apart, full memories", depth)):
        a, b = (_scattered(rng, count, place) for place in (-15_000, 15_000))
        yield Case(name, a, b, 100, _MOST_APART)


def on_filled_grid(name: str, solids: Sequence[Facets]) -> tuple[list[Integers], int]:
    """Return solids on the engine's grid, which they fill, and a margin, in LSB, of 1/400 of their extent."""
    extent = max(float(np.ptp(np.concatenate(solids).reshape(-1, 3), 0).max()), 1e-6)
    resolution = Fraction(ceil(extent * 10_000 / _STEPS), 10_000)
    grid = centred_grid(list(solids), resolution, CONFIGURATION.width)
    margin = margin_for(Fraction(extent / 400).limit_denominator(1000), grid)
    return [quantise(solid, grid, name) for solid in solids], margin


def _close_case(scene: Scene) -> Case:
    (a, b), margin = on_filled_grid(scene.name, [scene.a, scene.b])
    return Case(scene.name, a, b, margin, len(a) * len(b) // _LEAST_RATIO)


def cases(data: Path | None) -> list[Case]:
    """Return all scenes; those of real meshes where ``data`` is their folder."""
    close = [*scenes(), *(machine_scenes(data) if data else ())]
    return [*_made_cases(), *(_close_case(scene) for scene in close)]


def real_meshes() -> Path | None:
    """Return the folder of real meshes, or say that there is none."""
    data = mesh_data()
    if data is None:
        print("real meshes: no folder $TRIAXIS_DATA or ../shared/data: left out")
    return data


def add_mesh(parser: argparse.ArgumentParser) -> None:
    """Count the cycles of the simulated mesh engine in the worst case, on close scenes and on objects
    apart, against their bounds; compare every scene with the bulk checker. Scenes of real meshes are left
    out where their folder ($TRIAXIS_DATA, or ../shared/data) is absent. Writes build/bench/mesh.json.
    """
    parser.set_defaults(run=lambda _: report(harness.FOLDER / "mesh.json", _measured))


def _measured() -> Findings:
    data = real_meshes()
    chosen = cases(data)
    with progress_bar("scenes", len(chosen)) as progress:
        return findings(bench_mesh(chosen, progress), data is not None)


def bench_mesh(chosen: list[Case], progress: Progress) -> list[Row]:
    """Run all scenes; ``progress`` is told of each."""
    rows: list[Row] = []
    for case in chosen:
        run = MeshEngineScene(case.a, case.b, CONFIGURATION).run((0, 0, 0), case.margin)
        exact = scene_engine(BULK, case.a, case.b, CONFIGURATION.width).run((0, 0, 0), case.margin)
        right = np.array_equal(run.near, exact.near) and run.tested == exact.tested
        rows.append(Row(case, run, right, zoned(case)))
        progress(1)
    return rows


def zoned(case: Case) -> Zoned | None:
    """Run a scene with zones and without; None where its meshes do not fit at once."""
    parts = [parts_of(mesh, CONFIGURATION.depth, CONFIGURATION.group) for mesh in (case.a, case.b)]
    if max(map(len, parts)) > 1:
        return None
    engine = MeshEngine(CONFIGURATION)
    engine.load(*(one.facets for (one,) in parts))
    slow, warn = (min(by * case.margin, CONFIGURATION.max_margin) for by in _ZONES)
    alone = [engine.run((0, 0, 0), margin, Mode.COUNT) for margin in (case.margin, slow, warn)]
    one = engine.run((0, 0, 0), case.margin, Mode.COUNT, (slow, warn))
    asked = slow > case.margin, warn > slow
    due = sum(
        (run.near_count > 0 or not wider) << n
        for n, (run, wider) in enumerate(zip(alone[1:], asked, strict=True))
    )
    right = (one.near_count, one.tested, one.zones) == (alone[0].near_count, alone[-1].tested, due)
    cycles = [run.cycles for run in alone]
    return Zoned(one.cycles, (cycles[0], cycles[1], cycles[2]), right)


def findings(rows: list[Row], data_present: bool) -> Findings:
    """Return what is told of the rows; ``data_present``: scenes of real meshes are among them."""
    headings = (
        "scene", "facets", "pairs", "tested", "near", "cycles", "ms", "pairs/cycle", "at most", "with zones",
        "in 3 runs", "",
    )  # fmt: skip
    shown = table(f"triaxis_mesh {CONFIGURATION.name}, at {CLOCK_MHZ} MHz", headings)
    for row in rows:
        shown.add_row(
            row.case.name,
            f"{len(row.case.a)} x {len(row.case.b)}",
            *(f"{count:,}" for count in (row.pairs, row.run.tested, row.run.near_count, row.cycles)),
            f"{row.cycles / CLOCK_MHZ / 1000:.3f}",
            f"{row.pairs / row.cycles:.1f}",
            f"{row.case.most_cycles:,}",
            f"{row.zoned.together:,}" if row.zoned else "",
            f"{sum(row.zoned.alone):,}" if row.zoned else "",
            row.verdict,
        )
    pairs, cycles = sum(row.pairs for row in rows), sum(row.cycles for row in rows)
    return Findings(
        "triaxis bench mesh",
        f"{len(rows)} scenes, {pairs:,} pairs, {cycles:,} cycles",
        [
            f"{row.case.name}: {row.verdict}, {row.cycles:,} cycles, <= {row.case.most_cycles:,}"
            + (
                f"; with zones {row.zoned.more:,} more than the widest alone, <= {_MOST_MORE}"
                if row.zoned
                else ""
            )
            for row in rows
            if not row.passed
        ],
        {
            "engine": CONFIGURATION.name,
            "clock_mhz": CLOCK_MHZ,
            "real_meshes": data_present,
            "scenes": [_scene(row) for row in rows],
        },
        [shown],
    )


def _scene(row: Row) -> dict[str, Any]:
    return {
        "name": row.case.name,
        "facets": [len(row.case.a), len(row.case.b)],
        "pairs": row.pairs,
        "cycles": row.cycles,
        "milliseconds": row.cycles / CLOCK_MHZ / 1000,
        "group_pairs_skipped": row.run.group_pairs_skipped,
        "group_pairs_opened": row.run.group_pairs_opened,
        "pairs_skipped_in_groups": row.run.skipped_in_groups,
        "pairs_skipped_by_boxes": row.run.skipped,
        "tested": row.run.tested,
        "near": row.run.near_count,
        "zones": asdict(row.zoned) if row.zoned else None,
        "right": row.right,
        "most_cycles": row.case.most_cycles,
        "passed": row.passed,
    }
