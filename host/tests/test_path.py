"""Whole paths: nothing is missed, alarms stay in their band, all engines agree."""

import math
import re
from dataclasses import replace
from fractions import Fraction
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from triaxis.golden.errors import InputError
from triaxis.golden.exact import Rational
from triaxis.golden.judge import judge
from triaxis.host import scenes
from triaxis.host.cli import main
from triaxis.host.cli.path_report import Profile, print_nearest
from triaxis.host.engines import BulkEngine, DecidingEngine, MeshEngineScene, scene_engine
from triaxis.host.euclidean import EuclideanEngine, squared_distance
from triaxis.host.motion.clearance import Clearance, clearances, places
from triaxis.host.motion.contact import Rule
from triaxis.host.motion.curves import arc, centre_by_radius
from triaxis.host.motion.moves import Move, Program
from triaxis.host.motion.path_check import Effort, check_path
from triaxis.host.motion.path_scene import PathGrid, Segment, Wanted, prepare_path
from triaxis.host.motion.program import read_program
from triaxis.host.motion.rule_check import moves_within
from triaxis.host.quantise import NOWHERE, vector
from triaxis.host.scene import bulk_near
from triaxis.host.stl import StlMesh
from triaxis.host.tests.published import read_published
from triaxis.sim.mesh_configuration import MeshConfiguration

RASTER = Path(__file__).with_name("data") / "raster_with_dive.nc"
DIVE = 1 + next(k for k, line in enumerate(RASTER.read_text().splitlines()) if "the dive" in line)
# A program that does not say where it starts.
ASSUMED = "note: line 1: the first move starts at X0 Y0 Z0, which is assumed: give --start"
RATIONALS = st.fractions(-1000, 1000, max_denominator=1000)
PLACES = st.tuples(RATIONALS, RATIONALS, RATIONALS)


def program_of(corners):
    places = [vector(Fraction(float(c)) for c in corner) for corner in corners]
    moves = [Move(line, start, end, False) for line, (start, end) in enumerate(pairwise(places), 1)]
    return Program(Path("moves.nc"), tuple(moves), ())


def wanted_of(clearance: Any = Fraction(1, 2), resolution=Fraction(1, 1000), step=None, scale=1, width=None):
    return Wanted(Fraction(clearance), resolution, step or 4 * resolution, Fraction(scale), width)


def scene_of(tool, work, corners, wanted):
    a, b = (StlMesh(np.array(facets, np.float64), Fraction(0)) for facets in (tool, work))
    return prepare_path(a, b, ("tool.stl", "work.stl"), program_of(corners), wanted)


def vise_scene(corners, **options):
    return scene_of(scenes.tool(), scenes.vise(), corners, wanted_of(**options))


def checked(scene, engine="bulk"):
    deciding = scene_engine(engine, scene.a, scene.b, scene.grid.width)
    if scene.wanted.euclidean:
        steps = scene.wanted.clearance / scene.wanted.resolution
        deciding = EuclideanEngine(deciding, scene.a, scene.b, steps)
    return check_path(scene, deciding)


def exact(facets, move=NOWHERE):
    return [
        [[Fraction(float(x)) + m for x, m in zip(vertex, move, strict=True)] for vertex in facet]
        for facet in facets
    ]


def distance(scene, position):
    moved = exact(scene.tool.facets, scene.in_files(position))
    pairs = [(a, b) for a in moved for b in exact(scene.work.facets)]
    if scene.wanted.euclidean:
        return Fraction(math.sqrt(min(squared_distance(a, b) for a, b in pairs)))
    return min(judge(a, b, 0).distance for a, b in pairs)


@given(PLACES, PLACES, st.integers(2, 40))
def test_every_point_of_a_segment_is_within_reach_of_its_sample(start, end, count):
    segment = Segment(vector(map(Rational, start)), vector(map(Rational, end)), Rational(0), Rational(1))
    farthest = max(
        abs(a + (b - a) * Rational(k, count) - t)
        for k in range(count + 1)
        for a, b, t in zip(segment.start, segment.end, segment.sample, strict=True)
    )
    # The ends are among the points: the reach is no larger than it must be.
    assert farthest == segment.reach <= Rational(1, 2) + segment.length / 2
    first, second = segment.halves()
    assert (first.start, first.end, second.end) == (segment.start, second.start, segment.end)


