"""A machine is followed through a program: where it may be, for how long, and what stops it."""

import re
from contextlib import nullcontext
from copy import copy
from dataclasses import replace
from fractions import Fraction
from functools import partial
from itertools import count, pairwise, product
from types import SimpleNamespace

import numpy as np
import pytest

from triaxis.golden.errors import InputError
from triaxis.golden.exact import Rational
from triaxis.host.cli.engine import checkout_id
from triaxis.host.engines import BULK, scene_engine
from triaxis.host.link.board import Board
from triaxis.host.link.board_engine import BoardEngine
from triaxis.host.link.exchange import LinkError
from triaxis.host.link.messages import ZONES as ZONE_FLAGS
from triaxis.host.motion.follow import (
    LONGEST,
    DisagreementError,
    Follower,
    LateError,
    SimulatedTool,
    StrayedError,
    follow,
    pieces,
)
from triaxis.host.motion.path_scene import Wanted, prepare_path, upwards
from triaxis.host.motion.program import read_program
from triaxis.host.quantise import vector
from triaxis.host.scene import distance_of
from triaxis.host.stl import StlMesh
from triaxis.sim.board_parameters import BoardParameters
from triaxis.sim.simulated_board import PINS
from triaxis.sim.simulated_line import SimulatedLine, SimulatedWire

PROGRAM = """G21 G90 G64 P0.3 Q0.4
G0 X30 Y25 Z20
G1 Z10 F1000
X60
G2 X80 Y45 R20
G1 X80.3
X80.5 Y45.2
X80.4 Y45.5
Y70
G0 X0 Y0 Z40
"""
START = vector(map(Fraction, (0, 0, 40)))
TOOL = np.array([[[0, 0, 0], [3, 0, 0], [0, 3, 9]], [[0, 0, 0], [0, 3, 0], [3, 0, 9]]], np.float32)
FLOOR = np.array([[[-9, -9, 0], [99, -9, 0], [99, 99, 0]]], np.float32)
# A post on the way from X30 to X60.
POST = np.array([[[50, 20, 0], [52, 30, 12], [50, 30, 12]]], np.float32)
# By the post, which is 1.9 mm away, and up at the end.
ZONED = PROGRAM.replace("G0 X0 Y0 Z40", "G1 Z40")
BESIDE = np.concatenate([FLOOR, POST + np.array([0, 3.1, 0], np.float32)])
# Above the floor by any way, in long pieces, and down to be in a zone.
RAPID = "G21 G90 G64 P0.3 Q0.4\nG0 X30 Y25 Z20\nG1 Z11 F1000\nG0 X60 Y26\nG1 Z1.5\nZ40\n"
SPEED, LAG = Fraction(100), Fraction(1, 50)
# Of the program, in mm and in steps.
SLACK, SLACK_STEPS = Fraction(4, 5), 80
# Time is drawn out a hundred times, so that a hold is a small part of what an answer takes.
PARAMETERS = BoardParameters(depth=512, hold_clocks=1000, watchdog_clocks=100_000, build_id=checkout_id())
CLOCKS_PER_SECOND = 1_000_000


@pytest.fixture
def program(tmp_path):
    path = tmp_path / "program.nc"
    path.write_text(PROGRAM)
    return path


def scene_of(program, work=FLOOR):
    wanted = Wanted(Fraction(1, 2), Fraction(1, 100), Fraction(4), Fraction(1), 16)
    meshes = StlMesh(TOOL, Fraction(0)), StlMesh(work, Fraction(0))
    return prepare_path(*meshes, ("tool", "work"), read_program(program, START), wanted)


def cut(scene):
    return pieces(scene, scene_engine(BULK, scene.a, scene.b, scene.grid.width), Fraction(4), Fraction(20))


def with_slack(scene, slack):
    moves = tuple(replace(move, slack=slack) for move in scene.program.moves)
    return replace(scene, program=replace(scene.program, moves=moves))


def following(scene, found, ends=True):
    """Return a follower that may go all the way."""
    follower = Follower(scene, found, SPEED, LAG, ends=ends)
    follower.permitted = len(found)
    return follower


