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
    End,
    Mode,
    State,
    clear_run,
    clear_scene,
    flat,
    on_line,
    read_results,
    run_asked,
)

pytestmark = pytest.mark.simulator

DEPTH = PARAMETERS.depth


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
        assert host.ask(command).code == Code.SESSION
    # Session 0 is nobody's, even before the first HELLO.
    assert host.ask(Command.STATUS, session=0).code == Code.SESSION
    assert host.ask(Command.HELLO, session=0).code == Code.VALUE
    host.hello()
    assert host.status().errors == 7


@pytest.mark.parametrize("command", range(1, 8))
def test_another_session_is_turned_away_and_changes_nothing(host, command):
    clear_scene(host)
    host.move(1, 2, 3)
    before = host.status()
    reply = host.ask(command, session=host.session + 1)
    assert (reply.code, reply.payload) == (Code.SESSION, b"")
    after = host.status()
    assert after.errors == before.errors + 1
    assert (after.count_a, after.count_b, after.run) == (1, 1, 0)
    assert host.run(Mode.ALL).x == 1


def test_another_master_takes_a_board_that_nobody_uses(host):
    clear_scene(host)
    host.top.step(PARAMETERS.watchdog_clocks)
    other = BoardHost(host.top, host.session ^ 0x80000000)
    assert other.ask(Command.STATUS).code == Code.SESSION
    other.hello()
    assert other.status().count_a == 0
    assert host.ask(Command.STATUS).code == Code.SESSION
    assert host.ask(Command.HELLO).code == Code.SESSION
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
    assert (status.run, status.state, status.end, status.mode, status.cycles) == (0, State.NEVER, 0, 0, 0)
    assert (status.x, status.y, status.z, status.margin, status.count_a, status.count_b) == (0,) * 6
    clear_scene(host)
    status = host.run(Mode.ALL)
    assert (status.run, status.x, status.y, status.z) == (1, 0, 0, 0)


@pytest.mark.parametrize("ahead", [2, 3, 128, 256, 257, 1 << 31, 0])
def test_bad_sequence(host, ahead):
    host.status()
    # 0 ahead is the number of the last command, but another command.
    reply = host.ask(Command.ABORT, sequence=host.sequence + ahead)
    assert (reply.code, reply.payload) == (Code.SEQUENCE, struct.pack("<I", host.sequence + 1))
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
    reply = host.ask(Command.HELLO, sequence=first)
    assert (reply.code, reply.payload) == (Code.SEQUENCE, struct.pack("<I", host.sequence + 1))
    assert host.status().count_a == 1


def test_a_repeated_hello_is_answered_once_more(host):
    first = host.hello()
    assert host.exchange(on_line(host.frame(Command.HELLO, sequence=host.sequence))).payload == first
    host.load(0, flat(0))
    assert host.status().count_a == 1


def test_unknown_commands(host):
    for command in (0, 8, 0x7F, 0x55):
        assert refused(host, Code.UNKNOWN, command) == b""


# --- Repeats -------------------------------------------------------------------------------------------


def repeated(host: BoardHost, command: int, payload: bytes) -> bytes:
    """Return the reply to the last command's frame, sent again."""
    reply = host.exchange(on_line(host.frame(command, payload, host.sequence)))
    assert reply.code == Code.OK
    return reply.payload


def test_a_repeated_load_loads_once(host):
    payload = host.load_payload(0, 0, flat(0, 3))
    assert host.good(Command.LOAD, payload) == repeated(host, Command.LOAD, payload)
    payload = host.load_payload(0, 3, flat(0, 2))
    first = host.good(Command.LOAD, payload)
    assert [repeated(host, Command.LOAD, payload) for _ in range(3)] == [first] * 3
    assert host.status().count_a == 5


def test_a_repeated_move_moves_once(host):
    payload = struct.pack("<3i", 5, -6, 7)
    assert host.good(Command.MOVE, payload) == repeated(host, Command.MOVE, payload) == payload


def test_a_repeated_run_runs_once(host):
    clear_scene(host)
    payload = host.run_payload(Mode.ALL)
    number = host.good(Command.RUN, payload)
    host.finish()
    assert repeated(host, Command.RUN, payload) == number
    host.finish()
    assert host.top.go
    assert host.status().run == number[0] == 1


