"""Scenes that the project makes itself, and those of real machines and parts that it may be given.

Its own are a tool holder with its end mill, and a vise with its workpiece, in millimetres: the tool points
down the z axis with its tip at the origin; the vise's jaws are 60 mm apart with the workpiece between them,
its top face at z = 0.

The others come from files that are not part of the product. The machine stands as its simulator assembles
it, in units of 10 mm: head at z = 4, moving by 0.1 a millimetre of Z; saddle and table at y = 7 and 8. The
parts are put against each other in pairs.
"""

import io
import os
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

import numpy as np
import numpy.typing as npt
import stl

from triaxis.golden.outputs import write_whole
from triaxis.golden.pairs import Pairs
from triaxis.host.broadphase import all_candidates
from triaxis.host.quantise import centred_grid, quantise
from triaxis.host.stl import Facets, read_stl
from triaxis.sim.paths import ROOT

_SEGMENTS = 24


def revolved(profile: list[tuple[float, float]], segments: int = _SEGMENTS) -> Facets:
    """Return the solid that a profile of (radius, height) points makes when turned about z."""
    angle = 2 * np.pi * np.arange(segments) / segments
    circle = np.stack([np.cos(angle), np.sin(angle), np.zeros(segments)], 1)
    rings = [r * circle + np.array([0, 0, z]) for r, z in profile]
    facets: list[npt.NDArray[np.float64]] = []
    for (below, lower), (above, upper) in pairwise(zip((r for r, _ in profile), rings, strict=True)):
        next_lower, next_upper = np.roll(lower, -1, 0), np.roll(upper, -1, 0)
        # About a point on the axis half of the facets would have no area.
        if below:
            facets.append(np.stack([lower, next_lower, next_upper], 1))
        if above:
            facets.append(np.stack([lower, next_upper, upper], 1))
    return np.concatenate(facets).astype(np.float32)


