"""Host program, serial port, UART, engine and core together; and what a bad line can do to them."""

import re
import signal
import subprocess
import threading
import time
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from triaxis.golden.errors import InputError
from triaxis.host import scenes
from triaxis.host.cli import check as check_module
from triaxis.host.cli import engine as engine_module
from triaxis.host.cli import main
from triaxis.host.cli.board import simulated_parameters
from triaxis.host.enclosure import NOT_ASKED
from triaxis.host.engines import STILL
from triaxis.host.link import board as board_module
from triaxis.host.link.board import Board
from triaxis.host.link.board_engine import BoardEngine
from triaxis.host.link.exchange import LinkError, SerialLine
from triaxis.host.link.messages import LOADED_POSE, Mesh, Mode, RunEnd, TrialKind, trial_of
from triaxis.host.tests.line_faults import LineFaults, StaleReplies, patient
from triaxis.host.tests.published import read_published
from triaxis.host.tests.served_board import ServedBoard
from triaxis.host.tests.test_cli import TRIAXIS
from triaxis.sim.pseudo_terminal import Wire
from triaxis.sim.simulated_line import SimulatedLine, SimulatedWire

pytestmark = pytest.mark.simulator

GONE = "the port is gone: plug the board in again and repeat; verdict unknown"
# One build for all tests.
PARAMETERS = simulated_parameters(16, 512)
OTHER_BUILD = f"the board was built of {PARAMETERS.build_id:08x}, this checkout is 00facade"
# Simulated seconds are such that the client waits 60,000 clocks for a reply before it asks again.
CLOCKS_PER_SECOND = 1_200_000


@pytest.fixture
def board_check(top, capsys):
    """Return a function that runs `board check` on the simulated board: exit code, output, errors."""

    def run(*arguments, wire=None):
        with ServedBoard(top, wire or Wire(patient(top))) as served:
            status = main(["board", "check", *map(str, arguments), "--port", served.path])
            out, error = capsys.readouterr()
            # At once, not only when the watchdog has run out.
            assert top.stop
            return status, out, error.replace(served.path, "PORT")

    return run


@pytest.fixture
def boxes(tmp_path):
    """Return the files of two boxes, 2 mm apart along z."""
    paths = tmp_path / "a.stl", tmp_path / "b.stl"
    scenes.write_stl(paths[0], scenes.box((0, 0, 2), (10, 10, 12)))
    scenes.write_stl(paths[1], scenes.box((2, 2, -8), (8, 8, 0)))
    return paths


@pytest.fixture
def report(tmp_path):
    """Return a file that says clear, of an older run."""
    path = tmp_path / "report.json"
    path.write_text('{"verdict": "clear"}')
    return path


def test_the_scenes_through_the_serial_port(board_check, tmp_path, report):
    written = scenes.write_scenes(tmp_path)
    for number in (1, 4):
        scene, a, b = written[number]
        status, out, error = board_check(a, b, "--json", report)
        said = read_published(report, "check")
        assert (status, error, said["verdict"]) == (int(scene.near), "", "near" if scene.near else "clear")
        assert ("output: stop\n" if scene.near else "output: go; stop when this command ends") in out
        tested = said["pairs_tested"]
        certified = tested - len(said["near"])
        assert f"; tested: {tested}; clears certified: {certified}\n" in out
        assert (said["self_test"], said["clears_certified"]) == ("passed", certified)
        assert said["status"]["near"] == len(said["near"]) and (said["near"] != []) == scene.near


@pytest.mark.parametrize(
    ("facets", "status", "state"),
    [(12, 1, "inside"), pytest.param(11, 2, "undecided", marks=pytest.mark.long)],
)
def test_a_board_is_not_asked_where_one_mesh_may_be_inside_the_other(
    facets, status, state, top, board_check, boxes, path_on, tmp_path, report
):
    stock = tmp_path / "stock.stl"
    scenes.write_stl(stock, scenes.box((-20, -20, -20), (30, 30, 30))[:facets])
    options = (boxes[0], stock, "--json", report)
    found, out, _ = board_check(*options, "--hold")
    said = read_published(report, "check")
    assert (found, top.go_clocks, said["enclosure"]["state"]) == (status, 0, state)
    assert said["verdict"] == {1: "near", 2: "unknown"}[status]
    assert "output: stop; the board was not asked to run\n" in out
    # Facets that are near are found as ever.
    assert board_check(*options, "--move", 0, 0, 17.6)[0] == 1
    with ServedBoard(top, Wire(patient(top))) as served:
        board = ("board", "--port", served.path)
        found, said = path_on(stock, "G21 G0 X5", *board, "--profile", "2")
        assert (found, top.go_clocks, said["enclosure"]["state"]) == (status, 0, state)
        assert path_on(stock, "G21 G0 X5", *board, "--surfaces-only")[0] == 0
    went = top.go_clocks
    assert board_check(*options, "--surfaces-only")[0] == 0
    assert top.go_clocks > went > 0


