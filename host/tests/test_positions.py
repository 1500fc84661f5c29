"""Where a tool is: lines of a control, and pins of LinuxCNC's HAL."""

import os
import shutil
import subprocess
import tempfile
import threading
import time
from fractions import Fraction
from itertools import count
from pathlib import Path
from types import SimpleNamespace

import pytest
from filelock import FileLock

from triaxis.golden.errors import InputError
from triaxis.host import scenes
from triaxis.host.cli import engine as engine_module
from triaxis.host.cli import main
from triaxis.host.cli import watch as watch_module
from triaxis.host.link import hal as hal_module
from triaxis.host.link import positions
from triaxis.host.link.hal import HalPositions
from triaxis.host.link.positions import Positions
from triaxis.host.tests.test_follow import (
    CLOCKS_PER_SECOND,
    FLOOR,
    PARAMETERS,  # noqa: F401 - of the fixture `top`
    TOOL,
)
from triaxis.sim.simulated_line import SimulatedLine, SimulatedWire

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
    report = told(done.stdout).report()
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
        # A control character does not part numbers: these may be the ends of two lines.
        ("1 2 3\r4 5 6 7\n", "must be X Y Z"), ("1 2 3\v4\n", "must be X Y Z"),
        ("1 2 3\u00a04\n", "must be X Y Z"),
    ],
)  # fmt: skip
def test_lines_that_are_no_positions_are_refused(text, what):
    positions = told(text)
    with pytest.raises(InputError, match=what):
        while positions.report():
            pass


def told(text):
    """Return positions of a pipe that all of it is written to, after which nothing more comes."""
    end, start = os.pipe()
    positions = Positions(end)
    with os.fdopen(start, "w", encoding="utf-8") as pipe:
        pipe.write(text)
    return positions


@pytest.mark.parametrize("waiting", [b"", b"0 0 40\n" * 9000, b"0 0 40\n0 0", b"0 0 4"])
def test_what_waits_before_anybody_reads_it_is_no_position(waiting):
    """It may have been written minutes ago, while the path was cut; nor is the rest of a line that was."""
    end, start = os.pipe()
    os.write(start, waiting)
    begun = time.monotonic()
    positions = Positions(end)
    assert not positions.wait(0.05)
    cut = bool(waiting) and not waiting.endswith(b"\n")
    os.write(start, b"0.5\n" * cut)
    assert not positions.wait(0.05)
    os.write(start, b"7 8 9\n10 11")
    first, since = positions.report() or pytest.fail("none")
    assert first == (7, 8, 9) and begun <= since <= time.monotonic()
    os.write(start, b" 12\n")
    while (last := (positions.report() or pytest.fail("none"))[0]) == first:
        pass
    assert last == (10, 11, 12)
    os.close(start)


def test_a_terminal_that_is_gone_has_no_positions():
    end, terminal = os.openpty()
    positions = Positions(end)
    os.close(terminal)
    with pytest.raises(InputError, match="cannot read: Input/output error: the machine is stopped"):
        positions.report()
    os.close(end)


def test_an_ordinary_file_has_no_positions(tmp_path):
    recorded = tmp_path / "recorded.txt"
    recorded.write_text("0 0 40\n")
    with recorded.open() as file, pytest.raises(InputError, match="does not say when the tool was there"):
        Positions(file.fileno())


@pytest.mark.parametrize(
    ("arriving", "reported"),
    [
        # What comes while it is waited for: as old as the look before.
        ([(8, b"1 0 0\n"), (8, b"2 0 0\n")], [(1, 4), (2, 16)]),
        # This process was stopped while it waited.
        ([(8, b"1 0 0\n"), (8000, b"2 0 0\n")], [(1, 4), (2, 12)]),
        # What was there as soon as the one before was read, another moment after it: the last alone counts.
        ([(8, b"1 0 0\n"), (0, b"2 0 0\n3 0 0\n"), (2, b"4 0 0\n")], [(4, 16)]),
        # No other comes soon: it may be as old as the look that found nothing.
        ([(8, b"1 0 0\n"), (0, b"2 0 0\n"), (20, b"3 0 0\n")], [(2, 4), (3, 32)]),
        # In two parts: as old as the first.
        ([(8, b"1 0"), (8, b" 0\n")], [(1, 4)]),
        # A control that is never waited for, or one that waited, of which a line is read at a time.
        (
            [(8, b"1 0 0\n"), (0, b"2 0 0\n"), (0, b"3 0 0\n"), (20, b"4 0 0\n")],
            [(2, 4), (3, 4), (4, 36)],
        ),
    ],
)
def test_a_position_is_no_newer_than_is_known(arriving, reported, monkeypatch):
    """In steps of half a look; a line takes four to read; with each, those that pass before it comes."""
    step = positions._LOOK_SECONDS / 2
    clock, left = [0.0], list(arriving)
    stopped = [wait for wait, _ in arriving if wait > 100]

    def is_there(_, seconds):
        wait = left[0][0] if left else 0
        if wait and wait not in stopped and seconds < wait * step:
            left[0] = wait - round(seconds / step), left[0][1]
            clock[0] += seconds / step
            return False
        if wait in stopped and not seconds:
            return False
        clock[0] += wait
        left[:1] = [(0, left[0][1])] if left else []
        return True

    def read(*_):
        clock[0] += 4
        return left.pop(0)[1] if left else b""

    monkeypatch.setattr(positions.Positions, "_is_there", is_there)
    monkeypatch.setattr(positions, "os", SimpleNamespace(read=read))
    monkeypatch.setattr(positions, "time", SimpleNamespace(monotonic=lambda: clock[0]))
    reader = object.__new__(Positions)
    reader._descriptor, reader._cut = -1, False
    found = [(int(position[0][0]), since) for position, since in reader._arrived()]
    assert found == reported