@pytest.mark.parametrize(("euclidean", "many"), [(False, 2000), (True, 2000), (True, 0)])
def test_no_near_position_is_ever_missed(rng, euclidean, many, monkeypatch):
    """Fine subdivisions of random paths against the exact distance, with a grid so coarse that it matters.

    Of facets, of an edge and an edge, of a vertex and a facet; and with few bits for the engine's margin.
    """
    monkeypatch.setattr("triaxis.host.euclidean._MANY", many)
    asked = list[int]()
    for name in ("run", "first_near"):
        real = getattr(BulkEngine, name)
        noting = lambda of, at, margin, *more, real=real: asked.append(margin) or real(of, at, margin, *more)  # noqa: E731
        monkeypatch.setattr(BulkEngine, name, noting)
    found = {"clear": 0, "certain": 0, "band": 0, "places": 0}
    for trial in range(120):
        tool, work = (rng.uniform(-1, 1, (1, 3, 3)).astype(np.float32) for _ in "ab")
        if trial % 3 == 1:
            tool[0, 2], work[0, 2] = tool[0, 1], work[0, 0]
        elif trial % 3 == 2:
            tool[0, 1:] = tool[0, 0]
        # One path in five begins where the two are next to each other, and not in the band around.
        corners = rng.uniform(-4, 4, (3, 3)).round(3) * np.array([[trial % 5 > 0], [1], [1]])
        clearance, step = Fraction(int(rng.integers(0, 60)), 97), Fraction(int(rng.integers(1, 5)), 4)
        wanted = wanted_of(clearance, Fraction(1, 4), step)
        wanted = replace(wanted, euclidean=euclidean, margin_bits=4 if trial % 2 else None)
        scene = scene_of(tool, work, corners, wanted)
        result = checked(scene)
        before = places_before(scene, result.near)
        assert all(distance(scene, place) > clearance for place in before)
        assert max(asked, default=0) <= scene.largest_margin
        asked.clear()
        found["places"] += len(before)
        if result.near:
            real = distance(scene, result.near.position)
            assert real < clearance + scene.band
            assert result.near.within_clearance_for_certain == (real <= clearance)
            assert result.near.facets[0].distance == real
            found["certain" if result.near.within_clearance_for_certain else "band"] += 1
        else:
            found["clear"] += 1
    assert min(found.values()) > 3 and found["places"] > 2500, found


def test_each_contact_at_a_known_time_is_found(rng):
    """A vertex that comes to a facet, an edge to an edge, at a rational part of a move; touching is near."""
    before = 0
    for trial in range(90):
        tool, work = (rng.integers(-32, 33, (1, 3, 3)) / 16 for _ in "ab")
        of_tool, of_work = (rng.permutation([1, 2, 5]) / 8 for _ in "ab")
        if trial % 3 == 0:
            tool[0, 1:] = tool[0, 0]
        elif trial % 3 == 1:
            tool[0, 2], work[0, 2] = tool[0, 1], work[0, 0]
        else:
            of_tool = np.array([1.0, 0, 0])
        way = rng.integers(-32, 33, 3) / 8 + np.array([0, 0, 1 / 16])
        part = int(rng.integers(1, 16)) / 16
        # All are binary fractions of few bits: nothing is rounded.
        touching = of_work @ work[0] - of_tool @ tool[0]
        scene = scene_of(tool, work, [touching - part * way, touching + (1 - part) * way], wanted_of(0))
        assert distance(scene, vector(Fraction(float(c)) for c in touching)) == 0
        near = checked(scene).near
        assert near is not None and not near.move
        assert near.part_of_move <= Fraction(part) + part_of(scene.program.moves[0], scene.wanted.step)
        clear = places_before(scene, near)
        assert all(distance(scene, place) > 0 for place in clear)
        before += len(clear)
    assert before > 500, before


def part_of(move, length):
    """Return which part of a straight move is that long, on its fastest axis."""
    return length / max(abs(b - a) for a, b in zip(move.start, move.end, strict=True))


def places_before(scene, near):
    """Return places of straight moves, 25 of each, before what was found near, or all."""
    return [
        move.at(Fraction(k, 24))
        for index, move in enumerate(scene.program.moves)
        for k in range(25)
        if near is None
        or (index, Fraction(k, 24) + part_of(move, scene.wanted.step)) < (near.move, near.part_of_move)
    ]