def test_a_board_that_misses_near_facets_is_not_believed(board_check, boxes, monkeypatch):
    monkeypatch.setattr(check_module, "_insides", lambda meshes: NOT_ASKED)
    status, out, error = board_check(*boxes, "--hold")
    assert (status, out) == (2, "")
    assert "finds no near facets where this program does: verdict unknown" in error


def test_check_takes_the_board_like_any_other_engine(top, boxes, report, capsys):
    moved = "--rotate z 90 --move 12 0.5 -1.6 --resolution 0.01"
    found = []
    with ServedBoard(top, Wire(patient(top))) as served:
        for engine, width in ((("board", "--port", served.path), ()), (("bulk",), ("--width", "16"))):
            words = ("check", *map(str, boxes), *moved.split(), "--json", str(report), "--engine", *engine)
            assert main([*words, *width]) == 1
            found.append(read_published(report, "check"))
            assert main([*words, "--width", "24"]) == (2 if engine[0] == "board" else 1)
        assert "width 24: the board has 16 bits: leave --width out" in capsys.readouterr().err
    for same in ("verdict", "pose", "grid", "margin", "pairs_tested", "pairs_near", "near"):
        assert found[0][same] == found[1][same]


@pytest.fixture
def path_on(tmp_path, report):
    """Return a function that checks a box along a path: exit code, report."""
    tool, moves = tmp_path / "tool.stl", tmp_path / "moves.nc"
    scenes.write_stl(tool, scenes.box((-2, -2, 0), (2, 2, 10)))

    def run(work, gcode, *engine):
        moves.write_text(gcode)
        where = ("--start", "0", "0", "16", "--resolution", "0.01", "--json", str(report))
        status = main(["path", str(tool), str(work), str(moves), *where, "--engine", *engine])
        return status, read_published(report, "path")

    return run


def test_a_path_on_the_board(top, boxes, path_on):
    with ServedBoard(top, Wire(patient(top))) as served:
        # Above, down beside it, and into it: A is loaded once, and asked at many poses.
        for gcode, status in (("G21 G0 X20\nG0 Z3", 0), ("G21 G0 X20\nG0 Z5\nG0 X9", 1)):
            asked = path_on(boxes[0], gcode, "board", "--port", served.path)
            wanted = path_on(boxes[0], gcode, "bulk", "--width", "16")
            assert asked[0] == wanted[0] == status
            for same in ("verdict", "near", "levels", "enclosure"):
                assert asked[1][same] == wanted[1][same]
            # What boxes alone prove the board is not asked.
            assert (asked[1]["effort"]["cycles"] is None) == (status == 0)
            assert top.stop
        assert asked[1]["effort"]["cycles"] > 0


def test_modes_and_moves(board_check, boxes):
    told = {}
    for mode in ("--all", "--count", "--first"):
        status, out, _ = board_check(*boxes, "--move", "0.1234", "-0.5", "-1.6", mode)
        assert (status, "NEAR: at least 1 facet" in out) == (1, mode == "--first")
        assert ("NEAR: 18 facet pairs" in out) == (mode != "--first")
        told[mode] = [line for line in out.splitlines() if line.startswith("  ")]
    assert told["--all"][-1] == "  .. and 8 more" and told["--count"] == []
    assert all(line.endswith("exact distance 0.4") for line in told["--all"][:-1] + told["--first"])


def test_a_move_that_no_grid_of_the_board_could_hold_loaded(board_check, boxes):
    # The unmoved A would be 2 metres away: it is loaded as far off as the board's 16 bits allow.
    far = boxes[0].with_name("far.stl")
    scenes.write_stl(far, scenes.box((2000, 0, 2), (2010, 10, 12)))
    for z, status in ((0, 0), (-1.9, 1)):
        assert board_check(far, boxes[1], "--move", -2000, 0, z)[0] == status


