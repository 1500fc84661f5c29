"""What the board answers to each command, and that it does what it is told once, or not at all."""

import struct

import numpy as np
import pytest

from triaxis.sim.board_parameters import BoardParameters
from triaxis.sim.simulated_board import SimulatedTop
from triaxis.verif.board.tests.board_host import (
    PARAMETERS,
    BoardHost,
    Code,
    Command,
    Mode,
    State,
    clear_run,
    clear_scene,
    flat,
    load_payload,
    on_line,
    powered,
    read_results,
    run_asked,
)

pytestmark = pytest.mark.simulator

DEPTH = PARAMETERS.depth
PLACE, MOVE = struct.Struct("<H").pack, struct.Struct("<3i").pack


def refused(host: BoardHost, code: int, command: int, payload: bytes = b"") -> bytes:
    """The command is answered with the code, changes nothing, and does not use up its number."""
    before = host.status()
    reply = host.ask(command, payload)
    assert reply.code == code, (Code(reply.code), payload)
    assert host.status() == before
    return reply.payload


def load(mesh: int, first: int, count: int = 1) -> tuple[int, bytes]:
    return Command.LOAD, load_payload(mesh, first, flat(0, count))


def run(margin: int, count_a: int, count_b: int, mode: int = Mode.ALL) -> tuple[int, bytes]:
    return Command.RUN, run_asked(mode, margin, count_a, count_b)


def results(start: int) -> tuple[int, bytes]:
    return Command.RESULTS, struct.pack("<I", start)


# --- What is refused ------------------------------------------------------------------------------------

TWO = load(0, 0, 2)[1]
LENGTHS = {Command.HELLO: 0, Command.MOVE: 12, Command.RUN: 9, Command.RESULTS: 4, Command.STATUS: 0}
LENGTHS[Command.ABORT] = 0

# By name: how many triangles A and B have, then code, command and payload, and what the reply holds.
REFUSALS = {
    "unknown": (0, 0, Code.UNKNOWN, [(command, b"") for command in (0, 8, 0x7F, 0x55)], b""),
    "out of place": (7, 0, Code.PLACE, [load(0, n) for n in (1, 6, 8, 60, 65535)], PLACE(7)),
    "not from 0": (7, 0, Code.PLACE, [load(1, 1)], PLACE(0)),
    "full": (DEPTH, DEPTH, Code.OVERFULL, [load(0, DEPTH), load(1, DEPTH)], b""),
    "too full": (60, 0, Code.OVERFULL, [load(0, 60, 12)], b""),
    "no such mesh": (0, 0, Code.VALUE, [load(2, 0), load(255, 0)], None),
    "none or too many": (0, 0, Code.VALUE, [(Command.LOAD, TWO[:3] + b"\0"), load(0, 0, 13)], None),
    # The last: as many triangles as fill 8 bits with the right rest.
    "length of a load": (0, 0, Code.LENGTH, [(Command.LOAD, payload) for payload in (
        b"", TWO[:3], TWO[:4], TWO[:-1], TWO + b"\0", TWO[:22], TWO[:3] + b"\xff" + TWO[4:])], None),
    "length": (0, 0, Code.LENGTH, [
        (command, bytes(wrong))
        for command, length in LENGTHS.items()
        for wrong in sorted({0, 1, length - 1, length + 1, 100} - {length, -1})], None),
    "move": (0, 0, Code.VALUE, [
        (Command.MOVE, MOVE(*np.roll([value, 0, 0], place).tolist()))
        for value in (65536, -65537, 2**31 - 1, -(2**31))
        for place in range(3)], None),
    "nothing loaded": (0, 0, Code.EMPTY, [run(0, 0, 0)], b""),
    "no B": (3, 0, Code.EMPTY, [run(0, 3, 0)], None),
    "no A": (0, 2, Code.EMPTY, [run(0, 0, 2)], None),
    "counts without B": (3, 0, Code.COUNTS, [run(0, 3, 1)], None),
    "counts": (3, 2, Code.COUNTS, [
        run(0, *counts) for counts in ((2, 2), (3, 3), (0, 0), (2, 3), (3 + 256, 2), (3, 2 + 256))], None),
    "mode": (1, 1, Code.VALUE, [run(0, 1, 1, mode) for mode in (3, 4, 255)], None),
    "margin": (1, 1, Code.VALUE, [run(margin, 1, 1) for margin in (1 << 16, 1 << 31)], None),
    "results of no run": (1, 1, Code.VALUE, [results(1)], None),
}  # fmt: skip


