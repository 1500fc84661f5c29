"""Frames and layouts: what goes in comes out, and nothing else does."""

import struct

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from triaxis.host.link.messages import (
    LoadHead,
    RequestHead,
    RunRequest,
    Status,
    once,
    pack_triangles,
    triangles_per_load,
    twice,
)
from triaxis.host.link.wire import END, ESC, LONGEST, Deframer, LayoutError, decode, encode

# Bytes that matter to the framing, more often than by chance.
special = st.sampled_from([END, ESC, 0xDC, 0xDD, 0x00, 0xFF])
bodies = st.lists(special | st.integers(0, 255), max_size=LONGEST - 4).map(bytes)
streams = st.binary(max_size=600)


def test_the_wire_byte_by_byte():
    # The check value of CRC-32 as its catalogues give it, CBF43926 for these digits.
    assert encode(b"123456789") == b"\xc0123456789\x26\x39\xf4\xcb\xc0"
    assert encode(bytes([END, 0x01, ESC]))[:6] == b"\xc0\xdb\xdc\x01\xdb\xdd"
    numbers = (1, 2, 3, 4, 5, -6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18)
    words = struct.pack("<5B3i7I3H", *numbers)
    assert Status(*numbers).pack() == words and Status.unpack(words) == Status(*numbers)
    with pytest.raises(LayoutError):
        Status.unpack(words + b"\0")
    run = RunRequest(1, 2, 3, 4, 5, 6, 7, 8, -9, 10, 11)
    assert run.pack() == struct.pack("<B3I2HB3iH", 1, 2, 3, 4, 5, 6, 7, 8, -9, 10, 11)
    assert RunRequest.size() == 32


@given(streams, st.lists(bodies, max_size=5), st.lists(st.integers(1, 50), min_size=1, max_size=50))
def test_frames_come_back_after_garbage_and_however_they_are_cut(garbage, sent, cuts):
    frames = [encode(body) for body in sent]
    assert all(frame[0] == frame[-1] == END and END not in frame[1:-1] for frame in frames)
    assert len(set(frames)) == len(set(sent))
    wire = garbage + b"".join(frames)
    deframer, received = Deframer(), []
    while wire:
        cut = cuts[len(wire) % len(cuts)]
        received += deframer.feed(wire[:cut])
        wire = wire[cut:]
    assert received[len(received) - len(sent) :] == sent


@given(bodies, st.integers(0, 10**6), st.integers(1, 255))
@example(b"\0" * 8, 3, 0xC0)
def test_a_damaged_frame_is_none(body, place, change):
    frame = bytearray(encode(body))
    assert Deframer().feed(bytes(frame[: place % (len(frame) - 1)]) + bytes([END])) == []
    frame[place % len(frame)] ^= change
    # Whatever the damage does, no other body comes of it; the outer ENDs may go without harm.
    assert Deframer().feed(bytes(frame)) in ([], [body])
    if 0 < place % len(frame) < len(frame) - 1:
        assert all(decode(part) is None for part in bytes(frame[1:-1]).split(bytes([END])))


def test_lengths_are_bounded():
    longest = bytes(LONGEST - 4)
    assert Deframer().feed(encode(longest)) == [longest]
    with pytest.raises(ValueError, match="frame of 257 bytes: at most 256"):
        encode(longest + b"\0")
    # Noise without END fills no memory.
    deframer = Deframer()
    for _ in range(100):
        assert deframer.feed(b"\x55" * 1000) == []
    assert len(deframer._partial) < 1000 and deframer.feed(encode(b"x")) == [b"x"]
    for width, count in ((8, 12), (16, 12), (24, 8), (32, 6)):
        assert triangles_per_load(width) == count
        body = RequestHead(2, 0, 1).pack() + LoadHead(0, 0, count).pack() + bytes(count * 9 * -(-width // 8))
        assert decode(encode(body)[1:-1]) == body


@given(st.binary(min_size=1, max_size=60), st.integers(0, 10**6), st.integers(1, 255))
def test_a_record_comes_twice_or_not_at_all(record, place, change):
    payload = bytearray(twice(record))
    assert once(bytes(payload)) == record
    assert all(one ^ other == 0xFF for one, other in zip(record, payload[len(record) :], strict=True))
    with pytest.raises(LayoutError, match="a payload and its inverted copy differ"):
        once(bytes(payload) + b"\0")
    payload[place % len(payload)] ^= change
    with pytest.raises(LayoutError, match="differ"):
        once(bytes(payload))


@given(st.integers(8, 32), st.data())
def test_triangles_come_back_at_every_width(width, data):
    low, high = -(1 << (width - 1)), (1 << (width - 1)) - 1
    coordinate = st.integers(low, high) | st.sampled_from([low, high, -1, 0])
    numbers = data.draw(st.lists(coordinate, min_size=9, max_size=9))
    packed = pack_triangles(np.array(numbers * 2, np.int64).reshape(-1, 3, 3), width)
    size = -(-width // 8)
    cut = [packed[k : k + size] for k in range(0, len(packed), size)]
    assert [int.from_bytes(word, "little", signed=True) for word in cut] == numbers * 2
