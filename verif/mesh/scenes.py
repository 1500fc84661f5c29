"""Scenes: random ones of all kinds, exact gaps, the ends of the range and of the memories, and timed ones.

A scene's translation takes A back from where it is to come, as far as the range and the port allow.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from triaxis.golden.pairs import coordinate_range
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.mesh_engine import NO_ZONES, Mode, Move, spatial_order
from triaxis.verif.core.items import FULL_SPEED, Once, Pace, Steady
from triaxis.verif.mesh.items import RunRequest, RunTraffic, Scene
from triaxis.verif.mesh.shapes import KINDS, Integers, Shapes, in_one_place, slots


def as_move(values: Integers) -> Move:
    """Return a translation."""
    x, y, z = (int(value) for value in values)
    return x, y, z


def allowed_moves(there: Integers, configuration: MeshConfiguration) -> tuple[Integers, Integers]:
    """Return the least and the largest translation (3,) that A (N, 3, 3), now there, can have come by."""
    low, high = coordinate_range(configuration.width)
    reach = 1 << configuration.width
    if not len(there):
        return np.full(3, -reach), np.full(3, reach - 1)
    points = there.reshape(-1, 3)
    return points.max(0) - high, points.min(0) - low


def placed(
    rng: np.random.Generator, there: Integers, configuration: MeshConfiguration
) -> tuple[Integers, Move]:
    """Return A before it is moved, and its translation: none, an end of what can be, or any between."""
    low, high = allowed_moves(there, configuration)
    kind = rng.integers(0, 4, 3)
    # Between zero and the ends; zero is always allowed where A is within the range.
    between = rng.integers(low, high + 1)
    move = np.choose(kind, [0 * low, low, high, between])
    return there - move, as_move(move)


def random_margin(rng: np.random.Generator, configuration: MeshConfiguration) -> int:
    """Return a margin: 0, 1, the largest, or of any order of size."""
    largest = configuration.max_margin
    any_size = int(2 ** rng.uniform(0, configuration.margin_bits)) if largest else 0
    return min(largest, int(rng.choice([0, 1, largest, any_size, any_size, any_size // 8])))


def random_zones(rng: np.random.Generator, configuration: MeshConfiguration, margin: int) -> tuple[int, int]:
    """Return margins of the zones slow and warn: none, or one or both wider by little or by much."""
    if rng.integers(2):
        return NO_ZONES
    steps = (2 ** rng.uniform(0, configuration.margin_bits, 2)).astype(np.int64) >> rng.choice([0, 2, 40])
    slow, warn = (margin + np.cumsum(1 + steps)).tolist()
    kinds = ((slow, warn), (slow, warn), (slow, 0), (slow, slow), (0, warn), (warn, slow), (margin, slow))
    chosen = kinds[int(rng.integers(len(kinds)))]
    return min(chosen[0], configuration.max_margin), min(chosen[1], configuration.max_margin)


PACES = (FULL_SPEED, Pace(1, 1), Pace(1, 12), Pace(8, 3), Pace(3, 30))
_MODES = (*Mode, Mode.ALL, 3)
# Of so many scenes one is given more triangles than fit, one keeps a mesh of the scene before, and one has
# each run offered while the one before goes on.
_OVERFULL_ONE_IN, _KEEPS_ONE_IN, _CHAINED_ONE_IN = 25, 4, 4
# Scenes of more pairs are of kinds of which little is left to be tested, and in spatial order: a run in which
# nothing is skipped takes a clock for each pair.
_LARGE = 1 << 20
# Of the largest memories only one is filled.
_MOST_PAIRS = 1 << 24
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
    if count_a * count_b > _MOST_PAIRS:
        count_b = _MOST_PAIRS // count_a
        if rng.integers(2):
            count_a, count_b = count_b, count_a
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
        zones = NO_ZONES if large else random_zones(rng, configuration, margin)
        return Scene(a, b, ((RunRequest(move, margin, zones=zones), RunTraffic()),), kind=kind)
    others = 0 if large else int(rng.integers(0, 3))
    runs = tuple(_run(shapes, move, margin, n == 0, not large) for n in range(1 + others))
    scene = Scene(a, b, runs, _pace(rng), chained=rng.integers(_CHAINED_ONE_IN) == 0, kind=kind)
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


def _run(shapes: Shapes, move: Move, margin: int, first: bool, zoned: bool) -> tuple[RunRequest, RunTraffic]:
    """Return the run that the scene is made for, or one that differs in something; with zones or without."""
    rng, configuration = shapes.rng, shapes.configuration
    mode = int(rng.choice(_MODES))
    if not first:
        margin = random_margin(rng, configuration)
        step = rng.integers(-2, 3, 3) if rng.integers(2) else rng.integers(-1, 2, 3) * shapes.reach // 2
        reach = 1 << configuration.width
        move = as_move(np.clip(np.array(move) + step, -reach, reach - 1))
    aborts = (int(2 ** rng.uniform(0, 9)) - 1,) if rng.integers(6) == 0 else ()
    zones = random_zones(rng, configuration, margin) if zoned else NO_ZONES
    return RunRequest(move, margin, mode, zones=zones), RunTraffic(_pace(rng), _pace(rng), aborts)


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
    # Boxes are held against the widest zone.
    inner = np.sort(rng.integers(0, margin + 1, 2)).tolist()
    run = (
        RunRequest(move, inner[0], zones=(inner[1], margin)) if rng.integers(2) else RunRequest(move, margin)
    )
    return Scene(home, np.stack(b), ((run, RunTraffic()),), kind=f"gap {level}")


def _beside(rng: np.random.Generator, t: Integers, axis: int, side: int, gap: int, size: int) -> Integers:
    """Return a triangle (3, 3) whose box overlaps that of t but for one axis, where it is a gap away."""
    low, high = t.min(0), t.max(0)
    found = rng.integers(low, high + 1, (3, 3))
    places = rng.integers(0, size + 1, 3)
    places -= places.min()
    found[:, axis] = high[axis] + gap + places if side > 0 else low[axis] - gap - places
    return found


def zone_scenes(shapes: Shapes) -> Iterator[Scene]:
    """Yield scenes for each choice of zones that are wider than the one within them, and for each zone: all
    of B stands beside A at exactly its margin, or one step more.
    """
    for slow, warn, zone, step in product((False, True), (False, True), range(3), (0, 1)):
        if slow + warn <= shapes.configuration.max_margin:
            yield zone_scene(shapes, slow, warn, zone, step)


def zone_scene(shapes: Shapes, slow: bool, warn: bool, zone: int, step: int) -> Scene:
    """Return a scene in which slow, or warn, are wider zones, and B is a step beyond a zone."""
    rng, configuration = shapes.rng, shapes.configuration
    largest = min(configuration.max_margin, max(2, shapes.reach // 4))
    widths = sorted(rng.choice(min(largest + 1, 1 << 20), 1 + slow + warn, replace=False).tolist())
    margins = [widths[0], widths[int(slow)], widths[-1]]
    zones = [
        margin if wider else int(rng.choice([margin, rng.integers(0, margin + 1)]))
        for wider, margin in zip((slow, warn), margins[1:], strict=True)
    ]
    axis, side = int(rng.integers(3)), int(rng.choice([-1, 1]))
    size = max(1, shapes.reach // 16)
    flat = shapes.cloud(1, np.zeros(3, np.int64), size, size)
    flat[..., axis] = 0
    counts = rng.integers(1, min(configuration.depth, 2 * configuration.group) + 1, 2).tolist()
    a, b = (flat.repeat(count, 0) for count in counts)
    b[..., axis] = side * (margins[zone] + step)
    run = RunRequest(
        margin=margins[0], mode=int(rng.choice([Mode.ALL, Mode.COUNT])), zones=(zones[0], zones[1])
    )
    return Scene(a, b, ((run, RunTraffic()),), kind="zone")


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


# Meshes of large memories are filled up to here only, or it would be runs of minutes.
MOST_FULL = 128


def extreme_scenes(shapes: Shapes) -> Iterator[Scene]:
    """Yield full meshes that take counters and memories to their ends.

    All pairs near; all pairs of groups skipped; all groups overlapping and all pairs skipped by their boxes;
    coordinates at random all over the range, which reach every bit: of triangles, of points, of flat ones.
    """
    rng, configuration = shapes.rng, shapes.configuration
    depth, group = min(configuration.depth, MOST_FULL), configuration.group
    low, high = coordinate_range(configuration.width)
    points = np.zeros((depth, 3, 3), np.int64)
    yield _plain(points, points, (0, 0, 0), (1, 0, 0))
    # A's triangles and B's in turns along one axis, those of a group all over it.
    a = points.copy()
    a[..., 0] = (2 * np.arange(depth) % (2 * shapes.reach) - min(depth, shapes.reach))[:, None]
    spread = np.arange(depth).reshape(group, -1).T.ravel()
    yield _plain(a[spread], a[spread] + np.array([1, 0, 0]), (0, 0, 0))
    flat = np.array([1, 1, 0])
    for _ in range(2):
        a, b = rng.integers(low, high + 1, (2, depth, 3, 3))
        yield _plain(a, b, (0, 0, 0))
        yield _plain(a[:, :1].repeat(3, 1), b[:, :1].repeat(3, 1), (0, 0, 0))
        yield _plain(a // 8 * flat, b // 8 * flat, (0, 0, 0))


def growing_scenes(shapes: Shapes) -> Iterator[Scene]:
    """Yield scenes that add one triangle each to A, and then to B, up to a full mesh against one triangle."""
    depth = min(shapes.configuration.depth, MOST_FULL // 2)
    size = max(1, shapes.reach // 16)
    for mesh in range(2):
        triangles = shapes.cloud(depth, shapes.somewhere(), size, size)
        ends = [triangles[:0], triangles[:1]]
        yield Scene(ends[mesh], ends[1 - mesh], ())
        run = (RunRequest((0, 0, 0), random_margin(shapes.rng, shapes.configuration)), RunTraffic())
        for number in range(depth):
            one = triangles[number : number + 1]
            a, b = (one, None) if mesh == 0 else (None, one)
            yield Scene(a, b, (run,), early=bool(number % 2), append=True)


def _plain(a: Integers, b: Integers, *moves: Move) -> Scene:
    return Scene(a, b, tuple((RunRequest(move), RunTraffic()) for move in moves), kind="extreme")


# Triangles of the meshes of `clock_scenes` at most, and their runs: the first right after the loading.
_MOST_TIMED = 64
_TIMED = (Mode.ALL, Mode.ALL, Mode.FIRST)
# Aborts at every clock until the first verdict, and later.
_TIMED_ABORTS = (*range(48), 55, 89, 144, 233)
# The beginning of the names of scenes with stalls.
STALLED = "stalled"
_TIMED_STALLS = (1, 3, 12, 40)
# By then near pairs wait, and all queues are full.
_STALLED_ABORT = 150
# A pause in which all queues fill, early or late, in a scan with gaps between pairs before and after it.
_LONG_PAUSE, _LATEST_PAUSE, _TIMED_SLOTS = 400, 100, 24


def clock_scenes(configuration: MeshConfiguration) -> Iterator[tuple[str, Scene]]:
    """Yield the scenes whose clocks are kept, by name: the same ones always; stalls last."""
    shapes = Shapes(np.random.default_rng(1), configuration)
    depth, group = min(configuration.depth, _MOST_TIMED), configuration.group
    margin = min(configuration.max_margin, shapes.reach // 16)
    few, some = min(group + 1, depth), min(2 * group, depth)
    for counts in dict.fromkeys(((depth, depth), (few, some), (some, few))):
        for kind, make in KINDS.items():
            a, b = make(shapes, *counts, margin)
            runs = [(RunRequest(margin=margin, mode=int(mode)), RunTraffic()) for mode in _TIMED]
            yield f"{kind} {counts[0]} x {counts[1]}", Scene(a, b, tuple(runs), kind=kind)
    zoned = Shapes(np.random.default_rng(2), configuration)
    for kind, make in KINDS.items():
        a, b = make(zoned, depth, depth, margin // 4)
        zones = margin // 2, margin
        runs = [
            (RunRequest(margin=margin // 4, mode=int(mode), zones=zones), RunTraffic()) for mode in _TIMED
        ]
        yield f"zones, {kind}", Scene(a, b, tuple(runs), kind=kind)
    # A pair of groups has nothing behind it that takes longer to end than the pairs in it.
    for count in (group, depth):
        a, b = in_one_place(shapes, count, count, margin)
        aborts = tuple((RunRequest(), RunTraffic(aborts=(at,))) for at in _TIMED_ABORTS)
        yield f"aborted, {count} x {count}", Scene(a, b, aborts, kind="aborted")
    far = (2 * shapes.reach - 1, 0, 0)
    refused = (RunRequest(mode=3), RunRequest(far), RunRequest())
    yield "refused", Scene(a, too_many(shapes), tuple((run, RunTraffic()) for run in refused), kind="refused")
    empty = tuple((run, RunTraffic()) for run in (RunRequest(far), RunRequest()))
    yield "empty", Scene(a, b[:0], empty, early=True, chained=True, kind="empty")
    # Near pairs that wait while others are looked for, or while all others are dropped.
    for off in _TIMED_STALLS:
        for kind, make in KINDS.items():
            a, b = make(shapes, depth, depth, margin)
            pace = Steady(1, off)
            runs = tuple(
                (RunRequest(margin=margin, mode=int(mode)), RunTraffic(pace, pace, aborts))
                for mode, aborts in ((Mode.ALL, ()), (Mode.FIRST, ()), (Mode.ALL, (_STALLED_ABORT,)))
            )
            yield f"{STALLED} 1 in {1 + off}, {kind}", Scene(a, b, runs, kind=kind)
    for number in range(_TIMED_SLOTS):
        a, b = slots(shapes, depth, depth - number % group, number % 2 == 0)
        pause = Once(int(shapes.rng.integers(1, _LATEST_PAUSE)), _LONG_PAUSE)
        run = (RunRequest(), RunTraffic(pause))
        yield f"{STALLED} once, slots {number}", Scene(a, b, (run,), kind="slots")
