"""What the board answers to each command, and that it does what it is told once, or not at all."""

import struct

import numpy as np
import pytest

from triaxis.sim.board_parameters import BoardParameters
from triaxis.sim.simulated_board import SimulatedTop
from triaxis.verif.board.tests.board_host import (
    ABORT,
    ALL,
    BUSY,
    COMPLETE,
    COUNT,
    COUNTS,
    DONE,
    EMPTY,
    HELLO,
    LENGTH,
    LOAD,
    MOVE,
    NEVER,
    OK,
    OVERFULL,
    PARAMETERS,
    PLACE,
    RESULTS,
    RUN,
    SEQUENCE,
    SESSION,
    STATUS,
    UNKNOWN,
    VALUE,
    BoardHost,
    clear_run,
    clear_scene,
    flat,
    on_line,
    powered,
    read_results,
)

DEPTH = PARAMETERS.depth


@pytest.fixture
def host():
    return powered()


def refused(host: BoardHost, code: int, command: int, payload: bytes = b"") -> bytes:
    """The command is answered with the code, changes nothing, and does not use up its number."""
    before = host.status()
    reply = host.ask(command, payload)
    assert reply.code == code
    assert host.status() == before
    return reply.payload


# --- Session and sequence ------------------------------------------------------------------------------


def test_nothing_but_hello_without_a_session():
    host = BoardHost(SimulatedTop(PARAMETERS))
    for command in range(2, 8):
        assert host.ask(command).code == SESSION
    # Session 0 is nobody's, even before the first HELLO.
    assert host.ask(STATUS, session=0).code == SESSION
    assert host.ask(HELLO, session=0).code == VALUE
    host.hello()
    assert host.status().errors == 7


@pytest.mark.parametrize("command", range(1, 8))
def test_another_session_is_turned_away_and_changes_nothing(host, command):
    clear_scene(host)
    host.move(1, 2, 3)
    before = host.status()
    reply = host.ask(command, session=host.session + 1)
    assert (reply.code, reply.payload) == (SESSION, b"")
    after = host.status()
    assert after.errors == before.errors + 1
    assert (after.count_a, after.count_b, after.run) == (1, 1, 0)
    assert host.run(ALL).x == 1


def test_another_master_takes_a_board_that_nobody_uses(host):
    clear_scene(host)
    host.top.step(PARAMETERS.watchdog_clocks)
    other = BoardHost(host.top, host.session ^ 0x80000000)
    assert other.ask(STATUS).code == SESSION
    other.hello()
    assert other.status().count_a == 0
    assert host.ask(STATUS).code == SESSION
    assert host.ask(HELLO).code == SESSION
    other.status()


def test_the_master_comes_back_after_its_watchdog(host):
    clear_scene(host)
    assert not host.status().expired
    host.top.step(PARAMETERS.watchdog_clocks)
    status = host.status()
    assert status.expired
    assert (status.count_a, status.count_b) == (1, 1)
    clear_run(host)
    assert not host.status().expired


def test_hello_of_the_same_session_starts_afresh(host):
    clear_scene(host)
    host.move(1, 2, 3)
    clear_run(host)
    host.hello()
    status = host.status()
    assert (status.run, status.state, status.end, status.mode, status.cycles) == (0, NEVER, 0, 0, 0)
    assert (status.x, status.y, status.z, status.margin, status.count_a, status.count_b) == (0,) * 6
    clear_scene(host)
    status = host.run(ALL)
    assert (status.run, status.x, status.y, status.z) == (1, 0, 0, 0)


@pytest.mark.parametrize("ahead", [2, 3, 128, 256, 257, 1 << 31, 0])
def test_bad_sequence(host, ahead):
    host.status()
    # 0 ahead is the number of the last command, but another command.
    reply = host.ask(ABORT, sequence=host.sequence + ahead)
    assert (reply.code, reply.payload) == (SEQUENCE, struct.pack("<I", host.sequence + 1))
    host.status()


def test_the_sequence_wraps():
    host = BoardHost(SimulatedTop(PARAMETERS))
    host.sequence = 2**32 - 3
    host.hello()
    for number in range(5):
        host.move(number, 0, 0)
    assert host.sequence == 3


def test_an_old_hello_of_the_same_session_is_refused(host):
    first = host.sequence
    clear_scene(host)
    clear_run(host)
    reply = host.ask(HELLO, sequence=first)
    assert (reply.code, reply.payload) == (SEQUENCE, struct.pack("<I", host.sequence + 1))
    assert host.status().count_a == 1


def test_a_repeated_hello_is_answered_once_more(host):
    first = host.hello()
    assert host.exchange(on_line(host.frame(HELLO, sequence=host.sequence))).payload == first
    host.load(0, flat(0))
    assert host.status().count_a == 1


