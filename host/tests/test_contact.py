"""What may touch what while a program runs: feeds of the cutter into the stock, and nothing else."""

from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import pytest

from triaxis.host import scenes
from triaxis.host.cli import main
from triaxis.host.engines import scene_engine
from triaxis.host.motion.contact import Setup, rules_of
from triaxis.host.motion.machine_file import read_machine
from triaxis.host.motion.moves import Move, Program
from triaxis.host.motion.operations import Operation, parts_of
from triaxis.host.motion.path_check import _near_at, check_path
from triaxis.host.motion.path_scene import Wanted, prepare_path
from triaxis.host.motion.program import read_program
from triaxis.host.quantise import vector
from triaxis.host.stl import read_stl
from triaxis.host.tests.published import read_published

HERE = (Fraction(0), Fraction(0), Fraction(20))
START = ("--start", "0", "0", "20")
CUTS = "{{ diameter = {}, length = {}, cuts = true }}"
SHANK = "{{ diameter = {}, length = {} }}"
# A mill of 6 mm that cuts 8 mm deep, on a shank, or on a neck; wider in the middle; in two places; wider at
# the tip; all that cuts.
MILL = ", ".join((CUTS.format(6, 8), SHANK.format(6, 30), SHANK.format(20, 9)))
NECKED = ", ".join((CUTS.format(6, 8), SHANK.format(4, 30)))
STEPPED = ", ".join((CUTS.format(4, 2), CUTS.format(6, 6), SHANK.format(4, 30)))
TWO = ", ".join((CUTS.format(6, 4), SHANK.format(2, 4), CUTS.format(6, 4), SHANK.format(6, 30)))
DOVETAIL = ", ".join((CUTS.format(6, 2), CUTS.format(4, 6), SHANK.format(4, 20)))
BLADE = CUTS.format(6, 8)
# A block under Z0, on a table.
STOCK, TABLE = scenes.box((-40, -40, -20), (40, 40, 0)), scenes.box((-60, -60, -30), (60, 60, -21))
AWAY = "G0 X0 Y0 Z20"


@dataclass(frozen=True)
class Found:
    """What the command said."""

    status: int
    said: str
    report: dict

    @property
    def near(self):
        """Return the line, and what comes near what."""
        near = self.report["near"]
        return (near and near["line"], self.report["what"], self.report["of"])


@pytest.fixture
def written(tmp_path):
    """Return a function that writes a program, and a machine with tools of such parts, beside the meshes."""
    scenes.write_stl(tmp_path / "stock.stl", STOCK)
    scenes.write_stl(tmp_path / "work.stl", TABLE)

    def write(program, parts, second=None):
        shapes = {1: parts, 2: second or parts}
        tools = "".join(f"[[tools]]\nnumber = {k}\nlength = 0\nparts = [{shapes[k]}]\n" for k in shapes)
        (tmp_path / "m.toml").write_text(f'rapids = "straight"\nloaded = 1\n{tools}')
        (tmp_path / "p.nc").write_text(f"G21 G90 G61 F100\n{program}\n")

    return write


@pytest.fixture
def checked(written, tmp_path, capsys):
    """Return a function that checks a program with a tool of such parts, by which stocks."""
    stock, work, moves, machine = (tmp_path / name for name in ("stock.stl", "work.stl", "p.nc", "m.toml"))

    def run(program, parts=MILL, *words, stocks=(stock,), start=START, second=None):
        written(program, parts, second)
        files = (machine, work, moves, "--engine", "bulk", "--json", tmp_path / "report.json")
        chosen = [word for one in stocks for word in ("--stock", one)]
        status = main([str(word) for word in ("path", *files, *start, *chosen, *words)])
        said = "".join(capsys.readouterr())
        return Found(status, said, read_published(tmp_path / "report.json", "path"))

    return run


