"""Does a tool stay clear of a workpiece all along its path? Exactly, by proving whole segments clear.

The objects' boxes, swept along a segment, may prove it clear: along a face they do so where a margin,
which grows in all directions, cannot. Else the engine is asked about one pose at the middle of it, with a
margin that covers half of it (`path_scene`). Where that is near, both halves are looked at, down to the step.
Far from the workpiece one question serves for many moves.
"""

from bisect import bisect_left, bisect_right
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from fractions import Fraction

import numpy as np

from triaxis.golden.exact import Rational
from triaxis.host.enclosure import NOT_ASKED, Enclosure, State, enclosure
from triaxis.host.engines import (
    BULK,
    NO_PAIRS,
    Counts,
    Progress,
    SceneEngine,
    SceneRun,
    scene_engine,
    some_of,
    unwatched,
)
from triaxis.host.euclidean import euclidean_distance
from triaxis.host.motion.path_scene import PathScene, Segment, nearest
from triaxis.host.quantise import NOWHERE, Vector, vector
from triaxis.host.scene import FacetPairs, distance_of

# Near facet pairs whose exact distance is computed.
_JUDGED = 500
# Near facet pairs of a piece that its halves are asked about first.
_LIKELY = 16


@dataclass(frozen=True)
class NearFacets:
    """Facet numbers in the files, and the exact distance of the two, in millimetres."""

    tool_facet: int
    work_facet: int
    distance: Fraction


@dataclass(frozen=True)
class NearPose:
    """The first pose that could not be proven clear.

    ``facets``: the nearest of the ``facet_pairs`` within the margin, nearest first. Really within the
    clearance is one of them at the position, in millimetres, and at the angles of A, B and C, in degrees.
    """

    move: int
    line: int
    position: Vector
    part_of_move: Fraction
    margin: int
    facet_pairs: int
    facets: tuple[NearFacets, ...]
    within_clearance_for_certain: bool
    angles: Vector = NOWHERE


@dataclass
class Level:
    """What became of the segments of one level: moves are 0, their halves 1, and so on."""

    by_boxes: int = 0
    by_pose: int = 0
    halved: int = 0


@dataclass
class Effort(Counts):
    """Poses asked, and what the engine did in all of them: near pairs are those within the margins asked."""

    poses: int = 0
    most_cycles: int | None = None

    def add(self, run: Counts) -> None:
        """Count a pose."""
        super().add(run)
        self.poses += 1
        if run.cycles is not None:
            self.most_cycles = max(self.most_cycles or 0, run.cycles)

    def join(self, other: "Effort") -> None:
        """Count all poses of another."""
        self.add(other)
        self.poses += other.poses - 1
        if other.most_cycles is not None:
            self.most_cycles = max(self.most_cycles or 0, other.most_cycles)


@dataclass
class PathResult:
    """How far the path is clear, and how that was shown.

    ``near``: None where no facets are near on all of it. ``insides``: at the start of the move ``asked_at``,
    not asked where that is near.
    """

    near: NearPose | None = None
    levels: list[Level] = field(default_factory=list)
    effort: Effort = field(default_factory=Effort)
    insides: Enclosure = NOT_ASKED
    asked_at: int = 0

    @property
    def verdict(self) -> str:
        """Return clear, near or unknown."""
        return self.insides.verdict(self.near is not None)

    def join(self, other: "PathResult", first: int) -> None:
        """Go on with what was found of the moves from a number on."""
        self.effort.join(other.effort)
        self.levels += [Level() for _ in other.levels[len(self.levels) :]]
        for level, more in zip(self.levels, other.levels, strict=False):
            level.by_boxes += more.by_boxes
            level.by_pose += more.by_pose
            level.halved += more.halved
        if other.near is not None:
            self.near = replace(other.near, move=first + other.near.move)
        if other.insides != NOT_ASKED:
            self.insides, self.asked_at = other.insides, first + other.asked_at


