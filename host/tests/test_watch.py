"""`watch`: the command, with machines whose positions come in lines."""

import os
import re
import threading
import time
from functools import partial
from itertools import chain, count
from types import SimpleNamespace
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

from triaxis.golden.errors import InputError
from triaxis.host import scenes
from triaxis.host.cli import main
from triaxis.host.cli import watch as watch_module
from triaxis.host.link import positions
from triaxis.host.link.board import Board
from triaxis.host.link.board_engine import BoardEngine
from triaxis.host.motion.follow import DisagreementError
from triaxis.host.motion.operations import Operation
from triaxis.host.quantise import NOWHERE
from triaxis.host.tests.machines import MILL, STRAIGHT_MILL, write_meshes
from triaxis.host.tests.published import read_published
from triaxis.host.tests.served_board import ServedBoard
from triaxis.host.tests.test_follow import (
    FLOOR,
    PARAMETERS,  # noqa: F401 - of the fixture `top`
    PROGRAM,
    TOOL,
)
from triaxis.sim.pseudo_terminal import Wire


def lines_of(end):
    """Return all that comes from an open file, which stays open."""
    with os.fdopen(os.dup(end), encoding="utf-8") as lines:
        return lines.read().splitlines()


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


def telling(word, does):
    """Return what does the same, and prints a word first."""

    def told(*given):
        print(word)
        return does(*given)

    return told


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
    monkeypatch.setattr(watch_module, "time", clock)
    # As a control would: the next line when the last has been looked at.
    monkeypatch.setattr(watch_module, "Positions", lambda end: Steps(lines_of(end)))
    with ServedBoard(top, Wire()) as served:

        def run(lines, *words):
            positions.write_text("\n".join(lines) + "\n")
            where = () if words else ("--positions", str(positions))
            arguments = [str(machine), str(work), str(program), "--port", served.path, *where, *words]
            arguments += ["--speed", "100", "--lag", "50", "--hold", "500", "--start", "0", "0", "40"]
            arguments += ["--json", str(report), "--skip-self-test"]
            arguments += [] if "--stock" in words else ["--surfaces-only"]
            status = main(["watch", *arguments])
            return status, capsys.readouterr()

        status, said = run([], "--simulate")
        assert status == 0 and "with tool 2 from line 4 on" in said.out, said.err
        # At the end of a part it stands for a while.
        first = [f"{x} 0 40 1" for x in (*np.arange(0, 10, 0.25), *[10] * 12)]
        # Away to change it, back with the old one, and only then with the new one.
        away = ["10 0 200 1", "10 0 200 0", "10 0 200 2", "10 0 40 2"]
        second = [f"{x} 0 40 2" for x in (*np.arange(10, 20, 0.25), 20, 20, 20, 20)]
        status, said = run([*first, *away, *second])
        assert (status, said.err) == (0, "") and "FOLLOWED: to the end of the program" in said.out
        assert read_published(report, "watch")["verdict"] == "followed"
        for lines, status, what in (
            ([*first, *away[:3]], 1, "ENDED"),
            ([first[0], "4 0 40"], 2, "positions must say which one is in the spindle"),
            ([*first, *["10 0 40"] * 2], 2, "positions must say which one is in the spindle"),
            ([*first[:2], "1 0 40 2"], 2, "tool 2 is in the spindle, and not 1"),
            ([*first, *away, *second[:2], "18 0 60 2"], 2, "where it is not permitted to be"),
            # Off the path, at its start, by as much as it may be, and by more.
            (["-0.01 0 40 1", *first[1:], *away[:3]], 1, "ENDED"),
            (["-0.02 0 40 1"], 2, "the program begins at X0.0000 Y0.0000 Z40.0000: bring it there"),
            # A machine that stands where the last cycle ended has not gone through this one.
            (["10 0 40 1"], 2, "the tool is at X10.0000 Y0.0000 Z40.0000, and the program begins"),
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
        monkeypatch.setattr(Board, "abort", telling("OVER", Board.abort))
        monkeypatch.setattr(watch_module, "_draw", telling("DRAWN", vars(watch_module)["_draw"]))
        for lines, near in (
            ("G0 X2 Y0 Z32\nG1 X9 Z26 F900\nX20\nG0 Z40\nT2 M6\nG0 X0", (None, None, None)),
            ("G0 X2 Y0 Z32\nG1 X9 Z26 F900\nG0 X20", (4, "the cutter", "the stock")),
            ("G0 X9 Y0\nG1 Z25 F900\nZ19", (4, "the tool's body", "the stock")),
            # By another tool, which was not there.
            ("G0 X9 Y0\nG1 Z25 F900\nT2 M6\nG0 Z28", (5, "the cutter", "the stock")),
        ):
            program.write_text(f"G21 G90 G61\n{lines}\n")
            picture.write_bytes(b"old")
            words = ["--stock", str(tmp_path / "blank.stl"), "--length", "0.5", "--slow", "1"]
            words += ["--picture", str(picture)]
            status, said = run([], "--simulate", *words)
            # What was there before is never taken for what was found now.
            assert picture.exists() == (status == 1)
            if status:
                drawn = " ".join(ElementTree.fromstring(picture.read_text()).itertext())
                assert f"p.nc: stopped before line {near[0]}: {near[1]} comes near {near[2]}" in drawn
                # Go is over before anybody is told, and nobody waits for a picture to be told.
                order = " ".join(re.findall("OVER|zone: unknown|NEAR|DRAWN", said.out))
                assert re.fullmatch("(OVER (zone: unknown )?)+OVER NEAR DRAWN", order), said.out
            found = read_published(report, "watch")
            assert (found["line"], found["what"], found["of"]) == near, said
            assert status == int(near[0] is not None) and "what is cut away is not tracked" in said.out
            assert found["stock"] == [str(tmp_path / "blank.stl")]
        machine.write_text(TOOLS)
        status, said = run([], "--simulate", "--stock", str(tmp_path / "blank.stl"))
        assert status == 2 and "nobody said what of it cuts" in said.err
        program.write_text(whole)
        # Told before the first tool starts, and not when the second is to be loaded.
        machine.write_text(
            TOOLS.replace("[{ diameter = 4, length = 9 }", "[" + 9 * "{ diameter = 4, length = 1 }, ")
        )
        status, said = run([], "--simulate")
        assert status == 2 and "the board holds 512 a mesh" in said.err and "ready" not in said.out, said
        # Tool 0 is one as all others.
        machine.write_text(TOOLS.replace("= 1\n", "= 0\n"))
        for lines in (program.read_text(), "G21 G90 G61\nG0 X10\n"):
            program.write_text(lines)
            found, said = run(["0 0 40 2"])
            assert found == 2 and "tool 2 is in the spindle, and not 0" in said.err, said
    assert top.stop


@pytest.mark.long
@pytest.mark.simulator
def test_objects_are_on_the_board_or_shown_clear_before(top, tmp_path, capsys, monkeypatch):
    machine, work, program, report = (tmp_path / name for name in ("m.toml", "w.stl", "p.nc", "r.json"))
    write_meshes(tmp_path)
    scenes.write_stl(tmp_path / "w.stl", scenes.box((-20, -20, 0), (-10, 20, 70)))
    ticks = count()
    monkeypatch.setattr(watch_module, "time", SimpleNamespace(monotonic=lambda: next(ticks) / 400))
    with ServedBoard(top, Wire()) as served:

        def run(lines, text=STRAIGHT_MILL, words=()):
            machine.write_text(text)
            program.write_text(f"G21 G90 G61 G43 H1 F1000\n{lines}\n")
            arguments = [str(machine), str(work), str(program), "--port", served.path, "--simulate"]
            arguments += ["--speed", "100", "--lag", "50", "--hold", "500", "--start", "0", "0", "150"]
            status = main(["watch", *arguments, *words, "--json", str(report), "--skip-self-test"])
            found = read_published(report, "watch")
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
            place = read_published(report, "watch")["position"]
            assert abs(place[axis] - where) < 3 and f"about X{place[0]:.4f} Y{place[1]:.4f} Z" in said.out
        # The bed and the table are 2 mm apart at X-8, 5 at X-5, which is a piece by itself.
        for lines, within in (("G0 Z90\nG1 X-5\nX-8", [4]), ("G0 Z90\nG1 X-5", [])):
            status, _, said = run(lines, words=["--slow", "3"])
            (zone,) = read_published(report, "watch")["zones"]
            assert (status, zone["within"], zone["lines"]) == (0, 3, within), said
            assert zone["pieces"] == len(within) == said.out.count("zone: slow, line 4")
        # What may touch something on the board is looked at beside it, against all else.
        touching = STRAIGHT_MILL.replace("[spindle]", 'may_touch = ["workpiece"]\n[spindle]')
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


TURNING = MILL.replace("loaded = 1", "loaded = 1\nturn_tolerance = 0.01")


@pytest.mark.long
@pytest.mark.simulator
def test_between_turns_a_machine_is_followed_by_what_stands_then(top, tmp_path, capsys, monkeypatch):
    machine, work, program, report = (tmp_path / name for name in ("m.toml", "w.stl", "p.nc", "r.json"))
    write_meshes(tmp_path)
    scenes.write_stl(tmp_path / "w.stl", scenes.box((-20, -20, 0), (-10, 20, 70)))
    ticks, places = count(), tmp_path / "positions"
    monkeypatch.setattr(watch_module, "time", SimpleNamespace(monotonic=lambda: next(ticks) / 400))
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
    monkeypatch.setattr(watch_module, "Positions", lambda end: Watched(lines_of(end)))
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
            status = main(["watch", *arguments])
            found = read_published(report, "watch")
            return status, (found.get("line"), found.get("what"), found.get("of")), capsys.readouterr()

        status, near, said = run("G0 Z30\nC20\nG1 X5\nC0\nX0")
        assert (status, near, said.err) == (0, (None, None, None), ""), said
        ready = [line for line in said.out.splitlines() if line.startswith("ready: ")]
        assert [re.findall(r" C(\d+), .* from line (\d+) on$", line) for line in ready] == [
            [("0", "2")], [("20", "4")], [("0", "6")],
        ], ready  # fmt: skip
        down = [(0, 0, z, 0) for z in range(100, 29, -1)]
        stood = [*down, *[down[-1]] * 12]
        turn = [(0, 0, 30, c) for c in (5, 12, 19.98)]
        right = [(x, 0, 30, 20) for x in (0, 1, 2, 3, 4, 5)]
        status, _, said = run("G0 Z30\nC20\nG1 X5", [*stood, *turn, *right, *right[-1:] * 3])
        assert (status, said.err) == (0, "") and "FOLLOWED" in said.out, (said.err, went)
        # Go is ended before it turns, and nothing permitted before the angle is there.
        end = went.index("abort")
        turns = went.index(5)
        assert went[end - 1] == 0 and "permit" not in went[end:turns]
        assert went[turns : turns + 6] == [5, 12, 19.98, 20, 20, "permit"]
        # At once where the machine does not wait for stop.
        status, _, said = run("G0 Z30\nC20\nG1 X5", [*down, *turn, *right, *right[-1:] * 3])
        assert (status, said.err) == (0, "") and "FOLLOWED" in said.out, (said.err, went)
        assert went[went.index("abort") - 1] == 5
        # What ends with a turn ends before it, with stop.
        status, _, said = run("G0 Z30\nC20", [*down, *[(0, 0, 30, 0)] * 3, *turn])
        assert (status, said.err, went[-1]) == (0, "", "abort") and "FOLLOWED" in said.out, (said.err, went)
        # A part that ends where it begins is not over before it has begun; looked at three times before it.
        there = [(x, 0, 30, 20) for x in (0, 0, 0, *range(16), *range(16, -1, -1), 0, 0)]
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
            ("G0 Z30\nT1 M6\nX5", "line 4: the same tool and angles", two),
            ("G0 Z30\nT2 M6\nT1 M6\nX5", "line 5: the same tool and angles", two),
            ("G0 X1", "turn_tolerance: say by how many degrees C may be off", MILL),
        ):
            status, _, said = run(lines, text=text)
            assert status == 2 and what in said.err, said
    assert top.stop