CLEAR = (None, "the cutter", "the stock")
CUTS_AND_CRASHES = pytest.mark.parametrize(
    ("parts", "program", "near"),
    [
        # In, along, straight up; without the stock's rule the first cut is near.
        (MILL, "G0 Z2\nG1 Z-5\nX20\nG2 X10 Y10 I-10 J0\nG0 Z10\nX0 Y0", CLEAR),
        (MILL, "G0 Z-1\nG0 Z9", (2, "the cutter", "the stock")),
        (MILL, "G0 Z2\nG1 Z-5\nX20\nG0 X10\nZ10", (5, "the cutter", "the stock")),
        (MILL, "G0 Z2\nG1 Z-5\nX20\nG0 X30 Z30", (5, "the cutter", "the stock")),
        # Back down to where it has been, and deeper; where it has been elsewhere does not count.
        (MILL, "G0 Z2\nG1 Z-4\nG0 Z5\nZ-4\nG1 Z-7\nG0 Z5\nZ-6.9\nZ20", CLEAR),
        (MILL, "G0 Z2\nG1 Z-4\nG0 Z5\nZ-4.1", (5, "the cutter", "the stock")),
        (MILL, "G0 Z2\nG1 Z-4\nG0 Z5\nX0.1\nX0\nZ-4", (7, "the cutter", "the stock")),
        (MILL, "G0 Z2\nG98 G83 X5 Z-7 R1 Q2\nX9 Y3\nG80 G0 Z20", CLEAR),
        # Where it feeds through the air nothing is said of what comes after.
        (MILL, "G0 Z2\nG1 X50\nG0 Z-5\nX43.6", CLEAR),
        (MILL, "G0 Z2\nG1 X50\nG0 Z-5\nX43.4", (5, "the cutter", "the stock")),
        # Deeper than it cuts: the shank, whatever it does there; and what lies below the stock.
        (MILL, "G0 Z2\nG1 Z-7.4\nG0 Z20", CLEAR),
        (MILL, "G0 Z2\nG1 Z-7.6\nG0 Z20", (3, "the tool's body", "the stock")),
        (BLADE, "G0 Z2\nG1 X50\nZ-20.6\nX20", (4, "the tool", "the workpiece")),
        # After a change of the tool, to the same one, nobody knows how it came there.
        (MILL, "G0 Z2\nG1 Z-5\nT1 M6 G0 Z20", (4, "the cutter", "the stock")),
        # Where it feeds from then on it has not been, either.
        (MILL, "G0 Z2\nG1 Z-5\nT1 M6 G1 Z-1\nG0 Z20\nG0 Z-5", (6, "the cutter", "the stock")),
        # A neck leaves what is above the cutter to the cutter: it comes out of no undercut.
        (NECKED, "G0 Z2\nG1 Z-7.4\nX5\nG0 Z20", CLEAR),
        (NECKED, "G0 Z2\nG1 X50\nG1 Z-12\nX42.7\nG0 Z20", (6, "the cutter's top", "the stock")),
        (STEPPED, "G0 Z2\nG1 X50\nG1 Z-12\nX42.7\nG0 Z20", (6, "the cutter's top", "the stock")),
        # It may cut its way up, and then has not been where it would go down again.
        (NECKED, "G0 Z2\nG1 X50\nG1 Z-12\nX42.7\nG1 Z20", CLEAR),
        (NECKED, "G0 Z2\nG1 X50\nZ-12\nX42.7\nG3 Z2 I10 J0\nG0 Z-12", (7, "the cutter", "the stock")),
        # Nothing is known of what cuts in several places.
        (TWO, "G0 Z2\nG1 X50\nG1 Z-11\nX42.7\nG0 Z20", (6, "the cutter", "the stock")),
        (DOVETAIL, "G0 Z2\nG1 Z-5\nG0 Z20", (4, "the cutter", "the stock")),
        # Wholly inside, where no facets are near: not of a rapid.
        (BLADE, "G0 Z2\nG1 Z-14\nG0 X5", (None, "the cutter", "the stock")),
    ],
)


@CUTS_AND_CRASHES
def test_cutting_is_allowed_and_crashing_is_not(checked, parts, program, near):
    found = checked(program, parts)
    inside = "the cutter is inside the stock" in found.said
    assert (found.status, found.near) == (int(near[0] is not None or inside), near), found.said
    assert inside == ("Z-14" in program) and "what is cut away is not tracked" in found.said
    if near[0] is not None:
        assert f"{near[1]} comes within 0.5 mm of {near[2]}" in found.said
        assert found.report["near"]["move"] == near[0] - 2