def test_nothing_is_missed_on_arcs_and_ways_of_rapids(rng):
    """As above, at points of arcs, and anywhere in the box of a rapid."""
    found = {"clear": 0, "near": 0}
    for trial in range(100):
        tool, work = (rng.uniform(-1, 1, (1, 3, 3)).astype(np.float32) for _ in "ab")
        start, end = (vector(Fraction(float(c)) for c in rng.uniform(-4, 4, 3).round(3)) for _ in "se")
        axes = (0, 1, 2) if trial % 4 else (2, 0, 1)
        radius = Fraction(math.hypot(*(float(end[k] - start[k]) for k in axes[:2]))) * Fraction(11, 20)
        clockwise = bool(trial % 3)
        centre, _ = centre_by_radius(start, end, axes, radius * (-1) ** trial, clockwise)
        curve = arc(start, end, axes, centre, clockwise, 1) if trial % 2 else None
        slack = curve.slack if curve else Fraction(0)
        move = Move(1, start, end, curve is None, False, curve, slack)
        a, b = (StlMesh(np.array(facets, np.float64), Fraction(0)) for facets in (tool, work))
        wanted = wanted_of(
            Fraction(int(rng.integers(0, 60)), 97), Fraction(1, 4), Fraction(int(rng.integers(1, 5)), 4)
        )
        scene = prepare_path(a, b, ("tool.stl", "work.stl"), Program(Path("moves.nc"), (move,), ()), wanted)
        result = checked(scene)
        if result.near is None:
            found["clear"] += 1
            for k in range(25):
                part = vector(Fraction(float(c)) for c in rng.uniform(0, 1, 3))
                box = vector(a + (b - a) * t for a, b, t in zip(start, end, part, strict=True))
                place = vector(map(Fraction, map(float, curve.at(Fraction(k, 24))))) if curve else box
                assert distance(scene, place) > wanted.clearance
        else:
            found["near"] += 1
            assert distance(scene, result.near.position) < wanted.clearance + scene.band
            low, high = move.extent
            assert all(a <= c <= b for a, c, b in zip(low, result.near.position, high, strict=True))
    assert min(found.values()) > 10, found


def test_the_slack_of_a_control_is_covered():
    def near(slack):
        move = Move(
            1, (Fraction(-3), *NOWHERE[:2]), (Fraction(0), *NOWHERE[:2]), False, slack=Fraction(slack)
        )
        a, b = (StlMesh(np.array(facets, np.float64), Fraction(0)) for facets in POINTS)
        program = Program(Path("moves.nc"), (move,), ())
        return checked(prepare_path(a, b, ("a", "b"), program, wanted_of(Fraction(1, 2)))).near

    # The wall is 1 away from where the tool stops.
    assert near(Fraction(4, 10)) is None
    found = near(Fraction(6, 10))
    assert found is not None and not found.within_clearance_for_certain


# A tool at x = 1/2 that rounds to 0, a wall at 3/2 that rounds to 2, and a path that ends where they touch.
POINTS = (np.full((1, 3, 3), [0.5, 0, 0]), np.full((1, 3, 3), [1.5, 0, 0]))


def test_the_bound_is_tight(monkeypatch):
    def tight_scene():
        return scene_of(*POINTS, [(-3, 0, 0), (1, 0, 0)], wanted_of(0, Fraction(1), Fraction(1)))

    near = checked(tight_scene()).near
    assert near is not None
    assert near.part_of_move > Fraction(3, 4)
    monkeypatch.setattr(PathGrid, "base", PathGrid.base.func(tight_scene().path) - Fraction(1, 100))
    assert checked(tight_scene()).near is None, "a smaller bound would do"


@pytest.mark.long
@pytest.mark.simulator
def test_engines_agree():
    # Down beside a jaw with half a millimetre to spare, along it, closer, and into it.
    beside = [(0, 76.5, 60), (0, 76.5, -20), (10, 76.2, -20), (40, 74, -20)]
    scene = vise_scene(beside, clearance=1, resolution=Fraction(1, 100))
    bulk, golden, rtl = (checked(scene, name) for name in ("bulk", "golden", "rtl"))
    assert bulk.near == golden.near == rtl.near
    assert bulk.levels == golden.levels == rtl.levels
    assert bulk.effort.poses == golden.effort.poses == rtl.effort.poses > 10
    assert bulk.near and bulk.near.line == 3
    assert (rtl.effort.cycles or 0) >= (rtl.effort.most_cycles or 0) > 0


