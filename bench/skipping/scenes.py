"""What skipping is measured on: scenes of solids that meet, and meshes of any number of facets."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations
from math import sqrt
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from triaxis.bench.mesh_cycles import on_filled_grid
from triaxis.host.engines import Integers
from triaxis.host.scenes import machine_scenes, machine_solids, scenes, tool, vise
from triaxis.host.stl import Facets

# Where the whole machine is taken, in mm of its Z axis: with the head up, and down at the carousel.
_HEADS = (0, -250)


@dataclass(frozen=True)
class SkippingScene:
    """Pairs of solids that may meet, facets (N, 3, 3) and (M, 3, 3) in LSB, and a margin in LSB.

    ``real``: from files of real machines and parts, which are no part of the product.
    """

    name: str
    meetings: tuple[tuple[Integers, Integers], ...]
    margin: int
    real: bool = False

    @property
    def pairs(self) -> int:
        """Return how many facet pairs there are."""
        return sum(len(a) * len(b) for a, b in self.meetings)


def skipping_scenes(data: Path | None) -> list[SkippingScene]:
    """Return all scenes; those of real meshes where ``data`` is their folder."""
    cutter, fixture = tool(), vise()
    high = cutter + np.array([0, 0, 200])
    made = [_scene(scene.name, [scene.a, scene.b]) for scene in scenes()]
    made.append(_scene("tool 200 mm above the workpiece", [high, fixture]))
    if data is None:
        return made
    close = [_scene(scene.name, [scene.a, scene.b], real=True) for scene in machine_scenes(data)]
    machines = [
        _scene(f"whole machine at Z = {z} mm", list(machine_solids(data, z).values()), real=True)
        for z in _HEADS
    ]
    return [*made, *close, *machines]


def _scene(name: str, solids: Sequence[Facets], real: bool = False) -> SkippingScene:
    """Return a scene in which every two of the solids meet; of each two the larger is A."""
    placed, margin = on_filled_grid(name, solids)
    meetings = tuple((a, b) if len(a) >= len(b) else (b, a) for a, b in combinations(placed, 2))
    return SkippingScene(name, meetings, margin, real)


# Half the side of the cube that they lie in, in LSB: 24 bits hold them.
_RADIUS = 1 << 22
# Roughness, as a share of the length of an edge.
_ROUGHNESS = 0.3


@dataclass(frozen=True)
class Surfaces:
    """A pair of meshes of about as many facets as asked for: (N, 3, 3) each, in LSB, the same by seed."""

    name: str
    about: str
    make: Callable[[int, np.random.Generator], tuple[Integers, Integers]]


def _facets(vertices: npt.NDArray[np.floating[Any]], closed: bool) -> Integers:
    """Return the facets of a net of vertices (U, V, 3), in LSB; ``closed``: last and first column join."""
    if closed:
        vertices = np.concatenate([vertices, vertices[:, :1]], 1)
    corner = np.rint(vertices).astype(np.int64)
    quad = corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]
    halves = [np.stack([quad[0], quad[k], quad[k + 1]], 2).reshape(-1, 3, 3) for k in (1, 2)]
    return np.concatenate(halves)


def _sheet(count: int, rng: np.random.Generator) -> Integers:
    """Return a rough square of 2 side^2 facets."""
    side = max(1, round(sqrt(count / 2)))
    step = 2 * _RADIUS / side
    u, v = np.meshgrid(np.arange(side + 1) * step - _RADIUS, np.arange(side + 1) * step - _RADIUS)
    rough = _ROUGHNESS * step * rng.standard_normal((side + 1, side + 1))
    return _facets(np.stack([u, v, rough], -1), closed=False)


def _ball(count: int, rng: np.random.Generator) -> Integers:
    """Return a rough sphere of 4 rows^2 facets, but for openings at its poles."""
    rows = max(2, round(sqrt(count / 4)))
    latitude, longitude = np.linspace(0.1, np.pi - 0.1, rows + 1), np.arange(2 * rows) * np.pi / rows
    radius = _RADIUS / 2 * (1 + _ROUGHNESS * np.pi / rows * rng.standard_normal((rows + 1, 2 * rows)))
    around = radius * np.sin(latitude)[:, None]
    along = radius * np.cos(latitude)[:, None]
    return _facets(np.stack([around * np.cos(longitude), around * np.sin(longitude), along], -1), closed=True)


def _sheets(count: int, rng: np.random.Generator) -> tuple[Integers, Integers]:
    return _sheet(count, rng), _sheet(count, rng)


def _balls(count: int, rng: np.random.Generator) -> tuple[Integers, Integers]:
    return _ball(count, rng), _ball(count, rng) + np.array([int(0.6 * _RADIUS), 0, 0])


SURFACES = (
    Surfaces("sheets", "two rough sheets that touch everywhere", _sheets),
    Surfaces("spheres", "two rough spheres that meet along a circle", _balls),
)