def ways(move, rng):
    """Return places of a move in its order, by one of the ways that it may take."""
    parts = [Fraction(k, 40) for k in range(41)]
    if move.straight or move.curve:
        return [move.at(part) for part in parts]
    # No axis turns back, each goes at its own pace.
    paces = [sorted(rng.integers(0, 41, 39).tolist()) for _ in range(3)]
    return [
        move.start,
        *(
            vector(
                a + (b - a) * Fraction(pace[k], 40)
                for a, b, pace in zip(move.start, move.end, paces, strict=True)
            )
            for k in range(39)
        ),
        move.end,
    ]


def test_every_place_of_the_path_is_in_a_piece_and_they_come_in_order(program, rng):
    scene = scene_of(program)
    found = cut(scene)
    assert len({piece.line for piece in found}) >= 5
    # Of the short moves two are one piece.
    assert sum(piece.line in (6, 7, 8) for piece in found) == 2
    for _ in range(3):
        follower = following(scene, found)
        assert not follower.at_the_end
        looks = ((move, place) for move in scene.program.moves for place in ways(move, rng))
        for second, (move, place) in enumerate(looks):
            follower.moved(vector(c + d for c, d in zip(place, off_path(move, rng), strict=True)), second)
        # It ends where it began.
        assert follower.at_the_end


@pytest.mark.parametrize(
    "lines",
    [
        "G1 X10 F900\nX0\nX10\nX0", "G1 Z38 F900\nZ34\nZ38\nZ35\nZ30\nZ38", "G1 X-9 F900\nX9\nX0",
        "G0 Z35\nZ40", "G0 X9 Y9\nX0 Y0", "G2 X0 Y0 I10 F900", "G2 X0 Y0 I10 F900\nG2 X0 Y0 I10",
        "G2 X0 Y0 I10 P4 F900", "G2 X0 Y0 I10 P5 F900", "G5 X60 I100 J0 P-100 Q90 F900\nG1 X61",
    ],
    ids=[
        "laps", "pecks", "passed by", "rapids", "oblique rapids", "circle", "circles", "four turns",
        "five turns", "spline",
    ],
)  # fmt: skip
def test_a_path_ends_where_it_ends_and_not_where_it_passes_over_that(lines, tmp_path):
    path = tmp_path / "program.nc"
    path.write_text(f"G21 G90 G61\n{lines}\n")
    scene = with_slack(scene_of(path), Fraction(1, 100))
    follower = following(scene, cut(scene))
    moves = scene.program.moves
    counts = [160 * move.curve.turns if move.curve else 40 for move in moves]
    looks = [move.at(Fraction(k, n)) for move, n in zip(moves, counts, strict=True) for k in range(n)]
    seconds = 0.0
    for number, look in enumerate([*looks, moves[-1].end]):
        # By no more than its speed.
        way = max(abs(a - b) for a, b in zip(look, looks[max(number - 1, 0)], strict=True))
        seconds += max(0.001, float(way / SPEED))
        follower.moved(look, seconds)
        apart = max(abs(a - b) for a, b in zip(look, moves[-1].end, strict=True))
        assert follower.at_the_end == (number >= len(looks) - 1 and apart <= Fraction(2, 100)), number


def test_a_part_is_over_when_the_tool_stands_at_its_end(tmp_path):
    """And not as soon as it is as near to that as positions may be off."""
    path = tmp_path / "program.nc"
    path.write_text("G21 G90 G61\nG1 Z30 F600\n")
    scene = with_slack(scene_of(path), Fraction(1, 2))
    follower = following(scene, cut(scene), ends=False)
    over = []
    for number in range(130):
        # By 10 mm/s, a look each 10 ms.
        place = vector((Fraction(0), Fraction(0), max(Fraction(30), 40 - Fraction(number, 10))))
        follower.moved(place, number / 100)
        over.append(follower.is_done)
    assert over.index(True) == 100 + 10 and all(over[110:])
    follower.is_over = True
    assert follower.is_done