def test_unknown_commands(host):
    for command in (0, 8, 0x7F, 0x55):
        assert refused(host, UNKNOWN, command) == b""


# --- Repeats -------------------------------------------------------------------------------------------


def repeated(host: BoardHost, command: int, payload: bytes) -> bytes:
    """Return the reply to the last command's frame, sent again."""
    reply = host.exchange(on_line(host.frame(command, payload, host.sequence)))
    assert reply.code == OK
    return reply.payload


def test_a_repeated_load_loads_once(host):
    payload = host.load_payload(0, 0, flat(0, 3))
    assert host.good(LOAD, payload) == repeated(host, LOAD, payload)
    payload = host.load_payload(0, 3, flat(0, 2))
    first = host.good(LOAD, payload)
    assert [repeated(host, LOAD, payload) for _ in range(3)] == [first] * 3
    assert host.status().count_a == 5


def test_a_repeated_move_moves_once(host):
    payload = struct.pack("<3i", 5, -6, 7)
    assert host.good(MOVE, payload) == repeated(host, MOVE, payload) == payload


def test_a_repeated_run_runs_once(host):
    clear_scene(host)
    payload = host.run_payload(ALL)
    number = host.good(RUN, payload)
    host.finish()
    assert repeated(host, RUN, payload) == number
    host.finish()
    assert host.top.go
    assert host.status().run == number[0] == 1


def test_repeated_results_are_the_same(host):
    host.load(0, flat(0, 10))
    host.load(1, flat(0, 10))
    assert host.run(ALL).near == 100
    host.results(0)
    payload = struct.pack("<I", 32)
    first = host.good(RESULTS, payload)
    assert repeated(host, RESULTS, payload) == first
    assert len(read_results(first, 32)[1]) == 32
    # No part of the ring that was freed is ever shown, whoever asks.
    assert host.exchange(on_line(host.frame(RESULTS, struct.pack("<I", 7), host.sequence))).code == VALUE


@pytest.mark.parametrize("command", [STATUS, ABORT])
def test_repeated_status_and_abort(host, command):
    host.good(command)
    host.sequence -= 1
    first = host.good(command)
    assert repeated(host, command, b"") == first


def test_a_refused_command_is_refused_again(host):
    payload = host.load_payload(0, 5, flat(0))
    for _ in range(3):
        assert host.ask(LOAD, payload).code == PLACE


# --- LOAD ----------------------------------------------------------------------------------------------


def test_both_meshes_to_the_maximum(host):
    for mesh in (0, 1):
        host.load(mesh, flat(100 * mesh, DEPTH))
        payload = host.load_payload(mesh, DEPTH, flat(0))
        assert refused(host, OVERFULL, LOAD, payload) == b""
    status = host.run(COUNT)
    assert (status.end, status.count_a, status.count_b, status.near) == (COMPLETE, DEPTH, DEPTH, 0)
    # 60 and 12 are more than 64: refused as a whole.
    host.load(0, flat(0, 60))
    refused(host, OVERFULL, LOAD, host.load_payload(0, 60, flat(0, 12)))
    host.good(LOAD, host.load_payload(0, 60, flat(0, 4)))


def test_load_out_of_place(host):
    host.load(0, flat(0, 7))
    for first in (1, 6, 8, 60, 65535):
        assert refused(host, PLACE, LOAD, host.load_payload(0, first, flat(0))) == struct.pack("<H", 7)
    assert refused(host, PLACE, LOAD, host.load_payload(1, 1, flat(0))) == struct.pack("<H", 0)


def test_load_from_the_first_index_replaces(host):
    host.load(0, flat(0, 20))
    host.load(1, flat(0))
    host.load(0, flat(5, 2))
    status = host.run(ALL)
    assert (status.count_a, status.near) == (2, 0)


def test_load_of_bad_values(host):
    good = host.load_payload(0, 0, flat(0))
    for mesh in (2, 255):
        refused(host, VALUE, LOAD, bytes([mesh]) + good[1:])
    refused(host, VALUE, LOAD, good[:4][:3] + b"\0")
    refused(host, VALUE, LOAD, host.load_payload(0, 0, flat(0, 13)))


def test_load_of_bad_lengths(host):
    good = host.load_payload(0, 0, flat(0, 2))
    for payload in (b"", good[:3], good[:4], good[:-1], good + b"\0", good[:22]):
        refused(host, LENGTH, LOAD, payload)
    # As many triangles as fill 8 bits with the right rest.
    refused(host, LENGTH, LOAD, good[:3] + bytes([255]) + good[4:])


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
            refused(host, VALUE, LOAD, host.load_payload(0, 0, bad))
    host.load(1, triangles)
    # Each is near itself: what was loaded is what was sent.
    status = host.run(ALL)
    _, near = host.all_results()
    assert {(i, i) for i in range(8)} <= set(map(tuple, near.tolist()))
    assert status.near == len(near)
    for value in (1 << 20, -(1 << 20) - 1):
        refused(host, VALUE, MOVE, struct.pack("<3i", 0, value, 0))
    host.move((1 << 20) - 1, -(1 << 20), 0)
    refused(host, VALUE, RUN, struct.pack("<BIHH", ALL, 1 << 12, 8, 8))


