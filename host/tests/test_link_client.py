"""The client against boards that lie, are silent, or are somebody else's: never a verdict from them."""

import errno
import re
from dataclasses import replace

import numpy as np
import pytest
import serial

from triaxis.host.broadphase import spatial_order
from triaxis.host.link.board import Board
from triaxis.host.link.board_engine import BoardEngine
from triaxis.host.link.exchange import LinkError, SerialLine
from triaxis.host.link.messages import Code, Command, Flag, Mode, Pose, ReplyHead, Results, twice
from triaxis.host.link.wire import Deframer, encode
from triaxis.host.tests.scripted_board import BOARD, ScriptedLine

A = np.arange(6 * 9).reshape(6, 3, 3)
B = 100 + np.arange(5 * 9).reshape(5, 3, 3)


def check(line, mode=Mode.ALL, pose=(0, 0, 0), margin=3, a=A, b=B):
    with Board(line) as board:
        board.hello()
        return BoardEngine(board, a, b, mode).run(pose, margin)


def refused(line, **options):
    with pytest.raises(LinkError) as error:
        check(line, **options)
    assert "\n" not in str(error.value)
    assert line.name == "closed"
    return str(error.value)


def test_a_board_that_accounts_for_every_pair_is_believed():
    found = check(ScriptedLine())
    assert found.near_count == 0
    assert found.near.shape == (0, 2)


RUNNING = {"state": 1, "end": 0, "cycles": 0, "groups_skipped": 0, "groups_opened": 0, "pairs_skipped": 0,
           "tested": 0, "flags": 0}  # fmt: skip
LIES = [
    {"state": 0},
    {"state": 1},
    {"state": 1, "end": 0},
    {"state": 3},
    RUNNING,
    {"run": 2},
    {"run": 0},
    {"x": 1},
    {"z": -1},
    {"margin": 2},
    {"count_a": 5},
    {"count_b": 6},
    {"end": 0},
    {"end": 2},
    {"end": 3},
    {"end": 4},
    {"end": 5},
    {"end": 6},
    {"end": 7},
    {"near": 1},
    # Go, and yet near, or not the end of a complete run, or too late.
    {"near": 1, "flags": 1},
    {"end": 3, "flags": 1},
    {**RUNNING, "flags": 1},
    {"flags": 5},
    # Near pairs that nobody gets; a flag that there is not.
    {"flags": 2},
    {"flags": 8},
    # More than a pair a clock.
    {"cycles": 4},
    # Group pairs that were neither skipped nor opened, or more than there are.
    {"groups_skipped": 1},
    {"groups_opened": 3},
    # Pairs that were left out, or tested twice.
    {"groups_skipped": 0, "groups_opened": 4, "tested": 19},
    {"groups_skipped": 0, "groups_opened": 4, "tested": 21},
    {"groups_skipped": 1, "groups_opened": 3, "tested": 3},
    {"pairs_skipped": 30, "tested": 1},
    {"groups_skipped": 4, "groups_opened": 0},
    # Two pairs of groups cannot have so few, nor so many: 16, 8, 4 and 2 are there.
    {"pairs_skipped": 1, "tested": 4},
    {"pairs_skipped": 21, "tested": 4},
]


@pytest.mark.parametrize("lie", LIES, ids=str)
@pytest.mark.parametrize("mode", Mode)
def test_a_status_that_is_not_of_a_complete_run_is_no_verdict(lie, mode):
    line = ScriptedLine().lie(**lie)
    if lie == {"near": 1} and mode == Mode.COUNT:
        assert check(line, mode).near_count == 1
    elif lie == RUNNING:
        assert re.search(
            "a run without end in 30 s: aborted; reset the board; verdict unknown", refused(line)
        )
    else:
        assert refused(line, mode=mode).endswith("verdict unknown")


@pytest.mark.parametrize(
    ("lie", "what"),
    [
        ({"end": 3}, "the run was aborted; verdict unknown"),
        ({"end": 4}, "A leaves the board's coordinates when moved: move less"),
        ({"end": 5}, "a mesh has more triangles than the board holds"),
        ({"end": 6}, "the board does not know the mode"),
        ({"near": 5}, "5 near pairs of 4 tested"),
    ],
)
def test_the_reason_is_said(lie, what):
    assert what in refused(ScriptedLine().lie(**lie), mode=Mode.COUNT)