def test_a_board_that_finds_clear_what_was_near_is_not_believed(program):
    scene = scene_of(program, np.concatenate([FLOOR, POST]))
    follower = Follower(scene, cut(scene), SPEED, LAG)
    near = next(number for number, piece in enumerate(follower.pieces) if piece.near)
    clock = Clock(*[0.01] * 10_000)
    tool = SimulatedTool(scene.program, SPEED, clock.now, lambda: follower.permitted > 0)
    with pytest.raises(DisagreementError, match="line 4: clear to the board, and near to the host"):
        follow(follower, clock.permit, tool.report, clock.now, 200)
    assert follower.permitted == near


def test_a_tool_that_is_off_its_path_is_stopped_at_once(program, rng):
    """Where no move comes as near as its slack, however large the pieces are; all of them are permitted."""
    scene = scene_of(program)
    found = cut(scene)
    ends = np.array([[move.start, move.end] for move in scene.program.moves], float)
    rapid = np.array([not (move.straight or move.curve) for move in scene.program.moves])
    curves = [
        np.array([move.at(Fraction(k, 200)) for k in range(201)], float) for move in scene.program.moves
    ]
    stopped = 0
    for trial in range(400):
        number = trial % len(curves)
        place = curves[number][rng.integers(201)] + rng.uniform(-4, 4, 3)
        low, high = ends[rapid].min(1), ends[rapid].max(1)
        apart = [np.maximum(low - place, place - high).max(1).min()]
        apart += [
            np.abs(curve - place).max(1).min() for curve, fast in zip(curves, rapid, strict=True) if not fast
        ]
        follower = following(scene, found)
        # Of a move of 40 mm the next of the 201 places is at most so far.
        if min(apart) > float(SLACK) + 0.2:
            with pytest.raises(StrayedError, match="where it is not permitted to be now"):
                follower.moved(vector(Fraction(float(c)) for c in place))
            stopped += 1
    assert stopped > 100


def test_a_tool_that_comes_sooner_than_it_can_is_stopped(program):
    """As one does whose positions are those of a place where it stands no more: holds rest on its speed."""
    scene = scene_of(program)
    follower = following(scene, cut(scene))
    start, end = scene.program.moves[0].start, scene.program.moves[0].end
    way = max(abs(a - b) for a, b in zip(start, end, strict=True))
    assert follower.is_at_start(start) and not follower.is_at_start(end)
    follower.moved(start, 1.0)
    soonest = way / SPEED - LAG
    with pytest.raises(StrayedError, match="faster than --speed; the machine is stopped"):
        follower.moved(end, 1.0 + float(soonest - 2 * SLACK / SPEED) - 0.001)
    follower.moved(end, 1.0 + float(soonest))
    # Twice as fast, by steps each of which a lag would allow.
    hurried = following(scene, cut(scene))
    with pytest.raises(StrayedError, match="faster than --speed"):
        for number in range(41):
            seconds = float(way / SPEED) * number / 80
            hurried.moved(scene.program.moves[0].at(Fraction(number, 40)), seconds)


def test_a_simulated_tool_is_as_fast_as_it_may_be_on_a_long_move(tmp_path):
    path = tmp_path / "long.nc"
    path.write_text("G21 G90 G61\nG1 X300 F900\n")
    program, ticks = scene_of(path).program, count()
    tool = SimulatedTool(program, Fraction(1), lambda: next(ticks) / 100, lambda: True)
    reports = [tool.report() for _ in range(50)]
    places = [float(here[0][0]) for here in reports if here]
    assert places == pytest.approx([number / 100 for number in range(1, 51)], abs=1e-5)


