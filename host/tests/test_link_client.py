"""The client against boards that lie, are silent, or are somebody else's: never a verdict from them."""

import errno
import re
from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pytest
import serial

from triaxis.host.engines import STILL
from triaxis.host.link.audit import check_later, check_status
from triaxis.host.link.board import Board
from triaxis.host.link.board_engine import BoardEngine
from triaxis.host.link.exchange import LinkError, SerialLine
from triaxis.host.link.messages import (
    ZONES,
    Begun,
    Code,
    Command,
    Flag,
    Mode,
    ReplyHead,
    Results,
    RunRequest,
    twice,
)
from triaxis.host.link.wire import Deframer, encode
from triaxis.host.tests.scripted_board import BOARD, CLEAR, ScriptedLine
from triaxis.sim.pseudo_terminal import PseudoTerminal

A = np.arange(6 * 9).reshape(6, 3, 3)
B = 100 + np.arange(5 * 9).reshape(5, 3, 3)


def check(line, mode=Mode.ALL, pose=STILL, margin=3, a=A, b=B):
    with Board(line) as board:
        board.hello()
        return BoardEngine(board, a, b, mode).run(pose, margin)


def refused(line, **options):
    with pytest.raises(LinkError) as error:
        check(line, **options)
    assert "\n" not in str(error.value)
    assert line.name == "closed"
    return str(error.value)


RUNNING = {"state": 1, "end": 0, "cycles": 0, "groups_skipped": 0, "groups_opened": 0, "pairs_skipped": 0,
           "tested": 0, "flags": 0}  # fmt: skip
LIES = [
    {"state": 0}, {"state": 1}, {"state": 1, "end": 0}, {"state": 3}, RUNNING, {"run": 2}, {"run": 0},
    {"x": 1}, {"z": -1}, {"margin": 2}, {"count_a": 5}, {"count_b": 6}, {"near": 1},
    *({"end": end} for end in range(9) if end != 1),
    # Go, and yet near, or not the end of a complete run, or too late.
    {"near": 1, "flags": 1 | ZONES}, {"end": 3, "flags": 1 | ZONES}, {**RUNNING, "flags": 1},
    {"flags": 5 | ZONES},
    # Near pairs that nobody gets; a flag that there is not; more than a pair a clock.
    {"flags": 2 | ZONES}, {"flags": 64 | ZONES}, {"cycles": 4},
    # Nothing in zones that were not asked about.
    {"flags": Flag.GO | Flag.WARN}, {"flags": Flag.GO | Flag.SLOW}, {"flags": Flag.GO}, {"flags": 0},
    # A fault, in one of the two places that tell of it, in both, or with go.
    {"flags": 8 | ZONES}, {"end": 7, "flags": 8 | ZONES}, {"flags": 9 | ZONES},
    {"end": 7, "flags": 9 | ZONES},
    # Group pairs that were neither skipped nor opened, or more than there are.
    {"groups_skipped": 1}, {"groups_opened": 3},
    # Pairs that were left out, or tested twice.
    {"groups_skipped": 0, "groups_opened": 4, "tested": 19},
    {"groups_skipped": 0, "groups_opened": 4, "tested": 21},
    {"groups_skipped": 1, "groups_opened": 3, "tested": 3}, {"pairs_skipped": 30, "tested": 1},
    {"groups_skipped": 4, "groups_opened": 0},
    # Two pairs of groups cannot have so few, nor so many: 16, 8, 4 and 2 are there.
    {"pairs_skipped": 1, "tested": 4}, {"pairs_skipped": 21, "tested": 4},
    # Nor what is between, but is no sum of two.
    {"tested": 3}, {"tested": 5}, {"pairs_skipped": 10}, {"groups_skipped": 0, "groups_opened": 4},
    # A kind that there is once taken twice.
    {"pairs_skipped": 28}, {"pairs_skipped": 12}, {"pairs_skipped": 4}, {"pairs_skipped": 0},
    {"near": 5, "flags": ZONES}, {"errors": 4096},
]  # fmt: skip


@pytest.mark.parametrize("lie", LIES, ids=str)
def test_a_status_that_is_not_of_a_complete_run_is_no_verdict(lie):
    for mode in Mode:
        line = ScriptedLine().lie(**lie)
        if lie == {"near": 1} and mode == Mode.COUNT:
            assert check(line, mode).near_count == 1
        elif lie == RUNNING:
            assert "a run without end in 30 s: aborted; reset the board; verdict unknown" in refused(line)
        else:
            assert refused(line, mode=mode).endswith("verdict unknown")