def check_path(
    scene: PathScene,
    engine: SceneEngine,
    progress: Progress = unwatched,
    surfaces_only: bool = False,
    insides_first: bool = False,
) -> PathResult:
    """Prove the path clear, move by move, or find its first near pose; ``progress`` is told of moves done.

    ``insides_first``: where one is inside the other at the start, or may be, the engine is not asked at all.
    """
    moves, result, asked = scene.program.moves, PathResult(), 0
    starts = scene.program.starts
    for start in starts if insides_first and not surfaces_only else ():
        insides = insides_at(scene, start)
        if insides.state != State.OUTSIDE and _near_at(scene, start):
            # Unless the engine shows this start clear, there is nothing more to ask.
            break
        result.insides, result.asked_at, asked = insides, start, asked + 1
        if insides.state != State.OUTSIDE:
            return result
    found = _first_near_piece(scene, engine, result, progress)
    if found is not None:
        result.near = _near_pose(scene, *found)
    # What is before a near piece is clear: so is the start, but for the first piece.
    proven = found is None or found[0].first > 0 or found[0].segment.first > 0
    if surfaces_only or not proven:
        result.insides = NOT_ASKED
    else:
        last = len(moves) if result.near is None else max(1, result.near.move)
        for start in starts[asked : bisect_left(starts, last)]:
            result.insides, result.asked_at = insides_at(scene, start), start
            if result.insides.state != State.OUTSIDE:
                break
    return result


def bulk_engine(scene: PathScene) -> SceneEngine:
    """Return the quickest engine, for poses that decide nothing, or nothing that a board decides."""
    return scene_engine(BULK, scene.a, scene.b, scene.grid.width)


def _near_at(scene: PathScene, index: int) -> bool:
    """Return whether facets are near at the start of a move, as the bulk checker sees it."""
    start = scene.segment(scene.program.moves[index]).start
    segment = Segment(start, start, Rational(0), Rational(0))
    return (
        bulk_engine(scene).run(segment.sample, scene.path.margin(segment), stop_at_first=True).near_count > 0
    )


def insides_at(scene: PathScene, index: int = 0) -> Enclosure:
    """Return whether tool or workpiece is inside the other at the start of a move, where facets are clear.

    One pose is enough until the next of the program's `starts`. A part could only get in or out of a closed
    shell through its facets, and the path is continuous. The pose asked is the whole translation T nearest
    the start's place u. With S the sample that proved the start, no point of A moves by more than reach + 1/2
    from S to T (see `path_scene`), which is less than the distance at S; nor is the way from the real start
    to S longer than that. Where boxes proved it, they are more than 1 apart at u, so more than 1/2 at T.
    """
    start = np.array(nearest(scene.place(scene.program.moves[index].start)))
    starts = [*scene.program.starts, len(scene.program.moves)]
    end = starts[bisect_right(starts, index)]
    a, b = scene.solids
    return enclosure(a.moved(start), b, scene.extents[index:end] - start)


def shown_clear(scene: PathScene, engine: SceneEngine, segment: Segment, result: PathResult) -> bool:
    """Return whether a pose, or the objects' boxes, show that all of a segment is clear."""
    return _looked_at(scene, engine, _Piece(segment, 0, 1, NO_PAIRS), result) is None


@dataclass(frozen=True)
class _Piece:
    """A segment of a move, or of the box around several: from ``first`` to the one before ``last``.

    ``likely`` (K, 2): facet pairs that may well be near.
    """

    segment: Segment
    first: int
    last: int
    likely: FacetPairs

    @property
    def several(self) -> bool:
        """Return whether it is of several moves."""
        return self.last - self.first > 1

    def halves(self, scene: PathScene, likely: FacetPairs) -> Iterator["_Piece"]:
        """Yield both halves, in the order of the path."""
        if self.several:
            middle = (self.first + self.last) // 2
            yield _moves(scene, self.first, middle, likely)
            yield _moves(scene, middle, self.last, likely)
        else:
            for half in self.segment.halves():
                yield _Piece(half, self.first, self.last, likely)


def _moves(scene: PathScene, first: int, last: int, likely: FacetPairs) -> _Piece:
    """Return moves from one to the one before another, as a piece."""
    alone = last - first == 1
    segment = scene.segment(scene.program.moves[first]) if alone else scene.group(first, last)
    return _Piece(segment, first, last, likely)