class Steps(watch_module.Positions):
    """Positions of which each is looked at once, in their order."""

    def __init__(self, lines):
        """Take them; no thread reads them."""
        self._steps = iter(lines)

    def wait(self, seconds):
        """There is one, or none will come."""
        return True

    def look(self):
        """Return the next, and once more."""
        line = next(self._steps, None)
        self._steps = chain([line] * (line is not None), self._steps)
        return self._of(line)

    def report(self):
        """Return the next."""
        return self._of(next(self._steps, None))

    def _of(self, line):
        if line is None:
            return None
        position, self.tool, self.angles = positions.read_position(line)
        return position, watch_module.time.monotonic()


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


def says(fifo, text, begun, seconds):
    with fifo.open("w") as lines:
        # What is written before is passed over.
        assert begun.wait(60)
        time.sleep(seconds)
        lines.write(text)


def test_a_position_is_as_old_as_is_said():
    """So that an answer has no more than what is left of the lag."""
    machine = SimpleNamespace(tools={}, rotary=frozenset())
    one: Any = SimpleNamespace(machine=machine, stands=lambda _: True)
    source: Any = SimpleNamespace(report=lambda: (NOWHERE, 5.0), tool=None, angles=None)
    follower: Any = None
    assert watch_module._as_expected(source, one, follower, False, 0.75) == (NOWHERE, 4.25)
    one.machine.rotary = frozenset("AC")
    with pytest.raises(InputError, match=r"^A, C turn: positions must say where they are: X Y Z, the tool's"):
        watch_module._as_expected(source, one, follower, False, 0.75)