def test_what_is_first_near_is_so_in_whatever_order_pairs_are_decided(rng):
    verdicts = set()
    for trial in range(40):
        tool = rng.uniform(-3, 3, (4, 1, 3)) + rng.uniform(-1, 1, (4, 3, 3))
        work = rng.uniform(-8, 8, (60, 1, 3)) + rng.uniform(-1, 1, (60, 3, 3))
        corners = rng.uniform(-9, 9, (12, 3)).round(3) + np.array([0, 0, 14 - trial % 20])
        scene = scene_of(tool, work, corners, wanted_of(Fraction(1, 4), Fraction(1, 50), Fraction(1, 10)))
        natively, otherwise = BulkEngine(scene.a, scene.b), DecidingEngine(scene.a, scene.b, bulk_near)
        results = [check_path(scene, engine, surfaces_only=True) for engine in (natively, otherwise)]
        assert results[0].near == results[1].near and results[0].levels == results[1].levels
        # All of the path before it is shown to be clear, once.
        verdicts.add((results[0].verdict, bool(results[0].near and results[0].near.move)))
    assert verdicts == {("clear", False), ("near", False), ("near", True)}


@pytest.mark.parametrize("engine", [BulkEngine, partial(DecidingEngine, decide=bulk_near)])
def test_a_pose_is_near_where_any_pair_is(rng, engine):
    """With wrong hints: near where a run of all pairs is, and each clear one counted."""
    a, b = (rng.integers(-900, 900, (n, 1, 3)) + rng.integers(-60, 60, (n, 3, 3)) for n in (80, 150))
    asked, near = engine(a, b), 0
    for x, y, z in rng.integers(-2000, 2000, (60, 3)).tolist():
        # More of them than are decided at a time.
        margin, likely = int(rng.integers(0, 90)), rng.integers(0, 80, (rng.choice([0, 1, 150]), 2))
        run, whole = asked.first_near((x, y, z), margin, likely), engine(a, b).run((x, y, z), margin)
        wanted = {tuple(pair) for pair in whole.near.tolist()}
        assert (run.near_count > 0) == (len(wanted) > 0)
        assert {tuple(pair) for pair in run.near.tolist()} <= wanted
        assert wanted or (run.tested, run.skipped) == (whole.tested, whole.skipped)
        near += run.near_count > 0
        if len(wanted) and len(wanted) < len(a):
            clear = [(i, 0) for i in range(len(a)) if (i, 0) not in wanted]
            hints = np.array([*clear, *clear, *wanted])
            run = asked.first_near((x, y, z), margin, hints)
            assert 2 * len(clear) < run.tested <= len(hints)
    assert 10 < near < 50


def test_half_circles_by_radius_are_those_of_a_control_too(tmp_path):
    """LinuxCNC takes the middle of the chord where that is next to a diameter."""
    file = tmp_path / "half.nc"
    for radius in (10, 1000, 20_000):
        for short, nearly in ((Fraction(1, 3 * 10**12), True), (Fraction(1, 10**11), False)):
            end = vector(2 * radius * (1 - short) * Fraction(c, 5) for c in (3, 4, 0))
            centre, off = centre_by_radius(NOWHERE, end, (0, 1, 2), Fraction(radius), False)
            away = math.dist(centre, [c / 2 for c in end[:2]])
            assert (off > 0) == nearly and (away <= off < 3e-6 * radius or not nearly), (radius, short)
    # By rs274 about X602.8472 Y797.8567, which is 1.4 um away.
    file.write_text("G21 G90 G61 G17\nG3 X1205.6943 Y1595.7134 R1000 F900\n")
    [move] = read_program(file, NOWHERE).moves
    assert move.slack >= Fraction(14, 10**4)


