"""The test of the mesh engine that sends real meshes, which the host software reads."""

from collections.abc import Iterator
from fractions import Fraction

import numpy as np

from triaxis.host.quantise import centred_grid, quantise
from triaxis.host.scenes import machine_scenes, mesh_data, scenes
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.mesh_engine import Mode, spatial_order
from triaxis.verif.mesh.base_test import MeshEngineTest
from triaxis.verif.mesh.items import RunRequest, RunTraffic, Scene
from triaxis.verif.mesh.scenes import random_margin
from triaxis.verif.mesh.shapes import Integers
from triaxis.verif.mesh.uvm_tests import BOARD
from triaxis.verif.testbench.table import Runs, listed

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


@listed("V3", Runs((BOARD,), 1, smoke=(BOARD,)), why_seeds="One: only a margin is random.")
class MeshRealTest(MeshEngineTest):
    """Parts of a real machine, and solids of our own where those are absent, at several translations."""

    async def stimulus(self) -> None:
        """Send each pair of meshes in spatial order, and once as it comes in its file."""
        group, depth = self.configuration.group, self.configuration.depth
        for a, b, margin in real_scenes(self.configuration):
            a, b = a[:depth], b[:depth]
            orders = [(spatial_order(a, group), spatial_order(b, group))]
            orders += [(np.arange(len(a)), np.arange(len(b)))] if len(a) * len(b) < 1 << 20 else []
            for order_a, order_b in orders:
                runs = (
                    RunRequest((0, 0, 0), margin, Mode.ALL),
                    RunRequest((0, 0, 0), 0, Mode.FIRST),
                    RunRequest((0, 0, 0), random_margin(self.rng, self.configuration) // 64, Mode.COUNT),
                )
                await self.send(Scene(a[order_a], b[order_b], tuple((run, RunTraffic()) for run in runs)))