def test_a_fault_is_told_with_what_to_do():
    for lie in ({"end": 7, "flags": 8}, {"end": 7, "flags": 8 | ZONES}, {"end": 7, "flags": 8, "near": 1}):
        said = refused(ScriptedLine().lie(**lie))
        assert said.startswith("the board has found a fault in itself: run the command again")
        assert said.endswith("verdict unknown")
    assert "contradicts itself" in refused(ScriptedLine().lie(flags=8))
    board = Board(line := ScriptedLine())
    board.hello()
    engine = BoardEngine(board, A, B)
    engine.run(STILL, 3)
    line.lie(end=7, flags=8)
    with pytest.raises(LinkError, match="found a fault in itself"):
        board.still(engine.status)


def test_counters_at_the_edge_of_what_is_possible_are_believed():
    two = ((2, 2, pairs - 4, 4) for pairs in (6, 10, 12, 18, 20, 24))
    for counts in (*two, (0, 4, 30, 0), (1, 3, 28, 0), (3, 1, 2, 0), (4, 0, 0, 0)):
        names = ("groups_skipped", "groups_opened", "pairs_skipped", "tested")
        assert check(ScriptedLine().lie(**dict(zip(names, counts, strict=True)))).near_count == 0


SLOW, WARN, NEITHER = Flag.SLOW, Flag.WARN, Flag(0)
# Of a run at margin 3: the margins asked for, flags where nothing is in them, and where something is.
ZONED = [
    ((5, 9), NEITHER, {WARN, ZONES}),
    ((5, 5), WARN, {ZONES}), ((5, 4), WARN, {ZONES}), ((5, 0), WARN, {ZONES}),
    ((0, 9), SLOW, {ZONES}), ((3, 9), SLOW, {ZONES}), ((2, 4), SLOW, {ZONES}),
    ((0, 0), ZONES, set()), ((3, 3), ZONES, set()), ((0, 3), ZONES, set()), ((2, 1), ZONES, set()),
]  # fmt: skip
ALL_FLAGS = (NEITHER, SLOW, WARN, ZONES)


def permitted(line, zones):
    with Board(line) as board:
        board.hello()
        return BoardEngine(board, A, B, Mode.FIRST).permit(STILL, 3, 7, zones)


@pytest.mark.parametrize(("zones", "free", "entered"), ZONED, ids=str)
def test_zones_are_asked_and_told_in_the_same_run(zones, free, entered):
    line = ScriptedLine().lie(flags=Flag.GO | free)
    assert permitted(line, zones)
    (run,) = (frame for sent in line.frames for frame in Deframer().feed(sent) if frame[0] == Command.RUN)
    request = RunRequest.unpack(run[9:])
    assert (request.margin, request.slow, request.warn, request.hold) == (3, *zones, 7)
    for flags in entered:
        found = "|".join(str(flag.name) for flag in (SLOW, WARN) if flag in flags & ~free)
        with pytest.raises(LinkError, match=rf"in zones that it must be beyond: {re.escape(found)}; verdict"):
            permitted(ScriptedLine().lie(flags=Flag.GO | flags), zones)
    for flags in {*ALL_FLAGS} - entered - {free}:
        with pytest.raises(
            LinkError, match=f"{Flag.GO | flags:#04x} of zones within 3, {zones[0]}, {zones[1]}"
        ):
            permitted(ScriptedLine().lie(flags=Flag.GO | flags), zones)


def test_something_in_a_zone_was_tested():
    nothing = {"groups_skipped": 4, "groups_opened": 0, "pairs_skipped": 0, "tested": 0}
    for zones, free, entered in ZONED:
        assert permitted(ScriptedLine().lie(**nothing, flags=Flag.GO | free), zones)
        for flags in entered:
            with pytest.raises(LinkError, match="steps, 0 tested, COMPLETE"):
                permitted(ScriptedLine().lie(**nothing, flags=Flag.GO | flags), zones)


