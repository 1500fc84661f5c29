"""What scripts for the mesh engine are made of: small scenes, their limits, and disturbed runs.

Scenes are drawn so that boxes of groups and of triangles lie apart, meet and overlap, one LSB more or less.
"""

from collections.abc import Callable, Iterator

import numpy as np
import numpy.typing as npt

from triaxis.golden.pairs import coordinate_range
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.mesh_engine import Mode, Move
from triaxis.verif.mesh.scripts import EnginePlay, Script, Traffic, Triangles

_STREAM = 3
# Distance of groups from the origin, and of vertices from their group's middle.
_SPREADS = ((0, 2), (3, 1), (5, 2), (12, 3), (40, 4), (100, 10), (100, 27), (0, 100))


_Rng = np.random.Generator


def cloud(rng: _Rng, count: int, spread: int, size: int, configuration: MeshConfiguration) -> Triangles:
    """Return triangles (N, 3, 3) in groups: middles within ``spread``, vertices within ``size`` of them."""
    groups = -(-count // configuration.group)
    middles = rng.integers(-spread, spread + 1, (groups, 3)).repeat(configuration.group, 0)[:count]
    return _clipped(middles[:, None] + rng.integers(-size, size + 1, (count, 3, 3)), configuration)


def corners(rng: _Rng, count: int, configuration: MeshConfiguration) -> Triangles:
    """Return triangles (N, 3, 3) with coordinates at the ends and in the middle of the range."""
    low, high = coordinate_range(configuration.width)
    return rng.choice(np.array([low, low + 1, -1, 0, 1, high - 1, high]), (count, 3, 3))


def _clipped(triangles: Triangles, configuration: MeshConfiguration) -> Triangles:
    return triangles.clip(*coordinate_range(configuration.width)).astype(np.int64)


def _sizes(configuration: MeshConfiguration) -> npt.NDArray[np.int64]:
    group, depth = configuration.group, configuration.depth
    return np.unique([1, 2, group - 1, group, group + 1, depth // 2 + 1, depth - 1, depth]).clip(1)


def _margin(rng: _Rng, configuration: MeshConfiguration) -> int:
    largest = configuration.max_margin
    choices = (
        0,
        1,
        min(2, largest),
        int(rng.integers(0, min(largest, 12) + 1)),
        int(rng.integers(0, largest + 1)),
    )
    return min(int(rng.choice(choices)), largest)


def _move(rng: _Rng, a: Triangles, configuration: MeshConfiguration) -> Move:
    """Return a translation that keeps A in range, most of the time a small one."""
    if not len(a) or rng.integers(0, 3) == 0:
        return (0, 0, 0)
    low, high = coordinate_range(configuration.width)
    most = 4 if rng.integers(0, 2) else 2 * high
    room = np.stack([np.maximum(low - a.min((0, 1)), -most), np.minimum(high - a.max((0, 1)), most)], 1)
    x, y, z = (int(rng.integers(first, last + 1)) for first, last in room)
    return x, y, z


def _traffic(rng: _Rng) -> Traffic:
    return Traffic(
        int(rng.integers(1, 1 << 20)),
        int(rng.choice([0, 0, 64, 200])),
        int(rng.choice([0, 0, 0, 60, 150])),
        bool(rng.integers(0, 2)),
    )


def _pair(rng: _Rng, configuration: MeshConfiguration) -> tuple[Triangles, Triangles]:
    """Return a mesh A and a mesh B of one kind, whose sizes are limits half of the time."""
    sizes = _sizes(configuration)
    counts = [
        int(rng.choice(sizes)) if rng.integers(0, 2) else int(rng.integers(1, configuration.depth + 1))
        for _ in "AB"
    ]
    kind = int(rng.integers(0, len(_SPREADS) + 1))
    if kind == len(_SPREADS):
        return corners(rng, counts[0], configuration), corners(rng, counts[1], configuration)
    spread, size = _SPREADS[kind]
    a, b = (cloud(rng, count, spread, size, configuration) for count in counts)
    return a, b


def _run(script: Script, rng: _Rng, a: Triangles, mode: int, traffic: Traffic, abort_at: int = -1) -> None:
    configuration = script.configuration
    script.run(
        _move(rng, a, configuration), _margin(rng, configuration), mode, traffic, abort_at,
        int(rng.integers(1, 4)),
    )  # fmt: skip


def _scenes(rng: _Rng, script: Script, scenes: int) -> None:
    """Scenes in all modes, all streams flowing, the next word offered early now and then."""
    for _ in range(scenes):
        a, b = _pair(rng, script.configuration)
        script.load(0, a, traffic=Traffic(early=bool(rng.integers(0, 2)))).load(1, b, traffic=_early(rng))
        for mode in (Mode.ALL, Mode.COUNT, Mode.FIRST):
            _run(script, rng, a, mode, _early(rng))


def _early(rng: _Rng) -> Traffic:
    return Traffic(int(rng.integers(1, 100)), early=bool(rng.integers(0, 2)))


def _stalled(rng: _Rng, script: Script, scenes: int) -> None:
    """Scenes whose near pairs and summaries are taken late."""
    for _ in range(scenes):
        a, b = _pair(rng, script.configuration)
        script.load(0, a, traffic=_traffic(rng)).load(1, b, traffic=_traffic(rng))
        for mode in (Mode.ALL, Mode.ALL, Mode.FIRST, Mode.COUNT):
            _run(script, rng, a, mode, _traffic(rng))


def _crowded(rng: _Rng, script: Script, scenes: int) -> None:
    """Scenes in which nearly all is near, or nothing but the boxes, so that all queues fill."""
    depth = script.configuration.depth
    for number in range(scenes):
        a, b = (cloud(rng, depth, 0, 2 + 30 * (number % 2), script.configuration) for _ in "AB")
        script.load(0, a).load(1, b)
        for mode in (Mode.ALL, Mode.FIRST, Mode.COUNT):
            script.run(margin=0, mode=mode, traffic=Traffic(int(rng.integers(1, 99)), 100 * (number % 3), 80))


def _aborted(rng: _Rng, script: Script, scenes: int) -> None:
    """Runs that are aborted in every stage, each followed by a whole one that must know nothing of it."""
    for _ in range(scenes):
        a, b = _pair(rng, script.configuration)
        script.load(0, a).load(1, b)
        for _ in range(6):
            abort_at = int(rng.integers(0, int(rng.choice([6, 20, 60, 200]))))
            _run(script, rng, a, int(rng.integers(0, 3)), _traffic(rng), abort_at)
            _run(script, rng, a, Mode.ALL, _early(rng))


def _aborted_early(rng: _Rng, script: Script, scenes: int) -> None:
    """The same run aborted in every clock in turn: with every stage at its fullest, and at its emptiest."""
    for number in range(scenes):
        a, b = _half_near(rng, script.configuration, number)
        script.load(0, a).load(1, b)
        hold = 120 * (number % 2)
        for abort_at in range(48 + hold // 4):
            script.run(mode=Mode.ALL, traffic=Traffic(2, hold=hold), abort_at=abort_at)
        script.run()


def _cut(rng: _Rng, script: Script, scenes: int) -> None:
    """Loads and runs that a reset ends, each followed at once by a small scene, or by another one."""
    for number in range(scenes):
        a, b = _half_near(rng, script.configuration, number)
        script.load(0, a).load(1, b)
        cut = int(rng.integers(0, int(rng.choice([12, 40, 80, 200]))))
        traffic = Traffic(
            int(rng.integers(1, 99)), int(rng.choice([0, 0, 200])), int(rng.choice([0, 300])), cut=cut
        )
        _run(script, rng, a, Mode.ALL, traffic)
        script.load(0, a[:1], clear=False).load(1, b[:1], clear=False)
        script.run().run()
        _scenes(rng, script, number % 2)
        script.load(number % 2, a[: int(rng.integers(1, len(a)))], clear=False).reset().run()


def _half_near(rng: _Rng, configuration: MeshConfiguration, number: int) -> tuple[Triangles, Triangles]:
    """Return full meshes: all near; a part of triangles far; a part of groups far; few near, then all."""
    depth, group = configuration.depth, configuration.group
    a, b = (cloud(rng, depth, 0, 2, configuration) for _ in "AB")
    kind = number % 4
    if kind == 1:
        a[int(rng.integers(1, depth)) :: 2] += 60
        b[1::2] -= 60
    if kind == 2:
        b[group * int(rng.integers(1, depth // group)) :] += 60
    if kind == 3:
        few = min(depth - group, group * int(rng.integers(3, 6)))
        b[:few][rng.integers(0, 5, few) > 0] += 60
    return a, b


def _uneven(rng: _Rng, script: Script, scenes: int) -> None:
    """Near pairs that wait while much can be skipped, for each length of the wait."""
    for number in range(scenes):
        a, b = _half_near(rng, script.configuration, number)
        script.load(0, a).load(1, b)
        for _ in range(3):
            script.run(traffic=Traffic(int(rng.integers(1, 99)), hold=int(rng.choice([30, 70, 150, 400]))))


def _limits(rng: _Rng, script: Script, scenes: int) -> None:
    """Empty and overfull meshes, meshes that grow, bad modes."""
    configuration = script.configuration
    depth = configuration.depth
    for _ in range(max(scenes // 4, 1)):
        a, b = cloud(rng, depth + 2, 3, 3, configuration), cloud(rng, depth + 2, 3, 3, configuration)
        script.run()
        script.load(0, a[:1]).run(mode=Mode.COUNT).load(1, b[:1]).run().load(0, a[:0]).run((255, -256, 255))
        script.load(0, a[:depth]).load(0, a[depth:], clear=False).run().run(mode=3)
        script.load(0, a[:2]).run().load(1, b).run(mode=Mode.COUNT).load(1, b[:depth]).run()
        script.load(0, a[:3]).load(0, a[3:5], clear=False, traffic=Traffic(early=True)).run()
        script.load(1, b[:0]).run((127, 0, 0)).load(1, b[:2]).run(mode=3).run(mode=Mode.FIRST)
        script.load(1, b[2:3], clear=False).run().reset().run().load(0, a[:5]).reset().run()
        for size in _sizes(configuration):
            script.load(0, a[:size]).load(1, b[: max(depth - size, 1)]).run(
                margin=min(1, configuration.max_margin)
            )
        # Every count of triangles, one after the other.
        script.load(0, a[:0]).load(1, b[:1])
        for number in range(depth):
            script.load(0, a[number : number + 1], clear=False, traffic=Traffic(early=True)).run()


def _overflows(rng: _Rng, script: Script, scenes: int) -> None:
    """Translations to the ends of the range and one LSB beyond, each way, of one triangle or of many."""
    configuration = script.configuration
    low, high = coordinate_range(configuration.width)
    for number in range(max(scenes // 2, 2)):
        count = 1 if number % 2 else int(rng.integers(1, configuration.depth + 1))
        a = cloud(rng, count, 60 * (number % 3), 20, configuration)
        script.load(0, a).load(1, cloud(rng, configuration.group, 60, 60, configuration))
        for axis in range(3):
            for end in (low - int(a[:, :, axis].min()), high - int(a[:, :, axis].max())):
                for beyond in (0, -1 if end < 0 else 1):
                    move = [0, 0, 0]
                    move[axis] = end + beyond
                    script.run((move[0], move[1], move[2]), _margin(rng, configuration))
        script.run((-256, 0, 0)).run((0, 255, 0)).run((0, 0, -256), configuration.max_margin)


def _steps(rng: _Rng, script: Script, scenes: int) -> None:
    """Two triangles, and two groups, whose boxes are apart on one axis by the margin, or one LSB more."""
    configuration = script.configuration
    for _ in range(scenes):
        for axis in range(3):
            for side in (-1, 1):
                margin = _margin(rng, configuration)
                count = int(rng.choice([1, configuration.group, 2 * configuration.group]))
                a = cloud(rng, count, 0, 3, configuration)
                b = cloud(rng, count, 0, 3, configuration)
                a, b = a.clip(-3, 3), b.clip(-3, 3)
                script.load(0, a).load(1, b)
                touching = (
                    (a[:, :, axis].max() - b[:, :, axis].min())
                    if side < 0
                    else (a[:, :, axis].min() - b[:, :, axis].max())
                )
                for beyond in (0, 1):
                    move = [0, 0, 0]
                    move[axis] = int(-touching + side * (margin + beyond))
                    if abs(move[axis]) < 120:
                        script.run((move[0], move[1], move[2]), margin)


# By the test that sends such scenes and the family.
_FAMILIES: dict[tuple[str, str], tuple[Callable[[_Rng, Script, int], None], int]] = {
    ("MeshRandomTest", "scenes"): (_scenes, 12),
    ("MeshLimitsTest", "limits"): (_limits, 2),
    ("MeshGapsTest", "boxes apart by a step"): (_steps, 4),
    ("MeshLimitsTest", "translations"): (_overflows, 4),
    ("MeshAbortTest", "aborted runs"): (_aborted, 8),
    ("MeshStallsTest", "stalled streams"): (_stalled, 10),
    ("MeshResetsTest", "resets"): (_cut, 24),
    ("MeshAbortTest", "aborts in every clock"): (_aborted_early, 4),
    ("MeshStallsTest", "full queues"): (_crowded, 4),
    ("MeshStallsTest", "skipping while pairs wait"): (_uneven, 12),
}


def engine_directed(configuration: MeshConfiguration, seed: int) -> list[EnginePlay]:
    """Return the short scripts, the quickest to find mutants first."""
    return list(_plays(configuration, seed, 1))


def _extremes(rng: _Rng, script: Script, scenes: int) -> None:
    """Full meshes of which all pairs of groups are skipped, all pairs by their boxes, or all pairs are near.

    Coordinates at random all over the range, which reach every bit of the memories.
    """
    configuration = script.configuration
    depth, (low, high) = configuration.depth, coordinate_range(configuration.width)
    near = np.zeros((depth, 3, 3), np.int64)
    # A's triangles and B's in turns along one axis.
    a, b = near.copy(), near.copy()
    a[:, :, 0] = 2 * np.arange(depth)[:, None] - depth
    b[:, :, 0] = a[:, :, 0] + 1
    inner = np.lexsort(
        (
            np.arange(depth) // (depth // configuration.group),
            np.arange(depth) % (depth // configuration.group),
        )
    )
    for _ in range(scenes):
        script.load(0, near).load(1, near).run(mode=Mode.ALL).run((1, 0, 0))
        script.load(0, a[inner]).load(1, b[inner]).run(mode=Mode.COUNT)
        for _ in range(4):
            # Triangles, points, whose boxes are as random as they are, and triangles in one plane.
            a, b = rng.integers(low, high + 1, (2, depth, 3, 3))
            script.load(0, a).load(1, b).run()
            script.load(0, a[:, :1].repeat(3, 1)).load(1, b[:, :1].repeat(3, 1)).run()
            script.load(0, a // 8 * (1, 1, 0)).load(1, b // 8 * (1, 1, 0)).run()


def engine_extremes(configuration: MeshConfiguration, seed: int) -> list[EnginePlay]:
    """Return scripts that take counters and memories to their ends."""
    script = Script(configuration)
    _extremes(np.random.default_rng((seed, _STREAM + 1)), script, 2)
    return [script.play("MeshLimitsTest", "extremes")]


def engine_volume(configuration: MeshConfiguration, seed: int) -> list[EnginePlay]:
    """Return the long scripts, for what survives the short ones."""
    return list(_plays(configuration, seed + 1, 6))


def _plays(configuration: MeshConfiguration, seed: int, times: int) -> Iterator[EnginePlay]:
    for (test, family), (make, scenes) in _FAMILIES.items():
        script = Script(configuration)
        make(np.random.default_rng((seed, _STREAM)), script, times * scenes)
        yield script.play(test, family)