@pytest.mark.parametrize(
    ("place", "strays"),
    [
        ((20, 20, 40), False),
        ((20.01, 20, 40), False),
        # In the box of a piece of the diagonal; inside of the arc, and of its chord's sag.
        ((16, 14, 40), True),
        ((20, 20, 40.1), True),
        ((60, 50, 40), False),
        ((60, 49.9, 40), True),
        ((60, 50.1, 40), True),
    ],
)
def test_a_tool_is_held_against_lines_and_arcs_exactly(tmp_path, place, strays):
    path = tmp_path / "program.nc"
    path.write_text("G21 G90 G61\nG1 X40 Y40 F1000\nG2 X80 Y40 R25\nG1 X90 Y40")
    scene = with_slack(scene_of(path), Fraction(1, 100))
    follower = following(scene, cut(scene))
    with pytest.raises(StrayedError) if strays else nullcontext():
        follower.moved(vector(Fraction(str(c)) for c in place))


def off_path(move, rng):
    """Return by how much the control leaves a move."""
    return vector(SLACK * int(rng.integers(-1, 2)) * bool(move.slack) for _ in range(3))


def test_a_tool_cannot_leave_what_is_permitted_within_lag_and_hold(program, rng):
    """At its full speed, by any way within the slack, from any place; and no hold is shorter than need be."""
    scene = scene_of(program)
    found = cut(scene)
    checked, exact = 0, 0
    for _ in range(4):
        track = [
            (vector(c + d for c, d in zip(place, off_path(move, rng), strict=True)), move)
            for move in scene.program.moves
            for place in ways(move, rng)
        ]
        places = [place for place, _ in track]
        steps = [max(abs(b - a) for a, b in zip(*pair, strict=True)) for pair in pairwise(places)]
        nominal = 0
        for at in range(0, len(places) - 1, 3):
            while not found[nominal].holds(scene.place(places[at])):
                nominal += 1
            follower = Follower(scene, found, SPEED, LAG)
            follower._first = nominal
            # At least all that the tool may have come through.
            line, place = track[at][1].line, scene.place(places[at])
            latest = 1 + max(k for k, piece in enumerate(found) if piece.line <= line and piece.holds(place))
            if latest == len(found):
                break
            follower.permitted = min(latest + int(rng.integers(4)), len(found) - 1)
            follower.moved(places[at])
            for number in range(follower.permitted - 1, min(follower.permitted + 2, len(found) - 1)):
                hold = follower.hold(number)
                allowed, travelled = SPEED * (Fraction(hold, 1000) + LAG), Fraction(0)
                for step, place in zip(steps[at:], places[at + 1 :], strict=True):
                    travelled += step
                    if travelled > allowed:
                        break
                    seen = scene.place(place)
                    assert any(piece.holds(seen) for piece in found[: number + 1]), (number, place)
                    checked += 1
                if number == follower._last and found[number].rapid is None:
                    left = max(abs(a - b) for a, b in zip(follower._place, found[number].end, strict=True))
                    assert 1000 * (left - 2 * SLACK_STEPS) / (100 * SPEED) - 1000 * LAG - 1 <= hold
                    assert hold <= max(1000 * (left - SLACK_STEPS) / (100 * SPEED), 0) - 1000 * LAG
                    exact += 1
    assert checked > 1000 and exact > 20


# Millimetres, from the innermost.
ZONES = Fraction(2), Fraction(6)


def cut_for_zones(scene, shortest=4):
    engine = scene_engine(BULK, scene.a, scene.b, scene.grid.width)
    zones = [(scene.within(width), lambda *_: None) for width in ZONES]
    return pieces(scene, engine, Fraction(shortest), Fraction(20), zones=zones)


def cut_for_both(scene):
    return cut_for_zones(scene, 1)


def apart(scene, position):
    """Return the exact distance of tool and workpiece."""
    meshes = scene.tool, scene.work
    pairs = product(*(range(len(mesh.facets)) for mesh in meshes))
    return min(distance_of(scene.tool, i, scene.work, j, position) for i, j in pairs)