def pieces_of(folder, program, start, clearance=Fraction(1, 2), shortest=Fraction(1, 16)):
    """Return the pieces by which `watch` would follow a program, with a stock, of one tool."""
    machine = read_machine(folder / "m.toml")
    work, stock = ((read_stl(folder / name), folder / name) for name in ("work.stl", "stock.stl"))
    wanted = Wanted(clearance, Fraction(1, 100), shortest, Fraction(1), None)
    setup = Setup(machine.tools[1], work, stock, machine)
    (part,) = parts_of(setup, read_program(program, start, False, machine), wanted, ())
    assert isinstance(part, Operation)
    return part.pieces


@CUTS_AND_CRASHES
def test_a_machine_is_stopped_before_what_a_path_finds(written, tmp_path, parts, program, near):
    written(program, parts)
    inside = "Z-14" in program
    first = next((piece for piece in pieces_of(tmp_path, tmp_path / "p.nc", HERE) if piece.near), None)
    if near[0] is None and not inside:
        assert first is None
    else:
        # What is inside the stock is so at the start of line 4.
        due = (4, *near[1:]) if inside else near
        on_board = ("the tool", "the workpiece")
        assert first is not None and (first.line, *(first.beside or on_board)) == due


def test_without_a_stock_nothing_may_be_touched(checked, tmp_path):
    scenes.write_stl(tmp_path / "work.stl", STOCK)
    assert checked("G0 Z2\nG1 Z-5", stocks=()).near == (3, "the tool", "the workpiece")


def test_each_operation_has_its_stock(checked, tmp_path):
    """After the first tool a slot is left, in which the body of the second may be."""
    slotted = tmp_path / "slotted.stl"
    walls = [scenes.box((-40, -40, -20), (-8, 40, 0)), scenes.box((8, -40, -20), (40, 40, 0))]
    scenes.write_stl(slotted, np.concatenate([*walls, scenes.box((-8, -40, -20), (8, 40, -9))]))
    program = f"G0 Z2\nG1 Z-5\n{AWAY}\nT2 M6\nG0 Z2\nG1 Z-12\n{AWAY}"
    assert checked(program).near == (7, "the tool's body", "the stock")
    found = checked(program, stocks=(tmp_path / "stock.stl", slotted))
    assert found.status == 0 and [one["number"] for one in found.report["tools"]] == [1, 1, 1, 2, 2, 2]
    refused = checked(program, stocks=(slotted,) * 3)
    assert refused.status == 2 and "--stock: 3 files" in refused.said and "it moves: 2" in refused.said


def test_what_is_first_near_decides(checked):
    """The body comes near in line 5, the cutter in line 4."""
    found = checked("G0 Z2\nG1 Z-5\nG0 X5\nG1 Z-12")
    assert found.near == (4, "the cutter", "the stock")
    assert [(one["what"], one["verdict"]) for one in found.report["tools"]] == [
        ("the tool", "clear"), ("the tool's body", "near"), ("the cutter", "near"),
    ]  # fmt: skip
    found = checked("G0 Z2\nG1 Z-12\nG0 X5")
    assert found.near == (3, "the tool's body", "the stock")
    assert [one["moves"] for one in found.report["tools"]] == [3, 3, 1]


@pytest.mark.parametrize(
    ("program", "start", "line"),
    [
        # Nobody checked how the tool came to where it begins: straight up, down again, not at all, along.
        ("G0 Z50\nG0 X0 Y0\nG0 Z-2\nG1 Z-5\nG0 Z50", 0, 2),
        ("G0 Z-3\nG1 Z-5\nG0 Z50", -4, 2),
        ("G0 X0\nG1 Z5\nG0 Z-4", -4, 2),
        ("G0 X5\nG1 Z5\nG0 Z-4", -4, 2),
        # It cuts its way from there, and has not been where that begins.
        ("G1 X5\nG0 Z5\nG0 Z-4", -4, None),
        ("G1 Z5\nG0 Z-4\nG0 Z5\nG0 Z-4.1", -4, 3),
    ],
)
def test_where_an_operation_begins_it_has_not_been(checked, program, start, line):
    found = checked(program, start=("--start", 0, 0, start))
    assert found.near[0] == line and (line is None or found.near[1] == "the cutter"), found.said


