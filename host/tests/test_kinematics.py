"""Machines of objects: what carries and moves what, and what comes near what while a program runs."""

import re
import shutil
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import partial
from itertools import combinations, product

import numpy as np
import pytest

from triaxis.golden.errors import InputError
from triaxis.golden.exact import Rational
from triaxis.host import figures, scenes
from triaxis.host.cli import main
from triaxis.host.engines import BULK, scene_engine
from triaxis.host.motion import picture, rule_check
from triaxis.host.motion.contact import Setup, rules_of
from triaxis.host.motion.example import write_mill
from triaxis.host.motion.follow import pieces
from triaxis.host.motion.kinematics import Axis, Body, Meeting
from triaxis.host.motion.machine import CARRIED
from triaxis.host.motion.machine_file import read_machine
from triaxis.host.motion.moves import Move
from triaxis.host.motion.operations import parts_of
from triaxis.host.motion.path_scene import Wanted, prepare_path
from triaxis.host.motion.program import read_program
from triaxis.host.motion.rs274 import read_by_rs274
from triaxis.host.motion.supervision import Supervision, stands_and_turns
from triaxis.host.quantise import NOWHERE, vector
from triaxis.host.scene import bulk_near, near_facets
from triaxis.host.scenes import mesh_data
from triaxis.host.stl import StlMesh, read_stl
from triaxis.host.tests.machines import HEAD, MILL, TOOL, carriers, entry, write_meshes
from triaxis.host.tests.published import read_published

LETTERS = "XYZABC"


@pytest.fixture
def checked(tmp_path, capsys):
    """Return a function that checks a program on a machine, and gives what it said."""
    write_meshes(tmp_path)
    scenes.write_stl(tmp_path / "work.stl", scenes.box((-20, -20, 0), (20, 20, 20)))
    scenes.write_stl(tmp_path / "stock.stl", scenes.box((-15, -15, 20.5), (15, 15, 40)))

    def run(machine, program, *words, start=("0", "0", "100")):
        (tmp_path / "m.toml").write_text(machine)
        (tmp_path / "p.nc").write_text(f"G21 G90 G61 G43 H1 F100\n{program}\n")
        files = (tmp_path / "m.toml", tmp_path / "work.stl", tmp_path / "p.nc")
        more = ("--start", *start, "--json", tmp_path / "r.json", "--engine", "bulk", *words)
        status = main([str(word) for word in ("path", *files, *more)])
        said = "".join(capsys.readouterr())
        return status, said, read_published(tmp_path / "r.json", "path") if status < 2 else {}

    return run


@pytest.mark.parametrize(
    ("program", "near"),
    [
        ("G0 Z30\nX5 Y5\nG1 X-4", None),
        # What nothing of tool and workpiece shows: the table goes to the post, its corner as it turns.
        ("G0 Z60\nX-9.4", None),
        ("G0 Z60\nX-9.6", (3, "the bed", "the table")),
        ("G0 Z60\nC30", (3, "the bed", "the table")),
        ("G0 Z60\nX40 C90\nX-9", None),
        ("G0 Z60\nX20 C90", (3, "the bed", "the table")),
        ("G0 Z60\nX12\nC-90\nC0", None),
        ("G0 Z60\nX10\nC-90", (4, "the bed", "the table")),
        # The same turn, when the table has gone away meanwhile, and when it is at the end of it only.
        ("G0 Z60\nX30 C20\nC45", None),
        ("G0 Z60\nX-9 C45", (3, "the bed", "the table")),
        ("G0 Z60\nG91 G1 X-9 C45", (3, "the bed", "the table")),
        # The head reaches beyond its tool.
        ("G0 Z30\nX40\nZ10.4", (4, "the bed", "the head")),
        ("G0 Z30\nX40\nZ10.6", None),
        # And the tool itself is beside the workpiece, or not, as that is turned.
        ("G0 Z30\nX24\nG1 Z12", None),
        ("G0 Z30\nX24\nC45\nG1 Z12", (5, "the tool", "the workpiece")),
        ("G0 Z30\nX24\nG1 Z12\nG1 C45", (5, "the tool", "the workpiece")),
    ],
)
def test_each_object_is_watched(checked, program, near):
    status, said, report = checked(MILL, program)
    found = report["near"] and (report["near"]["line"], report["what"], report["of"])
    assert (status, found) == (int(near is not None), near), said
    assert "C turns the table right-handed about z; from 0 at the start, which is assumed" in said


@dataclass(frozen=True)
class Thing:
    """An object of a machine made up: what carries it, its axis, a point of that, its mesh, where that is."""

    on: str | None
    axis: str | None = None
    pivot: np.ndarray | None = None
    mesh: np.ndarray | None = None
    at: np.ndarray = field(default_factory=lambda: np.zeros(3))