def test_the_width_holds_what_moves_may_be_off():
    """Here the margin would be above 16 bits, and nothing else is."""
    corners = [(-8, 0, 0), (0, 0, 3)]
    for slack, width in ((0, 16), (5, 24)):
        moves = tuple(replace(move, slack=Fraction(slack)) for move in program_of(corners).moves)
        program = replace(program_of(corners), moves=moves)
        a, b = (StlMesh(np.array(facets, np.float64), Fraction(0)) for facets in POINTS)
        wanted = Wanted(Fraction(62), Fraction(1, 1000), Fraction(1), Fraction(1), None)
        assert prepare_path(a, b, ("a", "b"), program, wanted).grid.width == width


def test_turns_are_looked_into(tmp_path):
    [move, after] = program_of([(0, 0, 0), (0, 0, 9), (0, 0, 10)]).moves
    turn = replace(move, end=move.start, turns=(NOWHERE, (Rational(0), Rational(-90), Rational(0))))
    found = places(Program(Path("moves.nc"), (turn, replace(after, turns=turn.turns[1:] * 2)), ()), 92)
    assert len([place for place in found if place.move == 0]) > 88
    assert {place.along for place in found if place.move == 0} == {0}
    assert found[-1].along == 1


@pytest.mark.long
@pytest.mark.simulator
def test_meshes_larger_than_the_engine_run_part_by_part(rng):
    a, b = (rng.integers(-60, 60, (n, 1, 3)) + rng.integers(-25, 25, (n, 3, 3)) for n in (150, 70))
    small = MeshEngineScene(a, b, MeshConfiguration(16, 16, depth=64, group=8, lanes=8))
    whole = scene_engine("bulk", a, b, 16)
    for translation, margin in (((0, 0, 0), 3), ((5, -7, 2), 0), ((3, 3, 3), 20)):
        parts, wanted = small.run(translation, margin), whole.run(translation, margin)
        assert (parts.near == wanted.near).all()
        assert (parts.tested, parts.near_count) == (wanted.tested, wanted.near_count)
        assert parts.skipped_in_groups + parts.skipped + parts.tested == 150 * 70
        first = small.run(translation, margin, stop_at_first=True).near.tolist()
        assert len(first) == 1 and first[0] in wanted.near.tolist()


def test_bounds_of_the_clearance_hold_the_clearance():
    wanted = wanted_of(1, Fraction(1, 100))
    scene = scene_of(*POINTS, [(-8, 0, 0), (0, 0, 3), (1, 0, 0)], wanted)
    names, files, numbers = ("the tool", "the workpiece"), ("a", "b"), range(len(scene.program.moves))
    rule = Rule(names, scene.tool, scene.work, files, scene.program, numbers)
    engine_of, chosen = (
        (lambda one: scene_engine("bulk", one.a, one.b, one.grid.width)),
        places(scene.program, 12),
    )
    found = clearances(scene.program, [rule], wanted, engine_of, chosen, Effort())
    # Whatever margins a board has.
    narrow = replace(wanted, margin_bits=8)
    assert clearances(scene.program, [rule], narrow, engine_of, chosen, Effort()) == found
    assert [place.along for place in found] == sorted(place.along for place in found)
    assert found[-1].proven == 0 and len(found) == len(chosen)
    for place in found:
        real = float(distance(scene, [Fraction(c) for c in place.position]))
        assert place.proven < real + 1e-9 or place.proven == 0
        assert real <= place.seen + 1e-9
        assert place.seen - place.proven <= max(0.1, real / 10)


def test_a_move_is_in_a_zone_where_the_tool_comes_within_it(rng):
    """Against exact distances, 25 on each move: what is not told is beyond, other moves nearly within."""
    widths, told = [Fraction(1, 2), Fraction(2)], [0, 0]
    for _ in range(25):
        tool, work = (rng.uniform(-1, 1, (1, 3, 3)).astype(np.float32) for _ in "ab")
        scene = scene_of(tool, work, rng.uniform(-5, 5, (9, 3)).round(3), wanted_of(0, Fraction(1, 100)))
        # Not the first of the program, nor all of it.
        moves = scene.program.moves[2:]
        numbers = range(2, 2 + len(moves))
        part = replace(scene.program, moves=moves)
        rule = Rule(("a", "b"), scene.tool, scene.work, ("a.stl", "b.stl"), part, numbers)
        done = list[int]()
        within = moves_within(rule, scene.wanted, widths, done.append)
        assert within[0] <= within[1] and sum(done) == len(moves)
        for number, move in zip(numbers, moves, strict=True):
            least = min(distance(scene, move.at(Fraction(k, 24))) for k in range(25))
            between = max(abs(b - a) for a, b in zip(move.start, move.end, strict=True)) / 48
            for zone, width in enumerate(widths):
                if number in within[zone]:
                    assert least - between < width + Fraction(4, 100) + widths[0] / 32
                    told[zone] += 1
                else:
                    assert least > width
    assert 10 < told[0] < told[1] < 150