def one_near_pair(rng, near=True):
    """Return two meshes of small triangles (N, 3, 3), and the only pair within a margin of 2, if any."""
    places = np.stack(np.meshgrid(*[np.arange(-3, 4)] * 3), -1).reshape(-1, 3) * 100
    # Two LOADs each.
    triangles = rng.permutation(places)[: 14 + 13, None, :] + rng.integers(0, 20, (27, 3, 3))
    a, b = triangles[:14], triangles[14:].copy()
    i, j = int(rng.integers(14)), int(rng.integers(13))
    if near:
        b[j] = a[i] + np.array([0, 0, 2])
    return a, b, (i, j)


def board_on(top, wire=None):
    return Board(SimulatedLine(wire or SimulatedWire(top, CLOCKS_PER_SECOND)))


def near_of(board, a, b, margin=2):
    """Return the near pairs of a check."""
    board.hello()
    return BoardEngine(board, a, b).run(STILL, margin).near.tolist()


def near_or_unknown(board, a, b):
    try:
        return near_of(board, a, b)
    except LinkError as error:
        assert "\n" not in str(error)
        return None


def test_more_near_pairs_than_the_ring_holds(top, rng):
    a, b = rng.integers(-9, 9, (40, 3, 3)), rng.integers(-9, 9, (30, 3, 3))
    assert near_of(board_on(top), a, b, margin=20) == [[i, j] for i in range(40) for j in range(30)]


def test_a_mesh_is_left_alone_until_the_board_has_read_it_again(top, rng, monkeypatch):
    board, waited = board_on(top), []
    board.hello()
    monkeypatch.setattr(board._line, "wait", waited.append)
    for mesh in Mesh:
        board.load(mesh, rng.integers(-9, 9, (40, 3, 3)))
    # As if it were full, a triangle a clock of 10 ns.
    assert waited == [pytest.approx(512 * 10e-9)] * 2


def interrupt(*_):
    raise KeyboardInterrupt


@pytest.mark.parametrize("lost", [False, True])
def test_a_run_that_is_interrupted_is_aborted(lost, top, rng, monkeypatch):
    """Also where the board has not got what was asked last, and expects its number."""
    board = board_on(top)
    board.hello()
    for mesh in Mesh:
        board.load(mesh, rng.integers(-9, 9, (40, 3, 3)))
    if lost:
        send = board._line.send
        sends = iter([send, interrupt])
        monkeypatch.setattr(board._line, "send", lambda data: next(sends, send)(data))
    with pytest.raises(KeyboardInterrupt):
        board.run(Mode.ALL, 20, progress=interrupt)
    assert board.status().end == RunEnd.ABORTED


@pytest.mark.parametrize(
    "number", [*range(2), *(pytest.param(n, marks=pytest.mark.long) for n in range(2, 8))]
)
def test_a_bad_line_costs_the_verdict_and_never_makes_one(number, top, rng):
    faults = [LineFaults(rng, 0), LineFaults(rng, 0)]
    wire = SimulatedWire(top, CLOCKS_PER_SECOND, Wire(*faults))
    # Three in four scenes have one near pair: a false clear needs but one lost triangle.
    near = number % 4 != 0
    a, b, pair = one_near_pair(rng, near)
    right = [list(pair)] if near else []
    # The line remembers the frames of a check that was clear.
    assert near_of(board_on(top, wire), a, b + 30_000) == []
    assert top.go
    board = board_on(top, wire)
    board.hello()
    went = top.go_clocks
    for line_faults in faults:
        line_faults.rate = rng.choice([0.1, 0.2, 0.4])
    assert near_or_unknown(board, a, b) in (None, right)
    for line_faults in faults:
        line_faults.rate = 0
    assert near_or_unknown(board_on(top, wire), a, b) == right
    assert top.go == (not near)
    assert near == (top.go_clocks == went)


def test_a_stale_clear_is_not_believed(top, rng):
    stale = StaleReplies()
    wire = SimulatedWire(top, CLOCKS_PER_SECOND, Wire(to_host=stale))
    a, b, pair = one_near_pair(rng)
    assert near_of(board_on(top, wire), a, b + 30_000) == []
    stale.replaying = True
    assert near_of(board_on(top, wire), a, b) == [list(pair)]


@pytest.mark.long
def test_a_frame_of_long_ago_is_not_taken_for_the_next(top, rng):
    """A line that keeps frames back delivers one with the low bits of the number that is due."""
    sent, ago, replaying = [], 256, False

    def keep(data):
        sent.extend([data] if data else [])
        old = sent[-1 - ago] if replaying and data else b""
        return old + data

    board = board_on(top, SimulatedWire(top, CLOCKS_PER_SECOND, Wire(to_board=keep)))
    a, b, pair = one_near_pair(rng)
    board.hello()
    loaded = len(sent)
    assert BoardEngine(board, a, b + 30_000).run(STILL, 2).near_count == 0
    for _ in range(ago - (len(sent) - loaded)):
        board.status()
    replaying = True
    assert BoardEngine(board, a, b).run(STILL, 2).near.tolist() == [list(pair)]
    assert top.stop


