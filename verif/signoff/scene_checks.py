"""Whole meshes through the RTL, compared with the golden model pair by pair; insides; sizes between."""

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np
import numpy.typing as npt

from triaxis.golden.judge import judge_pairs
from triaxis.golden.pairs import Pairs
from triaxis.host.broadphase import in_order
from triaxis.host.enclosure import NOT_ASKED, enclosure
from triaxis.host.engines import DecidingEngine
from triaxis.host.scene import prepare
from triaxis.host.scenes import box, machine_solids, mesh_data, write_scenes, write_stl
from triaxis.host.shells import solid_of
from triaxis.host.stl import read_stl
from triaxis.sim.core_engine import RtlEngine, configuration_for
from triaxis.sim.mesh_configuration import parse_mesh_configuration
from triaxis.sim.mesh_engine import MeshEngine, Status
from triaxis.verif.mesh.uvm_tests import BOARD


@dataclass(frozen=True)
class SceneResult:
    """Two meshes, checked end to end through the RTL, and for one inside the other.

    ``agrees``: the golden model says the same of every tested pair.
    """

    name: str
    expected: str
    found: str
    agrees: bool
    pairs: int
    skipped: int
    tested: int
    near: int

    @property
    def passed(self) -> bool:
        """Return whether it came out as expected, and as the golden model says."""
        return self.agrees and self.found == self.expected


def _check_files(name: str, a: Path, b: Path, expected: bool, clearance: Fraction) -> SceneResult:
    """Check two STL files by the core, and compare every tested pair with the golden model."""
    meshes = prepare(read_stl(a), read_stl(b), (str(a), str(b)), Fraction(1, 1000), clearance, width=24)
    engine = RtlEngine(configuration_for(meshes.grid.width, meshes.margin))
    agrees = True

    def decide(pairs: Pairs, margins: npt.NDArray[np.int64]) -> npt.NDArray[np.bool_]:
        nonlocal agrees
        verdicts = engine.verdicts(pairs, margins)
        agrees &= bool((verdicts == judge_pairs(pairs, margins)).all())
        return verdicts["near"]

    run = DecidingEngine(meshes.a, meshes.b, decide).run((0, 0, 0), meshes.margin)
    insides = NOT_ASKED if run.near_count else enclosure(solid_of(meshes.a), solid_of(meshes.b))
    return SceneResult(
        name,
        "near" if expected else "clear",
        insides.verdict(run.near_count > 0),
        agrees,
        run.skipped + run.tested,
        run.skipped,
        run.tested,
        run.near_count,
    )


def check_scenes(folder: Path) -> list[SceneResult]:
    """Check the scenes that the project makes itself, written into a folder as STL files."""
    made = [(scene.name, a, b, scene.near) for scene, a, b in write_scenes(folder)]
    probe, stock, hollow = (folder / f"enclosed_{name}.stl" for name in ("probe", "stock", "hollow"))
    around, cavity = box((-30, -30, -30), (30, 30, 30)), box((-10, -10, -10), (10, 10, 10))[:, ::-1]
    write_stl(probe, box((-4, -4, -4), (4, 4, 4)))
    write_stl(stock, around)
    write_stl(hollow, np.concatenate([around, cavity]))
    made += [("probe inside a block", probe, stock, True), ("probe in a cavity", probe, hollow, False)]
    return [*(_check_files(*scene, Fraction(1, 2)) for scene in made), *check_sizes()]


def check_sizes() -> list[SceneResult]:
    """Check the engine that ships on meshes larger than those that its tests draw, and not full: where
    the last facets alone meet; with more near pairs, and more pairs that boxes decide, than 20 bits count.
    """
    engine = MeshEngine(parse_mesh_configuration(BOARD))
    found: list[SceneResult] = []
    for name, a, b, near in _sized():
        engine.load(a, b)
        run = engine.run()
        group, pairs = engine.configuration.group, len(a) * len(b)
        groups = -(-len(a) // group) * -(-len(b) // group)
        agrees = (
            run.status == Status.COMPLETE
            and run.near_count == len(near)
            and np.array_equal(in_order(run.near), near)
            and run.group_pairs_skipped + run.group_pairs_opened == groups
            # Where all groups are opened, each pair counts by itself.
            and (run.group_pairs_skipped > 0 or run.pairs_skipped + run.tested == pairs)
            and len(near) <= run.tested <= run.cycles
        )
        expected, said = ("near" if count else "clear" for count in (len(near), run.near_count))
        found.append(
            SceneResult(name, expected, said, agrees, pairs, pairs - run.tested, run.tested, run.near_count)
        )
    return found


def _sized() -> Iterator[tuple[str, npt.NDArray[np.int64], npt.NDArray[np.int64], npt.NDArray[np.int64]]]:
    """Give a name, two meshes, and the pairs of these that are near, in order."""
    facet = np.array([[0, 0, 0], [9, 0, 0], [0, 9, 0]])
    up = np.array([0, 0, 1])
    for count_a, count_b in ((130, 1001), (1003, 129), (2047, 2049), (4089, 3001)):
        a, b = (np.tile(facet, (count, 1, 1)) for count in (count_a, count_b))
        b[:-1] += 100 * up
        near = np.stack([np.arange(count_a), np.full(count_a, count_b - 1)], 1)
        yield f"the last of {count_b:,} facets touches {count_a:,}", a, b, near
        a[:-1] -= 100 * up
        yield f"the last of {count_a:,} facets touches the last of {count_b:,}", a, b, near[-1:]
    count = 1025
    many = np.tile(facet, (count, 1, 1))
    yield (
        f"all of {count:,} facets touch as many",
        many,
        many,
        np.stack(np.divmod(np.arange(count**2), count), 1),
    )
    apart = many + np.where(np.arange(count) % 2, 100, -100)[:, None, None] * up
    yield f"{count:,} facets between as many", many, apart, np.empty((0, 2), np.int64)


def check_real_meshes(folder: Path) -> list[SceneResult] | None:
    """Check parts of a real machine as its simulator assembles them, in units of 10 mm; None where they are
    absent. Moved parts are written into ``folder``.
    """
    data = mesh_data()
    if data is None:
        return None
    results = [
        _check_files(
            "carousel against arm", data / "vmc/carousel.stl", data / "vmc/arm.stl", True, Fraction(0)
        )
    ]
    for z_mm, near in ((0, False), (-250, True)):
        name = f"carousel against head at Z = {z_mm} mm"
        moved = folder / f"head_{abs(z_mm)}.stl"
        write_stl(moved, machine_solids(data, z_mm)["head"].astype(np.float32))
        results.append(_check_files(name, data / "vmc/carousel.stl", moved, near, Fraction(1, 20)))
    return results
