"""Bounds of the clearance at places along a path, from margins at which the engine says clear and near.

At each place all objects that must stay clear of each other there count: the clearance is the least of
theirs. The margin is bisected for each two of them, from the bounds that the place before leaves: moving by
n steps changes the distance by at most n. Two that are further apart than others were seen to be take one
question. Where axes turn, meshes are turned to where they stand at the place.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import accumulate

import numpy as np
import numpy.typing as npt

from triaxis.golden.exact import Rational
from triaxis.host.engines import Progress, SceneEngine, Translation, unwatched
from triaxis.host.least import least_distance
from triaxis.host.motion.contact import Rule
from triaxis.host.motion.moves import Move, Program
from triaxis.host.motion.path_check import Effort
from triaxis.host.motion.path_scene import PathScene, Wanted, nearest
from triaxis.host.quantise import Vector
from triaxis.host.scene import Pose, prepare

# The bounds are left this far apart: in steps of the grid, and as a part of the clearance.
_STEPS, _PART = 4, 32


@dataclass(frozen=True)
class Place:
    """A part, 0..1, of a move of the program; ``along``: millimetres from the beginning of the path."""

    move: int
    part: Fraction
    along: float


@dataclass(frozen=True)
class Clearance:
    """Bounds in millimetres of the clearance at one place, and the two objects that it was seen between.

    The clearance is more than ``proven``, where that is not 0, and not more than ``seen``. A, B and C are at
    ``angles`` in degrees.
    """

    move: int
    line: int
    along: float
    position: Vector
    angles: Vector
    what: str
    of: str
    proven: float
    seen: float


@dataclass(frozen=True)
class _Bounds:
    """What two objects showed, in millimetres."""

    proven: Fraction
    seen: Fraction
    names: tuple[str, str]

    def or_less(self, other: "_Bounds") -> "_Bounds":
        nearer = other if other.seen < self.seen else self
        return replace(nearer, proven=min(self.proven, other.proven))


def lengths(program: Program) -> npt.NDArray[np.float64]:
    """Return the Euclidean length of each move in millimetres, a rapid taken for straight."""
    return np.array([move.length for move in program.moves])


def clearances(
    program: Program, rules: Sequence[Rule], wanted: Wanted, engine_of: Callable[[PathScene], SceneEngine],
    chosen: Sequence[Place], effort: Effort, least_alone: bool = False, progress: Progress = unwatched,
) -> list[Clearance]:  # fmt: skip
    """Return bounds at places of the program, but for those where no rule holds.

    ``effort`` counts the runs; ``least_alone``: places at which others are nearer need no bounds, and have
    none; ``progress`` is told of places done, those of each rule.
    """
    # Not those of a board: the largest margin is to reach across the grid.
    wanted = replace(wanted, margin_bits=None)
    least, nearest_yet = dict[Place, _Bounds](), None
    for rule in rules:
        moves = dict(zip(rule.numbers, rule.program.moves, strict=True))
        here = [place for place in chosen if place.move in moves]
        standing = tuple(_at(moves[place.move], place.part) for place in here)
        for piece in rule.standing(standing) if standing else ():
            scene = rule.scene(piece, wanted)
            looking = _Looking(scene, engine_of(scene), rule.names, effort)
            for place, move in zip(here[piece.first :], piece.moves, strict=False):
                before = least.get(place)
                found = looking.bounds(move, nearest_yet if least_alone else before)
                if found is not None:
                    least[place] = found if before is None else before.or_less(found)
                    nearest_yet = found if nearest_yet is None else nearest_yet.or_less(found)
                elif least_alone and before is not None and nearest_yet is not None:
                    # It is beyond the nearest yet, and not shown to be beyond what was seen here.
                    least[place] = replace(before, proven=min(before.proven, nearest_yet.seen))
                progress(1)
    found = list[Clearance]()
    for place, bounds in least.items():
        move = _at(program.moves[place.move], place.part)
        found.append(
            Clearance(
                place.move,
                move.line,
                place.along,
                move.start,
                move.turns[0],
                *bounds.names,
                max(0.0, float(bounds.proven)),
                float(bounds.seen),
            )
        )
    return sorted(found, key=lambda one: (one.move, one.along))


def euclidean_at(least: Clearance, program: Program, rules: Sequence[Rule], wanted: Wanted) -> Fraction:
    """Return the Euclidean distance, in millimetres, of the two that a clearance was seen between, there.

    It is exact, of turned meshes of what turning makes of them.
    """
    names = least.what, least.of
    rule = next(rule for rule in rules if rule.names == names and least.move in rule.numbers)
    move = _standing(program.moves[least.move], least.position, least.angles)
    piece = next(rule.standing((move,)))
    scene = rule.scene(piece, wanted)
    pose = Pose(move=scene.in_files(piece.moves[0].start))
    clearance = wanted.clearance / wanted.scale
    meshes = prepare(scene.tool, scene.work, rule.files, scene.grid.resolution, clearance, None, pose)
    return Fraction(least_distance(meshes, True).distance) * wanted.scale


def _at(move: Move, part: Fraction) -> Move:
    """Return a move that stays where another is after a part of it."""
    return _standing(move, move.at(part), move.angles(part))


def _standing(move: Move, place: Vector, angles: Vector) -> Move:
    return replace(move, start=place, end=place, curve=None, straight=True, turns=(angles, angles))


def places(program: Program, count: int) -> list[Place]:
    """Return where to look, in the order of the path: ``count`` places spread evenly along it, a degree of a
    turn as long as a millimetre, and the ends of moves if those are fewer.
    """
    ways = lengths(program)
    turns = [max(abs(b - a) for a, b in zip(*move.turns, strict=True)) for move in program.moves]
    length = ways + np.array(turns, np.float64)
    starts, gone = [0.0, *accumulate(length)], [0.0, *accumulate(ways)]
    parts: set[tuple[int, Fraction]] = set()
    for along in np.linspace(0, starts[-1], count):
        index = min(int(np.searchsorted(starts, along, "right")) - 1, len(length) - 1)
        part = (along - starts[index]) / length[index] if length[index] else 0.0
        parts.add((index, Fraction(float(np.clip(part, 0, 1))).limit_denominator(1 << 20)))
    if len(length) <= count:
        parts |= {(index, Fraction(1)) for index in range(len(length))}
        parts.add((0, Fraction(0)))
    return [Place(k, part, gone[k] + float(part) * float(ways[k])) for k, part in sorted(parts)]


@dataclass
class _Looking:
    """Two objects at places one after the other, between which nothing turns."""

    scene: PathScene
    engine: SceneEngine
    names: tuple[str, str]
    effort: Effort
    _before: tuple[Translation, int, int] | None = None

    def bounds(self, move: Move, least: _Bounds | None) -> _Bounds | None:
        """Return bounds at a standing move; None where it is shown that these are not below ``least``.

        The largest margin reaches across the whole grid, so that everything is near at it; -1 is clear of
        anything.
        """
        scene, path, scale = self.scene, self.scene.path, self.scene.wanted.scale
        place = scene.place(move.start)
        sample = nearest(place)
        away = max(abs(c - s) for c, s in zip(place, sample, strict=True))
        away += Rational(move.slack / scene.wanted.resolution)
        clear, near = -1, scene.largest_margin
        if self._before is not None:
            moved = max(abs(a - b) for a, b in zip(sample, self._before[0], strict=True))
            clear, near = max(clear, self._before[1] - moved), min(near, self._before[2] + moved)
        enough = near if least is None else path.showing(least.seen / scale, away)
        if clear < enough < near:
            clear, near = self._asked(sample, enough, clear, near)
        while clear < enough and near - clear > max(_STEPS, near // _PART):
            clear, near = self._asked(sample, (clear + near) // 2, clear, near)
        self._before = sample, clear, near
        if least is not None and clear >= enough:
            return None
        return _Bounds(path.proven(clear, away) * scale, path.seen(near, away) * scale, self.names)

    def _asked(self, sample: Translation, margin: int, clear: int, near: int) -> tuple[int, int]:
        run = self.engine.run(sample, margin, stop_at_first=True)
        self.effort.add(run)
        return (clear, margin) if run.near_count else (margin, near)