def test_the_tool_of_an_stl_file_may_have_any_number():
    tool: Any = SimpleNamespace(tool=7)
    for tools, number, expected in (({}, 0, True), ({3: None}, 3, False), ({7: None}, 7, True)):
        one: Any = SimpleNamespace(machine=SimpleNamespace(tools=tools), tool=SimpleNamespace(number=number))
        assert watch_module._has_tool(tool, one) == expected


def test_pins_and_page_say_nothing_where_the_line_is_dead():
    """Pins before the board is asked to stop, which takes seconds then; the page if that is interrupted."""
    said = list[object]()

    class Dead:
        def abort(self):
            said.append("abort")
            raise KeyboardInterrupt

    display = object.__new__(watch_module._Display)
    display._zones, display._beyond = 0, None
    pins: Any = SimpleNamespace(known_until=said.append)
    page: Any = SimpleNamespace(tell=lambda **changes: said.append(changes))
    board: Any = Dead()
    display._pins, display._page = pins, page
    with pytest.raises(KeyboardInterrupt):
        display.end(board)
    assert said == [0.0, "abort", {"verdict": None}]


def test_what_only_the_board_finds_near_is_not_given_a_name():
    engine = SimpleNamespace(run=lambda *_, **__: SimpleNamespace(near=np.empty((0, 2), int)))
    part: Any = SimpleNamespace(engine=engine, supervised=None)
    piece: Any = SimpleNamespace(beside=None, sample=(0, 0, 0), margin=1, line=7)
    with pytest.raises(DisagreementError, match="line 7: near to the board, and clear to the host"):
        Operation.near_objects(part, piece)