def test_counters_at_the_edge_of_what_is_possible_are_believed():
    everything = {"groups_skipped": 0, "groups_opened": 4, "pairs_skipped": 30, "tested": 0}
    assert check(ScriptedLine().lie(**everything)).near_count == 0
    nothing = {"groups_skipped": 4, "groups_opened": 0, "pairs_skipped": 0, "tested": 0}
    assert check(ScriptedLine().lie(**nothing)).near_count == 0


NEAR = [(0, 0), (5, 4), (1, 2), (0, 4)]


def test_near_pairs_come_back_as_facet_numbers():
    # In another order along x than in the file.
    a = A + np.array([500, 0, 0]) * np.array([3, 1, 5, 0, 4, 2])[:, None, None]
    order_a, order_b = spatial_order(a, BOARD.group), spatial_order(B, BOARD.group)
    assert (order_a != np.arange(6)).any()
    found = check(ScriptedLine(near=NEAR).lie(near=4), a=a)
    assert found.near_count == 4
    assert found.near.tolist() == sorted([int(order_a[i]), int(order_b[j])] for i, j in NEAR)


@pytest.mark.parametrize(
    ("near", "what"),
    [
        (NEAR[:3], "near pairs received: 3, must be 4"),
        ([*NEAR, (1, 1)], "near pairs received: 5, must be 4"),
        ([*NEAR[:3], NEAR[0]], "a near pair twice"),
        ([*NEAR[:3], (6, 0)], "a near pair of triangles that were not loaded"),
        ([*NEAR[:3], (0, 5)], "a near pair of triangles that were not loaded"),
    ],
)
def test_near_pairs_that_cannot_be_are_no_verdict(near, what):
    assert what in refused(ScriptedLine(near=near).lie(near=4))


def test_first_near_pair():
    def first(**lies):
        return ScriptedLine(near=NEAR[:1]).lie(
            **{"near": 1, "end": 2, "tested": 1, "groups_opened": 1, **lies}
        )

    assert check(first(), Mode.FIRST).near_count == 1
    assert "mode of a run that stopped: 1, must be 0" in refused(first())
    stops = "near pairs of a run that stops at the first"
    assert f"{stops}: 0, must be 1" in refused(first(near=0), mode=Mode.FIRST)
    assert f"{stops}: 2, must be 1" in refused(first(near=2, tested=2), mode=Mode.FIRST)
    assert f"{stops}: 1, must be 0" in refused(first(end=1), mode=Mode.FIRST)
    assert "5 group pairs of 4, 11 pairs skipped or tested" in refused(
        first(groups_opened=3), mode=Mode.FIRST
    )
    assert "3 group pairs of 4, 17 pairs skipped" in refused(first(pairs_skipped=16), mode=Mode.FIRST)


def test_near_pairs_wait_where_there_are_some_and_nowhere_else():
    line = ScriptedLine()
    true = line.answer

    def waiting(command, payload):
        code, answer = true(command, payload)
        if command != Command.RESULTS:
            return code, answer
        results = Results.unpack(answer)
        other = results.status.flags ^ Flag.NEAR_WAITING
        return code, replace(results, status=replace(results.status, flags=other)).pack()

    line.answer = waiting
    line.lie(flags=0)
    assert "near pairs wait: True, must be False" in refused(line)
    line = ScriptedLine(near=NEAR).lie(near=4)
    true, line.answer = line.answer, waiting
    assert "near pairs wait: False, must be True" in refused(line)


LATER = [
    {"run": 2}, {"mode": 2}, {"x": 1}, {"margin": 4}, {"cycles": 100}, {"tested": 5}, {"count_a": 5},
    {"errors": 2}, {"near": 1}, {"end": 3},
]  # fmt: skip


