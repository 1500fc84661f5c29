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

BIT = PARAMETERS.clocks_per_bit


def good_again(host: BoardHost, errors: int) -> None:
    """The next frame is answered, and so many errors were counted."""
    assert host.status().errors == errors


def test_hello_describes_the_board(host):
    is_ = PARAMETERS
    assert host.hello() == struct.pack(
        "<BBBHBBIH", 3, is_.width, is_.margin_bits, is_.depth, is_.group, is_.lanes, is_.build_id, 1
    )


@pytest.mark.parametrize("session", [1, 0xC0C0C0C0, 0xDBDBDBDB, 0xDCDDDBC0, 0xFFFFFFFF])
def test_bytes_of_the_framing_go_through(session):
    host = powered(session)
    assert host.ask(Command.STATUS).code == Code.OK


def test_nothing_is_answered_before_a_frame_has_come():
    host = BoardHost(SimulatedTop(PARAMETERS))
    # A frame's end, as after a reset in the middle of it.
    host.silent(on_line(host.frame(Command.HELLO))[5:])
    host.hello()
    good_again(host, 0)


def test_a_frame_may_begin_with_the_end_of_the_last(host):
    assert host.exchange(on_line(host.frame(Command.STATUS))[1:]).code == Code.OK
    host.sequence += 1
    good_again(host, 0)


def test_every_damaged_byte_is_seen(host, rng):
    frame = host.frame(Command.STATUS)
    for place in range(len(frame) + 4):
        body = bytearray(frame + struct.pack("<I", zlib.crc32(frame)))
        body[place] ^= 1 << rng.integers(8)
        host.silent(b"\xc0" + stuffed(bytes(body)) + b"\xc0")
        good_again(host, place + 1)
        frame = host.frame(Command.STATUS)


def test_too_short(host):
    # Ends with a good CRC, and yet is none.
    for errors, length in enumerate(range(9), 1):
        host.silent(on_line(bytes(range(length))))
        good_again(host, errors)


def test_the_longest_frame_is_taken_and_a_longer_one_is_not(host):
    body = host.frame(Command.STATUS, bytes(243))
    assert len(body) + 4 == 256
    assert host.exchange(on_line(body)).code == Code.LENGTH
    assert host.exchange(on_line(host.frame(0x55, bytes(243)))).code == Code.UNKNOWN
    good_again(host, 0)
    host.silent(on_line(host.frame(Command.STATUS, bytes(244))))
    good_again(host, 1)
    host.silent(on_line(host.frame(Command.STATUS, bytes(1000))))
    good_again(host, 2)


@pytest.mark.parametrize("wrong", [b"\xdb\x00", b"\xdb\xdb", b"\xdb\xc0"])
def test_bad_stuffing(host, wrong):
    line = on_line(host.frame(Command.STATUS))
    host.silent(line[:4] + wrong + (line[4:] if wrong[1] != 0xC0 else b""))
    good_again(host, 1)


def test_truncated_frame(host):
    line = on_line(host.frame(Command.ABORT))
    for cut in range(2, len(line) - 1):
        host.top.send(line[:cut])
        # The next frame's beginning ends it.
        assert host.exchange(on_line(host.frame(Command.STATUS))).code == Code.OK
        host.sequence += 1
        good_again(host, cut - 1)


def noise(host: BoardHost, clocks: int, times: int = 1) -> None:
    for _ in range(times):
        host.top.glitch(clocks)
        host.top.step(100)


def long_break(host: BoardHost) -> None:
    host.top.break_line(5000)
    assert host.replies(6000) == []


def unplugged(host: BoardHost) -> None:
    host.top.send(on_line(host.frame(Command.STATUS)))
    host.top.step(10 * BIT * 5)
    host.top.unplug()
    assert host.replies(5000) == []


@pytest.mark.parametrize(
    ("disturb", "errors"),
    [
        (lambda host: host.silent(b"\xc0" * 20), 0),
        (lambda host: noise(host, BIT // 2 - 1, 5), 0),
        # It reads as a byte of ones: a frame that is too short, once something ends it.
        (lambda host: noise(host, BIT), 1),
        (long_break, 1),
        (unplugged, 1),
    ],
    ids=[
        "empty frames",
        "noise shorter than half a bit",
        "noise of a bit",
        "long break",
        "unplugged in a frame",
    ],
)
def test_what_is_no_frame_is_counted_and_not_answered(host, disturb, errors):
    disturb(host)
    good_again(host, errors)


def test_break_in_the_middle_of_a_frame(host):
    host.top.send(on_line(host.frame(Command.STATUS)))
    host.top.step(10 * BIT * 6)
    host.top.break_line(30 * BIT)
    assert host.replies(20_000) == []
    # What follows the break is cut into other bytes than were sent: one error or more.
    assert host.status().errors >= 1


def test_a_frame_during_a_reply_waits_and_a_third_is_an_error(host):
    next_ = host.sequence + 1
    host.top.send(b"".join(on_line(host.frame(Command.STATUS, sequence=next_ + i)) for i in range(3)))
    assert [reply.sequence for reply in host.replies(20_000)] == [next_, next_ + 1]
    host.sequence = next_ + 1
    good_again(host, 1)


def test_no_flood_of_frames_stops_the_board(host, rng):
    clear_scene(host)
    clear_run(host)
    frames = [
        on_line(host.frame(Command.STATUS, sequence=int(number))) for number in rng.integers(0, 2**32, 200)
    ]
    host.top.send(b"".join(frames))
    assert host.replies(150_000)
    assert not says_go(host.top)
    host.hello()
    clear_scene(host)
    clear_run(host)


def test_random_bytes_never_stop_the_board(host, rng):
    clear_scene(host)
    clear_run(host)
    for _ in range(20):
        # Rich in what means something to the framing.
        noise = rng.choice([0xC0, 0xDB, 0xDC, 0xDD, *rng.integers(0, 256, 8)], 100).astype("u1").tobytes()
        host.silent(noise + b"\xc0")
    assert not says_go(host.top)
    clear_run(host)


def test_the_line_to_the_host_is_well_formed(host):
    host.status()
    assert host.top.framing_errors == 0


def test_reset_in_the_middle_of_frames(host):
    clear_scene(host)
    clear_run(host)
    host.top.send(on_line(host.frame(Command.STATUS)))
    host.top.step(150)
    host.top.reset()
    host.top.unplug()
    host.top.receive()
    assert not says_go(host.top)
    again = BoardHost(host.top)
    again.hello()
    assert again.status().run == 0
