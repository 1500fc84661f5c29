"""What comes over the board's line: whole frames are answered, anything else is counted and not."""

import struct
import zlib

import pytest

from triaxis.sim.simulated_board import SimulatedTop
from triaxis.verif.board.tests.board_host import (
    PARAMETERS,
    BoardHost,
    Code,
    Command,
    clear_run,
    clear_scene,
    on_line,
    powered,
    says_go,
    stuffed,
)

pytestmark = pytest.mark.simulator


def test_hello_describes_the_board(host):
    is_ = PARAMETERS
    assert host.hello() == struct.pack(
        "<BBBHBBIH", 3, is_.width, is_.margin_bits, is_.depth, is_.group, is_.lanes, is_.build_id, 1
    )


@pytest.mark.parametrize("session", [1, 0xC0C0C0C0, 0xDBDBDBDB, 0xDCDDDBC0, 0xFFFFFFFF])
def test_bytes_of_the_framing_go_through(session):
    host = powered(session)
    assert host.ask(Command.STATUS).code == Code.OK
    assert host.top.framing_errors == 0


def test_nothing_is_answered_before_a_frame_has_come():
    host = BoardHost(SimulatedTop(PARAMETERS))
    # A frame's end, as after a reset in the middle of it.
    host.silent(on_line(host.frame(Command.HELLO))[5:])
    host.hello()
    assert host.status().errors == 0
    # A frame may begin with the end of the last.
    assert host.exchange(on_line(host.frame(Command.STATUS))[1:]).code == Code.OK
    host.sequence += 1
    assert host.status().errors == 0


def test_every_damaged_byte_is_seen(host, rng):
    frame = host.frame(Command.STATUS)
    for place in range(len(frame) + 4):
        body = bytearray(frame + struct.pack("<I", zlib.crc32(frame)))
        body[place] ^= 1 << rng.integers(8)
        host.silent(b"\xc0" + stuffed(bytes(body)) + b"\xc0")
        assert host.status().errors == place + 1
        frame = host.frame(Command.STATUS)


def test_too_short_and_too_long(host):
    # Ends with a good CRC, and yet is none.
    for errors, length in enumerate(range(9), 1):
        host.silent(on_line(bytes(range(length))))
        assert host.status().errors == errors
    body = host.frame(Command.STATUS, bytes(243))
    assert len(body) + 4 == 256
    assert host.exchange(on_line(body)).code == Code.LENGTH
    assert host.exchange(on_line(host.frame(0x55, bytes(243)))).code == Code.UNKNOWN
    assert host.status().errors == 9
    for errors, length in ((10, 244), (11, 1000)):
        host.silent(on_line(host.frame(Command.STATUS, bytes(length))))
        assert host.status().errors == errors


def test_truncated_frame(host):
    line = on_line(host.frame(Command.ABORT))
    for cut in range(2, len(line) - 1):
        host.top.send(line[:cut])
        # The next frame's beginning ends it.
        assert host.exchange(on_line(host.frame(Command.STATUS))).code == Code.OK
        host.sequence += 1
        assert host.status().errors == cut - 1


@pytest.mark.parametrize("unplugged", [True, False])
def test_a_frame_that_is_cut_off_is_counted_once_something_ends_it(host, unplugged):
    host.top.send(on_line(host.frame(Command.STATUS)))
    host.top.step(10 * PARAMETERS.clocks_per_bit * 5)
    if unplugged:
        host.top.unplug()
    else:
        host.top.break_line(30 * PARAMETERS.clocks_per_bit)
    assert host.replies(20_000) == []
    assert host.status().errors >= 1


def test_a_frame_during_a_reply_waits_and_a_third_is_an_error(host):
    next_ = host.sequence + 1
    host.top.send(b"".join(on_line(host.frame(Command.STATUS, sequence=next_ + i)) for i in range(3)))
    assert [reply.sequence for reply in host.replies(20_000)] == [next_, next_ + 1]
    host.sequence = next_ + 1
    assert host.status().errors == 1


def test_no_flood_and_no_random_bytes_stop_the_board(host, rng):
    clear_scene(host)
    clear_run(host)
    numbers = rng.integers(0, 2**32, 200).tolist()
    host.top.send(b"".join(on_line(host.frame(Command.STATUS, sequence=number)) for number in numbers))
    assert host.replies(150_000)
    assert not says_go(host.top)
    host.hello()
    clear_scene(host)
    clear_run(host)
    for _ in range(20):
        # Rich in what means something to the framing.
        noise = rng.choice([0xC0, 0xDB, 0xDC, 0xDD, *rng.integers(0, 256, 8)], 100).astype("u1").tobytes()
        host.silent(noise + b"\xc0")
    assert not says_go(host.top)
    clear_run(host)
