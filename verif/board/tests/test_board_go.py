"""The board's two outputs: go comes from a complete clear run alone, and every change or fault ends it."""

import struct
from collections.abc import Callable

import pytest

from triaxis.sim.board_parameters import BoardParameters
from triaxis.sim.simulated_board import SimulatedTop
from triaxis.verif.board.tests.board_host import (
    BUSY_LED,
    PARAMETERS,
    BoardHost,
    Command,
    End,
    Mode,
    clear_run,
    clear_scene,
    flat,
    load_payload,
    long_clear_scene,
    on_line,
    powered,
    run_asked,
    says_go,
    start_at_once,
)

pytestmark = pytest.mark.simulator


@pytest.fixture
def host():
    board = powered()
    assert not says_go(board.top)
    clear_scene(board)
    assert not says_go(board.top)
    return board


def bad_crc(host: BoardHost) -> None:
    line = bytearray(on_line(host.frame(Command.STATUS)))
    line[1] ^= 1
    host.silent(bytes(line))


def break_line(host: BoardHost) -> None:
    host.top.break_line(100)
    host.top.step(500)


def one_bit(host: BoardHost) -> None:
    # A byte on the idle line, and the next frame's beginning after it.
    host.top.glitch(PARAMETERS.clocks_per_bit)
    host.top.step(100)
    host.status()


def reload(host: BoardHost) -> None:
    host.load(0, flat(0))


def hello(host: BoardHost) -> None:
    host.hello()
    assert not says_go(host.top)
    clear_scene(host)


def reset(host: BoardHost) -> None:
    host.top.reset()
    hello(host)


def overrun(host: BoardHost) -> None:
    for number in range(3):
        host.top.send(on_line(host.frame(Command.STATUS, sequence=host.sequence + 1 + number)))
    assert len(host.replies(20_000)) == 2
    host.sequence += 2


# Each with what the board answers; the scene is the same and clear afterwards.
ENDS: dict[str, Callable[[BoardHost], object]] = {
    "LOAD": reload,
    "MOVE": lambda host: host.move(0, 0, 0),
    "ABORT": lambda host: host.good(Command.ABORT),
    "HELLO": hello,
    "reset": reset,
    "bad CRC": bad_crc,
    "bad stuffing": lambda host: host.silent(b"\xc0\x06\xdb\x06\xc0"),
    "stuffing twice": lambda host: host.silent(b"\xc0\x06\xdb\xdb\xc0"),
    "stuffing at the end": lambda host: host.silent(b"\xc0\x06\xdb\xc0"),
    "too short": lambda host: host.silent(b"\xc0\x06\xc0"),
    "too long": lambda host: host.silent(b"\xc0" + bytes(257) + b"\xc0"),
    "framing error": break_line,
    "noise": one_bit,
    "frame too early": overrun,
    "unknown command": lambda host: host.ask(0x20),
    "bad length": lambda host: host.ask(Command.STATUS, b"\0"),
    "other session": lambda host: host.ask(Command.STATUS, session=1),
    "other session's HELLO": lambda host: host.ask(Command.HELLO, session=1),
    "session 0": lambda host: host.ask(Command.HELLO, session=0),
    "bad sequence": lambda host: host.ask(Command.STATUS, sequence=host.sequence + 2),
    "bad value": lambda host: host.ask(Command.RUN, run_asked(3, 0, 1, 1)),
    "busy or bad value": lambda host: host.ask(Command.MOVE, struct.pack("<3i", 1 << 17, 0, 0)),
    "out of place": lambda host: host.ask(Command.LOAD, load_payload(0, 9, flat(0))),
    "counts differ": lambda host: host.ask(Command.RUN, run_asked(Mode.ALL, 0, 2, 1)),
    "watchdog": lambda host: host.top.step(PARAMETERS.watchdog_clocks),
}


NO_FRAMES = (
    "bad CRC", "bad stuffing", "stuffing twice", "stuffing at the end", "too short", "too long",
    "framing error", "noise", "frame too early",
)  # fmt: skip


@pytest.mark.parametrize("end", ENDS)
def test_go_ends_and_only_a_run_brings_it_back(host, end):
    clear_run(host)
    ENDS[end](host)
    assert not says_go(host.top)
    # What is no frame is counted, once.
    assert host.status().errors == 1 or end not in NO_FRAMES
    # Talk alone does not help.
    go_clocks = host.top.go_clocks
    for _ in range(3):
        host.status()
    host.results(0)
    assert host.top.go_clocks == go_clocks
    clear_run(host)


# A frame that is too long takes longer than the run; so does the watchdog.
IN_RUN = [end for end in ENDS if end not in ("LOAD", "MOVE", "too long", "watchdog")]


@pytest.mark.parametrize("end", IN_RUN)
def test_what_comes_during_a_run_spoils_it(host, end):
    long_clear_scene(host)
    start_at_once(host, Mode.ALL)
    host.replies(2000, 1)
    assert host.top.leds & BUSY_LED
    go_clocks = host.top.go_clocks
    ENDS[end](host)
    host.finish()
    host.status()
    assert not says_go(host.top)
    assert host.top.go_clocks == go_clocks


def test_no_go_while_a_clear_run_goes_on(host):
    long_clear_scene(host)
    clear_run(host)
    start_at_once(host, Mode.ALL)
    assert not says_go(host.top)
    go_clocks = host.top.go_clocks
    host.replies(2000, 1)
    while host.top.leds & BUSY_LED:
        assert host.top.go_clocks == go_clocks
        host.top.step(1)
    host.top.step(1)
    assert says_go(host.top)


