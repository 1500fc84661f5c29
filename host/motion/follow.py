"""Following a machine through a program, so that it is permitted to go on without a stop.

The path is cut into pieces, each of which one pose with its margin proves clear (`path_scene`). What was
found clear stays so, as the meshes do. So the tool may be in any piece up to the last one that was found
clear, in the program's order; and each answer counts for as long as the tool cannot leave those, its *hold*:

    hold = (least way to the end of the last piece - braking way) / (fastest axis) - lag.

Where that is shorter than what is left of the hold before, that is given again: more is permitted than then.
Ways are Chebyshev lengths, which no axis can be faster than. The *lag* is the longest time from when a
position was the tool's to the end of the run that is asked for after it. A position may be that of several
pieces: what was passed is at least what comes before the first of them, the way that is left is that from
the last. A control may leave its path by the slack: each piece is shorter by twice that, or each of two
straight lines, from the tool to the end of one of the pieces and from there to the end of the last.

*Zones* are around what must not be touched, wider than the clearance, for a machine that is to be slow near
it. When the pieces are cut it is seen, by poses too, how many zones each is beyond. A tool is beyond those
that all pieces are to which it may come within the hold: that is told before it is given.

The board says with go what its last run was beyond, while the tool is in pieces before, and knows nothing of
what is beside it. So it is asked about a zone only where the tool is beyond that, and so is the piece, as one
pose with its margin shows: the board must find it as well. It never says to be beyond what it is not asked.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import takewhile

import numpy as np

from triaxis.golden.errors import InputError
from triaxis.golden.exact import Rational
from triaxis.host.engines import SceneEngine, Translation
from triaxis.host.motion.moves import Program
from triaxis.host.motion.path_scene import GridPoint, PathScene, Segment, nearest
from triaxis.host.quantise import Vector, vector

# What a tool is told to be in that is beyond none, or the first, of the zones asked for; else it is free.
ZONES = ("slow", "warn")
# How often a piece of a rapid is halved, at most, to see which zones it is beyond.
_HALVINGS = 8
# Milliseconds that a hold can have; what is asked for where the tool cannot leave the program any more.
LONGEST = 65_535
# Over so many lags a tool is seen to be no faster than was said.
_LAGS = 10
# For so long at least a tool is seen to stand at the end of a part: one that feeds slowly is not there yet.
_STANDS_SECONDS = 0.1
# Of each turn of a curve, or of one that makes none, places that it goes to.
_QUARTERS = 4


class StrayedError(InputError):
    """The tool is where it was not permitted to be."""


class LateError(InputError):
    """An answer does not come in the time that the tool leaves it."""


class DisagreementError(InputError):
    """The board and the host do not say the same of the same pose, meshes and margin."""

    def __init__(self, line: int, board: str, host: str) -> None:
        """Say which says what, before a line."""
        super().__init__(
            f"line {line}: {board} to the board, and {host} to the host, by the same pose and margin: one of "
            "them is wrong; the machine is stopped: do not use the board"
        )


@dataclass(frozen=True)
class Piece:
    """A part of the path, of the program's ``line`` and ``moves``, that is clear where ``sample`` is at
    ``margin``.

    Each of its places is at most ``reach`` from the sample. ``end``: where the tool leaves it; ``way``: how
    far it goes in it at least. Of a ``rapid`` that takes an unknown way it may pass over pieces: they have
    its number, the start and the end of the whole, and no way but the last one's. ``near``: it is not found
    clear when it is cut. ``beside``: the objects, of those that the board is not asked about, that are not.
    ``beyond``: how many of the zones, from the innermost on, it is shown to be outside of.
    ``zones``: margins at which its sample alone shows that, of as many as it does: of a rapid that is seen
    part by part they may be fewer.
    """

    sample: Translation
    margin: int
    reach: Rational
    start: GridPoint
    end: GridPoint
    way: Rational
    line: int
    moves: range
    low: GridPoint
    high: GridPoint
    rapid: int | None = None
    near: bool = False
    beside: tuple[str, str] | None = None
    beyond: int = 0
    zones: tuple[int, ...] = ()

    def asked(self, beyond: int) -> tuple[int, int]:
        """Return margins for the board's two zones, 0 where it is not asked.

        ``beyond``: how many of the zones the tool is beyond.
        """
        slow, warn, *_ = (*self.zones[:beyond], 0, 0)
        return slow, warn

    def holds(self, place: GridPoint) -> bool:
        """Return whether a place is covered by its sample."""
        return _apart(place, self.sample) <= self.reach


def _apart(a: GridPoint, b: Sequence[Rational | int]) -> Rational:
    return max(abs(x - y) for x, y in zip(a, b, strict=True))


# Of those that the board is not asked about, the objects that are not clear where the sample of a segment
# covers it, which is of moves with these numbers (`supervision`).
NearBeside = Callable[[Segment, range], tuple[str, str] | None]
# The scene, with the clearance that the zone is wide, and what is beside the board with it.
Zone = tuple[PathScene, NearBeside]


def pieces(
    scene: PathScene,
    engine: SceneEngine,
    shortest: Fraction,
    longest: Fraction | None = None,
    beside: NearBeside = lambda *_: None,
    zones: Sequence[Zone] = (),
) -> tuple[Piece, ...]:
    """Return the pieces of a path in its order: as long as an engine finds them clear, short moves together.

    ``shortest``: what is not clear, or in a zone, is not cut further where it is no longer than that, in
    millimetres; ``longest``: nor is anything longer than that; ``zones``: from the innermost on. A rapid that
    takes an unknown way is not cut for zones: a piece of it is beyond those that all its parts are. Raises
    InputError where a margin does not fit the engine.
    """
    step = scene.wanted.resolution
    longest_steps = Rational(longest / step) if longest else None
    cut = _Cut(((scene, beside), *zones), engine, Rational(shortest / step), longest_steps)
    found = list[Piece]()
    moves = scene.program.moves
    first, together = 0, len(moves)
    while first < len(moves):
        together = min(together, len(moves) - first)
        if together > 1:
            group = scene.group(first, first + together)
            if cut.beyond(group, range(first, first + together)) != len(zones):
                together //= 2
                continue
            way = sum((_way(scene, number) for number in range(first, first + together)), Rational(0))
            ends = scene.place(moves[first].start), scene.place(moves[first + together - 1].end)
            piece = _piece(scene, group, ends, way, range(first, first + together))
            found.append(replace(piece, beyond=len(zones), zones=cut.margins(group, len(zones))))
        else:
            found += cut.move(first)
        first, together = first + together, 2 * together
    return tuple(found)


@dataclass(frozen=True)
class _Cut:
    """How pieces are cut: see `pieces`; ``around``: what is to be clear, then the zones; lengths in steps."""

    around: Sequence[Zone]
    engine: SceneEngine
    shortest: Rational
    longest: Rational | None

    @property
    def scene(self) -> PathScene:
        """Return the scene with the clearance of the board."""
        return self.around[0][0]

    def beyond(self, segment: Segment, moves: range) -> int:
        """Return how many zones all of a segment is beyond by one pose; -1 where it is near, or too long.

        The outermost is asked first: far from everything one question answers all of them.
        """
        if self.longest and segment.length > self.longest:
            return -1
        numbers = range(len(self.around) - 1, -1, -1)
        return next((number for number in numbers if self._shown(segment, moves, *self.around[number])), -1)

    def _shown(self, segment: Segment, moves: range, scene: PathScene, beside: NearBeside) -> bool:
        margin = scene.path.margin(segment)
        if margin > scene.largest_margin:
            return False
        run = self.engine.run(segment.sample, margin, stop_at_first=True)
        return not run.near_count and beside(segment, moves) is None

    def margins(self, segment: Segment, beyond: int) -> tuple[int, ...]:
        """Return margins of one pose for so many zones."""
        return tuple(scene.path.margin(segment) for scene, _ in self.around[1 : 1 + beyond])

    def move(self, number: int) -> Iterator[Piece]:
        """Yield the pieces of one move, in the order in which the tool comes to them."""
        only = range(number, number + 1)
        whole = self.scene.segment(self.scene.program.moves[number])
        pending = [whole]
        while pending:
            segment = pending.pop()
            beyond = self.beyond(segment, only)
            enough = len(self.around) - 1
            if segment.length > self.shortest and beyond < (0 if whole.between else enough):
                pending += reversed(segment.halves())
                continue
            if not whole.between:
                way = max(Rational(0), _apart(segment.start, segment.end) - 2 * segment.slack)
                piece = _piece(self.scene, segment, (segment.start, segment.end), way, only)
            else:
                way = Rational(0) if pending else _way(self.scene, number)
                piece = _piece(self.scene, segment, (whole.start, whole.end), way, only, number)
            if beyond >= 0:
                seen = self._in_parts(segment, only) if beyond < enough else beyond
                yield replace(piece, beyond=seen, zones=self.margins(segment, beyond))
            else:
                _, beside = self.around[0]
                yield replace(piece, near=True, beside=beside(segment, only))

    def _in_parts(self, whole: Segment, moves: range) -> int:
        """Return how many zones a segment that is clear is beyond, seen part by part."""
        pending, least = [whole], len(self.around) - 1
        while pending and least > 0:
            part = pending.pop()
            beyond = self.beyond(part, moves)
            if beyond < least:
                if part.length > self.shortest and part.level < whole.level + _HALVINGS:
                    pending += part.halves()
                else:
                    least = max(beyond, 0)
        return least


def _way(scene: PathScene, number: int) -> Rational:
    """Return how far the tool goes at least in a move."""
    move = scene.program.moves[number]
    nominal = _apart(scene.place(move.start), scene.place(move.end))
    return max(Rational(0), nominal - 2 * Rational(move.slack / scene.wanted.resolution))


def _piece(
    scene: PathScene,
    segment: Segment,
    ends: tuple[GridPoint, GridPoint],
    way: Rational,
    moves: range,
    rapid: int | None = None,
) -> Piece:
    margin, line = scene.path.margin(segment), scene.program.moves[moves[0]].line
    if margin > scene.largest_margin:
        raise InputError(
            f"line {line}: a piece of {float(segment.length * scene.wanted.resolution):.3g} mm: a margin of "
            f"{margin} steps, the engine's is at most {scene.largest_margin}; use a smaller --length or a "
            "coarser resolution"
        )
    beyond = segment.sag + segment.slack
    corners = list(zip(segment.start, segment.end, strict=True))
    low = tuple(min(ends) - beyond for ends in corners)
    high = tuple(max(ends) + beyond for ends in corners)
    return Piece(
        segment.sample, margin, segment.reach, *ends, way, line, moves,
        (low[0], low[1], low[2]), (high[0], high[1], high[2]), rapid,
    )  # fmt: skip


class Follower:
    """Where the tool may be, and what is to be asked next.

    ``speed``: of the fastest axis at most, in mm/s; ``lag`` in seconds; ``braking``: the way in which the
    machine stops, in mm; ``ends``: nothing comes after the last piece.
    """

    def __init__(
        self, scene: PathScene, found: Sequence[Piece], speed: Fraction, lag: Fraction,
        braking: Fraction = Fraction(0), ends: bool = True,
    ) -> None:  # fmt: skip
        """Begin with a tool that is nowhere permitted, and before the first piece."""
        self.scene, self.pieces, self.ends = scene, found, ends
        self._braking = Rational(braking / scene.wanted.resolution)
        self._steps_a_second, self.lag = Rational(speed / scene.wanted.resolution), lag
        self.permitted = 0
        self._first = self._last = 0
        self._place = scene.place(scene.program.moves[0].start)
        self._slack = Rational(max(move.slack for move in scene.program.moves) / scene.wanted.resolution)
        # The move that the tool has come to at least, and how far it has come in that, 0..1.
        self._move, self._part = 0, Rational(0)
        # When it was looked at last, the longest time between two looks, and since when it has stood where.
        self._looked: float | None = None
        # When it was where, of the last lags.
        self._looks = list[tuple[float, GridPoint]]()
        self._longest_look = 0.0
        self._stood, self._stood_since = self._place, 0.0
        # What comes after the last piece was seen to have begun.
        self.is_over = False

    @property
    def place(self) -> GridPoint:
        """Return where the tool was last."""
        return self._place

    def is_at_start(self, position: Vector) -> bool:
        """Return whether a position, in millimetres, is where the path begins, but for the way it brakes."""
        return _apart(self.scene.place(position), self.pieces[0].start) <= self._slack + self._braking

    @property
    def at_the_end(self) -> bool:
        """Return whether the tool is at the end of the path, and not where it only passes over that.

        From where it has come to at least, the path goes away from there no more, but for what a tool could
        do between two looks, there and back.
        """
        end, here = self.pieces[-1].end, self._slack + 1
        if self.permitted < len(self.pieces) or _apart(self._place, end) > here:
            return False
        most = here + 2 * self._slack + self._steps_a_second * Rational(self._longest_look) / 2
        moves = self.scene.program.moves
        return not any(
            _apart(place, end) > most
            for number in range(self._move, len(moves))
            for place in self._still_to_come(number)
        )

    @property
    def is_done(self) -> bool:
        """Return whether the tool stands at the end, or has left it for what comes after the last piece."""
        if self.ends or not self.at_the_end:
            return False
        stood = (self._looked or 0.0) - self._stood_since
        return self.is_over or stood >= max(_STANDS_SECONDS, self.lag)

    def _still_to_come(self, number: int) -> Iterator[GridPoint]:
        """Yield places that a move goes to from where the tool is at least."""
        move = self.scene.program.moves[number]
        segment = self.scene.segment(move)
        yield segment.end
        if segment.curve is not None and move.curve is not None:
            come = self._part if number == self._move else Rational(0)
            places = _QUARTERS * move.curve.turns
            yield from (segment.curve[0](Rational(k, places)) for k in range(int(come * places) + 1, places))

    def moved(self, position: Vector, since: float = 0.0) -> None:
        """Take where the tool is, in millimetres, at a second; raise StrayedError where it may not be.

        Holds rest on the speed. What is read of a time is true within a lag of it (`follow` sees to that), so
        between two looks there is a lag more than between their times.
        """
        place = self.scene.place(position)
        among = range(self._first, max(self.permitted, 1))
        held = [number for number in among if self._is_in(self.pieces[number], place)]
        if not held:
            where = " ".join(f"{name}{float(c):g}" for name, c in zip("XYZ", position, strict=True))
            lines = " to ".join(str(self.pieces[number].line) for number in (among[0], among[-1]))
            raise StrayedError(
                f"the tool is at {where}, where it is not permitted to be now, in lines {lines} of "
                f"{self.scene.program.path}; the machine is stopped: check the origin, and "
                "--deviation, or begin anew"
            )
        recent = [one for one in self._looks if since - one[0] <= _LAGS * float(self.lag)]
        self._looks = recent or self._looks[-1:]
        for earlier, there in self._looks:
            seconds = Rational(max(since - earlier, 0.0)) + Rational(self.lag)
            way = _apart(place, there)
            if way > self._steps_a_second * seconds + 2 * self._slack + 1:
                fast = float(way * self.scene.wanted.resolution)
                raise StrayedError(
                    f"the tool went {fast:.4g} mm in {float(seconds):.3g} s at most: faster than --speed; "
                    "the machine is stopped: check --speed, --lag, and where positions come from"
                )
        self._looks.append((since, place))
        self._first, self._last, self._place = held[0], held[-1], place
        if self._looked is not None:
            self._longest_look = max(self._longest_look, since - self._looked)
        if self._looked is None or _apart(place, self._stood) > 1:
            self._stood, self._stood_since = place, since
        self._looked = since
        self._come(place)

    def _come(self, place: GridPoint) -> None:
        """Take that the tool is at a place of the pieces that it may be in, in the program's order."""
        if self.pieces[self._first].moves.start > self._move:
            self._move, self._part = self.pieces[self._first].moves.start, Rational(0)
        for number in self._close(range(self._move, self.pieces[self._last].moves.stop), place):
            come = self._part if number == self._move else Rational(0)
            part = _reached(place, self.scene.segment(self.scene.program.moves[number]), come)
            if part is not None:
                self._move, self._part = number, part
                return

    def _close(self, moves: range, place: GridPoint) -> list[int]:
        """Return those of some moves whose boxes hold a place, nearly."""
        boxes, here = self.scene.extents[moves.start : moves.stop], np.array(nearest(place))
        close = ((boxes[:, 0] <= here + 1) & (here - 1 <= boxes[:, 1])).all(1)
        return (moves.start + np.flatnonzero(close)).tolist()

    def _is_in(self, piece: Piece, place: GridPoint) -> bool:
        """Return whether a place is one of a piece's path, and not only covered by its sample."""
        if not piece.holds(place) or _gap(place, piece) > 0:
            return False
        if piece.rapid is not None:
            return True
        # Where the tool has come to, mostly: a piece may have thousands of moves.
        close = sorted(self._close(piece.moves, place), key=lambda number: number < self._move)
        segments = (self.scene.segment(self.scene.program.moves[number]) for number in close)
        return any(_reached(place, segment) is not None for segment in segments)

    def hold(self, number: int) -> int:
        """Return how many milliseconds the tool cannot leave the pieces up to that one; or 0 or less.

        At the end, where another part of the program follows, it stands for three lags at least.
        """
        last = number + 1 == len(self.pieces)
        if last and self.ends:
            return LONGEST
        seconds = (self._left(number) - self._braking) / self._steps_a_second - Rational(self.lag)
        if last:
            seconds = max(seconds, 2 * Rational(self.lag))
        return min(int(1000 * seconds // 1), LONGEST)

    def next(self, enough: int) -> int:
        """Return the piece to be asked about: the next one, or the last again where its hold is enough.

        A rapid of many pieces is begun with sooner: while they are asked about, what is left does not grow.
        """
        last = self.permitted - 1
        if last < 0 or last + 1 == len(self.pieces):
            return max(last, 0)
        rapid = self.pieces[last + 1].rapid
        others = (one for one in range(last + 1, len(self.pieces)) if self.pieces[one].rapid != rapid)
        together = next(others, len(self.pieces)) - last if rapid is not None else 0
        wanted = min(enough + int(1000 * self.lag * together), LONGEST)
        return last if self.hold(last) >= wanted else last + 1

    def beyond(self, number: int, hold: int) -> int:
        """Return how many zones the tool is beyond until a piece is permitted, and a hold from then on."""
        upto = max(self.permitted, number + 1)
        if len(zones := {one.beyond for one in self.pieces[self._first : upto]}) == 1:
            return zones.pop()
        reached = next((one for one in range(self._last, upto) if self.hold(one) >= hold), upto - 1)
        return min(one.beyond for one in self.pieces[self._first : reached + 1])

    def line_beyond(self, beyond: int, number: int) -> int:
        """Return the line of the first piece, up to one of a number, that is beyond no more zones."""
        ahead = self.pieces[self._first : max(number + 1, self.permitted)]
        return next((one.line for one in ahead if one.beyond <= beyond), self.pieces[number].line)

    def permit(self, number: int) -> None:
        """Take that a piece was found clear, and go is said."""
        self.permitted = max(self.permitted, number + 1)

    def _left(self, number: int) -> Rational:
        """Return the least way, in steps, on which the tool leaves the pieces up to one of a number."""
        last, piece = self.pieces[self._last], self.pieces[number]
        # Of a rapid that is not permitted as a whole it may come to any other piece first.
        ahead = (self.pieces[one] for one in range(number + 1, len(self.pieces)))
        others = list(takewhile(lambda one: one.rapid is not None and one.rapid == piece.rapid, ahead))
        if others and piece.rapid == last.rapid:
            return min(_gap(self._place, one) for one in others)
        return max(self._along(number, others), self._straight(number, others))

    def _straight(self, number: int, others: Sequence[Piece]) -> Rational:
        """Return the longest of the ways by one of the ends between, each leg straight."""
        piece = self.pieces[number]
        passed = self.pieces[self._last : number + 1]
        # Of a rapid that is not permitted as a whole the end is not passed.
        ends = [one.end for one in passed if not others or one.rapid != piece.rapid]
        ends += [piece.start] if others else []
        beyond = min((_gap(ends[-1], one) for one in others), default=Rational(0))
        legs = (
            max(Rational(0), _apart(self._place, end) - self._slack)
            + max(Rational(0), _apart(end, ends[-1]) - 2 * self._slack)
            for end in ends
        )
        return max(legs) + max(Rational(0), beyond - self._slack)

    def _along(self, number: int, others: Sequence[Piece]) -> Rational:
        """Return the sum of the ways of the pieces, from where the tool is."""
        last, piece = self.pieces[self._last], self.pieces[number]
        way = max(Rational(0), _apart(self._place, last.end) - 2 * self._slack)
        for one in self.pieces[self._last + 1 : number + 1]:
            if one.rapid is None or one.rapid != last.rapid:
                way += one.way
        return way + min((_gap(piece.start, one) for one in others), default=Rational(0))


def _reached(place: GridPoint, segment: Segment, come: Rational = Rational(0)) -> Rational | None:  # noqa: B008
    """Return how far in its move, 0..1, a tool has come at least that is on a segment, and had come that far.

    None where the place is not on the segment but for its slack and, where that is a curve, two steps, or is
    behind. In a box in which no axis turns back, it is that of the axis that has come furthest.
    """
    most = segment.sag + segment.slack
    near, far = [Rational(0)], [Rational(1)]
    for x, a, b in zip(place, segment.start, segment.end, strict=True):
        if not min(a, b) - most <= x <= max(a, b) + most:
            return None
        if a != b:
            # Which part of the chord is that near in this coordinate.
            ends = sorted(((x - most - a) / (b - a), (x + most - a) / (b - a)))
            near.append(ends[0])
            far.append(ends[1])
    first = max(near)
    last = max(far[1:], default=far[0]) if segment.between else min(far)
    whole = segment.last - segment.first
    if (first > last and not segment.between) or segment.first + last * whole < come:
        return None
    if segment.sag <= 1:
        return max(come, segment.first + min(first, Rational(1)) * whole)
    return next(
        (part for half in segment.halves() if (part := _reached(place, half, come)) is not None), None
    )


def _gap(place: GridPoint, piece: Piece) -> Rational:
    """Return how far a place is from a piece."""
    sides = zip(place, piece.low, piece.high, strict=True)
    return max(Rational(0), *(max(low - x, x - high) for x, low, high in sides))


@dataclass
class Followed:
    """How far a machine was followed. ``near``: the piece that was found near, or None; ``place``: in
    millimetres, where the tool is in the middle of it.
    """

    asked: int = 0
    permitted: int = 0
    near: Piece | None = None
    place: Vector | None = None
    shortest_hold: int = LONGEST
    longest_lag: float = 0.0

    def add(self, other: "Followed") -> None:
        """Take what came of the part that comes next."""
        self.asked, self.permitted = self.asked + other.asked, self.permitted + other.permitted
        self.near, self.place = other.near, other.place
        self.shortest_hold = min(self.shortest_hold, other.shortest_hold)
        self.longest_lag = max(self.longest_lag, other.longest_lag)

    def refused(self, follower: Follower, piece: Piece) -> "Followed":
        """Return it, as it ends before a piece."""
        scene = follower.scene
        place = scene.path.position(vector(map(Rational, piece.sample)))
        self.place = vector(c * scene.wanted.scale for c in place)
        self.permitted, self.near = follower.permitted, piece
        return self


# Of an answer: the number of its piece, the hold in milliseconds, whether it is clear, and the seconds from
# when to when it took.
Seen = Callable[[int, int, bool, float, float], None]
# Before a question: the number of its piece, how many zones the tool is beyond until the next, and the second
# at which it was where that rests on.
Ahead = Callable[[int, int, float], None]
# Where the tool is, in millimetres, and at which second of `now` it was so; None: the machine has ended.
Report = tuple[Vector, float] | None
# So many times the hold that is aimed at is permitted ahead.
_AHEAD = 2
# A simulated tool takes so many straight steps along a curve, and stands at so many places of a move.
_PARTS, _PLACES = 1024, 1 << 30


def follow(
    follower: Follower,
    permit: Callable[[Translation, int, int, tuple[int, int]], bool],
    report: Callable[[], Report],
    now: Callable[[], float],
    longest: int,
    seen: Seen = lambda *_: None,
    ahead: Ahead = lambda *_: None,
) -> Followed:
    """Have a machine permitted piece by piece, until it ends or a piece is near.

    Where another part of the program follows, until it is at the end of this one.

    ``permit``: asks about a pose, a margin, a hold and zones (`BoardEngine.permit`); ``longest``: the hold
    that is aimed at, in milliseconds, and never exceeded; ``ahead`` is told of zones before the board is
    asked, ``seen`` of each answer. Raises StrayedError, and LateError where an answer takes, or could take,
    longer than the tool may stay, or longer than go is said for certain; DisagreementError where the board
    says clear of a piece that was near when it was cut.
    """

    def check_lag(since: float, until: float) -> None:
        if until - since > follower.lag:
            raise LateError(
                f"an answer came {until - since:.3g} s after its position, --lag is {float(follower.lag):g} "
                "s: give positions all the time, also where nothing moves, or a larger --lag"
            )

    done = Followed()
    # Until when the last answer counts at least.
    until = 0.0
    while True:
        here = report()
        if here is None:
            done.permitted = follower.permitted
            return done
        position, since = here
        try:
            follower.moved(position, since)
        except StrayedError:
            # Of a position that is too old nothing else is to be said.
            check_lag(since, now())
            raise
        if follower.is_done:
            done.permitted = follower.permitted
            return done
        number = follower.next(_AHEAD * longest)
        left = int(1000 * (until - since - float(follower.lag)) // 1)
        hold = min(max(follower.hold(number), left), longest)
        piece = follower.pieces[number]
        check_lag(since, now())
        if piece.beside is not None:
            # The board knows nothing of it: what it permitted before ends by itself.
            seen(number, 0, False, since, now())
            return done.refused(follower, piece)
        if hold < 1:
            raise LateError(
                f"line {piece.line}: the tool may be at the end of what is permitted "
                f"sooner than in the {float(follower.lag):g} s that an answer may take: begin with a longer "
                "move, use a larger --length, a lower --speed, a shorter --lag or --braking"
            )
        beyond = follower.beyond(number, hold)
        ahead(number, beyond, since)
        # Whom it is told may take his time; a question would begin go anew, of where the tool was.
        check_lag(since, now())
        said, until = until if follower.permitted else None, now() + hold / 1000
        clear = permit(piece.sample, piece.margin, hold, piece.asked(beyond))
        answered = now()
        done.asked += 1
        done.longest_lag = max(done.longest_lag, answered - since)
        done.shortest_hold = min(done.shortest_hold, hold)
        if not clear:
            seen(number, hold, clear, since, answered)
            return done.refused(follower, piece)
        if piece.near:
            raise DisagreementError(piece.line, "clear", "near")
        check_lag(since, answered)
        if said is not None and now() > said:
            # Go may have ended meanwhile, and begun again.
            raise LateError(
                f"line {piece.line}: the permission before was not renewed within its time: use a larger "
                "--hold or --length"
            )
        follower.permit(number)
        seen(number, hold, clear, since, answered)


class SimulatedTool:
    """A tool that goes along a program while it is permitted: to try all this without a machine.

    ``speed``: of its fastest axis, in mm/s; ``permitted``: whether it may go.
    """

    def __init__(
        self, program: Program, speed: Fraction, now: Callable[[], float], permitted: Callable[[], bool]
    ) -> None:
        """Begin at the start."""
        self._moves, self._speed, self._now, self._permitted = program.moves, float(speed), now, permitted
        self._number, self._part, self._since = 0, Fraction(0), now()
        # The way, in mm, that it has not gone yet of what it could.
        self._left = 0.0

    def report(self) -> Report:
        """Go on for the time that has passed; return where the tool is, None once it has been at the end."""
        now = self._now()
        self._left += self._speed * (now - self._since) if self._permitted() else 0.0
        self._since = now
        if self._number == len(self._moves):
            return None
        while self._number < len(self._moves):
            move = self._moves[self._number]
            here, step = move.at(self._part), min(1 - self._part, Fraction(1, _PARTS if move.curve else 1))
            way = float(max(abs(b - a) for a, b in zip(here, move.at(self._part + step), strict=True)))
            if self._left < way:
                part = Fraction(int((self._part + step * Fraction(self._left / way)) * _PLACES), _PLACES)
                self._left -= way * float((part - self._part) / step)
                self._part = part
                return move.at(self._part), now
            self._left -= way
            self._part += step
            if self._part == 1:
                self._number, self._part = self._number + 1, Fraction(0)
        return self._moves[-1].end, now