@pytest.mark.parametrize("what", REFUSALS)
def test_what_is_wrong_is_refused_and_changes_nothing(host, what):
    count_a, count_b, code, commands, said = REFUSALS[what]
    host.load(0, flat(0, count_a))
    host.load(1, flat(5, count_b))
    for command, payload in commands:
        # Again, it is refused again.
        for _ in range(2):
            reply = refused(host, code, command, payload)
            assert said is None or reply == said


# It needs a build of its own.
@pytest.mark.regress
def test_coordinates_that_need_more_bits_than_there_are(rng):
    host = BoardHost(SimulatedTop(BoardParameters(width=20, margin_bits=12, watchdog_clocks=100_000)))
    host.hello()
    low, high = -(1 << 19), (1 << 19) - 1
    triangles = rng.integers(low, high, (8, 3, 3), endpoint=True)
    triangles[0, 0] = low, high, 0
    host.load(0, triangles)
    for place in range(9):
        for wrong in (low - 1, high + 1):
            bad = triangles.copy()
            bad[7].reshape(-1)[place] = wrong
            # Not even the mesh is emptied.
            refused(host, Code.VALUE, Command.LOAD, load_payload(0, 0, bad, 20))
    host.load(1, triangles)
    # Each is near itself: what was loaded is what was sent.
    status = host.run(Mode.ALL)
    _, near = host.all_results()
    assert {(i, i) for i in range(8)} <= set(map(tuple, near.tolist()))
    assert status.near == len(near)
    for value in (1 << 20, -(1 << 20) - 1):
        refused(host, Code.VALUE, Command.MOVE, MOVE(0, value, 0))
    host.move((1 << 20) - 1, -(1 << 20), 0)
    refused(host, Code.VALUE, Command.RUN, run_asked(Mode.ALL, 1 << 12, 8, 8))


def test_a_run_that_goes_on_refuses_what_would_disturb_it(host):
    host.load_both(flat(0, DEPTH))
    # Stalled by a full ring, so it goes on as long as nobody takes near pairs.
    host.start(Mode.ALL)
    host.top.step(5000)
    for command in (load(0, 0), (Command.MOVE, MOVE(1, 1, 1)), run(0, DEPTH, DEPTH)):
        refused(host, Code.BUSY, *command)
    status, near = host.all_results()
    assert (status.state, status.near, len(near)) == (State.DONE, DEPTH**2, DEPTH**2)


def test_results_of_pairs_that_are_not_there(host):
    host.load_both(flat(0, 10))
    host.run(Mode.ALL)
    refused(host, Code.VALUE, *results(101))
    host.results(50)
    refused(host, Code.VALUE, *results(49))
    assert host.status().waiting
    assert len(host.results(100)[1]) == 0
    assert not host.status().waiting


# --- Session and sequence ------------------------------------------------------------------------------


def test_nothing_but_hello_without_a_session():
    host = BoardHost(SimulatedTop(PARAMETERS))
    for command in range(2, 8):
        assert host.ask(command).code == Code.SESSION
    # Session 0 is nobody's, even before the first HELLO.
    assert host.ask(Command.STATUS, session=0).code == Code.SESSION
    assert host.ask(Command.HELLO, session=0).code == Code.VALUE
    host.hello()
    assert host.status().errors == 7