def test_what_is_beyond_a_zone_is_so_at_every_place_and_what_is_not_is_within_nearly(program, rng):
    scene = scene_of(program, np.concatenate([FLOOR, POST]))
    found = cut_for_zones(scene)
    assert {piece.beyond for piece in found if not piece.near} == {0, 1, 2}
    assert all(piece.beyond == 0 for piece in found if piece.near)
    # The path between them is the same, and so is what is near.
    assert [piece.line for piece in found if piece.near] == [piece.line for piece in cut(scene) if piece.near]
    band = 4 * scene.wanted.resolution
    for piece in found:
        for _ in range(12):
            ends = zip(piece.low, piece.high, strict=True)
            place = vector(a + (b - a) * Rational(int(rng.integers(9)), 8) for a, b in ends)
            away = apart(scene, scene.path.position(place))
            assert all(away > width for width in ZONES[: piece.beyond]), (piece, place)
        away = apart(scene, scene.path.position(vector(map(Rational, piece.sample))))
        for width in ZONES[piece.beyond :] if not piece.near and piece.rapid is None else ():
            assert away <= width + Fraction(str(piece.reach)) * scene.wanted.resolution + band


def own_zones(scene, piece):
    """Return margins at which the sample of a piece shows that all of it is beyond each zone."""
    return tuple(upwards(scene.within(width).path.base + piece.reach) for width in ZONES)


def test_the_board_is_asked_about_zones_that_the_tool_is_beyond_as_one_pose_shows(program):
    scene = scene_of(program, BESIDE)
    engine = scene_engine(BULK, scene.a, scene.b, scene.grid.width)
    told = set()
    for piece in cut_for_zones(scene):
        own = own_zones(scene, piece)
        free = sum(not engine.run(piece.sample, margin).near_count for margin in own)
        for beyond in range(3):
            asked = min(beyond, free)
            assert piece.asked(beyond) == (*own[:asked], 0, 0)[:2]
            told.add((piece.beyond, beyond, asked))
    assert {(2, 0, 0), (2, 1, 1), (2, 2, 2), (1, 2, 1), (0, 2, 0)} <= told
    # Of a rapid seen part by part: the board does find something around its one pose.
    assert {(2, 2, 1), (1, 1, 0)} <= told
    assert all(piece.asked(2) == (0, 0) for piece in cut(scene))


def test_of_one_zone_the_board_is_asked_about_the_first(program):
    scene = scene_of(program, BESIDE)
    engine = scene_engine(BULK, scene.a, scene.b, scene.grid.width)
    zones = [(scene.within(ZONES[0]), lambda *_: None)]
    for piece in pieces(scene, engine, Fraction(4), Fraction(20), zones=zones):
        first, second = piece.asked(1)
        assert first in (0, own_zones(scene, piece)[0]) and second == 0


def test_what_is_beside_the_board_in_a_zone_is_not_asked_of_it(program):
    scene = scene_of(program, FLOOR)
    engine = scene_engine(BULK, scene.a, scene.b, scene.grid.width)
    beside = (lambda *_: None, lambda *_: ("column", "table"))
    zones = [(scene.within(width), near) for width, near in zip(ZONES, beside, strict=True)]
    found = pieces(scene, engine, Fraction(4), Fraction(20), zones=zones)
    assert {(piece.beyond, piece.asked(2)[1]) for piece in found if not piece.near} <= {(0, 0), (1, 0)}
    assert any(piece.asked(2)[0] for piece in found)


def test_margins_are_those_that_the_board_has(program):
    """Pieces are as short as these need, and what fits no piece is refused before the machine starts."""
    scene = scene_of(program, BESIDE)
    most = {}
    for bits in (16, 11, 10, 9):
        narrow = replace(scene, wanted=replace(scene.wanted, margin_bits=bits))
        try:
            found = cut_for_zones(narrow)
        except InputError as error:
            assert re.search(r"a margin of \d+ .*, .* at most 511", str(error))
            assert bits == 9
            continue
        most[bits] = max(max(piece.margin, *piece.zones, 0) for piece in found)
    assert 1 << 11 > most[16] > most[10] and most[11] == most[16] and most[10] < 1 << 10
    # Pieces that are longer than the margin was tried for.
    narrow = replace(scene, wanted=replace(scene.wanted, margin_bits=10))
    with pytest.raises(InputError, match=r"line \d: a piece of .* at most 1023; use a smaller --length"):
        pieces(narrow, scene_engine(BULK, scene.a, scene.b, scene.grid.width), Fraction(40))