# --- MOVE, RUN, RESULTS --------------------------------------------------------------------------------


def test_move_in_range(host):
    for values in ((-65536, 65535, 0), (0, -65536, 65535), (65535, 0, -65536)):
        host.move(*values)
    for value in (65536, -65537, 2**31 - 1, -(2**31)):
        for place in range(3):
            values = [0, 0, 0]
            values[place] = value
            refused(host, VALUE, MOVE, struct.pack("<3i", *values))
    # The last good one is still in force.
    clear_scene(host)
    status = host.run(ALL)
    assert (status.x, status.y, status.z) == (65535, 0, -65536)


@pytest.mark.parametrize(
    ("command", "length"), [(HELLO, 0), (MOVE, 12), (RUN, 9), (RESULTS, 4), (STATUS, 0), (ABORT, 0)]
)
def test_bad_lengths(host, command, length):
    for wrong in {0, 1, length - 1, length + 1, 100} - {length, -1}:
        refused(host, LENGTH, command, bytes(wrong))


def test_run_needs_two_meshes_and_their_counts(host):
    assert refused(host, EMPTY, RUN, struct.pack("<BIHH", ALL, 0, 0, 0)) == b""
    host.load(0, flat(0, 3))
    refused(host, EMPTY, RUN, struct.pack("<BIHH", ALL, 0, 3, 0))
    refused(host, COUNTS, RUN, struct.pack("<BIHH", ALL, 0, 3, 1))
    host.load(1, flat(5, 2))
    for counts in ((2, 2), (3, 3), (0, 0), (2, 3), (3 + 256, 2), (3, 2 + 256)):
        refused(host, COUNTS, RUN, struct.pack("<BIHH", ALL, 0, *counts))
    assert host.good(RUN, struct.pack("<BIHH", ALL, 0, 3, 2)) == b"\x01"
    host.finish()
    host.hello()
    host.load(1, flat(5, 2))
    refused(host, EMPTY, RUN, struct.pack("<BIHH", ALL, 0, 0, 2))


def test_run_of_bad_values(host):
    clear_scene(host)
    for mode in (3, 4, 255):
        refused(host, VALUE, RUN, struct.pack("<BIHH", mode, 0, 1, 1))
    for margin in (1 << 16, 1 << 31):
        refused(host, VALUE, RUN, struct.pack("<BIHH", ALL, margin, 1, 1))
    assert host.run(ALL, (1 << 16) - 1).near == 1


def test_a_run_that_goes_on_refuses_what_would_disturb_it(host):
    host.load(0, flat(0, DEPTH))
    host.load(1, flat(0, DEPTH))
    # Stalled by a full ring, so it goes on as long as nobody takes near pairs.
    host.start(ALL)
    host.top.step(5000)
    refused(host, BUSY, LOAD, host.load_payload(0, 0, flat(9)))
    refused(host, BUSY, MOVE, struct.pack("<3i", 1, 1, 1))
    refused(host, BUSY, RUN, host.run_payload(ALL))
    status, near = host.all_results()
    assert (status.state, status.near, len(near)) == (DONE, DEPTH**2, DEPTH**2)


def test_results_of_pairs_that_are_not_there(host):
    refused(host, VALUE, RESULTS, struct.pack("<I", 1))
    host.load(0, flat(0, 10))
    host.load(1, flat(0, 10))
    host.run(ALL)
    refused(host, VALUE, RESULTS, struct.pack("<I", 101))
    host.results(50)
    refused(host, VALUE, RESULTS, struct.pack("<I", 49))
    assert host.status().waiting
    assert len(host.results(100)[1]) == 0
    assert not host.status().waiting


def test_run_numbers_wrap(host):
    clear_scene(host)
    payload = host.run_payload(COUNT)
    for number in range(1, 258):
        assert host.good(RUN, payload) == bytes([number % 256])
        host.finish()


def test_pairs_come_as_loaded(host, rng):
    triangles = rng.integers(-(1 << 15), 1 << 15, (DEPTH, 3, 3))
    host.load(0, triangles)
    host.load(1, triangles[::-1])
    host.start(ALL)
    _, near = host.all_results()
    opposite = np.stack([np.arange(DEPTH), DEPTH - 1 - np.arange(DEPTH)], 1)
    assert set(map(tuple, opposite.tolist())) <= set(map(tuple, near.tolist()))
