"""Real meshes for the engine, on its grid: solids of our own, and parts of a machine where they are there."""

from collections.abc import Iterator
from fractions import Fraction

import numpy as np

from triaxis.host.machine_scenes import machine_scenes
from triaxis.host.mesh_data import mesh_data
from triaxis.host.quantise import centred_grid, quantise
from triaxis.host.scenes import scenes
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.verif.mesh.shapes import Integers

# Margins are this part of the range.
_MARGIN_PART = 256


def real_scenes(configuration: MeshConfiguration) -> Iterator[tuple[Integers, Integers, int]]:
    """Yield meshes (N, 3, 3), (M, 3, 3) in LSB, and a margin. Each scene fills most of the range."""
    data = mesh_data()
    width = configuration.width
    for scene in scenes() + (machine_scenes(data) if data else []):
        points = np.concatenate([scene.a, scene.b]).reshape(-1, 3)
        extent = float(np.ptp(points.astype(np.float64), 0).max())
        grid = centred_grid([scene.a, scene.b], Fraction(extent * 1.1) / (1 << width), width)
        a, b = quantise(scene.a, grid, f"{scene.name}: A"), quantise(scene.b, grid, f"{scene.name}: B")
        yield a, b, min(configuration.max_margin, (1 << width) // _MARGIN_PART)
