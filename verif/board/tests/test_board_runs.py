"""Runs on the board: every mode, stalls, aborts, against the golden model."""

import numpy as np
import pytest

from triaxis.golden.bulk import bulk_verdicts
from triaxis.verif.board.tests.board_host import (
    BUSY_LED,
    PARAMETERS,
    RING_FULL_LED,
    BoardHost,
    Command,
    End,
    Mode,
    State,
    clear_run,
    clear_scene,
    flat,
    long_clear_scene,
    on_line,
    run_asked,
    says_go,
    start_at_once,
    status_of,
)

pytestmark = pytest.mark.simulator

DEPTH = PARAMETERS.depth
RING = 1024


def scene(rng, count_a, count_b):
    """Return two meshes of small triangles that cross here and there."""
    centres = rng.integers(-400, 400, (count_a + count_b, 1, 3))
    triangles = centres + rng.integers(-150, 150, (count_a + count_b, 3, 3))
    return triangles[:count_a], triangles[count_a:]


def golden_near(a, b, move, margin):
    """Return the near pairs (K, 2) of all pairs."""
    i, j = np.meshgrid(np.arange(len(a)), np.arange(len(b)), indexing="ij")
    pairs = np.stack([(a + move)[i.reshape(-1)], b[j.reshape(-1)]], 1)
    near = bulk_verdicts(pairs, margin)["near"].astype(bool)
    return np.stack([i.reshape(-1), j.reshape(-1)], 1)[near]


def as_set(near):
    return set(map(tuple, near.tolist()))