def test_another_session_is_turned_away_and_changes_nothing(host):
    clear_scene(host)
    host.move(1, 2, 3)
    for command in range(1, 8):
        reply = host.ask(command, session=host.session + 1)
        assert (reply.code, reply.payload) == (Code.SESSION, b"")
    after = host.status()
    assert (after.count_a, after.count_b, after.run, after.errors) == (1, 1, 0, 7)
    assert host.run(Mode.ALL).x == 1


def test_a_board_that_nobody_uses_is_its_masters_or_anothers(host):
    clear_scene(host)
    assert not host.status().expired
    host.top.step(PARAMETERS.watchdog_clocks)
    status = host.status()
    assert (status.expired, status.count_a, status.count_b) == (True, 1, 1)
    clear_run(host)
    assert not host.status().expired
    host.top.step(PARAMETERS.watchdog_clocks)
    other = BoardHost(host.top, host.session ^ 0x80000000)
    assert other.ask(Command.STATUS).code == Code.SESSION
    other.hello()
    assert other.status().count_a == 0
    assert host.ask(Command.STATUS).code == Code.SESSION
    assert host.ask(Command.HELLO).code == Code.SESSION
    other.status()


def test_bad_sequence(host):
    first = host.sequence
    clear_scene(host)
    for ahead in (2, 3, 128, 256, 257, 1 << 31, 0):
        # 0 ahead is the number of the last command, but another command.
        reply = host.ask(Command.ABORT, sequence=host.sequence + ahead)
        assert (reply.code, reply.payload) == (Code.SEQUENCE, struct.pack("<I", host.sequence + 1))
        host.status()
    # An old HELLO of the same session is old, too.
    reply = host.ask(Command.HELLO, sequence=first)
    assert (reply.code, reply.payload) == (Code.SEQUENCE, struct.pack("<I", host.sequence + 1))
    assert host.status().count_a == 1


def test_numbers_wrap():
    host = BoardHost(SimulatedTop(PARAMETERS))
    host.sequence = 2**32 - 3
    host.hello()
    clear_scene(host)
    for number in range(5):
        host.move(number, 0, 0)
    assert host.sequence < 9
    payload = host.run_payload(Mode.COUNT)
    for number in range(1, 258):
        assert host.good(Command.RUN, payload) == bytes([number % 256])
        host.finish()


# --- What is done, and done once -----------------------------------------------------------------------


def repeated(host: BoardHost, command: int, payload: bytes = b"") -> bytes:
    """Return the reply to a command's frame, which it must give again to the same frame."""
    first = host.good(command, payload)
    for _ in range(3):
        reply = host.exchange(on_line(host.frame(command, payload, host.sequence)))
        assert (reply.code, reply.payload) == (Code.OK, first)
        host.finish()
    return first


def test_a_repeated_command_is_done_once_and_answered_again():
    host = powered()
    repeated(host, Command.HELLO)
    for first, count in ((0, 3), (3, 2)):
        assert repeated(host, *load(0, first, count)) == PLACE(first + count)
    host.load(1, flat(5))
    assert host.status().count_a == 5
    assert repeated(host, Command.MOVE, MOVE(5, -6, 7)) == MOVE(5, -6, 7)
    assert repeated(host, *run(0, 5, 1)) == b"\x01"
    assert host.top.go
    assert repeated(host, Command.STATUS)[0] == 1
    repeated(host, Command.ABORT)


def test_repeated_results_are_the_same(host):
    host.load_both(flat(0, 10))
    assert host.run(Mode.ALL).near == 100
    host.results(0)
    assert len(read_results(repeated(host, *results(32)), 32)[1]) == 32
    # No part of the ring that was freed is ever shown, whoever asks.
    command, payload = results(7)
    assert host.exchange(on_line(host.frame(command, payload, host.sequence))).code == Code.VALUE


def test_the_ends_of_the_ranges(host):
    clear_scene(host)
    for values in ((-65536, 65535, 0), (0, -65536, 65535), (65535, 0, -65536)):
        host.move(*values)
        status = host.run(Mode.ALL)
        assert (status.x, status.y, status.z) == values
    host.move(0, 0, 0)
    assert host.run(Mode.ALL, (1 << 16) - 1).near == 1
