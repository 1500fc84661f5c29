"""Meshes of any number of facets, rough on the scale of their facets, and placed against each other."""

from collections.abc import Callable
from dataclasses import dataclass
from math import sqrt
from typing import Any

import numpy as np
import numpy.typing as npt

from triaxis.host.scene_engines import Integers

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