def accounted(status):
    """Every pair of groups is there; where all were opened, every pair is."""
    group = PARAMETERS.group
    groups = -(-status.count_a // group) * -(-status.count_b // group)
    assert status.groups_skipped + status.groups_opened == groups
    if status.groups_skipped == 0:
        assert status.pairs_skipped + status.tested == status.count_a * status.count_b


@pytest.mark.parametrize(("count_a", "count_b", "margin"), [(1, 1, 0), (9, 64, 40), (40, 33, 0), (64, 64, 7)])
def test_every_mode_against_the_golden_model(host, rng, count_a, count_b, margin):
    a, b = scene(rng, count_a, count_b)
    host.load(0, a)
    host.load(1, b)
    for move in ([0, 0, 0], [-90, 35, 3]):
        host.move(*move)
        expected = golden_near(a, b, move, margin)

        host.start(Mode.ALL, margin)
        status, near = host.all_results()
        assert as_set(near) == as_set(expected)
        assert len(near) == len(expected) == status.near
        assert (status.end, [status.x, status.y, status.z], status.margin) == (End.COMPLETE, move, margin)
        accounted(status)

        status = host.run(Mode.COUNT, margin)
        assert (status.end, status.near, status.waiting) == (End.COMPLETE, len(expected), False)
        accounted(status)

        status = host.run(Mode.FIRST, margin)
        assert status.end == (End.STOPPED if len(expected) else End.COMPLETE)
        _, near = host.all_results()
        assert len(near) == min(1, len(expected))
        assert as_set(near) <= as_set(expected)


def test_a_ring_that_is_just_full_does_not_stall_and_can_be_left(host):
    host.load_both(flat(0, 32))
    status = host.run(Mode.ALL)
    assert (status.near, status.end) == (RING, End.COMPLETE)
    assert host.top.leds & RING_FULL_LED
    assert len(as_set(host.all_results()[1])) == RING
    # Nothing of a run that was not asked for its pairs is left to the next.
    assert host.run(Mode.ALL).near == RING
    assert host.run(Mode.FIRST).near == 1
    status, near = host.all_results()
    assert (status.near, near.tolist()) == (1, [[0, 0]])
    host.move(0, 0, 9)
    status = host.run(Mode.ALL)
    assert (status.near, status.waiting) == (0, False)


def start_long(host: BoardHost) -> None:
    """Begin a run of thousands of clocks, its reply still to come."""
    long_clear_scene(host)
    host.move(1, -2, 0)
    start_at_once(host, Mode.COUNT)


def stalled(host: BoardHost) -> None:
    """Begin a run that waits for its near pairs to be taken."""
    host.load_both(flat(0, DEPTH))
    host.start(Mode.ALL)
    host.top.step(20_000)
    assert host.top.leds & RING_FULL_LED and host.top.leds & BUSY_LED


def aborted(host: BoardHost) -> None:
    host.top.send(on_line(host.frame(Command.ABORT)))
    run, abort = host.replies(20_000, 2)
    host.sequence += 1
    status = status_of(abort.payload)
    assert run.payload == bytes([status.run])
    assert (status.state, status.end, status.go) == (State.DONE, End.ABORTED, False)
    assert 0 < status.cycles < DEPTH**2


def aborted_when_stalled(host: BoardHost) -> None:
    status = status_of(host.good(Command.ABORT))
    assert (status.state, status.end, status.waiting) == (State.DONE, End.ABORTED, True)
    assert status.near >= RING
    # What was in the ring can still be read: the first of the run.
    status, near = host.all_results()
    assert len(as_set(near)) == len(near) == RING


def greeted(host: BoardHost) -> None:
    host.replies(5_000, 1)
    host.hello()
    status = host.status()
    assert (status.state, status.run, status.end, status.waiting) == (State.NEVER, 0, 0, False)
    assert (status.mode, status.cycles, status.count_a, status.count_b) == (0, 0, 0, 0)
    assert (status.x, status.y, status.z, status.margin) == (0, 0, 0, 0)


def reset(host: BoardHost) -> None:
    host.top.reset()
    assert not host.top.leds & BUSY_LED
    host.top.receive()
    host.sequence = 0
    host.hello()


@pytest.mark.parametrize(
    ("begin", "end"),
    [(start_long, aborted), (stalled, aborted_when_stalled), (start_long, greeted), (stalled, greeted),
     (start_long, reset)],
)  # fmt: skip
def test_a_run_that_is_ended_leaves_nothing_behind(host, begin, end):
    begin(host)
    end(host)
    assert not says_go(host.top)
    clear_scene(host)
    clear_run(host)


def test_abort_at_any_time_of_a_short_run(host):
    clear_scene(host)
    for wait in range(80):
        abort = on_line(host.frame(Command.ABORT, sequence=host.sequence + 3))
        payload = host.run_payload(Mode.ALL)
        # The last bit of the abort comes so many clocks after the run has begun.
        frame = on_line(host.frame(Command.RUN, payload))
        host.top.send(frame[:-1])
        host.top.step(40 * len(frame) + 100)
        host.top.send(frame[-1:] + abort)
        host.top.step(wait)
        run, aborted = host.replies(20_000, 2)
        host.sequence += 2
        assert run.code == 0
        status = status_of(aborted.payload)
        assert status.state == State.DONE
        assert status.end in (End.ABORTED, End.COMPLETE)
        assert not says_go(host.top)


def test_abort_without_a_run(host):
    assert status_of(host.good(Command.ABORT)).state == State.NEVER
    clear_scene(host)
    before = host.run(Mode.ALL)
    status = status_of(host.good(Command.ABORT))
    assert (status.state, status.end, status.cycles) == (State.DONE, End.COMPLETE, before.cycles)


def test_a_full_ring_stalls_and_loses_nothing(host):
    stalled(host)
    status = host.status()
    assert (status.state, status.end, status.near, status.waiting) == (State.RUNNING, 0, 0, True)
    # While the run goes on, what was read can be read again.
    status, near = host.results(0)
    assert (status.state, status.mode, len(near)) == (State.RUNNING, Mode.ALL, 32)
    assert (host.results(0)[1] == near).all()
    assert (host.results(7)[1][:25] == near[7:]).all()
    found = near[:7].tolist()
    while not found or len(near):
        status, near = host.results(len(found))
        found += near.tolist()
    assert (status.end, status.near) == (End.COMPLETE, DEPTH**2)
    assert len(set(map(tuple, found))) == len(found) == DEPTH**2
    assert not host.top.leds & RING_FULL_LED


def test_display_and_leds(host):
    host.top.step(1000)
    assert host.top.digits == "StoP0000"
    clear_scene(host)
    clear_run(host)
    host.top.step(1000)
    assert host.top.digits == "  Go0000"
    assert host.top.leds & 0xFF == 0b1001
    host.load(0, flat(0, 64))
    host.load(1, flat(0, 60))
    host.start(Mode.COUNT)
    host.top.step(1000)
    assert host.top.digits == " run0000"
    assert host.top.leds & 0xFF == 0b1110
    host.finish()
    host.top.step(1000)
    assert host.top.digits == "StoP3840"
    assert host.ask(Command.RUN, run_asked(Mode.ALL, 0, 1, 1)).code != 0
    host.top.step(1000)
    assert host.top.digits == " Err3840"
    assert host.top.leds >> 8 == 0
    host.silent(b"\xc0\x55\xc0")
    assert host.top.leds >> 8 == 1
    host.top.step(PARAMETERS.watchdog_clocks)
    assert not host.top.leds & 1 << 3
    assert host.top.leds & 1 << 6