def box(low: tuple[float, float, float], high: tuple[float, float, float]) -> Facets:
    """Return the twelve facets of a box."""
    corner = np.array([low, high])
    v = np.array([[corner[i, 0], corner[j, 1], corner[k, 2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return np.array(
        [[v[a], v[b], v[c]] for q in quads for a, b, c in (q[:3], (q[0], q[2], q[3]))], np.float32
    )


def tool() -> Facets:
    """Return a 10 mm end mill in its holder, tip at the origin."""
    return revolved([(0, 0), (5, 0), (5, 25), (6, 45), (14, 45), (20, 60), (31.5, 75), (31.5, 85), (0, 85)])


def vise() -> Facets:
    """Return a vise with a workpiece of 80 x 60 x 30 mm between its jaws, top face at z = 0."""
    return np.concatenate(
        [
            box((-100, -90, -60), (100, 90, -32)),
            box((-75, -70, -32), (75, -30, -8)),
            box((-75, 30, -32), (75, 70, -8)),
            box((-40, -29.75, -30), (40, 29.75, 0)),
        ]
    )


@dataclass(frozen=True)
class Scene:
    """Two solids, and what is true of them."""

    name: str
    a: Facets
    b: Facets
    near: bool


def scenes() -> list[Scene]:
    """Return the scenes of the sign-off: the tool above, at, and in the workpiece; beside a jaw."""
    cutter, fixture = tool(), vise()

    def at(x: float, y: float, z: float, tilt_degrees: float = 0) -> Facets:
        c, s = np.cos(np.radians(tilt_degrees)), np.sin(np.radians(tilt_degrees))
        turn = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
        return (cutter @ turn.T + np.array([x, y, z])).astype(np.float32)

    return [
        Scene("tool 2 mm above the workpiece", at(0, 0, 2), fixture, False),
        Scene("tool 0.25 mm above the workpiece", at(10, 5, 0.25), fixture, True),
        Scene("tool 3 mm deep in the workpiece", at(-20, 10, -3), fixture, True),
        Scene("tool 1 mm beside a jaw", at(0, 76.5, -20), fixture, False),
        # Its long facets lie across the boxes of the workpiece: the axes have to decide.
        Scene("tool tilted by 40 degrees beside the workpiece", at(0, 42, -4, 40), fixture, False),
    ]


def write_scenes(folder: Path) -> list[tuple[Scene, Path, Path]]:
    """Write each scene as two binary STL files, <number>_tool.stl and <number>_vise.stl."""
    written: list[tuple[Scene, Path, Path]] = []
    for number, scene in enumerate(scenes()):
        a, b = folder / f"{number}_tool.stl", folder / f"{number}_vise.stl"
        write_stl(a, scene.a)
        write_stl(b, scene.b)
        written.append((scene, a, b))
    return written


def write_stl(path: Path, facets: Facets) -> None:
    """Write facets as a binary STL, whole or not at all."""
    mesh = stl.mesh.Mesh(np.zeros(len(facets), dtype=stl.mesh.Mesh.dtype))
    mesh.vectors[:] = facets
    content = io.BytesIO()
    mesh.save(path.name, content, mode=stl.Mode.BINARY)
    write_whole(path, content.getvalue())


def mesh_pairs(rng: np.random.Generator, count: int, width: int) -> Pairs:
    """Return ``count`` facet pairs of the scenes, on a grid that fills the width: (N, 2, 3, 3).

    Half of them have overlapping boxes, as far as there are such.
    """
    chosen: list[Pairs] = []
    every = scenes()
    for scene in every:
        # All of the scene within 3/4 of the range.
        resolution = Fraction(300, 1 << width)
        grid = centred_grid([scene.a, scene.b], resolution, width)
        a, b = quantise(scene.a, grid, "a"), quantise(scene.b, grid, "b")
        reach = int(2 / resolution)
        i, j = all_candidates(a, b, reach).T
        close = np.stack([a[i], b[j]], 1)
        each = -(-count // len(every))
        close = rng.permutation(close)[: each // 2]
        rest = each - len(close)
        any_pair = np.stack([a[rng.integers(0, len(a), rest)], b[rng.integers(0, len(b), rest)]], 1)
        chosen += [close.astype(np.int64), any_pair]
    return rng.permutation(np.concatenate(chosen))[:count]


# Solids that are put against each other, and by how much of their length the first one is lifted.
_PARTS = (
    ("angle_block", "plate_holes", 0.0),
    ("idler_riser", "featuretype", 0.0),
    ("angle_block", "angle_block", 0.3),
)


def machine_solids(data: Path, z_mm: float) -> dict[str, Facets]:
    """Return the machine's solids by name, where they stand, the head at a position of its Z axis in mm."""
    solids = {path.stem: read_stl(path).facets for path in sorted((data / "vmc").glob("*.stl"))}
    places = {"head": (0, 0, 4 + 0.1 * z_mm), "saddle": (0, 7, 0), "table": (0, 8, 0)}
    return {name: facets + np.array(places.get(name, (0, 0, 0))) for name, facets in solids.items()}


def machine_scenes(data: Path) -> list[Scene]:
    """Return close scenes from the folder of real meshes; see `triaxis.host.scenes`."""
    machine, lowered = machine_solids(data, -250), machine_solids(data, -200)
    carousel, base, saddle = machine["carousel"], machine["base"], machine["saddle"]
    scenes = [
        Scene("carousel against arm", carousel, machine["arm"], True),
        Scene("carousel against head at Z = -250 mm", carousel, machine["head"], True),
        Scene("head against base at Z = -200 mm", lowered["head"], base, True),
        Scene("table against saddle", machine["table"], saddle, True),
        Scene("saddle against base", saddle, base, True),
    ]
    return scenes + [_parts(data / "parts", *names) for names in _PARTS]


def _parts(folder: Path, a: str, b: str, lift: float) -> Scene:
    """Return two parts with their centres together, the first one lifted along z."""
    first, second = (read_stl(folder / f"{name}.STL").facets for name in (a, b))
    first = first - first.mean((0, 1)) + np.array([0, 0, lift * np.ptp(first.reshape(-1, 3), 0).max()])
    lifted = f", lifted by {lift:.0%}" if lift else ""
    return Scene(f"{a} against {b}{lifted}", first, second - second.mean((0, 1)), True)


def mesh_data() -> Path | None:
    """Return the folder of real meshes: $TRIAXIS_DATA, or ../shared/data; None where absent."""
    folder = Path(os.environ.get("TRIAXIS_DATA", ROOT.parent / "shared" / "data"))
    return folder if (folder / "vmc").is_dir() else None