@pytest.mark.parametrize("loading", [True, False])
def test_unplugged(loading, top, boxes, report, capsys):
    """While A is loaded, or the output says go: nothing remains in the report or on the line."""
    due, said, passed, wait = threading.Event(), [], [], patient(top)

    def count(data):
        wait(data)
        passed.append(data)
        if data and (said or (loading and sum(map(len, passed)) > 200)) and not due.is_set():
            due.set()
            # The plug is pulled while these bytes are on their way.
            time.sleep(0.2)
        return data

    def watch(data):
        if top.go_clocks > PARAMETERS.watchdog_clocks and not said:
            said.append(read_published(report, "check")["verdict"])
        return data

    with ServedBoard(top, Wire(count, watch)) as served:
        threading.Thread(target=lambda: due.wait(600) and served.unplug(), daemon=True).start()
        words = ["board", "check", *map(str, boxes), "--port", served.path, "--hold", "--json", str(report)]
        assert main([*words, "--skip-self-test"]) == 2
    out, error = capsys.readouterr()
    assert error == f"triaxis: error: {served.path}: {GONE}\n"
    assert read_published(report, "check") == {"verdict": "unknown"}
    assert (said, "output: go" in out, top.go) == (([], False, False) if loading else (["clear"], True, True))
    top.step(PARAMETERS.watchdog_clocks + 100)
    assert top.stop


@pytest.mark.parametrize(("step", "why"), [("load", "before the run: check again"), ("run", "after the run")])
def test_clear_without_go_says_why(step, why, top, board_check, boxes, monkeypatch):
    real = getattr(Board, step)

    def slow(board, *arguments):
        found = real(board, *arguments)
        # Until the watchdog has run out.
        while top.pins().leds & 1 << 3:
            time.sleep(0.01)
        return found

    monkeypatch.setattr(Board, step, slow)
    status, out, _ = board_check(*boxes, "--skip-self-test")
    assert (status, "CLEAR" in out) == (0, True)
    assert re.search(f"output: stop: .* silent for 1 ms {why}", out)


def test_an_interrupted_hold_stops_at_once(top, board_check, boxes, capsys, monkeypatch):
    monkeypatch.setattr(engine_module, "time", SimpleNamespace(sleep=interrupt))
    with pytest.raises(KeyboardInterrupt):
        board_check(*boxes, "--hold")
    assert top.go_clocks
    assert top.stop
    assert "output: go until interrupted" in capsys.readouterr().out


def test_the_end_of_a_hold_is_told_before_an_answer_is_waited_for():
    told: list[str] = []
    board: Any = SimpleNamespace(still=interrupt, stop=lambda: told.append("stop"))
    status: Any = None
    with pytest.raises(KeyboardInterrupt):
        engine_module.hold(board, status, lambda: told.append("unknown"))
    assert told == ["stop", "unknown"]

    def full():
        raise InputError("r.json: no space left on device")

    # Where the output says stop by itself, both are told.
    stopped: Any = SimpleNamespace(still=lambda _: SimpleNamespace(flags=0))
    with pytest.raises(LinkError, match=r"says stop: .* check again; r.json: no space left"):
        engine_module.hold(stopped, status, full)


def test_a_board_whose_check_is_silent_is_refused_before_anything_is_loaded(
    top, board_check, boxes, report, monkeypatch
):
    real = Board.run

    def tried(board, mode, margin, pose=LOADED_POSE, trial=0):
        return real(board, mode, margin, pose, trial=trial * (trial >> 5 != TrialKind.WALK))

    monkeypatch.setattr(Board, "run", tried)
    status, out, error = board_check(*boxes, "--json", report)
    assert (status, out, top.go_clocks) == (2, "", 0)
    assert "the board's check of one scan by another does not tell of the fault put before it" in error
    assert read_published(report, "check") == {"verdict": "unknown"}
    status, _, _ = board_check(*boxes, "--json", report, "--skip-self-test")
    assert (status, read_published(report, "check")["self_test"]) == (0, "skipped")


