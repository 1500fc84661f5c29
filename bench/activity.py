"""``triaxis fpga activity``: how much operand gating saves: toggles of all multipliers with and without it.

Toggles are counted in RTL simulation, bit by bit, on the operands, the registers behind the partial
products, and the products of every instance of triaxis_mul.

The pairs are such that their boxes leave about one in a hundred undecided.
"""

import argparse
import re
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from fractions import Fraction
from functools import partial
from math import ceil
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import numpy.typing as npt

from triaxis.bench.harness import Findings, report, told
from triaxis.bench.saif import Activity, read_saif
from triaxis.fpga.bitstream import ACTIVITY, SAIF
from triaxis.fpga.board_build import ENGINE_INSTANCE, TOP
from triaxis.golden.bulk import bulk_facts
from triaxis.golden.errors import InputError
from triaxis.golden.outputs import write_whole
from triaxis.golden.pairs import Pairs, coordinate_range
from triaxis.host.cli.arguments import add_seed
from triaxis.host.cli.terminal import progress_bar, table
from triaxis.host.quantise import centred_grid, quantise
from triaxis.host.scenes import Scene, scenes
from triaxis.sim.configuration import Configuration
from triaxis.sim.core_engine import RtlEngine
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.mesh_engine import MeshEngine, Mode, spatial_order
from triaxis.sim.paths import DUT
from triaxis.sim.player import followed
from triaxis.verif.core.expectation import expected_words
from triaxis.verif.core.stimulus.margins import box_gaps

WIDTH = 16
UNDECIDED = Fraction(1, 100)
RANDOM_PAIRS = 10_000

# All of a scene of `scenes` in the range of WIDTH bits, in millimetres.
_SPAN = 300


@dataclass(frozen=True)
class Stream:
    """Pairs (N, 2, 3, 3) in the order in which they are sent, and the margin for all of them."""

    name: str
    pairs: Pairs
    margin: int

    @property
    def undecided(self) -> npt.NDArray[np.bool_]:
        """Return which pairs (N,) no box axis separates by more than the margin."""
        return box_gaps(self.pairs) <= self.margin


def scene_meshes(scene: Scene) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Return both meshes of a scene, (N, 3, 3) and (M, 3, 3), on a grid that holds every scene."""
    grid = centred_grid([scene.a, scene.b], Fraction(_SPAN, 1 << WIDTH), WIDTH)
    return quantise(scene.a, grid, scene.name), quantise(scene.b, grid, scene.name)


def scene_stream(scene: Scene) -> Stream:
    """Return all facet pairs of a scene, facet by facet of A, each with all of B as they stand in the mesh.

    The margin is the smallest with which at least `UNDECIDED` of them are undecided.
    """
    a, b = scene_meshes(scene)
    pairs = np.stack([np.repeat(a, len(b), 0), np.tile(b, (len(a), 1, 1))], 1)
    return Stream(scene.name, pairs, _margin(box_gaps(pairs)))


def _margin(gaps: npt.NDArray[np.int64]) -> int:
    # Where boxes overlap, gaps are negative.
    return max(0, int(np.sort(gaps)[ceil(UNDECIDED * len(gaps)) - 1]))


def random_stream(rng: np.random.Generator, count: int = RANDOM_PAIRS, width: int = WIDTH) -> Stream:
    """Return random pairs over the whole range, and margin 0: exactly `UNDECIDED` of them are undecided."""
    low, high = coordinate_range(width)
    wanted = ceil(UNDECIDED * count)
    undecided, decided = np.empty((0, 2, 3, 3), np.int64), np.empty((0, 2, 3, 3), np.int64)
    while len(undecided) < wanted or len(decided) < count - wanted:
        drawn = rng.integers(low, high, (count, 2, 3, 3), endpoint=True)
        meet = box_gaps(drawn) <= 0
        undecided, decided = np.concatenate([undecided, drawn[meet]]), np.concatenate([decided, drawn[~meet]])
    pairs = np.concatenate([undecided[:wanted], decided[: count - wanted]])
    return Stream("random pairs", rng.permutation(pairs), 0)


def streams(seed: int) -> list[Stream]:
    """Return what is measured: random pairs, and all scenes."""
    return [random_stream(np.random.default_rng(seed)), *map(scene_stream, scenes())]


# What a scene with one undecided pair in a hundred may toggle of an ungated design.
BOUND = 0.03
GATED = Configuration(WIDTH, WIDTH)
UNGATED = replace(GATED, gating=False)

# What the power report of a bitstream goes by.
ENGINE = MeshConfiguration(WIDTH, WIDTH, certified=True)
SAIF_SCENE = scenes()[0]

_OPERANDS, _PIECES, _PRODUCT = ("a_i", "b_i"), "piece_q", "product_o"


@dataclass(frozen=True)
class MultiplierToggles:
    """Toggles of all multipliers: of their operands, of the registers in them, and of their products."""

    multipliers: int
    operands: int
    registers: int
    products: int

    @property
    def total(self) -> int:
        """Return all of them."""
        return self.operands + self.registers + self.products


@dataclass(frozen=True)
class Row:
    """One stream of pairs through both designs."""

    name: str
    pairs: int
    undecided: int
    margin: int
    gated: MultiplierToggles
    ungated: MultiplierToggles

    @property
    def ratio(self) -> float:
        """Return the gated design's share of the ungated one's toggles."""
        return self.gated.total / self.ungated.total

    @property
    def within_bound(self) -> bool:
        """Return whether gating saves enough."""
        return self.ratio <= BOUND


def multiplier_toggles(activity: Activity) -> MultiplierToggles:
    """Return the toggles of all instances of triaxis_mul, known by its ports.

    Raises InputError where there is none, or none that toggles.
    """
    wanted = {*_OPERANDS, _PRODUCT}
    found = [path for path, nets in activity.instances.items() if wanted <= nets.keys()]
    counted = MultiplierToggles(
        len(found),
        sum(activity.instances[path][signal] for path in found for signal in _OPERANDS),
        sum(activity.inside(path, _PIECES) for path in found),
        sum(activity.instances[path][_PRODUCT] for path in found),
    )
    # Nothing counted would pass every bound.
    if not all((counted.multipliers, counted.operands, counted.registers, counted.products)):
        raise InputError(
            f"activity: no toggles of multipliers in the trace ({counted}): nothing was measured"
        )
    return counted


def trace(stream: Stream, configuration: Configuration, file: Path, dut: Path = DUT) -> MultiplierToggles:
    """Send a stream through the core, leave its activity in ``file``, and return the multipliers' toggles.

    Raises InputError where an answer is wrong: the activity of a broken core is worth nothing.
    """
    margins = np.full(len(stream.pairs), stream.margin, np.int64)
    core = RtlEngine(configuration, dut, traced=True)
    with followed(core.library, file):
        words, _ = core.words(stream.pairs, margins)
    wrong = words != expected_words(bulk_facts(stream.pairs, margins), configuration)
    if wrong.any():
        raise InputError(
            f"activity: {stream.name}, {configuration.name}: {int(wrong.sum())} of {len(words)} answers wrong"
        )
    return multiplier_toggles(read_saif(file))


def measure(stream: Stream) -> Row:
    """Measure a stream, with and without gating."""
    with TemporaryDirectory() as folder:
        file = Path(folder) / "core.saif"
        gated, ungated = trace(stream, GATED, file), trace(stream, UNGATED, file)
    return Row(stream.name, len(stream.pairs), int(stream.undecided.sum()), stream.margin, gated, ungated)


def trace_scene() -> MultiplierToggles:
    """Run `SAIF_SCENE` on the mesh engine, leave its activity in `SAIF`; return the multipliers' toggles.

    The margin is that of the scene's stream. Raises InputError where the number of near pairs is wrong.
    """
    stream, meshes = scene_stream(SAIF_SCENE), scene_meshes(SAIF_SCENE)
    engine = MeshEngine(ENGINE, traced=True)
    a, b = (mesh[spatial_order(mesh, ENGINE.group)] for mesh in meshes)
    engine.load(a, b)
    with TemporaryDirectory() as folder:
        path = Path(folder) / SAIF.name
        # Without the loading.
        with followed(engine.library, path):
            found = engine.run(margin=stream.margin, mode=Mode.COUNT).near_count
        activity = in_place(path.read_text())
    right = int(bulk_facts(stream.pairs, stream.margin).near.sum())
    if found != right:
        raise InputError(
            f"activity: {SAIF_SCENE.name}: the mesh engine finds {found} near pairs, there are {right}"
        )
    write_whole(SAIF, activity)
    return multiplier_toggles(read_saif(SAIF))


def in_place(engine: str) -> str:
    """Return the activity of an engine by itself (SAIF) as that of the engine in the board's top."""
    for alone, placed in (("TOP", TOP), ("triaxis_mesh", ENGINE_INSTANCE)):
        engine = re.sub(rf"\(INSTANCE {alone}\b", f"(INSTANCE {placed}", engine, count=1)
    return engine