def test_of_a_run_that_was_refused_or_cut_off_zones_prove_nothing_but_must_be_possible():
    for zones, free, entered in ZONED:
        for end, what in (
            (3, "the run was aborted"),
            (4, "A leaves"),
            (5, "a mesh has"),
            (6, "not know the mode"),
        ):
            for flags in ALL_FLAGS:
                # Before it is cut off something may be found that is not counted.
                possible = flags == free or (end == 3 and flags in entered)
                with pytest.raises(LinkError, match=what if possible else "of zones within"):
                    permitted(ScriptedLine().lie(end=end, flags=flags, tested=0), zones)


def test_flags_of_zones_that_contradict_the_status():
    near, running = replace(CLEAR, near=1, flags=ZONES), replace(CLEAR, **RUNNING)
    for holds in (False, True):
        check_status(replace(near, flags=ZONES), BOARD.group, holds)
        check_status(running, BOARD.group, holds)
        for flags in (NEITHER, SLOW, WARN):
            with pytest.raises(LinkError, match=f"flags {flags:#04x}, 1 near pairs"):
                check_status(replace(near, flags=flags), BOARD.group, holds)
        for flags in (SLOW, WARN, ZONES):
            for go in (0, Flag.GO):
                with pytest.raises(LinkError, match="numbers of a run in state RUNNING"):
                    check_status(replace(running, flags=flags | go), BOARD.group, holds)
        check_status(replace(running, flags=Flag.NEAR_WAITING), BOARD.group, holds)
        idle = replace(running, state=0, run=0, mode=0, margin=0)
        for one in (replace(near, mode=2), replace(near, near=0), idle, replace(running, mode=2)):
            with pytest.raises(LinkError, match=r"near pairs wait|numbers of a run in state"):
                check_status(replace(one, flags=one.flags | Flag.NEAR_WAITING), BOARD.group, holds)
    # Go of the runs before, which no fault and no silence outlasts.
    for wrong in (0, Flag.FAULT, Flag.WATCHDOG_EXPIRED):
        with pytest.raises(LinkError, match="go, although the watchdog has") if wrong else nullcontext():
            check_status(replace(running, flags=Flag.GO | Flag.NEAR_WAITING | wrong), BOARD.group, True)


NEAR = [(0, 0), (5, 4), (1, 2), (0, 4)]


def test_near_pairs_that_cannot_be_are_no_verdict():
    for near, what in (
        (NEAR[:3], "near pairs received: 3, must be 4"),
        ([*NEAR, (1, 1)], "near pairs received: 5, must be 4"),
        ([*NEAR[:3], NEAR[0]], "a near pair twice"),
        ([*NEAR[:3], (6, 0)], "a near pair of triangles that were not loaded"),
        ([*NEAR[:3], (0, 5)], "a near pair of triangles that were not loaded"),
    ):
        assert what in refused(ScriptedLine(near=near).lie(near=4))


def test_first_near_pair():
    def first(**lies):
        truth = {"near": 1, "end": 2, "tested": 1, "groups_opened": 1}
        return ScriptedLine(near=NEAR[:1]).lie(**{**truth, **lies})

    assert check(first(), Mode.FIRST).near_count == 1
    assert "mode of a run that stopped: 1, must be 0" in refused(first())
    for lies in (
        {"near": 0}, {"near": 2, "tested": 2}, {"end": 1}, {"groups_opened": 3}, {"pairs_skipped": 16},
    ):  # fmt: skip
        assert refused(first(**lies), mode=Mode.FIRST).endswith("verdict unknown")


@pytest.mark.parametrize(("near", "what"), [([], "True, must be False"), (NEAR, "False, must be True")])
def test_near_pairs_wait_where_there_are_some_and_nowhere_else(near, what):
    line = ScriptedLine(near=near).lie(near=4, flags=ZONES)
    true = line.answer

    def waiting(command, payload):
        code, answer = true(command, payload)
        if command != Command.RESULTS:
            return code, answer
        results = Results.unpack(answer)
        other = results.status.flags ^ Flag.NEAR_WAITING
        return code, replace(results, status=replace(results.status, flags=other)).pack()

    line.answer = waiting
    assert f"near pairs wait: {what}" in refused(line)