def test_a_second_tool_has_not_been_where_the_first_was(checked):
    """Changed at the bottom of a hole, for a wider one."""
    program = f"G0 Z2\nG1 Z-5\nT2 M6\nG0 Z5\nG0 Z-4\n{AWAY}"
    wide = ", ".join((CUTS.format(12, 8), SHANK.format(12, 30)))
    assert checked(program, second=wide).near == (5, "the cutter", "the stock")


def test_insides_are_told_with_their_place(checked):
    """Wholly inside on the way, and near later: what is inside comes first."""
    found = checked("G0 Z2\nG1 Z-14\nG0 X5\nG0 Z20", BLADE)
    assert "at the start of line 4, but the cutter is inside the stock" in found.said
    assert found.report["enclosure_at"] == {"move": 2, "line": 4}
    found = checked("G0 Z2\nG1 Z-14\nG0 Z-13\nG0 X5\nG0 Z20", BLADE)
    assert (found.status, found.report["what"], found.report["enclosure_at"]["line"]) == (
        1, "the cutter's top", 4,
    )  # fmt: skip
    for words, why in (((), "the top is inside"), (("--surfaces-only",), "leave one of them out")):
        found = checked("G0 Z2\nG1 Z-14\nG0 X5", BLADE, *words)
        assert (found.status == 1) == (not words) and (not words or why in found.said)


def test_of_an_open_stock_nothing_is_known_inside(checked, tmp_path):
    scenes.write_stl(tmp_path / "open.stl", STOCK[1:])
    found = checked("G0 Z2\nG1 Z-14\nG0 X5", BLADE, stocks=(tmp_path / "open.stl",))
    # Where facets are near, nobody asks.
    scenes.write_stl(tmp_path / "stock.stl", STOCK[1:])
    (tmp_path / "p.nc").write_text("G21 G90 G61 F100\nG0 Z2\nG1 X37\nG1 Z-14\nG0 X60")
    near = [piece for piece in pieces_of(tmp_path, tmp_path / "p.nc", HERE) if piece.near]
    assert near and {piece.line for piece in near} == {5}
    assert found.status == 2 and "not closed" in found.said and "--surfaces-only" not in found.said
    assert "may be inside" in found.said and "at the start of line 4: verdict unknown" in found.said
    # What is open is told, though nothing of it was checked last.
    scenes.write_stl(tmp_path / "work.stl", TABLE[1:])
    scenes.write_stl(tmp_path / "stock.stl", STOCK)
    found = checked("G0 Z2\nG1 Z-5\nG0 Z9")
    assert found.status == 0 and found.said.count("note: the workpiece is not closed: 3 edges") == 1


def test_moves_of_a_profile_are_those_of_the_program(checked):
    program = "G0 Z2\nG1 Z-5\nX20\nG0 Z10\nG0 X0 Z3\nG1 Z-1\nG0 Z5\nG0 X9"
    found = checked(program, MILL, "--profile", 12)
    profile = found.report["profile"]
    assert [place["line"] - place["move"] for place in profile] == [2] * len(profile) and len(profile) >= 12
    # On a feed, and straight up, the cutter may touch the stock.
    nearest = {place["move"] for place in profile if place["what"] == "the cutter"}
    assert nearest == {0, 4, 7} and {place["of"] for place in profile} == {"the stock"}


def test_a_probe_touches_nothing(checked):
    probe = "{ diameter = 6, length = 30, cuts = false }"
    assert checked("G0 Z2\nG0 Z9", probe).status == 0
    assert checked("G0 Z2\nG1 Z0", probe).near == (3, "the tool's body", "the stock")