def test_repeated_results_are_the_same(host):
    host.load_both(flat(0, 10))
    assert host.run(Mode.ALL).near == 100
    host.results(0)
    payload = struct.pack("<I", 32)
    first = host.good(Command.RESULTS, payload)
    assert repeated(host, Command.RESULTS, payload) == first
    assert len(read_results(first, 32)[1]) == 32
    # No part of the ring that was freed is ever shown, whoever asks.
    assert (
        host.exchange(on_line(host.frame(Command.RESULTS, struct.pack("<I", 7), host.sequence))).code
        == Code.VALUE
    )


@pytest.mark.parametrize("command", [Command.STATUS, Command.ABORT])
def test_repeated_status_and_abort(host, command):
    host.good(command)
    host.sequence -= 1
    first = host.good(command)
    assert repeated(host, command, b"") == first


def test_a_refused_command_is_refused_again(host):
    payload = host.load_payload(0, 5, flat(0))
    for _ in range(3):
        assert host.ask(Command.LOAD, payload).code == Code.PLACE


# --- LOAD ----------------------------------------------------------------------------------------------


def test_both_meshes_to_the_maximum(host):
    for mesh in (0, 1):
        host.load(mesh, flat(100 * mesh, DEPTH))
        payload = host.load_payload(mesh, DEPTH, flat(0))
        assert refused(host, Code.OVERFULL, Command.LOAD, payload) == b""
    status = host.run(Mode.COUNT)
    assert (status.end, status.count_a, status.count_b, status.near) == (End.COMPLETE, DEPTH, DEPTH, 0)
    # 60 and 12 are more than 64: refused as a whole.
    host.load(0, flat(0, 60))
    refused(host, Code.OVERFULL, Command.LOAD, host.load_payload(0, 60, flat(0, 12)))
    host.good(Command.LOAD, host.load_payload(0, 60, flat(0, 4)))


def test_load_out_of_place(host):
    host.load(0, flat(0, 7))
    for first in (1, 6, 8, 60, 65535):
        assert refused(host, Code.PLACE, Command.LOAD, host.load_payload(0, first, flat(0))) == struct.pack(
            "<H", 7
        )
    assert refused(host, Code.PLACE, Command.LOAD, host.load_payload(1, 1, flat(0))) == struct.pack("<H", 0)


def test_load_from_the_first_index_replaces(host):
    host.load(0, flat(0, 20))
    host.load(1, flat(0))
    host.load(0, flat(5, 2))
    status = host.run(Mode.ALL)
    assert (status.count_a, status.near) == (2, 0)


def test_load_of_bad_values(host):
    good = host.load_payload(0, 0, flat(0))
    for mesh in (2, 255):
        refused(host, Code.VALUE, Command.LOAD, bytes([mesh]) + good[1:])
    refused(host, Code.VALUE, Command.LOAD, good[:4][:3] + b"\0")
    refused(host, Code.VALUE, Command.LOAD, host.load_payload(0, 0, flat(0, 13)))


def test_load_of_bad_lengths(host):
    good = host.load_payload(0, 0, flat(0, 2))
    for payload in (b"", good[:3], good[:4], good[:-1], good + b"\0", good[:22]):
        refused(host, Code.LENGTH, Command.LOAD, payload)
    # As many triangles as fill 8 bits with the right rest.
    refused(host, Code.LENGTH, Command.LOAD, good[:3] + bytes([255]) + good[4:])


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
            refused(host, Code.VALUE, Command.LOAD, host.load_payload(0, 0, bad))
    host.load(1, triangles)
    # Each is near itself: what was loaded is what was sent.
    status = host.run(Mode.ALL)
    _, near = host.all_results()
    assert {(i, i) for i in range(8)} <= set(map(tuple, near.tolist()))
    assert status.near == len(near)
    for value in (1 << 20, -(1 << 20) - 1):
        refused(host, Code.VALUE, Command.MOVE, struct.pack("<3i", 0, value, 0))
    host.move((1 << 20) - 1, -(1 << 20), 0)
    refused(host, Code.VALUE, Command.RUN, run_asked(Mode.ALL, 1 << 12, 8, 8))


# --- MOVE, RUN, RESULTS --------------------------------------------------------------------------------


