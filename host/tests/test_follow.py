"""A machine is followed through a program: where it may be, for how long, and what stops it."""

import os
import shutil
import subprocess
import tempfile
import threading
import time
from contextlib import nullcontext
from copy import copy
from dataclasses import replace
from fractions import Fraction
from functools import partial
from itertools import count, pairwise, product
from pathlib import Path
from types import SimpleNamespace
from xml.etree import ElementTree

import numpy as np
import pytest
from filelock import FileLock

from triaxis.golden.errors import InputError
from triaxis.golden.exact import Rational
from triaxis.host import scenes
from triaxis.host.cli import engine as engine_module
from triaxis.host.cli import follow as follow_module
from triaxis.host.cli import main
from triaxis.host.cli.engine import checkout_id
from triaxis.host.engines import BULK, scene_engine
from triaxis.host.link import hal as hal_module
from triaxis.host.link import positions
from triaxis.host.link.board import Board
from triaxis.host.link.board_engine import BoardEngine
from triaxis.host.link.exchange import LinkError
from triaxis.host.link.hal import HalPositions
from triaxis.host.link.messages import ZONES as ZONE_FLAGS
from triaxis.host.link.positions import Positions
from triaxis.host.motion.follow import (
    LONGEST,
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
from triaxis.host.tests.published import read_published
from triaxis.sim.board_parameters import BoardParameters
from triaxis.sim.pseudo_terminal import ServedBoard, Wire
from triaxis.sim.simulated_board import PINS, SimulatedTop
from triaxis.sim.simulated_line import SimulatedLine, SimulatedWire

PROGRAM = """G21 G90 G64 P0.4
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
RAPID = "G21 G90 G64 P0.4\nG0 X30 Y25 Z20\nG1 Z11 F1000\nG0 X60 Y26\nG1 Z1.5\nZ40\n"
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
        follower = Follower(scene, found, SPEED, LAG)
        follower.permitted = len(found)
        assert not follower.at_the_end
        for move in scene.program.moves:
            for place in ways(move, rng):
                follower.moved(vector(c + d for c, d in zip(place, off_path(move, rng), strict=True)))
        # It ends where it began.
        assert follower.at_the_end


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
        follower = Follower(scene, found, SPEED, LAG)
        follower.permitted = len(found)
        # Of a move of 40 mm the next of the 201 places is at most so far.
        if min(apart) > float(SLACK) + 0.2:
            with pytest.raises(StrayedError, match="where it is not permitted to be now"):
                follower.moved(vector(Fraction(float(c)) for c in place))
            stopped += 1
    assert stopped > 100


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
    scene = scene_of(path)
    moves = tuple(replace(move, slack=Fraction(1, 100)) for move in scene.program.moves)
    scene = replace(scene, program=replace(scene.program, moves=moves))
    follower = Follower(scene, cut(scene), SPEED, LAG)
    follower.permitted = len(follower.pieces)
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


def test_a_margin_of_a_zone_that_the_board_does_not_have_is_refused_before_the_start(program):
    found = cut_for_zones(scene_of(program, BESIDE))
    most = max(width for piece in found for width in piece.zones)
    bits = most.bit_length()
    follow_module._check_zones(found, bits)
    with pytest.raises(InputError, match=f"a margin of {most} steps: the board's has {bits - 1} bits"):
        follow_module._check_zones(found, bits - 1)
    follow_module._check_zones(cut(scene_of(program)), 0)


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

    follow(follower, permit, tool.report, clock.now, 200, ahead=lambda _, beyond: told.append(beyond))
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


@pytest.fixture
def top():
    with SimulatedTop(PARAMETERS) as board:
        yield board
        assert board.bad_clocks == 0


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

    done = follow(case.follower, permit, report, case.now, 200, ahead=lambda _, beyond: told.append(beyond))
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


HAL = """loadrt threads name1=servo period1=1000000
loadrt sampler depth=1000 cfg=fff
addf sampler.0 servo
setp sampler.0.pin.0 12.5
setp sampler.0.pin.1 -0.125
setp sampler.0.pin.2 1e3
start
loadusr -w halsampler -n 3
"""


@pytest.mark.skipif(shutil.which("halrun") is None, reason="LinuxCNC is not installed (linuxcnc-uspace)")
def test_what_halsampler_writes_is_understood():
    with tempfile.TemporaryDirectory() as folder:
        script = Path(folder, "sample.hal")
        script.write_text(HAL)
        # As root it asks for whom it is to run, who writes into the folder.
        Path(folder).chmod(0o777)
        environment = {**os.environ, "RTAPI_UID": "65534", "HOME": folder}
        command = ["halrun", "-f", script]
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    if done.returncode:
        pytest.skip(f"LinuxCNC's HAL does not start here: {done.stderr}")
    report = Positions(piped(done.stdout)).report()
    assert report and report[0] == (Fraction(25, 2), Fraction(-1, 8), 1000)


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("1 2 3\noverrun\n1 2 3\n", "position 'overrun': must be X Y Z in mm"),
        ("1 2 3 4 5\n", "must be X Y Z"), ("1 2 3 4.5\n", "must be X Y Z"),
        ("1 2 3 4 5 6 x\n", "must be X Y Z"),
        ("1 2 1e999999999\n", "must be X Y Z"), ("1 2 1e400\n", "must be X Y Z"),
        ("1 2 x\n", "must be X Y Z"), ("1 2 1/0\n", "must be X Y Z"),
        ("1 2 \ufffd\n", "must be X Y Z"),
    ],
)  # fmt: skip
def test_lines_that_are_no_positions_are_refused(text, what):
    positions = Positions(piped(text))
    with pytest.raises(InputError, match=what):
        while positions.report():
            pass


def lines_of(end):
    """Return all that comes from an open file, which stays open."""
    with os.fdopen(os.dup(end), encoding="utf-8") as lines:
        return lines.read().splitlines(True)


def piped(text):
    """Return the end of a pipe that all of it is in, and nothing more comes."""
    end, start = os.pipe()
    with os.fdopen(start, "w", encoding="utf-8") as pipe:
        pipe.write(text)
    return end


def test_of_positions_that_waited_the_last_is_taken():
    """As where this process was stopped meanwhile: with a time before it was read, and of none before it."""
    end, start = os.pipe()
    os.write(start, b"".join(b"%d 0 0\n" % number for number in range(3000)) + b"9999 0")
    begun = time.monotonic()
    positions = Positions(end)
    first, since = positions.report() or pytest.fail("none")
    assert first == (2999, 0, 0) and begun <= since <= time.monotonic()
    os.write(start, b" 1\n")
    while (last := (positions.report() or pytest.fail("none"))[0]) == first:
        pass
    assert last == (9999, 0, 1)
    os.close(start)


def test_a_line_without_an_end_is_no_position(monkeypatch):
    monkeypatch.setattr(positions, "_PART", 100)
    with pytest.raises(InputError, match="a line without an end"):
        Positions(piped("1" * 150)).report()


def test_a_position_that_is_cut_off_is_none():
    positions = Positions(piped("1 2 3\n10 20 3"))
    while report := positions.report():
        assert report[0] == (1, 2, 3)


TOOLS = """rapids = "straight"
loaded = 1
[[tools]]
number = 1
length = 0
parts = [{ diameter = 2, length = 9 }]
[[tools]]
number = 2
length = 0
parts = [{ diameter = 4, length = 9 }]
"""
CUTTERS = TOOLS.replace("length = 9 }", "length = 9, cuts = true }, { diameter = 9, length = 20 }")


@pytest.mark.long
@pytest.mark.simulator
def test_tools_are_followed_one_after_the_other(top, tmp_path, capsys, monkeypatch):
    machine, work, program, report = (tmp_path / name for name in ("m.toml", "w.stl", "p.nc", "r.json"))
    machine.write_text(TOOLS)
    scenes.write_stl(work, FLOOR)
    program.write_text("G21 G90 G61\nG0 X10\nT2 M6\nG1 X20 F1000\n")
    positions = tmp_path / "positions"
    ticks = count()
    clock = SimpleNamespace(monotonic=lambda: next(ticks) / 400)
    monkeypatch.setattr(follow_module, "time", clock)
    # As a control would: the next line when the last has been looked at.
    monkeypatch.setattr(follow_module, "Positions", lambda end: Steps(lines_of(end)))
    with ServedBoard(top, Wire()) as served:

        def run(lines, *words):
            positions.write_text("\n".join(lines) + "\n")
            where = () if words else ("--positions", str(positions))
            arguments = [str(machine), str(work), str(program), "--port", served.path, *where, *words]
            arguments += ["--speed", "100", "--lag", "50", "--hold", "500", "--start", "0", "0", "40"]
            arguments += ["--json", str(report), "--skip-self-test"]
            arguments += [] if "--stock" in words else ["--surfaces-only"]
            status = main(["board", "follow", *arguments])
            return status, capsys.readouterr()

        status, said = run([], "--simulate")
        assert status == 0 and "with tool 2 from line 4 on" in said.out, said.err
        first = [f"{x} 0 40 1" for x in (0, 4, 8, 10, 10, 10, 10)]
        # Away to change it, back with the old one, and only then with the new one.
        away = ["10 0 200 1", "10 0 200 0", "10 0 200 2", "10 0 40 2"]
        second = [f"{x} 0 40 2" for x in (10, 14, 18, 20, 20, 20, 20)]
        status, said = run([*first, *away, *second])
        assert (status, said.err) == (0, "") and "FOLLOWED: to the end of the program" in said.out
        assert read_published(report, "follow")["verdict"] == "followed"
        for lines, status, what in (
            ([*first, *away[:3]], 1, "ENDED"),
            ([first[0], "4 0 40"], 2, "positions must say which one is in the spindle"),
            ([*first, *["10 0 40"] * 2], 2, "positions must say which one is in the spindle"),
            ([*first[:2], "8 0 40 2"], 2, "tool 2 is in the spindle, and not 1"),
            ([*first, *away, *second[:2], "18 0 60 2"], 2, "where it is not permitted to be"),
            # Off the path, at its start, by as much as it may be, and by more.
            (["-0.01 0 40 1", *first[1:], *away[:3]], 1, "ENDED"),
            (["-0.02 0 40 1"], 2, "where it is not permitted to be"),
        ):
            found, said = run(lines)
            assert found == status and what in said.out + said.err, (lines, said)
        # What ends with a change of the tool ends before it, with stop.
        whole = program.read_text()
        program.write_text("G21 G90 G61\nG0 X10\nT2 M6\nM30\n")
        status, said = run([*first, "10 0 40 1", "10 0 40 2"])
        assert (status, said.err) == (0, "") and "FOLLOWED: to the end" in said.out and top.stop
        # The cutter may be in the stock where it feeds, the shank never, and neither of them on a rapid.
        machine.write_text(CUTTERS)
        scenes.write_stl(tmp_path / "blank.stl", scenes.box((5, -9, 10), (30, 9, 30)))
        picture = tmp_path / "near.svg"
        for lines, near in (
            ("G0 X2 Y0 Z32\nG1 X9 Z26 F900\nX20\nG0 Z40\nT2 M6\nG0 X0", (None, None, None)),
            ("G0 X2 Y0 Z32\nG1 X9 Z26 F900\nG0 X20", (4, "the cutter", "the stock")),
            ("G0 X9 Y0\nG1 Z25 F900\nZ19", (4, "the tool's body", "the stock")),
            # By another tool, which was not there.
            ("G0 X9 Y0\nG1 Z25 F900\nT2 M6\nG0 Z28", (5, "the cutter", "the stock")),
        ):
            program.write_text(f"G21 G90 G61\n{lines}\n")
            picture.write_bytes(b"old")
            words = ["--stock", str(tmp_path / "blank.stl"), "--length", "0.5", "--picture", str(picture)]
            status, said = run([], "--simulate", *words)
            # What was there before is never taken for what was found now.
            assert picture.exists() == (status == 1)
            if status:
                drawn = " ".join(ElementTree.fromstring(picture.read_text()).itertext())
                assert f"p.nc: stopped before line {near[0]}: {near[1]} comes near {near[2]}" in drawn
            found = read_published(report, "follow")
            assert (found["line"], found["what"], found["of"]) == near, said
            assert status == int(near[0] is not None) and "what is cut away is not tracked" in said.out
            assert found["stock"] == [str(tmp_path / "blank.stl")]
        machine.write_text(TOOLS)
        status, said = run([], "--simulate", "--stock", str(tmp_path / "blank.stl"))
        assert status == 2 and "nobody said what of it cuts" in said.err
        program.write_text(whole)
        # Tool 0 is one as all others.
        machine.write_text(TOOLS.replace("= 1\n", "= 0\n"))
        for lines in (program.read_text(), "G21 G90 G61\nG0 X10\n"):
            program.write_text(lines)
            found, said = run(["0 0 40 2"])
            assert found == 2 and "tool 2 is in the spindle, and not 0" in said.err, said
    assert top.stop


OBJECTS = """rapids = "straight"
loaded = 1
[offsets]
G54 = [0.0, 0.0, -250.0]
[[tools]]
number = 1
length = 50
mesh = "tool.stl"
[[objects]]
name = "bed"
mesh = "post.stl"
[[objects]]
name = "saddle"
axis = "-Y"
[[objects]]
name = "table"
on = "saddle"
axis = "-X"
mesh = "table.stl"
[[objects]]
name = "head"
axis = "Z"
mesh = "head.stl"
at = [0.0, 0.0, 250.0]
[spindle]
on = "head"
nose = [0.0, 0.0, 250.0]
[workpiece]
on = "table"
"""


@pytest.mark.long
@pytest.mark.simulator
def test_objects_are_on_the_board_or_shown_clear_before(top, tmp_path, capsys, monkeypatch):
    machine, work, program, report = (tmp_path / name for name in ("m.toml", "w.stl", "p.nc", "r.json"))
    for name, corners in {
        "tool": ((-3, -3, 0), (3, 3, 50)), "table": ((-50, -50, -10), (50, 50, 0)),
        "post": ((60, -5, -30), (70, 5, 60)), "head": ((-40, -40, 0), (65, 40, 60)),
        "w": ((-20, -20, 0), (-10, 20, 70)),
    }.items():  # fmt: skip
        scenes.write_stl(tmp_path / f"{name}.stl", scenes.box(*corners))
    ticks = count()
    monkeypatch.setattr(follow_module, "time", SimpleNamespace(monotonic=lambda: next(ticks) / 400))
    with ServedBoard(top, Wire()) as served:

        def run(lines, text=OBJECTS, words=()):
            machine.write_text(text)
            program.write_text(f"G21 G90 G61 G43 H1 F1000\n{lines}\n")
            arguments = [str(machine), str(work), str(program), "--port", served.path, "--simulate"]
            arguments += ["--speed", "100", "--lag", "50", "--hold", "500", "--start", "0", "0", "150"]
            status = main(["board", "follow", *arguments, *words, "--json", str(report), "--skip-self-test"])
            found = read_published(report, "follow")
            return status, (found.get("line"), found.get("what"), found.get("of")), capsys.readouterr()

        status, near, said = run("G0 Z30\nX5 Y5\nG1 X-3")
        assert (status, near, said.err) == (0, (None, None, None), "")
        # By X and Y, of which the board knows nothing; by Z; and by all three, which it is asked about.
        for lines, near, (axis, where) in (
            ("G0 Z60\nX-9.6", (3, "the bed", "the table"), (0, -9.55)),
            ("G0 Z60\nX60\nZ10.4", (4, "the bed", "the head"), (2, 10.45)),
            ("G0 Z30\nG1 Z20.4", (3, "the head", "the workpiece"), (2, 20.45)),
        ):
            status, found, said = run(lines)
            assert (status, found) == (1, near), said
            assert (
                f"NEAR: line {near[0]}: the machine was stopped before it, where {near[1]} comes" in said.out
            )
            place = read_published(report, "follow")["position"]
            assert abs(place[axis] - where) < 3 and f"about X{place[0]:.4f} Y{place[1]:.4f} Z" in said.out
        # The bed and the table are 2 mm apart at X-8, 5 at X-5, which is a piece by itself.
        for lines, within in (("G0 Z90\nG1 X-5\nX-8", [4]), ("G0 Z90\nG1 X-5", [])):
            status, _, said = run(lines, words=["--slow", "3"])
            (zone,) = read_published(report, "follow")["zones"]
            assert (status, zone["within"], zone["lines"]) == (0, 3, within), said
            assert zone["pieces"] == len(within) == said.out.count("zone: slow, line 4")
        # What may touch something on the board is looked at beside it, against all else.
        touching = OBJECTS.replace("[spindle]", 'may_touch = ["workpiece"]\n[spindle]')
        for lines, near in (("G0 Z30\nG1 Z20.4", None), ("G0 Z60\nX60\nZ10.4", (4, "the bed", "the head"))):
            status, found, said = run(lines, touching)
            assert (status, found) == (int(near is not None), near or (None, None, None)), said
        scenes.write_stl(tmp_path / "post.stl", scenes.box((200, 200, 0), (201, 201, 1)))
        status, found, said = run("G0 X60\nZ-49.6", touching)
        assert (status, found) == (1, (3, "the table", "the head")), said
        # A table that has a bed inside it.
        scenes.write_stl(tmp_path / "post.stl", scenes.box((-5, -5, -7), (5, 5, -3)))
        status, found, said = run("G0 Z60")
        assert status == 1 and "NEAR: of the bed and the table one is inside the other" in said.out
    assert top.stop


TURNING = OBJECTS.replace("loaded = 1", "loaded = 1\nturn_tolerance = 0.01").replace(
    'name = "table"\non = "saddle"\naxis = "-X"',
    'name = "slide"\non = "saddle"\naxis = "-X"\n[[objects]]\nname = "table"\non = "slide"\naxis = "C"\n'
    "pivot = [0.0, 0.0, 0.0]",
)
OBJECTS_WITHOUT = TURNING.replace("turn_tolerance = 0.01", "")


@pytest.mark.long
@pytest.mark.simulator
def test_between_turns_a_machine_is_followed_by_what_stands_then(top, tmp_path, capsys, monkeypatch):
    machine, work, program, report = (tmp_path / name for name in ("m.toml", "w.stl", "p.nc", "r.json"))
    for name, corners in {
        "tool": ((-3, -3, 0), (3, 3, 50)), "table": ((-50, -50, -10), (50, 50, 0)),
        "post": ((60, -5, -30), (70, 5, 60)), "head": ((-40, -40, 0), (40, 40, 60)),
        "w": ((-20, -20, 0), (-10, 20, 70)),
    }.items():  # fmt: skip
        scenes.write_stl(tmp_path / f"{name}.stl", scenes.box(*corners))
    ticks, places = count(), tmp_path / "positions"
    monkeypatch.setattr(follow_module, "time", SimpleNamespace(monotonic=lambda: next(ticks) / 400))
    went = list[float | str]()

    class Watched(Steps):
        """Positions, of which C is kept."""

        def report(self):
            """Return the next."""
            here = super().report()
            assert self.angles
            went.append(float(self.angles[2]))
            return here

    def watched(of, name):
        real = getattr(of, name)
        monkeypatch.setattr(of, name, lambda *words: went.append(name) or real(*words))

    watched(BoardEngine, "permit")
    watched(Board, "abort")
    monkeypatch.setattr(follow_module, "Positions", lambda end: Watched(lines_of(end)))
    with ServedBoard(top, Wire()) as served:

        def run(lines, positions=None, text=TURNING):
            machine.write_text(text)
            program.write_text(f"G21 G90 G61 G43 H1 F1000\n{lines}\n")
            where = ["--simulate"]
            if positions is not None:
                places.write_text("".join(f"{x} {y} {z} 1 0 0 {c}\n" for x, y, z, c in positions))
                where = ["--positions", str(places)]
            arguments = [str(machine), str(work), str(program), "--port", served.path, *where]
            arguments += ["--speed", "100", "--lag", "50", "--hold", "500", "--start", "0", "0", "150"]
            arguments += ["--json", str(report), "--skip-self-test", "--length", "0.5"]
            went.clear()
            status = main(["board", "follow", *arguments])
            found = read_published(report, "follow")
            return status, (found.get("line"), found.get("what"), found.get("of")), capsys.readouterr()

        status, near, said = run("G0 Z30\nC20\nG1 X5\nC0\nX0")
        assert (status, near, said.err) == (0, (None, None, None), ""), said
        assert all(f"line {line} on, at C{angle}\n" in said.out for line, angle in ((2, 0), (4, 20), (6, 0)))
        down = [(0, 0, z, 0) for z in range(100, 29, -1)]
        turn = [(0, 0, 30, c) for c in (5, 12, 19.98)]
        right = [(x, 0, 30, 20) for x in (0, 1, 2, 3, 4, 5)]
        status, _, said = run("G0 Z30\nC20\nG1 X5", [*down, *turn, *right, *right[-1:] * 3])
        assert (status, said.err) == (0, "") and "FOLLOWED" in said.out, (said.err, went)
        # Go is ended before it turns, and nothing permitted before the angle is there.
        end = went.index("abort")
        assert went[end - 1 : end + 7] == [0, "abort", 5, 12, 19.98, 20, 20, "permit"]
        # What ends with a turn ends before it, with stop.
        status, _, said = run("G0 Z30\nC20", [*down, *[(0, 0, 30, 0)] * 3, *turn])
        assert (status, said.err, went[-1]) == (0, "", "abort") and "FOLLOWED" in said.out, (said.err, went)
        # A part that ends where it begins is not over before it has begun; looked at three times before it.
        there = [(x, 0, 30, 20) for x in (0, 0, 0, 0, 3, 7, 12, 16, 13, 9, 4, 0, 0, 0)]
        last = [(x, 0, 30, 40) for x in (0, 2, 4, 5, 5, 5)]
        positions = [*down, *turn, *there, (0, 0, 30, 30), *last]
        bare = TURNING.replace('mesh = "table.stl"', "")
        status, _, said = run("G0 Z30\nC20\nG1 X16\nX0\nC40\nG1 X5", positions, bare)
        first, second, *_ = (number for number, what in enumerate(went) if what == "abort")
        assert went[first:second].count("permit") > 9, went
        assert (status, said.err) == (0, "") and "FOLLOWED" in said.out, (said.out, said.err, went)
        for positions, status, what in (
            ([*down[:4], (0, 0, 96, 0.02)], 2, "axes are at C0.02, not at C0; the machine is stopped"),
            ([*down, *turn[:2], (1, 0, 30, 12)], 1, "ENDED"),
            ([*down, *turn, *right[:2], (2, 0, 30, 19)], 2, "axes are at C19, not at C20"),
            ([*down, *turn, *right[:2], (2, 5, 30, 20)], 2, "where it is not permitted to be"),
        ):
            found, _, said = run("G0 Z30\nC20\nG1 X5", positions)
            assert found == status and what in said.out + said.err, (positions, said)
        # In a stand the workpiece is where it has turned to, in one before not.
        for lines, near in (
            ("G0 Z30\nG1 Y9\nY-8", None), ("G0 Z30\nC90\nG1 Y9\nY-8", (5, "the tool", "the workpiece")),
            ("G0 Z30\nG1 X9\nX-8", (4, "the tool", "the workpiece")), ("G0 Z30\nC90\nG1 X9\nX-8", None),
            # A table that turns comes near a post; the tool has not moved yet; or is not to come so far.
            ("G0 C45\nZ30", (2, "the bed", "the table")), ("G0 Z90\nX1\nC45", (4, "the bed", "the table")),
            ("G0 Z30\nG1 X9\nX-6\nC18\nX0", (5, "the tool", "the workpiece")),
        ):  # fmt: skip
            text = bare if "C90" in lines else TURNING
            status, found, said = run(lines, text=text)
            assert (status, found) == (int(near is not None), near or (None, None, None)), (lines, said)
        tool = TURNING[TURNING.index("[[tools]]") : TURNING.index("[[objects]]")]
        two = TURNING.replace(tool, tool + tool.replace("number = 1", "number = 2"))
        # The table is 1 mm from the post, and would be within it at C25.
        for tolerance, near in ((0.01, None), (3, (5, "the bed", "the table"))):
            text = TURNING.replace("turn_tolerance = 0.01", f"turn_tolerance = {tolerance}")
            status, found, said = run("G0 Z90\nX30\nC22\nG1 X-3", text=text)
            assert (status, found) == (int(near is not None), near or (None, None, None)), said
        for lines, what, text in (
            ("G0 X5 C5\nC9\nG1 X9 C3", "line 2, 4: A, B, C turn while X, Y, Z move", TURNING),
            ("G0 C30\nC0\nX1", "line 3: the angles at the end of this turn are passed", TURNING),
            ("G0 C0.015\nX1", "line 2: the angles at the end of this turn are passed, or nearly", TURNING),
            ("G0 C20", "no line moves X, Y or Z", TURNING),
            ("G0 Z30\nT2 M6 G43 H2\nC90\nT1 M6 G43 H1\nC0\nX5", "line 7: the same tool and angles", two),
            ("G0 X1", "turn_tolerance: say by how many degrees C may be off", OBJECTS_WITHOUT),
        ):
            status, _, said = run(lines, text=text)
            assert status == 2 and what in said.err, said
    assert top.stop


class Steps(follow_module.Positions):
    """Positions of which each is looked at once, in their order."""

    def __init__(self, lines):
        """Take them; no thread reads them."""
        self._steps = iter(lines)

    def wait(self, seconds):
        """There is one, or none will come."""
        return True

    def report(self):
        """Return the next."""
        line = next(self._steps, None)
        if line is None:
            return None
        position, self.tool, self.angles = positions.read_position(line)
        return position, follow_module.time.monotonic()


class Shown:
    """A page that keeps what it is told."""

    address = "http://here/"

    def __init__(self, shown, port):
        """Begin."""
        self._shown = shown

    def show(self, tool, work, ends, title):
        """Keep it."""
        self._shown.append((tool, ends, title))

    def tell(self, **changes):
        """Keep it."""
        self._shown.append(changes)


def says_late(fifo):
    with fifo.open("w") as lines:
        time.sleep(2)
        lines.write("0 0 40\n")


@pytest.mark.simulator
def test_the_command_follows_positions_and_says_how_far(program, top, tmp_path, capsys, monkeypatch):
    tool, work = tmp_path / "tool.stl", tmp_path / "work.stl"
    for path, facets in ((tool, TOOL), (work, FLOOR)):
        record = np.zeros(len(facets), [("normal", "<f4", 3), ("facet", "<f4", (3, 3)), ("attribute", "<u2")])
        record["facet"] = facets
        path.write_bytes(bytes(80) + len(facets).to_bytes(4, "little") + record.tobytes())
    positions, report = tmp_path / "positions", tmp_path / "report.json"
    always = ["--speed", "100", "--lag", "50", "--hold", "500", "--start", "0", "0", "40"]
    # A clock that knows nothing of how busy the machine is.
    ticks = count()
    clock = SimpleNamespace(monotonic=lambda: next(ticks) / 400)
    monkeypatch.setattr(follow_module, "time", clock)
    with ServedBoard(top, Wire()) as served:

        def run(*words):
            arguments = [str(tool), str(work), str(program), "--port", served.path, *always, *words]
            status = main(["board", "follow", *arguments, "--json", str(report), "--skip-self-test"])
            return status, capsys.readouterr()

        shown = []
        monkeypatch.setattr(follow_module, "Page", partial(Shown, shown))
        status, said = run("--simulate", "--surfaces-only", "--page", "0")
        assert (status, said.err) == (0, "") and "FOLLOWED: to the end of the program" in said.out
        assert "page: http://" in said.out
        (facets, ends, title), *told = shown
        assert np.array_equal(facets, TOOL) and title == f"{tool} along {program.name}"
        assert ends[0].tolist() == [0, 0, 40] and all(one["verdict"] == "clear" for one in told)
        assert [one["asked"] for one in told] == [*range(1, len(told) + 1)]
        assert told[-1]["permitted"] == len(ends) - 1 and told[-1]["position"] == pytest.approx([0, 0, 40])
        # It comes down to 10 mm above the floor.
        shown.clear()
        zones = ["--slow", "12", "--warn", "17", "--hold", "60", "--lag", "20"]
        status, said = run("--simulate", "--surfaces-only", "--page", "0", *zones)
        assert (status, said.err) == (0, "") and "within 12 mm, or nearly: " in said.out
        told = [one["zone"] for one in shown[1:] if "zone" in one]
        assert told == ["free", "warn", "slow", None], told
        assert [line.split()[1] for line in said.out.splitlines() if line.startswith("zone: ")] == [
            "free,",
            "warn,",
            "slow,",
            "unknown",
        ]
        slow, warn = read_published(report, "follow")["zones"]
        assert 0 < slow["pieces"] < warn["pieces"] and {4, 5, 10} <= set(slow["lines"]) <= set(warn["lines"])
        positions.write_text("0 0 40\n0 0\n")
        shown.clear()
        run("--positions", str(positions), "--surfaces-only", "--page", "0")
        assert "must be X Y Z" in shown[-1]["stopped"]
        positions.write_text("0 0 40\n0 0 39.5\n")
        status, said = run("--positions", str(positions), "--surfaces-only")
        assert status == 1 and "ENDED: the positions ended before the program did" in said.out
        # Silence for longer than the watchdog's time, before the machine starts.
        fifo = tmp_path / "fifo"
        os.mkfifo(fifo)
        control = threading.Thread(target=says_late, args=(fifo,))
        control.start()
        status, said = run("--positions", str(fifo), "--surfaces-only")
        control.join()
        assert (status, said.err) == (1, "")
        positions.write_text("0 0\n")
        status, said = run("--positions", str(positions), "--surfaces-only")
        assert status == 2 and "position '0 0': must be X Y Z in mm" in said.err
        assert read_published(report, "follow") == {"verdict": "unknown"}
        for option, what in (
            ("--speed", "say how fast"),
            ("--lag", "must be more than 0"),
            ("--length", "more than 0"),
            ("--slow", "each must be wider"),
            ("--warn", "give that, too"),
        ):
            assert what in run(option, "0")[1].err
    assert top.stop


class Machine:
    """Another component of HAL, whose pins are netted to ours."""

    def __init__(self, hal):
        """Make it."""
        self.hal, self.pins = hal, hal.component("machine")
        kinds = {**dict.fromkeys("xyzc", hal.HAL_FLOAT), "running": hal.HAL_BIT, "tool": hal.HAL_S32}
        for name, kind in kinds.items():
            self.pins.newpin(name, kind, hal.HAL_OUT)
            hal.new_sig(f"from-{name}", kind)
            hal.connect(f"machine.{name}", f"from-{name}")
        self.pins.ready()

    def net(self, *names):
        """Net pins of ours to it."""
        for name in names:
            self.hal.connect(f"triaxis.{name}", f"from-{name}")


class Moving(dict):
    """Pins of which each reading is another."""

    def __init__(self, pins, places):
        """Keep the others."""
        super().__init__(pins)
        self._places = places

    def __getitem__(self, name):
        """Return the next place."""
        return float(next(self._places)) if name in "xyzabc" else super().__getitem__(name)


@pytest.fixture
def machine():
    try:
        hal = hal_module._hal()
    except InputError as error:
        pytest.skip(str(error))
    # There is one HAL on a computer.
    with FileLock(Path(tempfile.gettempdir()) / "triaxis-hal.lock"):
        made = Machine(hal)
        yield made
        made.pins.exit()
        # They are gone with the last component, but for those where a machine is running.
        for name in ("x", "y", "z", "c", "running", "tool", "go"):
            subprocess.run(
                ["halcmd", "delsig", name if name == "go" else f"from-{name}"],
                check=False,
                capture_output=True,
            )


def test_positions_are_those_of_the_pins(machine):
    """On the real HAL of LinuxCNC, where that is installed."""
    pins = HalPositions({"C"})
    component = pins._component
    try:
        machine.net("x", "y", "z")
        assert not pins.wait(0.01)
        machine.net("running")
        assert not pins.wait(0.01)
        machine.net("c")
        assert pins.wait(0) and pins.tool is None
        machine.net("tool")
        machine.pins["x"], machine.pins["z"], machine.pins["c"], machine.pins["tool"] = 1.25, 40.0, 30.0, 3
        report = pins.report()
        assert report
        position, since = report
        assert position == (Fraction(5, 4), 0, 40) and since <= time.monotonic() and pins.tool == 3
        assert pins.angles == (0, 0, 30)
        # What nobody knows for any time is none.
        pins.said(True)
        assert machine.hal.get_value("triaxis.go") is False
        pins.known_until(time.monotonic() + 60)
        pins.said(True)
        assert machine.hal.get_value("triaxis.go") is True
        for zones, expected in ((2, [True, True]), (0, [False, False]), (1, [True, False])):
            pins.beyond(zones)
            assert [machine.hal.get_value(f"triaxis.{name}") for name in ("full-speed", "quiet")] == expected
        # Put off, and then not any more, though nobody says so.
        pins.known_until(time.monotonic() + 0.05)
        assert machine.hal.get_value("triaxis.full-speed") is True
        time.sleep(0.5)
        assert [machine.hal.get_value(f"triaxis.{name}") for name in ("go", "full-speed")] == [False] * 2
        machine.pins["running"] = True
        assert pins.report()
        machine.pins["running"] = False
        assert pins.report() is None
        machine.pins["running"], machine.pins["y"] = True, float("nan")
        with pytest.raises(InputError, match="no number"):
            pins.report()
        for name in ("tool", "x"):
            machine.hal.disconnect(f"machine.{name}")
            with pytest.raises(InputError, match=rf"triaxis\.{name}: nothing writes this pin any more"):
                pins.report()
            machine.hal.connect(f"machine.{name}", f"from-{name}")
        with pytest.raises(InputError, match="no component triaxis"):
            HalPositions()
        machine.pins["y"] = 0.0
        # A machine that is elsewhere whenever a pin is read.
        pins._component = Moving({"running": True}, count())
        with pytest.raises(InputError, match="no two readings"):
            pins.report()
    finally:
        pins._component = component
        machine.hal.new_sig("go", machine.hal.HAL_BIT)
        machine.hal.connect("triaxis.go", "go")
        pins.known_until(time.monotonic() + 60)
        pins.close()
        assert not pins._clearing.is_alive()
    assert machine.hal.get_value("go") is False


def test_without_linuxcnc_it_says_so(monkeypatch):
    def absent(_):
        raise ModuleNotFoundError("No module named 'hal'")

    monkeypatch.setattr(hal_module, "import_module", absent)
    with pytest.raises(InputError, match="install linuxcnc-uspace"):
        HalPositions()


@pytest.mark.simulator
def test_the_command_follows_the_pins_of_a_machine(machine, top, tmp_path, capsys, monkeypatch):
    tool, work, program = (tmp_path / name for name in ("t.stl", "w.stl", "p.nc"))
    scenes.write_stl(tool, TOOL)
    scenes.write_stl(work, FLOOR)
    program.write_text("G21 G90 G61\nG0 X10\nG1 X20 F1000\n")
    ticks, ours = 0, threading.get_ident()

    def monotonic():
        # Another thread that looks, as often as it comes to, takes no time.
        nonlocal ticks
        ticks += threading.get_ident() == ours
        return ticks / 400

    for module in (follow_module, hal_module):
        monkeypatch.setattr(module, "time", SimpleNamespace(monotonic=monotonic, sleep=lambda _: None))
    # The board's time goes on only while it is asked.
    line = SimulatedLine(SimulatedWire(top, CLOCKS_PER_SECOND))
    monkeypatch.setattr(engine_module, "SerialLine", lambda _: line)
    places = iter([*range(0, 21, 2), *[20] * 4])
    go = []

    class Stepped(HalPositions):
        """The machine goes on a step whenever it is looked at, and runs until it is at the end."""

        def __init__(self, rotary):
            """Net all pins that are wanted."""
            super().__init__(rotary)
            machine.net("x", "y", "z", "running")
            machine.pins["z"] = 40.0

        def report(self):
            """Go on."""
            place = next(places, None)
            machine.pins["running"] = place is not None
            machine.pins["x"] = 20.0 if place is None else float(place)
            go.append(machine.hal.get_value("triaxis.go"))
            return super().report()

    monkeypatch.setattr(follow_module, "HalPositions", Stepped)
    arguments = [str(tool), str(work), str(program), "--port", line.name, "--hal", "--skip-self-test"]
    arguments += ["--speed", "100", "--lag", "50", "--hold", "500", "--start", "0", "0", "40"]
    assert main(["board", "follow", *arguments, "--surfaces-only"]) == 0
    assert "FOLLOWED: to the end of the program" in capsys.readouterr().out
    assert go[0] is False and go[1:] == [True] * (len(go) - 1)