def made_up(rng, turning=True):
    """Return a machine by random: its objects, what carries tool and workpiece, where these are."""
    sides = rng.integers(0, 2, 3)
    things, ends = {}, []
    for side, sign in ((0, ""), (1, "-")):
        on = None
        axes = [sign + letter for letter, at in zip("XYZ", sides, strict=True) if at == side]
        turned = rng.choice(list("ABC"), rng.integers(0, 4) if turning else 0, replace=False)
        axes = [*rng.permutation(axes), *(rng.choice(["", "-"]) + letter for letter in turned), None]
        for axis in axes:
            name = f"thing {len(things)}"
            mesh = rng.uniform(-7, 7, (4, 3)).round(3) if rng.random() < 0.5 else None
            pivot = rng.uniform(-9, 9, 3).round(2) if axis and axis[-1] in "ABC" else None
            facets = None if mesh is None else mesh[[[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]]
            things[name] = Thing(on, axis, pivot, facets, rng.uniform(-20, 20, 3).round(2))
            on = name
        ends.append(on)
    nose, zero = rng.uniform(-9, 9, (2, 3)).round(2)
    return things, ends, nose, zero


def moved(things, name, points, coordinates):
    """Return points that an object carries, (.., 3), at coordinates of six axes, by one after the other."""
    while name is not None:
        thing = things[name]
        if thing.axis is not None:
            value = coordinates[LETTERS.index(thing.axis[-1])] * (-1 if thing.axis[0] == "-" else 1)
            k = LETTERS.index(thing.axis[-1]) % 3
            if thing.pivot is None:
                points = points + value * np.eye(3)[k]
            else:
                turn = turned_about(k, np.radians(value))
                points = (points - thing.pivot) @ turn.T + thing.pivot
        name = thing.on
    return points


def turned_about(k, angle):
    """Return the matrix of a turn about an axis."""
    matrix, (i, j) = np.eye(3), ((k + 1) % 3, (k + 2) % 3)
    matrix[[i, j, i, j], [i, j, j, i]] = np.cos(angle), np.cos(angle), -np.sin(angle), np.sin(angle)
    return matrix


def axes_of(things, name):
    """Return what moves an object."""
    found = set()
    while name is not None:
        found |= {name} if things[name].axis else set()
        name = things[name].on
    return found


def within(a, b, distance):
    """Return whether any two facets (N, 3, 3) are within a distance, but for a millionth."""
    step = 1e-6
    a, b = (np.rint(mesh / step).astype(np.int64) for mesh in (a, b))
    found = near_facets(a, b, round(distance / step), bulk_near)
    return any(len(near) for _, near in found)


def angles_between(rng, first, last, part, free):
    """Return all coordinates a part of the way from first to last, each on its own where ``free``."""
    return first + (last - first) * (rng.random(6) if free else part)


@pytest.mark.parametrize(
    "number", [*range(20), *(pytest.param(n, marks=pytest.mark.long) for n in range(20, 120))]
)
def test_pieces_hold_every_position_and_angle(rng, number):
    """No point of A, as B sees it, is further from where a piece has it than the slack of its moves."""
    things = made_up(rng)[0]
    bodies, free = [], rng.random() < 0.5
    chains: dict[str | None, tuple[Axis, ...]] = {None: ()}
    for name, thing in things.items():
        axis = thing.axis and Axis(
            name, thing.axis[-1], -1 if thing.axis[0] == "-" else 1,
            NOWHERE if thing.pivot is None else exactly(thing.pivot),
        )  # fmt: skip
        chains[name] = (*chains[thing.on], *((axis,) if axis else ()))
        mesh = StlMesh(rng.uniform(-7, 7, (3, 3, 3)), Fraction(0))
        bodies.append(Body(name, mesh, name, exactly(thing.at), chains[name]))
    first, last = rng.uniform([-25] * 3 + [-60] * 3, [25] * 3 + [60] * 3, (2, 6)).round(2)
    turns, base = (exactly(first[3:]), exactly(last[3:])), exactly(rng.uniform(-9, 9, 3))
    move = Move(1, exactly(first[:3]), exactly(last[:3]), free, not free, turns=turns)
    for a, b in rng.permutation(list(combinations(range(len(bodies)), 2)))[:4]:
        a, b = bodies[a], bodies[b]
        meeting = Meeting.of(a, b, base, Fraction(1))
        pieces = list(meeting.pieces([move], Fraction(12)))
        assert all(piece.swept <= 12 for piece in pieces)
        for part in rng.random(8):
            real = angles_between(rng, first, last, part, free)
            piece = next(one for one in pieces if holds(one, part, real, free))
            (seen,), (inner,) = piece.moves, piece.program
            start, end = (np.array([float(c) for c in place]) for place in (seen.start, seen.end))
            along = (real[:3] - first[:3]) / (last[:3] - first[:3])
            if not free:
                low, high = map(float, piece.part)
                along = (part - low) / (high - low)
            taken = (
                piece.a.facets.reshape(-1, 1, 3)
                + start
                + (end - start) * along
                - piece.b.facets.reshape(-1, 3)
            )
            at = real + np.array([*map(float, base), 0, 0, 0])
            one, other = (
                moved(things, body.name, body.mesh.facets.reshape(-1, 3) + things[body.name].at, at)
                for body in (a, b)
            )
            # The common axes turn both: distances alone stay the same, by all axes but those.
            common = len(chains[a.name]) - len(meeting.a.chain)
            if not any(axis.rotary for axis in chains[a.name][:common]):
                assert np.abs(one[:, None] - other - taken).max() <= float(seen.slack) + 1e-9
            apart = np.linalg.norm(one[:, None] - other, axis=-1) - np.linalg.norm(taken, axis=-1)
            assert np.abs(apart).max() <= 2 * float(seen.slack) + 1e-9
            assert inner.line == 1


@pytest.mark.parametrize("number", range(30))
def test_no_point_is_further_from_its_line(rng, number):
    mesh = StlMesh(rng.uniform(-2, 2, (3, 3, 3)), Fraction(0))
    letters, at = rng.permutation(list("ABC")), rng.uniform(-9, 9, 3)
    pivots = rng.uniform(-50, 50, (3, 3))
    axes = zip(letters, pivots, strict=True)
    chain = tuple(Axis(letter, letter, 1, exactly(pivot)) for letter, pivot in axes)
    radii = Body("", mesh, "", exactly(at), chain).radii(Fraction(1))
    for outer in range(3):
        found = 0.0
        for _ in range(300):
            points = mesh.facets.reshape(-1, 3) + at
            for letter, pivot in [*zip(letters, pivots, strict=True)][:outer:-1]:
                turn = turned_about(LETTERS.index(letter) % 3, rng.uniform(0, 2 * np.pi))
                points = (points - pivot) @ turn.T + pivot
            off = np.delete(points - pivots[outer], LETTERS.index(letters[outer]) % 3, 1)
            found = max(found, np.linalg.norm(off, axis=1).max())
        assert found <= float(radii[outer]) and radii[outer] < 4 * found


def exactly(numbers):
    """Return numbers as they are."""
    return vector(Fraction(float(c)) for c in numbers)


def holds(piece, part, real, free):
    """Return whether a piece has a part of a straight move, or angles of one that is not."""
    low, high = (np.array([float(c) for c in end]) for end in piece.program[0].turns)
    if not free:
        return piece.part[0] <= part <= piece.part[1]
    return bool(((np.minimum(low, high) <= real[3:]) & (real[3:] <= np.maximum(low, high))).all())


LENGTH = 6.0
# Degrees that axes may be off.
OFF = 3


def written(tmp_path, rng, turning=True):
    """Write the meshes of a machine by random.

    Returns its file, its objects, what they carry of which mesh, the base of its coordinates, whether rapids
    are straight.
    """
    things, (spindle, table), nose, zero = made_up(rng, turning)
    meshes, parts = {}, []
    for name, thing in things.items():
        if thing.mesh is not None:
            scenes.write_stl(tmp_path / f"{name}.stl", thing.mesh)
            meshes[name] = name, read_stl(tmp_path / f"{name}.stl").facets + thing.at
        file, at = (None, None) if thing.mesh is None else (f"{name}.stl", thing.at.tolist())
        pivot = None if thing.pivot is None else thing.pivot.tolist()
        parts.append(entry(name, thing.on, thing.axis, pivot, file, at))
    small = scenes.box((-2, -2, 0), (2, 2, 6)), scenes.box((-5, -4, -3), (5, 4, 3))
    for name, mesh, on, at in (
        ("tool", small[0], spindle, nose - [0, 0, LENGTH]), ("work", small[1], table, nose + zero),
    ):  # fmt: skip
        scenes.write_stl(tmp_path / f"{name}.stl", mesh)
        meshes[{"tool": "tool", "work": "workpiece"}[name]] = on, mesh.astype(np.float64) + at
    straight = rng.random() < 0.7
    machine = "".join(
        (
            f'rapids = "{"straight" if straight else "any"}"\nloaded = 1\n[offsets]\nG54 = {zero.tolist()}\n',
            TOOL.format(LENGTH), *parts, carriers(spindle, table, nose.tolist()),
        )
    )  # fmt: skip
    base = np.array([zero[0], zero[1], zero[2] + LENGTH, 0, 0, 0])
    return machine, things, meshes, base, straight


# The first line that moves in a program that is checked; poses on each move.
FIRST, EACH = 2, 120
# As many each time; all of them take minutes.
MADE_UP = [*range(4), *(pytest.param(number, marks=pytest.mark.long) for number in range(4, 24))]


def near_by(things, meshes, one, other, pose, distance):
    """Return whether two objects are within a distance, along x, y, z of what carries both, at a pose."""
    (a, mesh), (b, other_mesh) = meshes[one], meshes[other]
    pose = pose.copy()
    for common in axes_of(things, a) & axes_of(things, b):
        pose[LETTERS.index(things[common].axis[-1])] = 0
    return within(moved(things, a, mesh, pose), moved(things, b, other_mesh, pose), distance)


@pytest.mark.parametrize("number", MADE_UP)
def test_machines_made_up(checked, tmp_path, rng, number):
    machine, things, meshes, base, straight = written(tmp_path, rng)
    letters = {thing.axis[-1] for thing in things.values() if thing.axis and thing.axis[-1] in "ABC"}
    start = rng.uniform(-9, 9, 3).round(2)
    here, poses, lines, ways = np.zeros(6), [], [], []
    here[:3] = start
    for _ in range(rng.integers(1, 5)):
        to = here.copy()
        for k, letter in enumerate(LETTERS):
            if rng.random() < 0.6 and (k < 3 or letter in letters):
                to[k] = rng.uniform(-25, 25) if k < 3 else rng.uniform(-120, 120)
        to = to.round(2)
        if (to == here).all():
            continue
        rapid = rng.random() < 0.5
        words = "".join(f" {letter}{to[k]}" for k, letter in enumerate(LETTERS) if to[k] != here[k])
        lines.append(("G0" if rapid else "G1") + words)
        free = rapid and not straight
        poses += [here + (to - here) * (rng.random(6) if free else rng.random()) for _ in range(EACH)]
        ways.append((here, to))
        here = to
    if not lines:
        return
    first = [str(c) for c in start + np.array([0, 0, LENGTH])]
    words = ["--surfaces-only", "--clearance", "0.3", "--resolution", "0.01", "--slow", "1", "--warn", "3"]
    # Without a profile of those alone that were nearest.
    asked = number % 3 > 0
    words += ["--profile", "7"] * asked
    status, said, report = checked(machine, "\n".join(lines), *words, start=first)
    assert status < 2, said
    near = partial(near_by, things, meshes)
    moving = [
        (one, other)
        for one, other in combinations(meshes, 2)
        if axes_of(things, meshes[one][0]) != axes_of(things, meshes[other][0])
    ]
    assert len(report["profile"]) >= (7 if asked and not status else asked or not status)
    for place in report["profile"]:
        pose, (here, to) = np.array([*place["position"], *place["angles"]], np.float64), ways[place["move"]]
        moves = to != here
        parts = (pose - here)[moves] / (to - here)[moves]
        assert np.ptp(parts) < 1e-6 and (pose == here)[~moves].all(), place
        pose = pose + base
        proven, (what, of) = (
            place["proven"] - 1e-5,
            (place[key].removeprefix("the ") for key in ("what", "of")),
        )
        assert near(what, of, pose, place["seen"] + 1e-5), place
        assert not (proven > 0 and any(near(*pair, pose, proven) for pair in moving)), place
        assert not asked or place["seen"] - place["proven"] < 0.15 + place["seen"] / 16
    if status:
        found = report["near"]
        pose = np.array([float(c) for c in (*found["position"], *found["angles"])])
        what, of = (report[key].removeprefix("the ") for key in ("what", "of"))
        assert near(what, of, pose + base, 0.3 + float(report["false_alarm_band"]) + 1e-5), said
        return
    for one, other in moving:
        of_these = {f"the {one}", f"the {other}"}
        zones = [zone for zone in report["zones"] if {zone["what"], zone["of"]} == of_these]
        assert [zone["within"] for zone in zones] == [1, 3]
        for number, pose in enumerate(poses):
            line = FIRST + number // EACH
            beyond = [0.3, *(zone["within"] for zone in zones if line not in zone["lines"])]
            assert not near(one, other, pose + base, beyond[-1] - 1e-5), (one, other, pose, machine, lines)


@pytest.mark.parametrize("number", MADE_UP)
def test_wherever_a_piece_permits_the_tool_each_two_objects_are_clear(tmp_path, rng, number):
    """And where one does not, two are near at some place of it, but for the band of false alarms."""
    text, things, meshes, base, _ = written(tmp_path, rng, turning=number % 2 > 0)
    text = f"turn_tolerance = {OFF}\n{text}"
    # An object may touch what is on the other side of the board, or not.
    objects = [name for name in meshes if name not in CARRIED]
    touching = (str(rng.choice(objects)), str(rng.choice(CARRIED[:2]))) if objects and number % 3 == 2 else ()
    if touching:
        named = f'name = "{touching[0]}"\n'
        text = text.replace(named, f'{named}may_touch = ["{touching[1]}"]\n')
    (tmp_path / "m.toml").write_text(text)
    machine, program = read_machine(tmp_path / "m.toml"), tmp_path / "p.nc"
    places = rng.uniform(-15, 15, (5, 3)).round(2)
    lines = [f"G{int(rng.integers(2))} X{x} Y{y} Z{z}" for x, y, z in places[1:]]
    turns = np.array([round(rng.uniform(20, 99), 1) * (letter in machine.rotary) for letter in "ABC"])
    if turns.any():
        words = (f"{letter}{c}" for letter, c in zip("ABC", turns, strict=True) if c)
        lines.insert(0, f"G0 {' '.join(words)}")
    program.write_text("\n".join(("G21 G90 G61 G43 H1 F100", *lines, "")))
    read = read_program(program, exactly(places[0] + [0, 0, LENGTH]), False, machine)
    *_, read = stands_and_turns(read, Fraction(OFF))
    wanted = Wanted(Fraction(3, 10), Fraction(1, 100), Fraction(2), Fraction(1), None)
    work = read_stl(tmp_path / "work.stl"), tmp_path / "work.stl"
    setup = Setup(machine.tools[1], work, None, machine)
    supervised = Supervision.of(setup, read, rules_of(setup, read, 0), wanted)
    tool, fixed = supervised.tool, supervised.work
    wanted = replace(wanted, clearance=wanted.clearance + supervised.off)
    scene = prepare_path(tool.mesh, fixed.mesh, (tool.files, fixed.files), read, wanted)
    engine = scene_engine(BULK, scene.a, scene.b, scene.grid.width)
    found = pieces(scene, engine, Fraction(2), beside=partial(supervised.near_beside, scene))
    pairs = [
        (one, other)
        for one, other in combinations(meshes, 2)
        if axes_of(things, meshes[one][0]) != axes_of(things, meshes[other][0])
        and {one, other} != set(touching)
    ]
    chosen = rng.choice(len(found), min(len(found), 40), replace=False)
    for piece in (found[k] for k in chosen):
        sample = np.array([float(c) for c in scene.path.position(vector(map(Rational, piece.sample)))])
        reach = float(piece.reach) / 100
        cube = sample + reach * np.array([*product((-1, 0, 1), repeat=3)])
        # Axes that turn may be off, and the tool is wherever a control says that it is.
        off = turns + OFF * rng.integers(-1, 2, 3) * (turns != 0)
        for one, other in pairs:
            seen = [
                near_by(things, meshes, one, other, np.append(place, off) + base, distance)
                for place, distance in [(place, 0.3 - 1e-5) for place in cube] * (not piece.near)
            ]
            assert not any(seen), (one, other, piece, text, lines)
        if piece.near:
            assert reach < 2
            most = max(float(supervised.off), *(float(two._off) / 100 for two in supervised.beside), 0.0)
            beyond = 0.3 + 4 * reach + 0.05 + 2 * most
            names = [name.removeprefix("the ") for name in piece.beside] if piece.beside else None
            for one, other in [names] if names else pairs:
                if near_by(things, meshes, one, other, np.append(sample, turns) + base, beyond):
                    break
            else:
                raise AssertionError((piece, text, lines))


def test_both_readers_turn_alike(tmp_path):
    if shutil.which("rs274") is None:
        pytest.skip("rs274 is not installed")
    program = tmp_path / "p.nc"
    scenes.write_stl(tmp_path / "tool.stl", scenes.box((-3, -3, 0), (3, 3, 50)))
    for mesh in ("table", "post", "head"):
        scenes.write_stl(tmp_path / f"{mesh}.stl", scenes.box((0, 0, 0), (1, 1, 1)))
    (tmp_path / "m.toml").write_text(MILL)
    machine = read_machine(tmp_path / "m.toml")
    program.write_text(
        "G21 G90 G61 F100\nG0 X1 C12.5\nG91 C-30\nG20 G1 C.0625 Y1\nG90\nC0\nG2 I1\nG1 C[1/3]\nM2\n"
    )
    own, other = (read(program, NOWHERE, False, machine) for read in (read_program, read_by_rs274))
    assert len(own.moves) == len(other.moves) == 6
    for one, two in zip(own.moves, other.moves, strict=True):
        for mine, theirs in zip(one.turns, two.turns, strict=True):
            assert all(abs(a - b) <= two.turn_slack for a, b in zip(mine, theirs, strict=True))
    program.write_text("G21 G90 G61 F100\nG0 X1\nG92 C5\nC10\nG92.1\nC4\nM2\n")
    turns = [float(move.turns[1][2]) for move in read_by_rs274(program, NOWHERE, False, machine).moves]
    assert turns == [0, 5, 4]
    # What is not printed of an angle is no turn.
    program.write_text("G21 G90 G61 F100\nG1 X3 C[1/3]\nG92 C[1/7]\nG2 X30 I13.5\nG64 P.1\nG1 X31\nM2\n")
    assert not any(move.turning for move in read_by_rs274(program, NOWHERE, False, machine).moves[1:])
    for line in ("G28", "G30 C5", "G28 X0 C5", "G92.1\nG[28] C5", "G2 X2 I.5 C5"):
        program.write_text(f"G21 G90 G61 F100\nG0 X1\n{line}\nM2\n")
        with pytest.raises(InputError, match="arc on which axes turn" if "I" in line else "name X, Y or Z"):
            read_by_rs274(program, NOWHERE, False, replace(machine, homes={"G28": NOWHERE, "G30": NOWHERE}))
    assert [move.turns[1][2] for move in own.moves[:5]] == [
        Fraction(25, 2), Fraction(-35, 2), Fraction(-35, 2) + Fraction(1, 16), 0, 0,
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("program", "why"),
    [
        ("G0 B1", "not an axis of the machine"),
        ("G2 X2 I1 C5", "G2 does not turn axes"),
        ("G0 C4000", "turns by more than 3600 degrees"),
        ("G98 G81 Z5 R8 C5", "G81 does not turn axes"),
        ("G92 C5", "axes that turn have no offsets here"),
        ("G10 L2 P1 C5", "axes that turn have no offsets here"),
        ("G28", "name X, Y or Z"),
        ("G0 C5 C6", "C stands twice"),
        ("C5", "no G0 or G1"),
        ("G64 P0.1\nG0 C5", "give turn_tolerance"),
        ("G0 C5\nG64 P0.1\nG0 X5", "give turn_tolerance"),
    ],
)
def test_what_does_not_turn_is_refused(checked, program, why):
    status, said, _ = checked(MILL.replace("[offsets]", "[homes]\nG28 = [0, 0, 0]\n[offsets]"), program)
    assert status == 2 and why in said and "p.nc: line " in said, said


def test_angles_are_those_of_the_place_that_is_told(checked, tmp_path):
    """Where neither of the two objects turns, too."""
    scenes.write_stl(tmp_path / "slide.stl", scenes.box((-10, -5, -20), (10, 5, -12)))
    slide, table = entry("slide", "saddle", "-X"), entry("table", "slide", "C", [0.0, 0.0, 0.0], "table.stl")
    machine = MILL.replace(slide, entry("slide", "saddle", "-X", mesh="slide.stl"))
    machine = machine.replace(table, entry("table", "slide", "C", [0.0, 0.0, 0.0]))
    # That comes near before, and turns.
    machine = machine.replace('name = "bed"', 'name = "bed"\nmay_touch = ["workpiece"]')
    status, said, _ = checked(machine, "G0 Z60\nG1 F9 X-58 C90")
    assert status == 1
    place = re.search(r"at X(\S+) .* C(\S+) the bed comes .* of the slide", said)
    assert place, said
    assert float(place[2]) == pytest.approx(float(place[1]) / -58 * 90, abs=0.01)


def test_what_is_undecided_is_said(checked, monkeypatch):
    monkeypatch.setattr(rule_check, "_MOST_PIECES", 9)
    status, said, _ = checked(MILL, "G0 Z60\nX-9 C45")
    assert status == 2 and "line 3: undecided after 9 parts of its turn" in said


def test_a_picture_shows_the_machine_where_two_objects_come_near(checked, tmp_path, monkeypatch):
    drawn: list[tuple[str, np.ndarray]] = []
    real = picture._add_mesh

    def add(axes, facets, colour, alpha):
        drawn.append((colour, facets))
        real(axes, facets, colour, alpha)

    monkeypatch.setattr(picture, "_add_mesh", add)
    file = tmp_path / "machine.svg"
    status, said, report = checked(MILL, "G0 Z60\nX-9 C45", "--picture", file)
    assert status == 1 and "the bed comes within 0.5 mm of the table in line 3" in file.read_text(), said
    assert [colour for colour, _ in drawn] == [figures.A.colour, figures.B.colour, *[picture._WORK] * 3]
    # The corner of the table where its slide and the turn have it.
    angle = np.radians(float(report["near"]["angles"][2]))
    corner = 50 * (np.cos(angle) + np.sin(angle)) - float(report["near"]["position"][0])
    table = drawn[1][1]
    assert table[..., 0].max() == pytest.approx(corner)
    assert "rapid" not in file.read_text()
    # Where all is clear nothing is marked; and where nothing turns the tool's way is shown.
    drawn.clear()
    status, said, _ = checked(MILL, "G0 Z60\nX2", "--picture", file)
    assert status == 0 and {colour for colour, _ in drawn} == {picture._WORK}, said
    assert "rapid" in file.read_text() and "all is clear by more than" in file.read_text()
    # The tool stands where the program begins.
    assert drawn[2][1][..., 2].min() == pytest.approx(100)
    # With a profile the clearance along the path is shown beside it.
    status, said, report = checked(MILL, "G0 Z60\nX-9 C45", "--picture", file, "--profile", "40")
    shown = file.read_text()
    assert f"clearance at {len(report['profile'])} places" in shown and "wanted: 0.5 mm" in shown
    least = min(report["profile"], key=lambda place: place["seen"])
    assert (least["what"], least["of"], least["line"]) == ("the bed", "the table", 3)
    assert f"places: least in line 3 at X{float(least['position'][0]):.4f}" in said


def test_an_angle_that_stays_is_none(checked):
    status, said, _ = checked(MILL, "G0 Z60\nX20\nC10\nG2 X22 I1 C#5425\nG98 G81 X23 Z55 R58 C10\nG80")
    assert status == 0, said


def test_an_axis_of_nothing_turns_nothing(checked):
    machine = MILL.replace("[spindle]", entry("spare", axis="A", pivot=[0.0, 0.0, 0.0]) + "[spindle]")
    assert checked(machine, "G0 Z60 A30")[0] == 0


def test_nothing_comes_into_an_open_mesh_by_a_coarse_turn(checked, tmp_path):
    """Above a box without a lid, so near that the first parts of a turn are too coarse to tell."""
    scenes.write_stl(tmp_path / "work.stl", scenes.box((-20, -20, 0), (20, 20, 20))[:-2])
    machine = MILL.replace('name = "bed"', 'name = "bed"\nmay_touch = ["table"]')
    machine = machine.replace('mesh = "tool.stl"', "parts = [{ diameter = 1, length = 1 }]")
    status, said, report = checked(machine, "G0 Z21\nC90")
    assert status == 0, said
    # Each that is open is named, and not only what was checked last.
    assert said.count("not closed: 4 edges") == 1, said
    assert {tuple(one["open_edges"]) for one in report["tools"]} == {(0, 4), (0, 0)}


def test_a_turn_within_an_open_stock_is_undecided(checked, tmp_path):
    """For `path`, and when `watch` cuts its pieces."""
    files = tmp_path / "work.stl", tmp_path / "open.stl"
    scenes.write_stl(files[1], scenes.box((-30, -30, 25), (30, 30, 80))[1:])
    machine = MILL.replace('mesh = "tool.stl"', "parts = [{ diameter = 6, length = 8, cuts = true }]")
    assert "open.stl: verdict unknown" in checked(machine, "G0 C5", "--stock", files[1])[1]
    mill = read_machine(tmp_path / "m.toml")
    program = read_program(tmp_path / "p.nc", vector(map(Fraction, (0, 0, 100))), False, mill)
    work, stock = ((read_stl(file), file) for file in files)
    wanted = Wanted(Fraction(1), Fraction(1, 100), Fraction(1), Fraction(1), None)
    with pytest.raises(InputError, match=r"open.stl at the start of line 2: verdict unknown"):
        list(parts_of(Setup(mill.tools[1], work, stock, mill), program, wanted, ()))


def test_axes_that_turn_may_be_off(checked):
    near = "G0 Z60\nX12\nG64 P0.01\nC-90\nC0"
    for degrees, wanted in (("0.01", 0), ("3", 1)):
        machine = f"turn_tolerance = {degrees}\n" + MILL
        status, said, _ = checked(machine, near)
        assert status == wanted, said


@pytest.mark.parametrize(
    ("before", "after", "why"),
    [
        ('name = "slide"', 'name = "saddle"', "object 3: 'name': must be given, and no other's"),
        ('name = "slide"', 'name = "tool"', "object 3: 'name'"),
        (
            'on = "saddle"',
            'on = "table"',
            "object 3, slide: 'on': must be an object that stands before it (bed, saddle)",
        ),
        ('axis = "-X"', 'axis = "X"', "by X the tool, seen from the workpiece, does not move"),
        ('axis = "-X"', 'axis = "-Y"', "object 3, slide: 'axis': must be another"),
        ('axis = "-X"', 'axis = "U"', "object 3, slide: 'axis': must be X, Y"),
        ('axis = "C"', 'axis = "-Z"', "object 4, table: 'pivot': must be given for A, B and C"),
        ("pivot = [0.0, 0.0, 0.0]\n", "", "object 4, table: 'pivot'"),
        ('on = "slide"\naxis = "C"', "", "object 4, table: 'pivot': must be of an axis"),
        ('[spindle]\non = "head"', "[spindle]", "spindle: 'on'"),
        ("nose = [0.0, 0.0, 250.0]", "", "spindle: 'nose'"),
        ("G54 = [0.0, 0.0, -250.0]", "", "G54 says: give its offset"),
        ("length = 50", "", "the length of each is needed"),
        ('name = "bed"', 'name = "bed"\nmay_touch = ["sadle"]', "object 1, bed: 'may_touch'"),
        ('name = "bed"', 'name = "bed"\nmay_touch = "saddle"', "object 1, bed: 'may_touch'"),
        (
            'name = "bed"',
            'name = "bed"\nmay_touch = ["bed"]',
            "object 1, bed: 'may_touch': must be of others",
        ),
        ('name = "bed"', 'name = "bed"\nweight = 5', "object 1, bed: 'weight': not known"),
        ('name = "bed"', 'name = "bed"\non = ""', "object 1, bed: 'on': must be an object that stands"),
        ('mesh = "post.stl"', "at = [1.0, 2.0, 3.0]", "object 1, bed: 'at': must be of a mesh"),
        ("loaded = 1", "loaded = 1\nturn_tolerance = -1", "'turn_tolerance': must be not negative"),
        (
            'mesh = "post.stl"',
            'mesh = "po\\u0000st.stl"',
            "object 1, bed: 'mesh': must be the name of a file",
        ),
        ("number = 1", "number = 0", "'length': must be not negative, and 0 of an empty spindle"),
        ('name = "head"\n', 'name = "head"\non = "table"\n', "nothing that turns carries linear axes"),
    ],
)
def test_machines_that_are_none(checked, before, after, why):
    assert before in MILL
    status, said, _ = checked(MILL.replace(before, after, 1), "G0 X1")
    assert status == 2 and why in said, said


def test_a_tool_that_does_not_reach_the_spindle_is_told(checked):
    assert "mm above its tip" not in checked(MILL, "G0 Z60")[1]
    said = checked(MILL.replace("length = 50", "length = 60"), "G0 Z60")[1]
    assert "note: tool.stl: ends 50 mm above its tip, and the spindle's nose is at 60" in said


def test_what_may_touch_is_not_looked_at(checked):
    machine = MILL.replace('name = "bed"', 'name = "bed"\nmay_touch = ["table"]')
    assert checked(MILL, "G0 Z60\nC30")[0] == 1
    leaning = MILL.replace('name = "bed"', 'name = "bed"\nat = [-11, 0, 0]')
    assert "name one in may_touch of the other" in checked(leaning, "G0 Z60")[1]
    status, _, report = checked(machine, "G0 Z60\nC30")
    assert status == 0 and not any(
        {one["what"], one["of"]} == {"the bed", "the table"} for one in report["tools"]
    )


def test_where_a_table_turned_the_tool_has_not_been(checked, tmp_path):
    """Down again at another angle is not back."""
    mill = MILL.replace('mesh = "tool.stl"', "parts = [{ diameter = 6, length = 50, cuts = true }]")
    cut = "G0 Z42\nG1 X5 Z30\nG0 Z42\n"
    stock = ("--stock", tmp_path / "stock.stl", "--clearance", "0.4")
    for program, near in ((f"{cut}Z30", None), (f"{cut}C5\nZ30", 6), (f"{cut}C5\nC0\nZ30", 7)):
        status, said, report = checked(mill, program, *stock)
        assert (report["near"] and report["near"]["line"]) == near, said
        assert status == int(near is not None)


def test_a_tilted_tool_does_not_come_out_along_itself(checked, tmp_path):
    parts = "parts = [{ diameter = 6, length = 30, cuts = true }, { diameter = 6, length = 20 }]"
    swivel = entry("swivel", "head", "B", [0.0, 0.0, 250.0])
    mill = MILL.replace('mesh = "tool.stl"', parts).replace("[spindle]", swivel + "[spindle]")
    mill = mill.replace('name = "head"', 'name = "head"\nmay_touch = ["tool"]')
    mill = mill.replace('on = "head"', 'on = "swivel"', 2).replace('on = "swivel"', 'on = "head"', 1)
    for angle, near in ((0, None), (10, 6)):
        program = f"G0 Z60\nB{angle}\nG1 Z30\nX1\nG0 Z60"
        status, said, report = checked(mill, program, "--stock", tmp_path / "stock.stl")
        assert (report["near"] and report["near"]["line"]) == near, said
        assert status == int(near is not None) and (not near or "the cutter" in report["what"])


@pytest.mark.skipif(mesh_data() is None, reason="no real meshes: set TRIAXIS_DATA to a folder with vmc/*.stl")
def test_a_machining_centre(tmp_path, capsys):
    """The carousel is apart from the head when that is up, and touches it at Z-250; its arm turns."""
    data = mesh_data()
    assert data is not None
    folder = data / "vmc"
    for mesh in ("base", "head", "saddle", "table", "arm", "carousel"):
        (tmp_path / f"{mesh}.stl").write_bytes((folder / f"{mesh}.stl").read_bytes())
    scenes.write_stl(tmp_path / "tool.stl", scenes.box((-0.3, -0.3, 0), (0.3, 0.3, 5)))
    scenes.write_stl(tmp_path / "work.stl", scenes.box((-3, -3, 0), (3, 3, 2)))
    machine = (
        HEAD.replace("-250.0", "-559.0")
        + TOOL.format(50)
        + entry("base", mesh="base.stl", may_touch=["saddle", "head", "arm", "carousel"])
        + entry("arm", axis="C", mesh="arm.stl", pivot=[0, 0, 0], may_touch=["head"])
        + entry("carousel", "arm", mesh="carousel.stl")
        + entry("saddle", axis="-Y", mesh="saddle.stl", at=[0, 70, 0], may_touch=["table"])
        + entry("table", "saddle", "-X", mesh="table.stl", at=[0, 80, 0])
        + entry("head", axis="Z", mesh="head.stl", at=[0, 0, 40])
        + carriers("head", "table", (0.0, 560.0, 940.0))
    )
    (tmp_path / "m.toml").write_text(machine)
    for way, near in (
        ("X50\nZ460\nX-80 Y30", None),
        ("X50\nZ250\nX-80 Y30", "the carousel comes within 0.5 mm of the head"),
        ("C-20\nZ250", None),
        ("C20\nZ460", "the carousel comes within 0.5 mm of the tool"),
    ):
        (tmp_path / "p.nc").write_text(f"G21 G90 G61 G43 H1 F500\nG0 Z500\n{way}\n")
        files = [tmp_path / name for name in ("m.toml", "work.stl", "p.nc")]
        words = ["path", *files, "--scale", "10", "--start", "0", "0", "559", "--engine", "bulk"]
        status = main([str(word) for word in (*words, "--surfaces-only", "--resolution", "0.01")])
        said = "".join(capsys.readouterr())
        assert status == (near is not None) and (near or "CLEAR") in said, said


@pytest.mark.long
def test_the_mill_to_try(tmp_path, capsys):
    """As host.md has it."""
    files = [str(file) for file, _ in write_mill(tmp_path)]
    within = list[tuple[float, str, str, list[int]]]()
    for program, near in (("part.nc", None), ("crash.nc", (9, "the cutter", "the stock"))):
        words = [files[0], tmp_path / "vise.stl", tmp_path / program, "--stock", tmp_path / "blank.stl"]
        words += ["--start", 0, 0, 400, "--engine", "bulk", "--resolution", 0.01, "--slow", 8, "--warn", 14]
        status = main(["path", *map(str, (*words, "--json", tmp_path / "r.json"))])
        said, report = capsys.readouterr().out, read_published(tmp_path / "r.json", "path")
        found = (report["near"]["line"], report["what"], report["of"]) if report["near"] else None
        assert (status, found) == (int(near is not None), near), said
        if near is None:
            within += [(z["within"], z["what"], z["of"], z["lines"]) for z in report["zones"] if z["moves"]]
    # Rapids of a drilling cycle come near the stock; turns do not.
    assert sorted(within) == [
        (8, "the cutter", "the stock", [19, 20]),
        (14, "the cutter", "the stock", [19, 20]),
        (14, "the table", "the trunnion", [*range(4, 15), *range(17, 21), 22]),
        (14, "the tool", "the workpiece", [11, 12, 13, 19, 20]),
    ]
    assert "NEAR: line 9: at X0.0000 Y0.0000 Z62.0000 A9.2798 the cutter comes within 0.5 mm" in said


def test_without_a_profile_no_place_has_more_than_the_least_of_all(checked):
    """The bed is 10 mm from the table all along, which nobody looks at once the tool is nearer elsewhere."""
    status, said, report = checked(MILL, "G1 Z22")
    assert status == 0 and {place["position"][2] for place in report["profile"]} > {50, 22}, said
    assert all(place["proven"] <= 10 for place in report["profile"]), report["profile"]