def test_a_fault_in_use_is_unknown_and_a_further_check_is_right(top, board_check, boxes, monkeypatch):
    real = Board.run

    def failing(board, mode, margin, pose=LOADED_POSE, trial=0):
        return real(board, mode, margin, pose, trial=trial or trial_of(TrialKind.WALK, 3))

    with monkeypatch.context() as patched:
        patched.setattr(Board, "run", failing)
        status, out, error = board_check(*boxes, "--skip-self-test", "--hold")
    assert (status, out, top.go_clocks) == (2, "", 0)
    assert error.startswith("triaxis: error: the board has found a fault in itself: run the command again")
    assert board_check(*boxes)[0] == 0


def test_a_port_is_for_one_program(top, capsys):
    with ServedBoard(top, Wire(patient(top))) as served, Board(SerialLine(served.path)) as board:
        board.hello()
        assert main(["board", "status", "--port", served.path]) == 2
        assert capsys.readouterr().err == (
            f"triaxis: error: {served.path}: port in use: end the other program\n"
        )
        assert board.status().errors == 0


def test_a_second_master_is_refused_while_the_first_lives(top, rng, monkeypatch):
    wire = SimulatedWire(top, CLOCKS_PER_SECOND)
    first, second = board_on(top, wire), board_on(top, wire)
    a, b, pair = one_near_pair(rng)
    order = []

    def keeps_asking(step):
        # Between two frames of the first, and then with its replies among our own.
        order.append(step)
        with monkeypatch.context() as patched:
            patched.setattr(board_module, "_REFUSALS", 2)
            with pytest.raises(LinkError, match="belongs to another master: end that program"):
                second.hello()

    first.hello()
    assert BoardEngine(first, a, b, progress=keeps_asking).run(STILL, 2).near.tolist() == [list(pair)]
    assert len(order) > 3
    # The first falls silent: the second waits for its watchdog.
    a, b, _ = one_near_pair(rng, near=False)
    assert near_of(second, a, b) == []
    assert top.go
    # Whatever the first then asks for only stops the machine.
    with pytest.raises(LinkError, match="was reset, or another master has taken it; verdict unknown"):
        first.run(Mode.ALL, 2)
    assert top.stop
    assert second.status().errors > 0
    assert near_of(second, a, b) == []
    top.press(16)
    assert top.stop
    with pytest.raises(LinkError, match="was reset, or another master has taken it"):
        second.run(Mode.ALL, 2)
    assert near_of(second, a, b) == []


@pytest.mark.long
def test_a_bitstream_of_another_checkout_is_refused_unless_allowed(
    top, board_check, boxes, report, monkeypatch, capsys
):
    options = (*boxes, "--json", report)
    assert board_check(*options)[0] == 0
    assert read_published(report, "check")["bitstream"] == {"known": True, "any_allowed": False}
    monkeypatch.setattr(engine_module, "checkout_id", lambda: 0xFACADE)
    status, out, error = board_check(*options)
    assert (status, out) == (2, "")
    assert f"{OTHER_BUILD}: load the bitstream of this checkout, or allow others" in error
    assert read_published(report, "check") == {"verdict": "unknown"}
    status, out, _ = board_check(*options, "--any-bitstream")
    assert (status, out.startswith(f"warning: {OTHER_BUILD}; allowed by --any-bitstream\n")) == (0, True)
    said = read_published(report, "check")
    assert (said["verdict"], said["bitstream"]) == ("clear", {"known": False, "any_allowed": True})
    with ServedBoard(top, Wire(patient(top))) as served:
        assert main(["board", "status", "--port", served.path]) == 0
    said = capsys.readouterr().out
    assert f"warning: {OTHER_BUILD}: `board check` refuses it without --any-bitstream\n" in said
    assert (
        "16 bits, margin 16 bits, 512 facets a mesh, groups of 8, 8 lanes" in said
        and "watchdog 1 ms, each clear certified" in said
    )


@pytest.mark.parametrize("once", [[], ["--once"]])
def test_the_simulated_board_as_a_program_of_its_own(once, capsys):
    command = [TRIAXIS, "board", "simulate", "--depth", "512", *once]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as simulation:
        try:
            assert simulation.stdout
            assert simulation.stderr
            path = simulation.stdout.readline().strip()
            # A machine that is too busy for the client's patience is no failure of the board's.
            asked = (main(["board", "status", "--port", path]) for _ in range(1 if once else 20))
            assert (once and next(asked) in (0, 2)) or 0 in asked
            assert once or "512 facets a mesh" in capsys.readouterr().out
            if not once:
                simulation.send_signal(signal.SIGINT)
            assert simulation.wait(120) == (0 if once else 130)
            # Before it, that a board was built, where it was.
            assert once or simulation.stderr.read().endswith("triaxis: interrupted\n")
        finally:
            simulation.kill()