@pytest.mark.long
@pytest.mark.parametrize("stop", ["near the surface", pytest.param("open", marks=pytest.mark.long)])
def test_a_board_is_asked_for_insides_wherever_it_is_clear(tmp_path, stop):
    """Insides are asked first. Where the start looks near then, and is shown clear after all, they count."""
    (tmp_path / "m.toml").write_text(f"[[tools]]\nnumber = 1\nparts = [{BLADE}]\n")
    scenes.write_stl(tmp_path / "stock.stl", STOCK if stop != "open" else STOCK[1:])
    machine = read_machine(tmp_path / "m.toml")
    differ = 0
    for tenths in range(60):
        deep = Fraction(-85000 - tenths, 10000)
        start = (Fraction(0), Fraction(0), deep)
        move = Move(1, start, (Fraction(0), Fraction(0), deep - Fraction(1, 100)), True)
        program = Program(tmp_path / "p.nc", (move,), ())
        mesh = scenes.read_stl(tmp_path / "stock.stl")
        wanted = Wanted(Fraction(1, 2), Fraction(1, 1000), Fraction(4, 1000), Fraction(1), None)
        scene = prepare_path(machine.tools[1].mesh, mesh, ("a", "b"), program, wanted)
        engine = scene_engine("bulk", scene.a, scene.b, scene.grid.width)
        first, after = (check_path(scene, engine, insides_first=asked).verdict for asked in (True, False))
        assert first == after != "clear"
        differ += _near_at(scene, 0) and check_path(scene, engine).near is None
    assert differ > 0


@pytest.mark.parametrize(
    ("parts", "why"),
    [
        ("{ diameter = 6, length = 8 }", "nobody said what of it cuts"),
        ('{ mesh = "stock.stl" }, { diameter = 6, length = 8 }', "of a cylinder below all meshes"),
        ('{ diameter = 6, length = 8, cuts = "yes" }', "'cuts': must be true or false"),
    ],
)
def test_what_cuts_must_be_said(checked, parts, why):
    found = checked("G0 Z2", parts)
    assert found.status == 2 and why in found.said


def met(points, radius, low, high, move):
    """Return which points an upright cylinder meets on a straight move of its foot."""
    start, end = (np.array([float(c) for c in at]) for at in (move.start, move.end))
    way, off = end - start, points - start
    # The times at which a point is at a height of the cylinder, and within its radius.
    with np.errstate(divide="ignore", invalid="ignore"):
        times = np.sort((off[:, 2:] - np.array([high, low])) / way[2], axis=1)
        across = way[0] ** 2 + way[1] ** 2
        middle = (off[:, :2] @ way[:2]) / across
        distance = ((off[:, :2] - (middle[:, None] * way[:2])) ** 2).sum(1)
        half = np.sqrt(np.maximum(radius**2 - distance, 0) / across)
    first, last = np.zeros(len(points)), np.ones(len(points))
    reached = np.ones(len(points), bool)
    if way[2]:
        first, last = np.maximum(first, times[:, 0]), np.minimum(last, times[:, 1])
    else:
        reached &= (low <= off[:, 2]) & (off[:, 2] <= high)
    if across:
        reached &= distance <= radius**2
        first, last = np.maximum(first, middle - half), np.minimum(last, middle + half)
    else:
        reached &= (off[:, :2] ** 2).sum(1) <= radius**2
    return reached & (first <= last)


def crash(moves, parts, points):
    """Return the first move on which something touches what is left of the stock and must not."""
    for number, move in enumerate(moves):
        foot = 0.0
        for diameter, length, cuts in parts:
            less = 1e-6 if move.rapid or not cuts else -1e-6
            hit = met(points, diameter / 2 - less, foot + less, foot + length - less, move)
            foot += length
            if hit.any() and (move.rapid or not cuts):
                return number
            points = points[~hit]
    return None


def test_of_two_that_come_near_on_a_move_the_first_is_told(checked, tmp_path):
    scenes.write_stl(tmp_path / "work.stl", scenes.box((30, -60, -30), (60, 60, 20)))
    found = checked("G0 X-50 Z-15\nG1 X35", MILL, start=("--start", "-50", "0", "20"))
    assert (found.status, found.report["near"]["line"], found.report["what"]) == (1, 3, "the tool's body")
    assert found.report["near"]["position"][0] < -40