@pytest.mark.parametrize(
    ("proven", "seen", "told"),
    [(1.99996, 2.00004, "1.999 to 2.001"), (0.5, 0.75, "0.5 to 0.75"), (0.0, 12345.6, "0 to 12350")],
)
def test_bounds_are_rounded_outwards(proven, seen, told, capsys):
    least = Clearance(0, 7, 0.0, NOWHERE, NOWHERE, "the tool", "the vise", proven, seen)
    print_nearest(Profile([least], 1, Effort()))
    assert f"the tool and the vise, {told} mm (Chebyshev)" in capsys.readouterr().out


def test_what_does_not_fit_is_refused():
    with pytest.raises(InputError, match=r"moves\.nc: line 2: at X0 Y0 Z900 the tool leaves the 16-bit grid"):
        vise_scene([(0, 0, 60), (0, 0, 5), (0, 0, 900)], resolution=Fraction(1, 100), width=16)
    for height, width in ((900, 24), (90000, 32)):
        assert vise_scene([(0, 0, 60), (0, 0, height)]).grid.width == width
    for options, why in (
        ({"clearance": -1}, "must not be negative"),
        ({"scale": 0}, "scale 0: must be positive"),
        ({"step": Fraction(1, 2000)}, "step 0.0005: must be at least the resolution"),
    ):
        with pytest.raises(InputError, match=why):
            vise_scene([(0, 0, 60), (0, 0, 5)], **options)


MACHINE = """
rapids = "straight"
loaded = 1
[[tools]]
number = 1
length = 0
parts = [{ diameter = 10, length = 60 }]
[[tools]]
number = 2
length = 0
parts = [{ diameter = 4, length = 1 }, { diameter = 60, length = 30 }]
"""


def test_tools_of_a_machine_file_are_checked_in_turn(path, tmp_path):
    machine, work = tmp_path / "machine.toml", tmp_path / "work.stl"
    machine.write_text(MACHINE)
    # Over a jaw, which is 8 mm lower than the workpiece: the holder of the second tool comes into that.
    start, program = ("--start", 0, 0, 60), "G21 G0 Y55\nZ-6\nZ60\nT2 M6\nZ1"
    status, said, found = path(program, *start, meshes=(machine, work))
    assert [tool["verdict"] for tool in found["tools"]] == ["clear", "clear"] and status == 0
    status, said, found = path(f"{program}\nZ-6", *start, meshes=(machine, work))
    assert (status, found["near"]["line"], found["near"]["move"]) == (1, 6, 4)
    assert [tool["verdict"] for tool in found["tools"]] == ["clear", "near"]
    assert "tool: tool 2" in said and "how the machine moves to change tools is not checked" in said


def test_rapids_are_covered_any_way_unless_the_machine_says_how(path, tmp_path):
    machine, work = tmp_path / "machine.toml", tmp_path / "work.stl"
    # Down beside the vise on a straight line; each axis on its own might go through the jaw.
    program, start = "G21 G0 X0 Y90 Z-15", ("--start", 0, 20, 60)
    machine.write_text(MACHINE)
    assert path(program, *start, meshes=(machine, work))[0] == 0
    machine.write_text(MACHINE.replace("straight", "any"))
    assert path(program, *start, meshes=(machine, work))[0] == 1


