"""The engine's stimulus is what it says: within the range, with the gaps and at the ends that it names."""

from collections import Counter
from itertools import product

import numpy as np
import pytest

from triaxis.golden.pairs import coordinate_range
from triaxis.golden.scene import boxes_of, boxes_of_groups, scene_answer
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.verif.mesh.expectation import moved, overflows
from triaxis.verif.mesh.items import pack_run, pack_triangle, unpack_pair, unpack_run, unpack_triangle
from triaxis.verif.mesh.scenes import (
    GROUP,
    LEVELS,
    PAIR,
    ROW,
    gap_scene,
    random_scene,
    range_scenes,
)
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


def meshes_of(scene):
    assert scene.a is not None and scene.b is not None
    return scene.a, scene.b


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


@pytest.mark.parametrize("level", LEVELS)
def test_gaps_decide_alone_at_their_level(shapes, level):
    group = shapes.configuration.group
    if (level == PAIR and group == 1) or (level == GROUP and shapes.configuration.depth == group):
        pytest.skip("there is no such level in this build")
    for axis, side, step in product(range(3), (-1, 1), (0, 1)):
        scene = gap_scene(shapes, level, axis, side, step)
        request, (home, there_b) = scene.runs[0][0], meshes_of(scene)
        there = moved(home, request.translation)
        answer = scene_answer(there, there_b, request.margin, group)
        at = {ROW: answer.rows_apart[0], GROUP: answer.groups_apart[0, 0], PAIR: answer.boxes_apart[0, 0]}
        assert at[level] == bool(step)
        if level != ROW:
            assert not answer.rows_apart[0]
        if level == PAIR:
            assert not answer.groups_apart[0, 0]
        a = boxes_of(there)[0]
        b = {
            ROW: boxes_of_groups(boxes_of(there_b), len(there_b)),
            GROUP: boxes_of_groups(boxes_of(there_b), group),
            PAIR: boxes_of(there_b),
        }[level][0]
        gap = b[0, axis] - a[1, axis] if side > 0 else a[0, axis] - b[1, axis]
        assert gap == request.margin + step


def test_ends_of_the_range_are_met_exactly(shapes):
    found = Counter()
    low, high = coordinate_range(shapes.configuration.width)
    for scene in range_scenes(shapes):
        request, (home, _) = scene.runs[0][0], meshes_of(scene)
        if not len(home):
            continue
        points = moved(home, request.translation).reshape(-1, 3)
        past = np.stack([low - points.min(0), points.max(0) - high])
        found[overflows(home, request.translation, shapes.configuration.width), int(past.max())] += 1
    assert found[True, 1] >= 6 and found[False, 0] >= 6
    assert {fits for fits, past in found if past <= 0} == {False}