def test_a_line_without_an_end_is_no_position(monkeypatch):
    monkeypatch.setattr(positions, "_PART", 100)
    with pytest.raises(InputError, match="a line without an end"):
        told("1" * 150).report()


def test_a_position_that_is_cut_off_is_none():
    positions = told("1 2 3\n10 20 3")
    while report := positions.report():
        assert report[0] == (1, 2, 3)


class Machine:
    """Another component of HAL, whose pins are netted to ours."""

    def __init__(self, hal):
        """Make it."""
        self.hal, self.pins = hal, hal.component("machine")
        kinds = {**dict.fromkeys("xyzc", hal.HAL_FLOAT), "tool": hal.HAL_S32}
        kinds |= dict.fromkeys(("running", "idle"), hal.HAL_BIT)
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
        for name in ("x", "y", "z", "c", "running", "idle", "tool", "go"):
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
        machine.net("running", "idle")
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
        assert [machine.hal.get_value(f"triaxis.{name}") for name in ("go", "beat")] == [False, True]
        pins.known_until(time.monotonic() + 60)
        pins.said(True)
        assert [machine.hal.get_value(f"triaxis.{name}") for name in ("go", "beat")] == [True, False]
        for zones, expected in ((2, [True, True]), (0, [False, False]), (1, [True, False])):
            pins.beyond(zones)
            assert [machine.hal.get_value(f"triaxis.{name}") for name in ("full-speed", "quiet")] == expected
        # Put off, and then not any more, though nobody says so.
        pins.known_until(until := time.monotonic() + 0.05)
        assert machine.hal.get_value("triaxis.full-speed") or time.monotonic() >= until
        for _ in range(600):
            if not machine.hal.get_value("triaxis.full-speed"):
                break
            time.sleep(0.1)
        assert [machine.hal.get_value(f"triaxis.{name}") for name in ("go", "full-speed")] == [False] * 2
        # Before the program, in it, in a pause, and as HAL has it between two pins that change.
        for idle, running in ((True, False), (True, True), (False, True), (False, False), (True, True)):
            machine.pins["idle"], machine.pins["running"] = idle, running
            assert pins.report()
        machine.pins["running"] = False
        assert pins.report() is None
        machine.pins["idle"], machine.pins["y"] = False, float("nan")
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
        pins._component = Moving({"idle": False, "running": True}, count())
        with pytest.raises(InputError, match="no two readings"):
            pins.report()
    finally:
        pins._component = component
        machine.hal.new_sig("go", machine.hal.HAL_BIT)
        machine.hal.connect("triaxis.go", "go")
        pins.known_until(time.monotonic() + 60)
        pins.said(True)
        pins.close()
        assert not pins._clearing.is_alive()
    assert machine.hal.get_value("go") is False


class Written(dict):
    """Pins of which each value is kept that they are given."""

    def __init__(self):
        super().__init__(beat=False)
        self.kept = []

    def __setitem__(self, name, value):
        self.kept.append((name, value))
        super().__setitem__(name, value)


def test_pins_are_not_true_for_an_instant():
    """A servo thread reads them whenever it likes: not first true, and then cleared."""
    pins = object.__new__(HalPositions)
    pins._component, pins._changed, pins._known = Written(), threading.Condition(), 0.0
    pins.said(True)
    pins.beyond(2)
    assert {value for name, value in pins._component.kept if name != "beat"} == {False}


def test_pins_are_cleared_that_are_over_between_two_looks():
    """At the first there is a moment left; nobody looks again before somebody says something, or it waits."""
    times = iter([0.9, 1.1])
    pins = object.__new__(HalPositions)
    pins._component, pins._changed, pins._known = Written(), threading.Condition(), 1.0
    clock = SimpleNamespace(monotonic=lambda: next(times))
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(hal_module, "time", clock)
        left = pins._clear_where_over()
        assert left == pytest.approx(0.1) and not pins._component.kept
        assert pins._clear_where_over() is None
    assert {name for name, value in pins._component.kept if value is False} == {"go", "full-speed", "quiet"}


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

    for module in (watch_module, hal_module):
        monkeypatch.setattr(module, "time", SimpleNamespace(monotonic=monotonic, sleep=lambda _: None))
    # The board's time goes on only while it is asked.
    line = SimulatedLine(SimulatedWire(top, CLOCKS_PER_SECOND))
    monkeypatch.setattr(engine_module, "SerialLine", lambda _: line)
    places = iter([*range(0, 21, 2), *[20] * 4])
    go = []

    class Stepped(HalPositions):
        """The machine goes on a step whenever it is looked at, and runs until it is at the end."""

        def __init__(self, rotary, several):
            """Net all pins that are wanted."""
            super().__init__(rotary, several)
            machine.net("x", "y", "z", "running", "idle")
            machine.pins["z"] = 40.0

        def report(self):
            """Go on."""
            place = next(places, None)
            machine.pins["idle"], machine.pins["running"] = place is None, place is not None
            machine.pins["x"] = 20.0 if place is None else float(place)
            go.append(machine.hal.get_value("triaxis.go"))
            return super().report()

    monkeypatch.setattr(watch_module, "HalPositions", Stepped)
    arguments = [str(tool), str(work), str(program), "--port", line.name, "--hal", "--skip-self-test"]
    arguments += ["--speed", "100", "--lag", "50", "--hold", "500", "--start", "0", "0", "40"]
    assert main(["watch", *arguments, "--surfaces-only"]) == 0
    assert "FOLLOWED: to the end of the program" in capsys.readouterr().out
    # It is looked whether the machine is at the start, and then asked.
    assert go == [False] * 2 + [True] * (len(go) - 2)