@pytest.mark.simulator
def test_the_command_follows_positions_and_says_how_far(top, tmp_path, capsys, monkeypatch):
    tool, work, program = (tmp_path / name for name in ("tool.stl", "work.stl", "program.nc"))
    program.write_text(PROGRAM)
    for path, facets in ((tool, TOOL), (work, FLOOR)):
        record = np.zeros(len(facets), [("normal", "<f4", 3), ("facet", "<f4", (3, 3)), ("attribute", "<u2")])
        record["facet"] = facets
        path.write_bytes(bytes(80) + len(facets).to_bytes(4, "little") + record.tobytes())
    fifo, report = tmp_path / "fifo", tmp_path / "report.json"
    os.mkfifo(fifo)
    begun = threading.Event()

    class Begun(watch_module.Positions):
        """Positions of which it is known that they are read."""

        def __init__(self, descriptor):
            """Begin."""
            super().__init__(descriptor)
            begun.set()

    monkeypatch.setattr(watch_module, "Positions", Begun)
    usual = {"--speed": "100", "--lag": "50", "--hold": "500", "--start": "0 0 40"}
    # A clock that knows nothing of how busy the machine is.
    ticks = count()
    clock = SimpleNamespace(monotonic=lambda: next(ticks) / 400)
    monkeypatch.setattr(watch_module, "time", clock)
    with ServedBoard(top, Wire()) as served:

        def run(*words):
            arguments = [str(tool), str(work), str(program), "--port", served.path, *words]
            for option in usual.keys() - set(words):
                arguments += [option, *usual[option].split()]
            status = main(["watch", *arguments, "--json", str(report), "--skip-self-test"])
            return status, capsys.readouterr()

        shown = []
        monkeypatch.setattr(watch_module, "Page", partial(Shown, shown))
        status, said = run("--simulate", "--surfaces-only", "--page", "0")
        assert (status, said.err) == (0, "") and "FOLLOWED: to the end of the program" in said.out
        assert "page: http://" in said.out
        (facets, ends, title), *told, over = shown
        assert np.array_equal(facets, TOOL) and title == f"{tool} along {program.name}"
        assert ends[0].tolist() == [0, 0, 40] and all(one["verdict"] == "clear" for one in told)
        assert [one["asked"] for one in told] == [*range(1, len(told) + 1)]
        assert told[-1]["permitted"] == len(ends) - 1 and told[-1]["position"] == pytest.approx([0, 0, 40])
        # What was said says nothing any more.
        assert over == {"verdict": None}
        # It comes down to 10 mm above the floor.
        shown.clear()
        zones = ["--slow", "12", "--warn", "17", "--hold", "60", "--lag", "20"]
        status, said = run("--simulate", "--surfaces-only", "--page", "0", *zones)
        assert (status, said.err) == (0, "") and "within 12 mm, or nearly: " in said.out
        told = [one["zone"] for one in shown[1:] if "zone" in one]
        assert told == ["free", "warn", "slow", None], told
        changes = [line.split() for line in said.out.splitlines() if line.startswith("zone: ")]
        assert [words[1] for words in changes] == ["free,", "warn,", "slow,", "unknown"]
        slow, warn = read_published(report, "watch")["zones"]
        # Where each begins, and not what is asked about when it may be reached.
        began = [int(words[3]) for words in changes[:-1]]
        assert began[1:] == [warn["lines"][0], slow["lines"][0]] and began[0] < warn["lines"][0]
        assert 0 < slow["pieces"] < warn["pieces"] and {4, 5, 10} <= set(slow["lines"]) <= set(warn["lines"])

        def followed(text, *words, seconds=0.0):
            begun.clear()
            control = threading.Thread(target=says, args=(fifo, text, begun, seconds))
            control.start()
            done = run("--positions", str(fifo), "--surfaces-only", *words)
            control.join()
            return done

        shown.clear()
        followed("0 0 40\n0 0\n", "--page", "0")
        assert "must be X Y Z" in shown[-1]["stopped"]
        status, said = followed("0 0 40\n0 0 39.5\n")
        assert status == 1 and "ENDED: the positions ended before the program did" in said.out
        # Silence for longer than the watchdog's time, before the machine starts.
        status, said = followed("0 0 40\n", seconds=2.0)
        assert (status, said.err) == (1, "")
        bitstream = {"known": True, "any_allowed": False}
        assert read_published(report, "watch")["bitstream"] == bitstream
        status, said = followed("0 0\n")
        assert status == 2 and "position '0 0': must be X Y Z in mm" in said.err
        assert read_published(report, "watch") == {"verdict": "unknown"}
        for option, what in (
            ("--speed", "say how fast"),
            ("--lag", "must be more than 0"),
            ("--length", "more than 0"),
            ("--slow", "each must be wider"),
            ("--warn", "give that, too"),
        ):
            assert what in run(option, "0")[1].err
    assert top.stop