@pytest.mark.long
def test_a_zone_is_told_before_the_tool_can_be_there_and_until_it_has_left(program):
    program.write_text(ZONED)
    scene = scene_of(program, BESIDE)
    found = cut_for_both(scene)
    assert not any(piece.near for piece in found)
    follower, clock = Follower(scene, found, SPEED, LAG), Clock(*[0.01] * 10_000)
    tool = SimulatedTool(scene.program, SPEED, clock.now, lambda: follower.permitted > 0)
    told = list[int]()

    def permit(translation, margin, hold, *_):
        # Wherever it is while that is said: until the hold ends, after which it is told again or stops.
        for part in range(9):
            later = copy(tool)
            later._now = partial(float, clock.time + hold * part / 8000)
            here = later.report()
            assert here is None or all(apart(scene, here[0]) > width for width in ZONES[: told[-1]])
        return clock.permit(translation, margin, hold)

    follow(follower, permit, tool.report, clock.now, 200, ahead=lambda _, beyond, __: told.append(beyond))
    assert set(told) == {0, 1, 2} and told[0] == told[-1] == 2


def test_slack_shortens_ways_and_widens_boxes(program):
    scene = scene_of(program)
    found = cut(scene)
    down, first, second, arc = found[4:8]
    assert [piece.way for piece in (down, first, second)] == [1000 - 160, 1500 - 160, 1500 - 160]
    follower = Follower(scene, found, SPEED, LAG)
    follower._first = follower._last = 5
    follower._place = first.start
    # By the corner at X60.
    way = max(abs(a - b) for a, b in zip(arc.end, arc.start, strict=True))
    assert abs(follower._straight(7, []) - (3000 - 80 + way - 160)) < 1
    home = [piece for piece in found if piece.line == 10]
    whole = max(abs(a - b) for a, b in zip(home[0].start, home[0].end, strict=True))
    assert [piece.way for piece in home] == [0] * (len(home) - 1) + [whole - 160]
    assert min(piece.low[0] for piece in home) == scene.place(START)[0] - 80
    assert max(piece.high[2] for piece in home) == scene.place(START)[2] + 80


def test_braking_shortens_each_hold(program):
    scene = scene_of(program)
    found = cut(scene)
    late, early = (Follower(scene, found, SPEED, LAG, braking) for braking in (Fraction(0), Fraction(2)))
    assert late.hold(3) - early.hold(3) == 20


class Clock:
    """Of which each answer takes some time."""

    def __init__(self, *takes):
        self.time, self.takes, self.holds = 0.0, iter(takes), []

    def now(self):
        return self.time

    def permit(self, translation, margin, hold, *_):
        self.holds.append(hold)
        self.time += next(self.takes)
        return True


def test_an_answer_is_late_after_the_lag_or_when_go_may_have_ended(program):
    scene = scene_of(program)

    def late(clock, longest=200, position=START):
        follower = Follower(scene, cut(scene), SPEED, LAG)
        with pytest.raises(LateError) as error:
            follow(follower, clock.permit, lambda: (position, clock.time), clock.now, longest)
        return follower, str(error.value)

    follower, said = late(Clock(0.01, 0.02, 0.0201))
    assert "an answer came 0.0201 s after its position, --lag is 0.02 s" in said and follower.permitted == 2
    # What was permitted for 12 ms is renewed within 12 ms of having been asked for.
    clock = Clock(0.01, 0.0121)
    assert "was not renewed within its time" in late(clock, 12)[1]
    assert clock.holds == [12, 12]
    # Where the way allows no more, what is left of the hold before, less the lag.
    follower, clock = Follower(scene, cut(scene), SPEED, LAG), Clock(0.01, 0.01, 0.01)
    ways_left = iter([80, 0, 0, 0])
    follower.hold = lambda number: 0 if number < follower.permitted else next(ways_left)
    with pytest.raises(LateError, match=r"may be at the end of what is permitted sooner than in the 0.02 s"):
        follow(follower, clock.permit, lambda: (START, clock.time), clock.now, 200)
    assert clock.holds == [80, 50, 20]