def test_move_in_range(host):
    for values in ((-65536, 65535, 0), (0, -65536, 65535), (65535, 0, -65536)):
        host.move(*values)
    for value in (65536, -65537, 2**31 - 1, -(2**31)):
        for place in range(3):
            values = [0, 0, 0]
            values[place] = value
            refused(host, Code.VALUE, Command.MOVE, struct.pack("<3i", *values))
    # The last good one is still in force.
    clear_scene(host)
    status = host.run(Mode.ALL)
    assert (status.x, status.y, status.z) == (65535, 0, -65536)


@pytest.mark.parametrize(
    ("command", "length"),
    [
        (Command.HELLO, 0),
        (Command.MOVE, 12),
        (Command.RUN, 9),
        (Command.RESULTS, 4),
        (Command.STATUS, 0),
        (Command.ABORT, 0),
    ],
)
def test_bad_lengths(host, command, length):
    for wrong in {0, 1, length - 1, length + 1, 100} - {length, -1}:
        refused(host, Code.LENGTH, command, bytes(wrong))


def test_run_needs_two_meshes_and_their_counts(host):
    assert refused(host, Code.EMPTY, Command.RUN, run_asked(Mode.ALL, 0, 0, 0)) == b""
    host.load(0, flat(0, 3))
    refused(host, Code.EMPTY, Command.RUN, run_asked(Mode.ALL, 0, 3, 0))
    refused(host, Code.COUNTS, Command.RUN, run_asked(Mode.ALL, 0, 3, 1))
    host.load(1, flat(5, 2))
    for counts in ((2, 2), (3, 3), (0, 0), (2, 3), (3 + 256, 2), (3, 2 + 256)):
        refused(host, Code.COUNTS, Command.RUN, run_asked(Mode.ALL, 0, *counts))
    assert host.good(Command.RUN, run_asked(Mode.ALL, 0, 3, 2)) == b"\x01"
    host.finish()
    host.hello()
    host.load(1, flat(5, 2))
    refused(host, Code.EMPTY, Command.RUN, run_asked(Mode.ALL, 0, 0, 2))


def test_run_of_bad_values(host):
    clear_scene(host)
    for mode in (3, 4, 255):
        refused(host, Code.VALUE, Command.RUN, run_asked(mode, 0, 1, 1))
    for margin in (1 << 16, 1 << 31):
        refused(host, Code.VALUE, Command.RUN, run_asked(Mode.ALL, margin, 1, 1))
    assert host.run(Mode.ALL, (1 << 16) - 1).near == 1


def test_a_run_that_goes_on_refuses_what_would_disturb_it(host):
    host.load_both(flat(0, DEPTH))
    # Stalled by a full ring, so it goes on as long as nobody takes near pairs.
    host.start(Mode.ALL)
    host.top.step(5000)
    refused(host, Code.BUSY, Command.LOAD, host.load_payload(0, 0, flat(9)))
    refused(host, Code.BUSY, Command.MOVE, struct.pack("<3i", 1, 1, 1))
    refused(host, Code.BUSY, Command.RUN, host.run_payload(Mode.ALL))
    status, near = host.all_results()
    assert (status.state, status.near, len(near)) == (State.DONE, DEPTH**2, DEPTH**2)


def test_results_of_pairs_that_are_not_there(host):
    refused(host, Code.VALUE, Command.RESULTS, struct.pack("<I", 1))
    host.load_both(flat(0, 10))
    host.run(Mode.ALL)
    refused(host, Code.VALUE, Command.RESULTS, struct.pack("<I", 101))
    host.results(50)
    refused(host, Code.VALUE, Command.RESULTS, struct.pack("<I", 49))
    assert host.status().waiting
    assert len(host.results(100)[1]) == 0
    assert not host.status().waiting


def test_run_numbers_wrap(host):
    clear_scene(host)
    payload = host.run_payload(Mode.COUNT)
    for number in range(1, 258):
        assert host.good(Command.RUN, payload) == bytes([number % 256])
        host.finish()


def test_pairs_come_as_loaded(host, rng):
    triangles = rng.integers(-(1 << 15), 1 << 15, (DEPTH, 3, 3))
    host.load(0, triangles)
    host.load(1, triangles[::-1])
    host.start(Mode.ALL)
    _, near = host.all_results()
    opposite = np.stack([np.arange(DEPTH), DEPTH - 1 - np.arange(DEPTH)], 1)
    assert set(map(tuple, opposite.tolist())) <= set(map(tuple, near.tolist()))