@pytest.mark.parametrize("mode", [Mode.FIRST, Mode.ALL, Mode.COUNT])
def test_go_in_every_mode_and_only_without_near_pairs(host, mode):
    for height, is_go in ((0, True), (5, False), (6, True), (-1, True), (4, True)):
        host.move(0, 0, height)
        status = host.run(mode)
        assert status.go == says_go(host.top) == is_go
    # Exactly at the margin is near.
    assert host.run(mode, 1).go is False
    host.move(0, 0, 3)
    assert host.run(mode, 1).go
    host.move(1 << 15, 0, 0)
    status = host.run(mode)
    assert (status.end, status.near, status.tested) == (End.OVERFLOW, 0, 0)
    assert not status.go and not says_go(host.top)


def test_what_does_not_end_go(host):
    payload = host.run_payload(Mode.ALL)
    host.good(Command.RUN, payload)
    host.finish()
    go_clocks, clocks = host.top.go_clocks, host.top.clocks
    host.exchange(on_line(host.frame(Command.RUN, payload, host.sequence)))
    host.status()
    host.results(0)
    host.silent(b"\xc0\xc0")
    # Shorter than half a bit.
    host.top.glitch(PARAMETERS.clocks_per_bit // 2 - 1)
    host.top.step(100)
    assert host.status().errors == 0
    for _ in range(3):
        host.status()
        host.top.step(PARAMETERS.watchdog_clocks - 7000)
        assert says_go(host.top)
    assert host.top.go_clocks - go_clocks == host.top.clocks - clocks


def test_the_watchdog_is_exact(host):
    clear_run(host)
    host.status()
    # Known to a frame's length: the watchdog began with the frame, the reply has come since.
    reply = 10 * PARAMETERS.clocks_per_bit * 125
    host.top.step(PARAMETERS.watchdog_clocks - reply)
    assert says_go(host.top)
    host.top.step(reply)
    assert not says_go(host.top)


ALIVE_LED = 1 << 3


def sent_for_ever(host: BoardHost, frame: bytes) -> None:
    """Deliver one frame again and again, twice in each of some watchdog times; nobody else speaks."""
    for _ in range(6):
        host.exchange(on_line(frame))
        host.top.step(PARAMETERS.watchdog_clocks // 2)


# Each with how far its number is from the last one.
NOT_EXECUTED = {
    "the last one again": (Command.STATUS, b"", 0),
    "far ahead": (Command.STATUS, b"", 77),
    "bad length": (Command.STATUS, b"\0", 1),
    "counts differ": (Command.RUN, run_asked(Mode.ALL, 0, 9, 9), 1),
    "out of place": (Command.LOAD, load_payload(0, 9, flat(0)), 1),
    # Older ones of the board's own master: its HELLO, too, must not keep the board from others.
    "an old one": (Command.STATUS, b"", -1),
    "an old HELLO": (Command.HELLO, b"", -5),
    "another master's": (Command.STATUS, b"", 1),
}


@pytest.mark.parametrize("what", NOT_EXECUTED)
def test_what_is_not_executed_keeps_no_go_and_no_watchdog_alive(host, what):
    command, payload, ahead = NOT_EXECUTED[what]
    clear_run(host)
    for _ in range(5):
        host.status()
    session = 77 if what == "another master's" else None
    sent_for_ever(host, host.frame(command, payload, host.sequence + ahead, session))
    assert not says_go(host.top)
    assert not host.top.leds & ALIVE_LED
    BoardHost(host.top, 99).hello()


@pytest.mark.regress
def test_a_load_of_bad_coordinates_keeps_no_watchdog_alive():
    host = BoardHost(SimulatedTop(BoardParameters(width=20, margin_bits=12, watchdog_clocks=100_000)))
    host.hello()
    sent_for_ever(host, host.frame(Command.LOAD, struct.pack("<BHB", 0, 0, 1) + b"\xff\xff\x0f" * 9))
    assert not host.top.leds & ALIVE_LED


def test_the_beat_is_there_while_go_is_and_no_longer(host):
    clear_run(host)
    host.status()
    host.top.step(PARAMETERS.beat_clocks)
    beats = host.top.beats
    host.top.step(10 * PARAMETERS.beat_clocks)
    assert host.top.beats == beats + 10
    host.good(Command.ABORT)
    beats = host.top.beats
    host.top.step(10 * PARAMETERS.beat_clocks)
    assert host.top.beats == beats


def test_stop_from_power_up():
    host = BoardHost(SimulatedTop(PARAMETERS))
    host.top.step(5000)
    assert (host.top.go_clocks, host.top.beats) == (0, 0)
    assert not says_go(host.top)


def test_soak(host, rng):
    """Anything in any order: go exactly as the steps so far say, and never for a clock more."""
    go = False
    ends = [ENDS[name] for name in ENDS if name != "watchdog"]
    for _ in range(100):
        before = host.top.go_clocks
        kind = rng.integers(4)
        if kind == 0:
            ends[rng.integers(len(ends))](host)
            go = False
        elif kind == 1:
            host.move(0, 0, int(rng.integers(4, 7)))
            go = False
        elif kind == 2:
            status = host.run(int(rng.integers(3)))
            # The scene is near at one height alone.
            go = status.z != 5
        else:
            # Nothing that changes or fails.
            host.results(0)
            host.silent(b"\xc0\xc0\xc0")
        assert says_go(host.top) == go
        if not go and kind == 3:
            assert host.top.go_clocks == before
    assert host.top.go_clocks