def moving(program, work, top, stalls=0.0, cut=cut):
    """Return a follower, what it asks, a simulated tool, and a line's clock."""
    scene = scene_of(program, work)
    board = Board(SimulatedLine(SimulatedWire(top, CLOCKS_PER_SECOND)))
    board.hello()
    engine = BoardEngine(board, scene.a, scene.b)
    engine.load()
    tool = SimulatedTool(scene.program, SPEED * 98 / 100, board._line.now, lambda: top.go)
    follower = Follower(scene, cut(scene), SPEED, LAG)

    def permit(translation, margin, hold, *zones):
        if follower.permitted == 5:
            board._line.wait(stalls)
        return engine.permit(translation, margin, hold, *zones)

    return SimpleNamespace(
        follower=follower, permit=permit, tool=tool, now=board._line.now, scene=scene, engine=engine
    )


@pytest.mark.simulator
def test_a_machine_goes_through_the_program_without_a_stop(program, top):
    case = moving(program, FLOOR, top)
    done = follow(case.follower, case.permit, case.tool.report, case.now, 200)
    assert (done.near, done.permitted) == (None, len(case.follower.pieces))
    # It stood still for no more than until the first answer.
    length = sum(
        move.length
        if move.curve
        else float(max(abs(b - a) for a, b in zip(move.start, move.end, strict=True)))
        for move in case.scene.program.moves
    )
    assert top.go_clocks >= length / float(SPEED) * CLOCKS_PER_SECOND


@pytest.mark.simulator
def test_a_machine_is_stopped_before_what_is_near(program, top):
    case = moving(program, np.concatenate([FLOOR, POST]), top)
    done = follow(case.follower, case.permit, case.tool.report, case.now, 200)
    assert done.near and done.near.line == 4 and not top.go
    # It is asked about ahead: the tool has not come to the post, which begins at X50.
    place, _ = case.tool.report()
    assert place[0] + 3 < 50


@pytest.mark.simulator
@pytest.mark.parametrize(
    ("lines", "work", "all_said"),
    [(ZONED, BESIDE, {(0, 0), (1, 0), (1, 1)}), (RAPID, FLOOR, {(0, 0), (1, 0), (1, 1)})],
    ids=["post", "rapid"],
)
def test_the_board_says_by_pins_that_the_tool_is_beyond_a_zone(lines, work, all_said, program, top):
    program.write_text(lines)
    case = moving(program, work, top, cut=cut_for_both)
    said, told, asked, pins = set(), [], [], 0
    top.note()

    def report():
        nonlocal pins
        here = case.tool.report()
        for event in top.events():
            pins = int(event["value"]) if event["kind"] == PINS else pins
        beyond = [bool(pins >> bit & 1) for bit in (18, 19)]
        assert top.go or not any(beyond)
        away = here and apart(case.scene, here[0])
        assert away is None or all(away > width for width, says in zip(ZONES, beyond, strict=True) if says)
        # What was asked of what was permitted last, and no more than the host says.
        assert not asked or not top.go or beyond == [width > 0 for width in asked[-1]]
        assert sum(beyond) <= (told[-1] if told else 0)
        said.add(tuple(beyond))
        return here

    def permit(translation, margin, hold, zones):
        asked.append(zones)
        return case.permit(translation, margin, hold, zones)

    done = follow(
        case.follower, permit, report, case.now, 200, ahead=lambda _, beyond, __: told.append(beyond)
    )
    assert (done.near, done.permitted) == (None, len(case.follower.pieces))
    assert said == all_said
    # The rapid is beyond both, part by part, and the board is asked about the first.
    assert ((2, 1) in {(one.beyond, len(one.zones)) for one in case.follower.pieces}) == (lines == RAPID)