@pytest.mark.parametrize("lie", LATER, ids=str)
def test_a_later_status_is_of_the_same_run(lie):
    line = ScriptedLine().lie(errors=3)
    board = Board(line)
    board.hello()
    found = BoardEngine(board, A, B)
    found.run((0, 0, 0), 3)
    assert board.still(found.status) == found.status
    line.lie(errors=4, flags=Flag.WATCHDOG_EXPIRED)
    later = board.still(found.status)
    assert (later.errors, later.flags) == (4, Flag.WATCHDOG_EXPIRED)
    # The output says go only from the end of a run, and the watchdog's end is not forgotten.
    line.lie(flags=Flag.GO)
    with pytest.raises(LinkError, match="flags 0x01 after 0x04; verdict unknown"):
        board.still(later)
    line.lie(**lie)
    with pytest.raises(LinkError, match="contradicts itself or us"):
        board.still(found.status)


@pytest.mark.parametrize(
    "lie",
    [
        {"width": 7}, {"width": 33}, {"margin_bits": 17}, {"depth": 0}, {"depth": 48}, {"group": 0},
        {"lanes": 0}, {"group": 3}, {"lanes": 8}, {"depth": 8}, {"watchdog_ms": 0},
    ],
    ids=str,
)  # fmt: skip
def test_a_board_that_cannot_be_is_none(lie):
    assert "contradicts itself" in refused(ScriptedLine(board=replace(BOARD, **lie)))


def says(code, payload=b""):
    return lambda: (code, payload)


@pytest.mark.parametrize(
    ("command", "code", "what"),
    [
        (Command.LOAD, Code.OTHER_SESSION, "was reset, or another master has taken it; verdict unknown"),
        (Command.LOAD, Code.BAD_SEQUENCE, "LOAD: BAD_SEQUENCE: state lost; verdict unknown"),
        (Command.LOAD, Code.OUT_OF_PLACE, "LOAD: OUT_OF_PLACE: state lost; verdict unknown"),
        (Command.LOAD, Code.OVERFULL, "LOAD was refused: OVERFULL; verdict unknown"),
        (Command.RUN, Code.COUNTS_DIFFER, "RUN: COUNTS_DIFFER: state lost; verdict unknown"),
        (Command.RUN, Code.BUSY, "RUN: BUSY: state lost; verdict unknown"),
        (Command.MOVE, Code.BAD_VALUE, "MOVE was refused: BAD_VALUE; verdict unknown"),
        (Command.HELLO, Code.OTHER_SESSION, "belongs to another master: end that program, then repeat"),
    ],
)
def test_refusals_are_said(command, code, what):
    assert what in refused(ScriptedLine(answers={command: says(code)}))


@pytest.mark.parametrize(
    ("command", "payload", "what"),
    [
        (Command.LOAD, twice(b"\x05\x00"), "triangles loaded: 5, expected 6"),
        (
            Command.LOAD,
            twice(b"\x05"),
            "Loaded: 1 bytes, must be 2: not this protocol, or altered on its way",
        ),
        (Command.LOAD, b"\x06\x00", "a payload and its inverted copy differ: not this protocol, or altered"),
        (
            Command.MOVE,
            twice(bytes(11) + b"\x01"),
            "pose: Pose(x=0, y=0, z=16777216), expected Pose(x=0, y=0, z=0)",
        ),
        (Command.RUN, twice(b"\x02"), "run number: 2, expected 1"),
        (Command.RESULTS, twice(bytes(7)), "must be 51: not this protocol"),
        (Command.HELLO, b"\x02" + bytes(12), "speaks protocol 02, this program 03: load the bitstream"),
        (Command.HELLO, b"", "speaks protocol none, this program 03"),
        (Command.HELLO, twice(b"\x03"), "Description: 1 bytes, must be 13: not this protocol"),
    ],
)
def test_answers_to_another_question_are_said(command, payload, what):
    assert what in refused(ScriptedLine(answers={command: says(Code.OK, payload)}))


@pytest.mark.parametrize("command", Command)
def test_silence_is_said(command):
    line = ScriptedLine(answers={command: lambda: None})
    if command in (Command.STATUS, Command.ABORT):
        board = Board(line)
        board.hello()
        with pytest.raises(LinkError, match=f"no answer to {command.name}"):
            (board.status if command == Command.STATUS else board.abort)()
    else:
        assert "no answer" in refused(line)
    # A person waits for this line.
    assert line.time < 8