@pytest.mark.long
def test_a_corner_is_not_near_by_euclid(path, tmp_path):
    """Past the edge of a box, diagonally: within 0.5 in each coordinate, 0.57 away."""
    tool, work = tmp_path / "pin.stl", tmp_path / "block.stl"
    scenes.write_stl(tool, scenes.box((0, 0, 0), (1, 1, 1)))
    scenes.write_stl(work, scenes.box((-9, -9, -9), (-0.4, -0.4, 20)))
    start, program, meshes = ("--start", 0, 0, 30), "G21 G0 Z-5\nG1 F9 Z5", (tool, work)
    status, said, found = path(program, *start, "--profile", 9, meshes=meshes)
    assert status == 1 and found["least_euclidean"] is None and "(Euclid)" not in said
    status, said, found = path(program, *start, "--distance", "euclidean", meshes=meshes)
    assert (
        found["least_euclidean"] == pytest.approx(0.4 * math.sqrt(2)) and "there 0.5657 mm (Euclid)" in said
    )
    assert (status, found["distance"], found["verdict"]) == (0, "euclidean", "clear") and "CLEAR" in said
    closer = f"{program}\nX-0.1"
    status, said, found = path(closer, *start, "--distance", "euclidean", meshes=meshes)
    distance = found["near"]["facets"][0]["distance"]
    assert (status, found["near"]["line"]) == (1, 3) and 0.49 < distance < 0.5 + found["false_alarm_band"]
    board = ("--distance", "euclidean", "--engine", "board", "--port", "/dev/null")
    status, said, _ = path(program, *board)
    assert status == 2 and "a board knows Chebyshev's alone" in said


@pytest.fixture
def path(tmp_path, capsys):
    """Return a function that checks a program along meshes: exit code, what was said, the report if any."""
    names = ("tool.stl", "work.stl", "moves.nc", "report.json")
    tool, work, moves, report = (tmp_path / name for name in names)
    scenes.write_stl(tool, scenes.tool())
    scenes.write_stl(work, scenes.vise())

    def run(program, *words, meshes=(tool, work)):
        moves.write_text(program)
        engine = () if "--engine" in words else ("--engine", "bulk")
        command = ("path", *meshes, moves, *engine, "--json", report, *words)
        status = main([*map(str, command)])
        return status, "".join(capsys.readouterr()), read_published(report, "path")

    return run


def test_a_dive_is_found(path, tmp_path):
    program, start, picture = RASTER.read_text(), ("--start", 0, 0, 60), tmp_path / "picture.png"
    status, said, found = path(program, *start, "--picture", picture, "--profile", 20)
    assert status == 1
    assert f"NEAR: line {DIVE}: at X-10.0000 Y5.0000 Z0.50" in said
    assert "facet 0 of the tool, facet 4" in said
    assert (found["verdict"], found["near"]["line"], found["false_alarm_band"]) == ("near", DIVE, 0.006)
    assert found["near"]["facets"][0]["distance"] < 0.506
    assert len(found["profile"]) >= 20
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert path(program, *start, "--clearance", 0, "--block-delete")[0] == 1
    # Passes at 1 mm above the face alone are clear, and it is said how near they come.
    status, said, found = path("G21 G0 X0 Y0 Z1\nX35 Y25\nX-35 F100", *start)
    least = min(found["profile"], key=lambda place: place["seen"])
    assert status == 0 and least["proven"] < 1 <= least["seen"] < 1.1
    assert re.search(r"places: least in line \d at X.*: the tool and the workpiece, 0\.9\d* to 1", said)
    assert found["zones"] == []


def test_zones_of_a_clear_program_are_told(path):
    program = "G21 G0 X0 Y0 Z30\nZ4 F100\nX35\nZ1\nX-35\nZ5\nZ30"
    zones, start = ("--slow", 2, "--warn", 10), ("--start", 0, 0, 60)
    status, said, found = path(program, *start, *zones)
    wanted = [(2, [4, 5, 6]), (10, [2, 3, 4, 5, 6, 7])]
    assert status == 0 and [(one["within"], one["lines"]) for one in found["zones"]] == wanted
    two = "the tool and the workpiece"
    assert f"{two} within 2 mm, or nearly: 3 of 7 moves, lines 4, 5, 6\n" in said
    said = path(program, *start, "--slow", "0.6")[1]
    assert "\nwithin 0.6 mm, or nearly: 0 of 7 moves\n" in said
    # What is near is told alone.
    status, said, found = path(program + "\nZ0", *start, *zones)
    assert (status, found["zones"]) == (1, []) and "or nearly" not in said
    assert "note: --slow and --warn are told of a clear program alone" in said
    for wrong in (("--warn", 9), ("--slow", 9, "--warn", 9), ("--slow", "0.5")):
        status, said, _ = path(program, *start, *wrong)
        assert status == 2 and ("give that, too" in said or "each must be wider" in said)
    for wrong in (("--slow", "1e7"), ("--slow", "2e6", "--step", "2e5")):
        status, said, _ = path(program, *start, *wrong)
        assert status == 2 and "--slow, --warn: at most 2.14748e+06 mm at this resolution" in said