@pytest.mark.parametrize(
    ("programs", "least_rapids"),
    [pytest.param(75, 2, marks=pytest.mark.long), pytest.param(150, 20, marks=pytest.mark.regress)],
)
def test_no_crash_is_missed_whatever_was_cut_before(rng, tmp_path, programs, least_rapids):
    """Random programs and tools against a stock of points, of which feeds take away what they meet."""
    low, high = (-12.0, -12.0, -12.0), (12.0, 12.0, 0.0)
    stock = tmp_path / "stock.stl"
    scenes.write_stl(stock, scenes.box(low, high))
    scenes.write_stl(tmp_path / "work.stl", TABLE)
    told = {"clear": 0, "near, and a crash": 0, "near": 0}
    rapids = 0
    for _ in range(programs):
        parts = [
            (rng.choice([2, 4, 6]), rng.choice([2, 4, 8]), k == 0 or rng.random() < 0.3) for k in (0, 1, 2)
        ]
        parts = sorted(parts, key=lambda part: not part[2])
        lines, at = ["G21 G90 G61 F9"], np.array([0, 0, rng.choice([2, 2, 2, -3])])
        here = [int(c) for c in at]
        for _ in range(12):
            kind = rng.choice(["in", "out", "again", "along", "any"], p=[0.25, 0.3, 0.15, 0.25, 0.05])
            to = at.copy()
            if kind == "in":
                to[2] = at[2] - rng.integers(1, 5)
            elif kind in ("out", "again"):
                to[2] = max(to[2], -8) + rng.integers(1, 14) if kind == "out" else at[2] - rng.integers(0, 4)
            else:
                to[:2] += rng.integers(-6, 7, 2)
            rapid = kind in ("out", "again", "any") or (kind == "along" and at[2] > 0)
            lines.append(f"G{0 if rapid else 1} X{to[0]} Y{to[1]} Z{to[2]}")
            at = to
        shape = ", ".join((CUTS if cut else SHANK).format(wide, tall) for wide, tall, cut in parts)
        tools = f"[[tools]]\nnumber = 1\nparts = [{shape}]\n"
        (tmp_path / "m.toml").write_text(f'rapids = "straight"\n{tools}')
        (tmp_path / "p.nc").write_text("\n".join(lines))
        words = (tmp_path / "m.toml", tmp_path / "work.stl", tmp_path / "p.nc", "--clearance", "0")
        report = tmp_path / "report.json"
        words = (
            "path",
            *words,
            "--start",
            *here,
            "--stock",
            stock,
            "--resolution",
            "0.01",
            "--json",
            report,
            "--engine",
            "bulk",
        )
        status = main([str(word) for word in words])
        start = vector(map(Fraction, here))
        moves = read_program(tmp_path / "p.nc", start, False, read_machine(tmp_path / "m.toml")).moves
        first = crash(moves, parts, rng.uniform(low, high, (4000, 3)))
        said = read_published(report, "path")
        assert status in (0, 1), lines
        if status == 0:
            assert first is None, (lines, parts, first)
        elif first is not None and said["near"] is not None:
            assert said["near"]["move"] <= first, (lines, parts, first)
        # Followed, it would be stopped before.
        found = pieces_of(tmp_path, tmp_path / "p.nc", start, Fraction(0))
        if first is not None:
            assert any(piece.near and piece.line <= moves[first].line for piece in found), (lines, first)
        assert status or not any(piece.near for piece in found), lines
        told["clear" if status == 0 else "near" if first is None else "near, and a crash"] += 1
        rapids += sum(move.rapid and move.start[2] < 0 for move in moves) * (status == 0)
    assert min(told["clear"], told["near, and a crash"]) > 20 and rapids > least_rapids, (told, rapids)


def test_rapids_that_need_no_look(tmp_path):
    """Of a slot: in, along, out, over, back into the hole, out."""
    (tmp_path / "m.toml").write_text(f"[[tools]]\nnumber = 1\nparts = [{MILL}]\n")
    (tmp_path / "p.nc").write_text("G21 G90 F9\nG0 Z2\nG1 Z-4\nX9\nG0 Z5\nX0\nZ-1\n")
    scenes.write_stl(tmp_path / "stock.stl", STOCK)
    machine = read_machine(tmp_path / "m.toml")
    program = read_program(tmp_path / "p.nc", HERE, False, machine)
    mesh = scenes.read_stl(tmp_path / "stock.stl"), tmp_path / "stock.stl"
    rules = rules_of(Setup(machine.tools[1], mesh, mesh), program, 7)
    assert [list(rule.numbers) for rule in rules] == [[7, 8, 9, 10, 11, 12]] * 2 + [[7, 11, 12]]
    assert rules[2].program.starts == [0, 1]
    part = rules[2].until(11)
    assert part is not None and len(part.program.moves) == 2 and rules[2].until(6) is None
    assert rules[2].among(8, 3) is None