def test_a_later_status_is_of_the_same_run():
    for lie in (
        {"run": 2}, {"mode": 2}, {"x": 1}, {"margin": 4}, {"cycles": 100},
        {"pairs_skipped": 6, "tested": 6}, {"count_a": 5}, {"errors": 2}, {"near": 1}, {"end": 3},
    ):  # fmt: skip
        line = ScriptedLine().lie(errors=3)
        board = Board(line)
        board.hello()
        engine = BoardEngine(board, A, B)
        engine.run(STILL, 3)
        assert board.still(engine.status) == engine.status
        line.lie(errors=4)
        with pytest.raises(LinkError, match="4 errors after 3, flags 0x31; verdict unknown"):
            board.still(engine.status)
        line.lie(errors=4, flags=Flag.WATCHDOG_EXPIRED | ZONES)
        later = board.still(engine.status)
        assert (later.errors, later.flags) == (4, Flag.WATCHDOG_EXPIRED | ZONES)
        for zone in (SLOW, WARN):
            for before, now in ((Flag.GO, Flag.GO | zone), (Flag.GO | zone, Flag.GO)):
                said = replace(engine.status, flags=before)
                with pytest.raises(LinkError, match=f"flags 0x{now:02x} after 0x{before:02x}"):
                    check_later(said, replace(said, flags=now))
        # The output says go only from the end of a run, and the watchdog's end is not forgotten.
        line.lie(flags=Flag.GO | ZONES)
        with pytest.raises(LinkError, match="flags 0x31 after 0x34; verdict unknown"):
            board.still(later)
        line.lie(**lie)
        with pytest.raises(LinkError, match="contradicts itself or us"):
            board.still(engine.status)


BEGUN = twice(Begun(1, 0).pack())


def test_a_board_that_cannot_be_is_none():
    for lie in (
        {"width": 7}, {"width": 33}, {"margin_bits": 17}, {"depth": 0}, {"depth": 48}, {"group": 0},
        {"lanes": 0}, {"group": 3}, {"lanes": 8}, {"depth": 8}, {"watchdog_ms": 0}, {"certifies": 2},
        {"depth": 32768, "group": 128}, {"depth": 32768, "group": 64, "lanes": 64},
        {"depth": 1, "group": 1, "lanes": 1},
    ):  # fmt: skip
        assert "contradicts itself" in refused(ScriptedLine(board=replace(BOARD, **lie)))


SAID = [
    (Command.LOAD, Code.OTHER_SESSION, b"", "was reset, or another master has taken it; verdict unknown"),
    (Command.LOAD, Code.OVERFULL, b"", "LOAD was refused: OVERFULL; verdict unknown"),
    (Command.RUN, Code.COUNTS_DIFFER, b"", "RUN: COUNTS_DIFFER: state lost; verdict unknown"),
    (Command.RUN, Code.BAD_VALUE, b"", "RUN was refused: BAD_VALUE; verdict unknown"),
    (Command.HELLO, Code.OTHER_SESSION, b"", "belongs to another master: end that program, then repeat"),
    # Answers to another question.
    (Command.LOAD, Code.OK, twice(bytes([5, 0, 0, 0, 0, 0])), "triangles loaded: 5, expected 6"),
    (Command.LOAD, Code.OK, twice(bytes([6, 0, 0, 0, 0, 0])), "signature of the mesh loaded: 0, expected"),
    (Command.LOAD, Code.OK, bytes(6), "a payload and its inverted copy differ: not this protocol"),
    (Command.RUN, Code.OK, twice(bytes([2, 0, 0])), "hold: Begun(number=2, hold=0), expected Begun(number=1"),
    (Command.RUN, Code.OK, twice(bytes([1, 7, 0])), "hold: Begun(number=1, hold=7), expected Begun(number=1"),
    (Command.RESULTS, Code.OK, twice(bytes(7)), "must be 51: not this protocol"),
    *(
        (
            Command.RESULTS,
            Code.OK,
            twice(CLEAR.pack() + bytes([0, 0, 0, 0, count])) + bytes(4 * came),
            f"Results: {4 * came} bytes for {count} near pairs: not this protocol",
        )
        for count, came in ((2, 1), (1, 2))
    ),
    (Command.HELLO, Code.OK, b"\x03" + bytes(12), "speaks protocol 03, this program 07: load the bitstream"),
]


@pytest.mark.parametrize(("command", "code", "payload", "what"), SAID)
def test_refusals_are_said(command, code, payload, what):
    assert what in refused(ScriptedLine(answers={command: lambda: (code, payload)}))


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