def test_the_same_frame_is_sent_again_until_it_is_answered():
    line = ScriptedLine()
    silences = iter([None, None])
    move = twice(Pose(0, 0, 0).pack())
    line.answers[Command.MOVE] = lambda: next(silences, (Code.OK, move))
    assert check(line).near_count == 0
    moves = [frame for frame in line.frames if frame[1] == Command.MOVE]
    assert len(moves) == 3
    assert len(set(moves)) == 1
    assert len(set(line.frames)) == len(line.frames) - 2


def test_sessions_differ_and_are_never_0():
    sessions = set()
    for _ in range(20):
        line = ScriptedLine()
        Board(line).hello()
        (body,) = Deframer().feed(line.frames[0])
        sessions.add(body[5:9])
    assert len(sessions) == 20
    assert bytes(4) not in sessions


def test_a_lost_session_is_begun_again():
    line = ScriptedLine()
    lost = iter([(Code.BAD_SEQUENCE, b"\x07")])
    line.answers[Command.MOVE] = lambda: next(lost, (Code.OK, twice(Pose(0, 0, 0).pack())))
    assert check(line).near_count == 0
    assert sum(frame[1] == Command.HELLO for frame in line.frames) == 2


@pytest.mark.parametrize("field", ["command", "sequence", "session", "code"])
def test_replies_to_others_are_not_heard(field):
    line = ScriptedLine()
    board = Board(line)
    board.hello()
    true = line.answer

    def also_a_wrong_one(command, payload):
        exchange = board._exchange
        head = ReplyHead(command | 0x80, exchange._sequence, exchange._session, 0)
        wrong = replace(head, **{field: getattr(head, field) ^ 0x40})
        status = replace(line.status, flags=Flag.WATCHDOG_EXPIRED)
        line.heard += encode(wrong.pack() + twice(status.pack()))
        line.heard += encode(b"") + encode(b"\x86")
        return true(command, payload)

    line.answer = also_a_wrong_one
    assert board.status().flags == Flag.GO


def test_meshes_too_large_for_the_board_are_refused():
    assert "A: 65 facets: the board holds 64 a mesh" in refused(ScriptedLine(), a=np.repeat(A, 11, 0)[:65])
    assert "B: 65 facets: the board holds 64 a mesh" in refused(ScriptedLine(), b=np.repeat(B, 13, 0))
    assert "B: coordinates 40100..40144: the board's have 16 bits, -32768..32767" in refused(
        ScriptedLine(), b=B + 40000
    )
    assert "A when moved: coordinates 0..32772" in refused(ScriptedLine(), pose=(0, 32720, 0))
    small = ScriptedLine(board=replace(BOARD, margin_bits=4))
    assert "margin 16: the board's has 4 bits, at most 15" in refused(small, margin=16)


@pytest.mark.parametrize(
    ("number", "what"),
    [
        (
            errno.EACCES,
            "no permission: join the port's group (Debian: adduser USER dialout) and log in again",
        ),
        (errno.EBUSY, "port in use: end the other program"),
        (errno.EAGAIN, "port in use: end the other program"),
    ],
)
def test_ports_that_others_hold(monkeypatch, number, what):
    def refuse(*_, **__):
        raise serial.SerialException(number, "could not open port")

    monkeypatch.setattr(serial, "Serial", refuse)
    with pytest.raises(LinkError, match=re.escape(f"/dev/ttyUSB1: {what}")):
        SerialLine("/dev/ttyUSB1")


def test_ports_that_cannot_be_used(tmp_path):
    with pytest.raises(LinkError, match="no such port: plug the board in"):
        SerialLine(str(tmp_path / "none"))
    with pytest.raises(LinkError, match=r"/dev/null: cannot be used as a serial port: .*not a|Inappropriate"):
        SerialLine("/dev/null")
    with pytest.raises(LinkError, match="cannot be used as a serial port"):
        SerialLine(str(tmp_path))