def test_the_least_clearance_counts_what_a_control_may_leave_the_path_by(path):
    program = "G21 G61 G0 X0 Y0 Z1.2\nX35 Y25\nZ3\nG64 P1 G1 X30 F100\nG61 G0 Z60"
    status, said, found = path(program, "--start", 0, 0, 60, "--clearance", 0.1, "--profile", 60)
    printed = re.search(r"workpiece, ([\d.]+) to ([\d.]+) mm \(Chebyshev\)", said.split("places:")[1])
    proven, seen = (min(place[key] for place in found["profile"]) for key in ("proven", "seen"))
    assert status == 0 and printed and proven < 1.1 < seen
    assert [float(one) for one in printed.groups()] == pytest.approx([proven, seen], rel=1e-3)


def test_pictures_show_what_is_not_proven_clear_and_zones(path, tmp_path):
    for program, shown in (("G21 G0 X0 Y0 Z0.4", "not proven clear"), ("G21 G0 X0 Y0 Z1", "slow: 2 mm")):
        words = ("--slow", 2, "--profile", 9, "--picture", tmp_path / "p.svg")
        path(program, "--start", 0, 0, 60, *words)
        assert shown in (tmp_path / "p.svg").read_text()


def test_a_start_that_nobody_gave_is_said(path):
    assert ASSUMED in path("G21 G0 Z500")[1]
    status, said, _ = path("G21 G0 Z500", "--start", 0, 0, 60)
    assert (status, ASSUMED in said) == (0, False)


@pytest.mark.parametrize(
    ("facets", "program", "words", "status", "verdict", "state", "line"),
    [
        (12, "G0 Z50", "--picture {}/p.svg", 1, "near", "inside", "but the tool is inside the work"),
        (12, "G0 Z50", "--surfaces-only", 0, "clear", "not asked", "(surfaces only: one may be inside"),
        (11, "G0 Z50", "", 2, "unknown", "undecided", "outer.stl: not closed: 3 edges"),
        # On its way out it comes near: what is so at the start is said first.
        (12, "G0 Z50\nG0 Z900", "", 1, "near", "inside", "is inside the workpiece\nNEAR: line 2"),
        (12, "G0 Z900", "--start 0 0 600", 0, "clear", "outside", "CLEAR"),
    ],
)
def test_a_tool_that_starts_within_the_work_is_near(
    path, tmp_path, facets, program, words, status, verdict, state, line
):
    meshes, stock = (tmp_path / "inner.stl", tmp_path / "outer.stl"), (500, 500, 500)
    scenes.write_stl(meshes[0], scenes.box((-5, -5, 0), (5, 5, 20)))
    scenes.write_stl(meshes[1], scenes.box((-500, -500, -500), stock)[:facets])
    found, said, report = path(f"G21 {program}", *words.format(tmp_path).split(), meshes=meshes)
    assert (found, report["verdict"], report["enclosure"]["state"]) == (status, verdict, state)
    assert line in said
    assert (tmp_path / "p.svg").exists() == ("--picture" in words)


def test_a_tool_that_comes_into_something_open_is_undecided():
    tool, bowl = scenes.box((-5, -5, 0), (5, 5, 20)), scenes.box((-50, -50, -50), (50, 50, 50))
    # Without its two upper facets.
    without_lid = bowl[~(bowl[..., 2] == 50).all(1)]
    inwards, above = [(0, 0, 100), (0, 0, 10)], [(0, 0, 100), (0, 0, 60)]
    assert checked(scene_of(tool, without_lid, inwards, wanted_of())).verdict == "unknown"
    assert checked(scene_of(tool, without_lid, above, wanted_of())).verdict == "clear"
    result = checked(scene_of(tool, bowl, inwards, wanted_of()))
    assert (result.verdict, result.insides.state) == ("near", "outside")