def test_a_board_of_a_slow_machine_is_waited_for_until_its_watchdog_has_run_out():
    line = ScriptedLine()
    # No board says more in 100,000 clocks; its machine takes a second for each.
    refusals = iter([(Code.OTHER_SESSION, b"")] * 166)
    line.answers[Command.HELLO] = lambda: line.wait(1) or next(refusals, (Code.OK, twice(BOARD.pack())))
    assert Board(line).hello() == BOARD
    assert line.time > 166


def test_the_same_frame_is_sent_again_until_it_is_answered():
    line = ScriptedLine()
    silences = iter([None, None])
    line.answers[Command.RUN] = lambda: next(silences, (Code.OK, BEGUN))
    assert check(line).near_count == 0
    runs = [frame for frame in line.frames if frame[1] == Command.RUN]
    assert (len(runs), len(set(runs))) == (3, 1)
    assert len(set(line.frames)) == len(line.frames) - 2


def test_sessions_differ_are_never_0_and_a_lost_one_is_begun_again():
    lines = [ScriptedLine() for _ in range(20)]
    for line in lines:
        Board(line).hello()
    sessions = {Deframer().feed(line.frames[0])[0][5:9] for line in lines}
    assert len(sessions) == 20 and bytes(4) not in sessions
    line = ScriptedLine()
    lost = iter([(Code.BAD_SEQUENCE, b"\x07")])
    line.answers[Command.RUN] = lambda: next(lost, (Code.OK, BEGUN))
    assert check(line).near_count == 0
    assert sum(frame[1] == Command.HELLO for frame in line.frames) == 2


def test_another_board_that_answers_in_the_place_of_the_first_is_refused():
    line = ScriptedLine()

    def exchanged():
        line.board = replace(line.board, build=2)
        return Code.BAD_SEQUENCE, b"\x07"

    line.answers[Command.RUN] = exchanged
    with pytest.raises(LinkError, match="another board answers than before; verdict unknown"):
        check(line)


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
        line.heard += encode(b"") + encode(b"\x85")
        return true(command, payload)

    line.answer = also_a_wrong_one
    assert board.status().flags == CLEAR.flags


def test_what_is_too_large_for_the_board_is_refused():
    for options, what in (
        ({"a": np.repeat(A, 11, 0)[:65]}, "A: 65 facets: the board holds 64 a mesh"),
        ({"b": np.repeat(B, 13, 0)}, "B: 65 facets: the board holds 64 a mesh"),
        ({"b": B + 40000}, "B: coordinates 40100..40144: the board's have 16 bits, -32768..32767"),
        ({"pose": (0, 32720, 0)}, "A when moved: coordinates 0..32772"),
    ):
        assert what in refused(ScriptedLine(), **options)
    small = ScriptedLine(board=replace(BOARD, margin_bits=4))
    assert "margin 16: the board's has 4 bits, at most 15" in refused(small, margin=16)
    for zones in ((16, 0), (0, 16)):
        with pytest.raises(LinkError, match="margin 16: the board's has 4 bits, at most 15"):
            permitted(small, zones)
    assert not any(frame[1] == Command.RUN for frame in small.frames)


def test_ports_that_cannot_be_used(monkeypatch, tmp_path):
    for name, what in (
        (str(tmp_path / "none"), "no such port: plug the board in"),
        ("/dev/null", r"/dev/null: cannot be used as a serial port: .*not a|Inappropriate"),
        (str(tmp_path), "cannot be used as a serial port"),
    ):
        with pytest.raises(LinkError, match=what):
            SerialLine(name)
    monkeypatch.setattr("triaxis.host.link.exchange._WRITE_SECONDS", 0.05)
    port = PseudoTerminal()
    # Nobody fetches what is sent.
    with pytest.raises(LinkError, match="takes no bytes: check the cable; verdict unknown"):
        SerialLine(port.path).send(bytes(1 << 20))
    port.close()
    for number, what in (
        (errno.EACCES, "no permission: join the port's group"),
        (errno.EBUSY, "port in use"),
    ):

        def refuse(*_, number=number, **__):
            raise serial.SerialException(number, "could not open port")

        monkeypatch.setattr(serial, "Serial", refuse)
        with pytest.raises(LinkError, match=what):
            SerialLine("/dev/ttyUSB1")
