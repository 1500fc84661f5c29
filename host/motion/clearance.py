"""Bounds of the clearance at places along a path, from margins at which the engine says clear and near.

The margin is bisected at each place, from the bounds that its predecessor leaves: moving the tool by n
steps changes the distance by at most n.
"""

from dataclasses import dataclass
from fractions import Fraction
from itertools import accumulate

import numpy as np
import numpy.typing as npt

from triaxis.golden.exact import Rational
from triaxis.host.engines import Progress, SceneEngine, Translation, unwatched
from triaxis.host.motion.moves import Program
from triaxis.host.motion.path_check import Effort
from triaxis.host.motion.path_scene import PathScene, nearest
from triaxis.host.quantise import vector

# The bounds are left this far apart: in steps of the grid, and as a part of the clearance.
_STEPS, _PART = 4, 32


@dataclass(frozen=True)
class Clearance:
    """Bounds in millimetres of the clearance at one place.

    ``along``: millimetres from the beginning of the path, of the moves that are asked for. The clearance is
    more than ``proven``, where that is not 0, and not more than ``seen``.
    """

    move: int
    line: int
    along: float
    position: tuple[float, float, float]
    proven: float
    seen: float


def lengths(program: Program) -> npt.NDArray[np.float64]:
    """Return the Euclidean length of each move in millimetres, a rapid taken for straight."""
    return np.array([move.length for move in program.moves])


def clearances(
    scene: PathScene, engine: SceneEngine, count: int, effort: Effort, progress: Progress = unwatched
) -> list[Clearance]:
    """Return bounds at ``count`` places spread evenly along the path, and at the ends of moves if those are
    fewer.

    ``effort`` counts the runs; ``progress`` is told of places done.
    """
    found: list[Clearance] = []
    before: tuple[Translation, int, int] | None = None
    moves = scene.program.moves
    starts = [0.0, *accumulate(lengths(scene.program))]
    for index, part in places(scene, count):
        move = moves[index]
        position = move.at(part)
        place = scene.path.place(scene.in_files(position))
        sample = nearest(place)
        clear, near = _bisect(scene, engine, sample, before, effort)
        before = (sample, clear, near)
        away = max(abs(c - s) for c, s in zip(place, sample, strict=True))
        away += Rational(move.slack / scene.wanted.resolution)
        scale = scene.wanted.scale
        along = starts[index] + float(part) * (starts[index + 1] - starts[index])
        found.append(
            Clearance(
                index,
                move.line,
                along,
                vector(map(float, position)),
                max(0.0, float(scene.path.proven(clear, away) * scale)),
                float(scene.path.seen(near, away) * scale),
            )
        )
        progress(1)
    return found


def places(scene: PathScene, count: int) -> list[tuple[int, Fraction]]:
    """Return where to look: (move, part of it 0..1), in the order of the path."""
    length = lengths(scene.program)
    ends = np.concatenate([[0.0], np.cumsum(length)])
    chosen: set[tuple[int, Fraction]] = set()
    for along in np.linspace(0, ends[-1], count):
        index = min(int(np.searchsorted(ends, along, "right")) - 1, len(length) - 1)
        part = (along - ends[index]) / length[index] if length[index] else 0.0
        chosen.add((index, Fraction(float(np.clip(part, 0, 1))).limit_denominator(1 << 20)))
    if len(length) <= count:
        chosen |= {(index, Fraction(1)) for index in range(len(length))}
        chosen.add((0, Fraction(0)))
    return sorted(chosen)


def _bisect(
    scene: PathScene,
    engine: SceneEngine,
    sample: Translation,
    before: tuple[Translation, int, int] | None,
    effort: Effort,
) -> tuple[int, int]:
    """Return margins with which a pose is clear and near, close together; -1 is clear of anything.

    The largest margin reaches across the whole grid, so that everything is near at it.
    """
    clear, near = -1, scene.largest_margin
    if before is not None:
        moved = max(abs(a - b) for a, b in zip(sample, before[0], strict=True))
        clear, near = max(clear, before[1] - moved), min(near, before[2] + moved)
    while near - clear > max(_STEPS, near // _PART):
        margin = (clear + near) // 2
        run = engine.run(sample, margin, stop_at_first=True)
        effort.add(run)
        if run.near_count:
            near = margin
        else:
            clear = margin
    return clear, near