def _looked_at(scene: PathScene, engine: SceneEngine, piece: _Piece, result: PathResult) -> FacetPairs | None:
    """Return None where a pose, or the objects' boxes, show a piece to be clear, else what is near.

    Nothing is where the margin is more than can be asked for.
    """
    margin = scene.path.margin(piece.segment)
    if _boxes_apart(scene, piece.segment):
        _level(result, piece.segment).by_boxes += 1
        return None
    if margin > scene.largest_margin:
        return piece.likely
    run = engine.first_near(piece.segment.sample, margin, piece.likely)
    result.effort.add(run)
    if run.near_count:
        return some_of(run.near, _LIKELY)
    _level(result, piece.segment).by_pose += 1
    return None


def _level(result: PathResult, segment: Segment) -> Level:
    result.levels += [Level() for _ in range(segment.level + 1 - len(result.levels))]
    return result.levels[segment.level]


def near_moves(scene: PathScene, engine: SceneEngine, progress: Progress = unwatched) -> list[int]:
    """Return the numbers of moves that are not shown to be clear by pieces as long as the step."""
    found, first = list[int](), 0
    while (piece := next(_near_pieces(scene, engine, PathResult(), progress, first), None)) is not None:
        found.append(piece.first)
        first = piece.first + 1
        progress(1)
    return found


def _first_near_piece(
    scene: PathScene, engine: SceneEngine, result: PathResult, progress: Progress
) -> tuple[_Piece, SceneRun] | None:
    """Return the first piece, no longer than the step, that is near, and all that is near there."""
    for piece in _near_pieces(scene, engine, result, progress):
        # Which facets are near is asked where that ends the check.
        run = engine.run(piece.segment.sample, scene.path.margin(piece.segment))
        result.effort.add(run)
        if run.near_count:
            return piece, run
        # Euclid's distance is not asked of many pairs where one would do.
        _level(result, piece.segment).by_pose += 1
    return None


def _near_pieces(
    scene: PathScene, engine: SceneEngine, result: PathResult, progress: Progress, first: int = 0
) -> Iterator[_Piece]:
    """Yield pieces no longer than the step where something is near, from a move on, in the path's order.

    All between them is shown to be clear.
    """
    # Moves in a piece; the pieces that are still to be shown clear; the first move that is in none yet.
    together, pending, index = 1, deque[_Piece](), first
    count, done = len(scene.program.moves), first
    while pending or index < count:
        if not pending:
            last = min(index + together, count)
            pending.append(_moves(scene, index, last, NO_PAIRS))
            index = last
        piece = pending.popleft()
        likely = _looked_at(scene, engine, piece, result)
        if piece.segment.level == 0:
            together = 2 * together if likely is None else max(1, together // 2)
        if likely is not None:
            margin = scene.path.margin(piece.segment)
            if piece.several or piece.segment.length > scene.step or margin > scene.largest_margin:
                _level(result, piece.segment).halved += not piece.several
                pending.extendleft(reversed([*piece.halves(scene, likely)]))
                continue
            progress(piece.first - done)
            done = piece.first
            yield piece
        now = pending[0].first if pending else index
        progress(now - done)
        done = now


def _boxes_apart(scene: PathScene, segment: Segment) -> bool:
    """Return whether one axis keeps the objects' boxes further apart than the clearance all along."""
    low_a, high_a = scene.box_a
    low_b, high_b = scene.box_b
    base = scene.path.base + segment.sag + segment.slack
    for k in range(3):
        least, most = sorted((segment.start[k], segment.end[k]))
        if low_a[k] + least - high_b[k] > base or low_b[k] - high_a[k] - most > base:
            return True
    return False


def _near_pose(scene: PathScene, piece: _Piece, run: SceneRun) -> NearPose:
    segment, move = piece.segment, scene.program.moves[piece.first]
    half = (segment.first + segment.last) / 2
    along, scale = Fraction(int(half.numerator), int(half.denominator)), scene.wanted.scale
    place = scene.path.position(segment.middle)
    position = vector(c * scale for c in place)
    of = euclidean_distance if scene.wanted.euclidean else distance_of
    judged = [
        NearFacets(int(i), int(j), scale * Fraction(of(scene.tool, i, scene.work, j, place)))
        for i, j in run.near[:_JUDGED]
    ]
    judged.sort(key=lambda found: (found.distance, found.tool_facet, found.work_facet))
    certain = not segment.between and judged[0].distance + move.slack <= scene.wanted.clearance
    margin = scene.path.margin(segment)
    return NearPose(piece.first, move.line, position, along, margin, run.near_count, tuple(judged), certain)