def add_activity(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``fpga activity``."""
    parser.description = (
        "Send the same pairs, one in a hundred undecided by its boxes, through the core with and without "
        f"operand gating, which must leave at most {100 * BOUND:g} % of the toggles. Writes "
        "build/fpga/activity.json, and build/fpga/activity.saif, the activity of the mesh engine on a "
        "scene, for power reports."
    )
    add_seed(parser, "seed of the random pairs")
    parser.set_defaults(run=lambda options: report(ACTIVITY, partial(_measured, options.seed)))


def _measured(seed: int) -> Findings:
    wanted = streams(seed)
    rows: list[Row] = []
    with progress_bar("activity", len(wanted) + 1) as progress:
        for stream in wanted:
            rows.append(measure(stream))
            progress(1)
        engine = trace_scene()
        progress(1)
    return findings(rows, engine, seed)


def findings(rows: Sequence[Row], engine: MultiplierToggles, seed: int) -> Findings:
    """Return what is told of all rows, and of the mesh engine on the scene of `SAIF`."""
    title = f"toggles of all {rows[0].gated.multipliers} multipliers, W = 16, M = 16"
    shown = table(title, ("pairs", "undecided", "ungated", "gated", "share", "at most"))
    for row in rows:
        shown.add_row(
            f"{row.pairs:,}: {row.name}",
            f"{100 * row.undecided / row.pairs:.2f} %",
            f"{row.ungated.total:,}",
            f"{row.gated.total:,}",
            f"{100 * row.ratio:.2f} %",
            f"{100 * BOUND:g} %" if row.within_bound else f"{100 * BOUND:g} % EXCEEDED",
        )
    worst = max(row.ratio for row in rows)
    problems = [
        f"{row.name}: {100 * row.ratio:.2f} % of the ungated toggles" for row in rows if not row.within_bound
    ]
    content = {
        "seed": seed,
        "bound": BOUND,
        "worst": worst,
        "streams": [told(row, "ratio", "within_bound") for row in rows],
        "engine": {"scene": SAIF_SCENE.name, "saif": SAIF.name, **asdict(engine)},
    }
    summary = f"multipliers toggle at most {100 * worst:.2f} % of the ungated design's toggles"
    command = f"triaxis fpga activity --seed {seed}"
    return Findings(command, summary, problems, content, [shown], notes=[f"activity of a scene: {SAIF}"])
