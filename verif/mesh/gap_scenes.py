"""Scenes with a gap of exactly the margin, or the smallest step more, on one axis and side, at each level."""

from collections.abc import Iterator
from itertools import product

import numpy as np

from triaxis.verif.mesh.items import RunRequest, RunTraffic, Scene
from triaxis.verif.mesh.placing import placed
from triaxis.verif.mesh.shapes import Integers, Shapes

ROW, GROUP, PAIR = "row", "group", "pair"
LEVELS = (ROW, GROUP, PAIR)


def gap_scenes(shapes: Shapes) -> Iterator[Scene]:
    """Yield a scene for every level, axis, side and step, at a random margin."""
    levels = [level for level in LEVELS if _possible(level, shapes)]
    for level, axis, side, step in product(levels, range(3), (-1, 1), (0, 1)):
        yield gap_scene(shapes, level, axis, side, step)


def _possible(level: str, shapes: Shapes) -> bool:
    group, depth = shapes.configuration.group, shapes.configuration.depth
    return level == ROW or (level == GROUP and depth > group) or (level == PAIR and group > 1)


def gap_scene(shapes: Shapes, level: str, axis: int, side: int, step: int) -> Scene:
    """Return a scene in which B stands clear of A on one axis and side by the margin and a step."""
    rng, configuration = shapes.rng, shapes.configuration
    size = max(1, shapes.reach // 16)
    margin = int(rng.integers(0, min(configuration.max_margin, shapes.reach // 4) + 1))
    t = shapes.cloud(1, np.zeros(3, np.int64), size, size)[0]
    b = [_beside(rng, t, axis, side, margin + step, size)]
    a = [t]
    # The same on the other side of A: what holds both overlaps A.
    other = _beside(rng, t, axis, -side, margin + 1 + int(rng.integers(0, size)), size)
    if level == GROUP:
        b += [b[0]] * (configuration.group - 1) + [other]
    elif level == PAIR:
        b.append(other)
    there = shapes.clipped(np.stack(a))
    home, move = placed(rng, there, configuration)
    run = RunRequest(move, margin)
    return Scene(home, np.stack(b), ((run, RunTraffic()),), kind=f"gap {level}")


def _beside(rng: np.random.Generator, t: Integers, axis: int, side: int, gap: int, size: int) -> Integers:
    """Return a triangle (3, 3) whose box overlaps that of t but for one axis, where it is a gap away."""
    low, high = t.min(0), t.max(0)
    found = rng.integers(low, high + 1, (3, 3))
    places = rng.integers(0, size + 1, 3)
    places -= places.min()
    found[:, axis] = high[axis] + gap + places if side > 0 else low[axis] - gap - places
    return found