# What the host has wrong of a piece, or of a rapid that it has seen part by part; what the board's flags are.
DISAGREEING = {
    "claim": "something in zones that it must be beyond: WARN",
    "parts": "something in zones that it must be beyond: WARN",
    "set": "flags 0x31 of zones within",
    "clear": "flags 0x01 of zones within",
}


@pytest.mark.simulator
@pytest.mark.parametrize("planted", DISAGREEING)
def test_a_board_that_disagrees_about_a_zone_ends_it(planted, program, top, monkeypatch):
    lines, work = (RAPID, FLOOR) if planted == "parts" else (ZONED, BESIDE)
    program.write_text(lines)
    case = moving(program, work, top, cut=cut_for_both)
    found = case.follower.pieces
    # One that the host may not ask about, as the board does not find it beyond both.
    number = next(number for number, piece in enumerate(found) if len(piece.zones) < 2)
    if planted == "set":
        number -= 1
    assert found[number].beyond == (2 if planted in ("parts", "set") else 1)
    if planted in ("claim", "parts"):
        wrong = replace(found[number], zones=own_zones(case.scene, found[number]), beyond=2)
        case.follower.pieces = (*found[:number], wrong, *found[number + 1 :])
    else:
        real = Board.run

        def altered(board, *words, **more):
            run = real(board, *words, **more)
            if case.follower.permitted < number:
                return run
            flags = run.status.flags & ~ZONE_FLAGS
            return replace(
                run, status=replace(run.status, flags=flags | (ZONE_FLAGS if planted == "set" else 0))
            )

        monkeypatch.setattr(Board, "run", altered)
    with pytest.raises(LinkError, match=f"contradicts itself or us: {DISAGREEING[planted]}"):
        follow(case.follower, case.permit, case.tool.report, case.now, 200)
    assert case.follower.permitted == number
    # Nobody asks any more: what was permitted is over in its time.
    top.step(300 * PARAMETERS.hold_clocks)
    assert not top.go


@pytest.mark.simulator
def test_what_is_late_stops_the_machine(program, top):
    case = moving(program, FLOOR, top, stalls=0.4)
    before = top.go_clocks
    with pytest.raises((LateError, LinkError), match=r"stop|--lag"):
        follow(case.follower, case.permit, case.tool.report, case.now, 200)
    top.step(300_000)
    assert not top.go and top.go_clocks > before


def test_a_tool_where_it_may_not_be_and_pieces_too_short(program):
    scene = scene_of(program)
    follower = Follower(scene, cut(scene), SPEED, LAG)
    with pytest.raises(
        StrayedError, match="at X0 Y0 Z9, where it is not permitted to be now, in lines 2 to 2"
    ):
        follower.moved(vector(map(Fraction, (0, 0, 9))))
    hurried = Follower(scene, cut(scene), Fraction(100_000), LAG)
    with pytest.raises(
        LateError, match=r"line 2: .* in the 0.02 s that an answer may take: begin with a longer move"
    ):
        follow(hurried, lambda *_: True, lambda: (START, 0.0), lambda: 0.0, 200)
    assert follower.hold(len(follower.pieces) - 1) == LONGEST


def test_nothing_is_asked_after_a_position_that_is_late(program):
    """Go would begin of where the tool no longer is; and nobody is told of what was not in time."""
    scene, asked, seen = scene_of(program), [], []
    follower = Follower(scene, cut(scene), SPEED, LAG)
    times = iter([0.0, float(LAG) + 0.001, *[float(LAG) + 0.002] * 9])

    def permit(*run):
        asked.append(run)
        return True

    report = lambda: (START, next(times))  # noqa: E731
    with pytest.raises(LateError, match="after its position"):
        follow(follower, permit, report, lambda: next(times), 200, lambda *told: seen.append(told))
    assert (asked, seen, follower.permitted) == ([], [], 0)
    # Nor after one that is late when its zone has been told.
    clock = Clock(0.0)

    def ahead(*_):
        clock.time += float(LAG) + 0.001

    with pytest.raises(LateError, match="after its position"):
        follow(follower, permit, lambda: (START, clock.time), clock.now, 200, ahead=ahead)
    assert asked == []
