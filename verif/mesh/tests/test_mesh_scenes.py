"""The engine's stimulus is what it says: within the range, and its beats come back."""

import numpy as np
import pytest

from triaxis.golden.pairs import coordinate_range
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.verif.mesh.items import pack_run, pack_triangle, unpack_pair, unpack_run, unpack_triangle
from triaxis.verif.mesh.scenes import random_scene
from triaxis.verif.mesh.shapes import Shapes

CONFIGURATIONS = (
    MeshConfiguration(16, 16, 64, 8, 8),
    MeshConfiguration(12, 0, 32, 4, 2, 8),
    MeshConfiguration(8, 8, 16, 4, 1),
    MeshConfiguration(10, 3, 8, 8, 1),
    MeshConfiguration(9, 9, 16, 1, 1),
)


@pytest.fixture(params=CONFIGURATIONS, ids=lambda c: c.name)
def shapes(request, seed):
    return Shapes(np.random.default_rng(seed), request.param)


def test_random_scenes_fit_the_ports_and_their_beats_come_back(shapes):
    configuration = shapes.configuration
    low, high = coordinate_range(configuration.width)
    reach = 1 << configuration.width
    for scene in (random_scene(shapes) for _ in range(200)):
        for mesh in (scene.a, scene.b):
            assert mesh is None or not len(mesh) or low <= mesh.min() <= mesh.max() <= high
        for request, _ in scene.runs:
            assert all(-reach <= part < reach for part in request.translation)
            assert 0 <= request.margin <= configuration.max_margin
            assert unpack_run(*pack_run(request, configuration), configuration) == request
        for triangle in () if scene.a is None else scene.a[:5]:
            data = pack_triangle(triangle.ravel().tolist(), configuration.width)
            assert data < 1 << 9 * configuration.width
            assert (unpack_triangle(data, configuration.width) == triangle).all()
    assert unpack_pair(3 << configuration.index_bits | 2, configuration) == (2, 3)
