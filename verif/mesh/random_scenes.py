"""Random scenes of all kinds and sizes, with several runs on the same meshes, stalls and aborts."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from triaxis.host.spatial_order import spatial_order
from triaxis.sim.mesh_engine import Mode, Move
from triaxis.verif.core.items import FULL_SPEED, Pace
from triaxis.verif.mesh.items import RunRequest, RunTraffic, Scene
from triaxis.verif.mesh.placing import as_move, placed, random_margin
from triaxis.verif.mesh.scene_kinds import KINDS
from triaxis.verif.mesh.shapes import Integers, Shapes

PACES = (FULL_SPEED, Pace(1, 1), Pace(1, 12), Pace(8, 3), Pace(3, 30))
_MODES = (*Mode, Mode.ALL, 3)
# Of so many scenes one is given more triangles than fit, and one keeps a mesh of the scene before.
_OVERFULL_ONE_IN, _KEEPS_ONE_IN = 25, 4
# Scenes of more pairs are of kinds of which little is left to be tested, and in spatial order: a run in which
# nothing is skipped takes a clock for each pair.
_LARGE = 1 << 20
_KINDS_OF_LARGE = ["rows_apart", "lattice", "one_contact"]


def random_scene(
    shapes: Shapes,
    calm: bool = False,
    counts: tuple[int, int] | None = None,
    kinds: Sequence[str] = tuple(KINDS),
) -> Scene:
    """Return a scene of any of some kinds. ``calm``: without stalls, aborts, and runs that are refused."""
    rng, configuration = shapes.rng, shapes.configuration
    count_a, count_b = counts or (shapes.size(), shapes.size())
    margin = random_margin(rng, configuration)
    large = count_a * count_b > _LARGE
    kind = str(rng.choice(_KINDS_OF_LARGE if large else kinds))
    # Kinds that are about distances need room for the margin.
    fitting = min(margin, shapes.reach // 16)
    margin = margin if kind in ("cloud", "in_one_place") else fitting
    there, b = KINDS[kind](shapes, count_a, count_b, margin)
    if large or (kind == "cloud" and rng.integers(2)):
        there, b = (mesh[spatial_order(mesh, configuration.group)] for mesh in (there, b))
    a, move = placed(rng, there, configuration)
    if calm:
        return Scene(a, b, ((RunRequest(move, margin), RunTraffic()),), kind=kind)
    others = 0 if large else int(rng.integers(0, 3))
    runs = tuple(_run(shapes, move, margin, first=n == 0) for n in range(1 + others))
    scene = Scene(a, b, runs, _pace(rng), kind=kind)
    if rng.integers(_OVERFULL_ONE_IN) == 0:
        scene = replace(scene, **{str(rng.choice(["a", "b"])): too_many(shapes)})
    elif rng.integers(_KEEPS_ONE_IN) == 0 and configuration.depth**2 <= _LARGE:
        scene = replace(scene, **dict.fromkeys(_kept(rng)))
    return scene


def too_many(shapes: Shapes) -> Integers:
    """Return a mesh of more triangles than fit."""
    count = shapes.configuration.depth + int(shapes.rng.integers(1, 4))
    return shapes.cloud(count, shapes.somewhere(), 3, 3)


def _kept(rng: np.random.Generator) -> list[str]:
    return [["a"], ["b"], ["a", "b"]][int(rng.integers(3))]


def _pace(rng: np.random.Generator) -> Pace:
    return PACES[int(rng.choice([0, 0, 0, 1, 2, 3, 4]))]


def _run(shapes: Shapes, move: Move, margin: int, first: bool) -> tuple[RunRequest, RunTraffic]:
    """Return the run that the scene is made for, or one that differs in something."""
    rng, configuration = shapes.rng, shapes.configuration
    mode = int(rng.choice(_MODES))
    if not first:
        margin = random_margin(rng, configuration)
        step = rng.integers(-2, 3, 3) if rng.integers(2) else rng.integers(-1, 2, 3) * shapes.reach // 2
        reach = 1 << configuration.width
        move = as_move(np.clip(np.array(move) + step, -reach, reach - 1))
    aborts = (int(2 ** rng.uniform(0, 9)) - 1,) if rng.integers(6) == 0 else ()
    return RunRequest(move, margin, mode), RunTraffic(_pace(rng), _pace(rng), aborts)
