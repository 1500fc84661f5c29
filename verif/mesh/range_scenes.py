"""Scenes in which A moved ends exactly at an end of the range, or a step beyond it, on each axis and side."""

from collections.abc import Iterator
from itertools import product

import numpy as np

from triaxis.golden.pairs import coordinate_range
from triaxis.sim.mesh_engine import Mode
from triaxis.verif.mesh.items import RunRequest, RunTraffic, Scene
from triaxis.verif.mesh.placing import as_move, random_margin
from triaxis.verif.mesh.shapes import Shapes


def range_scenes(shapes: Shapes) -> Iterator[Scene]:
    """Yield a scene for every axis and end, at the end and a step beyond it; and the ends of the port."""
    for axis, end, step in product(range(3), range(2), range(2)):
        yield _at_end(shapes, axis, end, step)
    for axis in range(3):
        yield _across(shapes, axis)
        yield _too_far(shapes, axis)
        yield _nothing_moved(shapes, axis)


def _at_end(shapes: Shapes, axis: int, end: int, step: int) -> Scene:
    rng, configuration = shapes.rng, shapes.configuration
    size = max(1, shapes.reach // 8)
    a = shapes.cloud(1 + int(rng.integers(2 * configuration.group)), shapes.somewhere(0.2), size, size)
    a = a[: configuration.depth]
    limit = coordinate_range(configuration.width)[end]
    move = rng.integers(-shapes.reach // 4, shapes.reach // 4 + 1, 3)
    extreme = a[..., axis].max() if end else a[..., axis].min()
    move[axis] = limit - extreme + (step if end else -step)
    b = shapes.clipped(a[: 1 + len(a) // 2] + move)
    return _scene(shapes, a, b, as_move(move))


def _across(shapes: Shapes, axis: int) -> Scene:
    """A flat mesh from one end of the range to the other: the largest translation that fits."""
    low, high = coordinate_range(shapes.configuration.width)
    a = shapes.cloud(1 + int(shapes.rng.integers(3)), shapes.somewhere(), 4, 4)[: shapes.configuration.depth]
    a[..., axis] = low
    move = np.zeros(3, np.int64)
    move[axis] = high - low
    b = a + move - np.eye(3, dtype=np.int64)[axis] * shapes.rng.integers(0, 3)
    return _scene(shapes, a, b, as_move(move))


def _too_far(shapes: Shapes, axis: int) -> Scene:
    """The lowest translation that the port takes: no mesh stays within the range."""
    move = np.zeros(3, np.int64)
    move[axis] = -2 * shapes.reach
    a = shapes.cloud(1, shapes.somewhere(), 4, 4)
    a[..., axis] = coordinate_range(shapes.configuration.width)[1]
    return _scene(shapes, a, a, as_move(move))


def _nothing_moved(shapes: Shapes, axis: int) -> Scene:
    """No triangle leaves the range where there is none."""
    move = np.zeros(3, np.int64)
    move[axis] = shapes.rng.choice([-2 * shapes.reach, 2 * shapes.reach - 1])
    b = shapes.cloud(1, shapes.somewhere(), 4, 4)
    return _scene(shapes, b[:0], b, as_move(move))


def _scene(shapes: Shapes, a: np.ndarray, b: np.ndarray, move: tuple[int, int, int]) -> Scene:
    margin, mode = random_margin(shapes.rng, shapes.configuration), int(shapes.rng.choice(list(Mode)))
    run = RunRequest(move, margin, mode)
    return Scene(a, b, ((run, RunTraffic()),), kind="range")
