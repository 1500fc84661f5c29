"""Holds the board's replies against what is due."""

import struct
from collections.abc import Callable

import numpy as np

from triaxis.verif.board.board_state import ALL_ZONES, Due, Run
from triaxis.verif.board.protocol import (
    MOST_NEAR,
    REPLY,
    Command,
    Flag,
    Integers,
    Mode,
    Reply,
    State,
    Status,
)
from triaxis.verif.board.protocol import End as RunEnd
from triaxis.verif.mesh.expectation import walked

# Counters of the engine that the status block calls otherwise.
_NAMED = {"group_pairs_skipped": "groups_skipped", "group_pairs_opened": "groups_opened"}


class ReplyCheck:
    """Tells ``wrong`` of each difference, ``happened`` of what is covered.

    ``checked``: replies that were compared; ``near``: near pairs that the last status told.
    """

    def __init__(self, wrong: Callable[[str], None], happened: Callable[[str, str], None]) -> None:
        """Begin with nothing compared."""
        self._tell, self._happened = wrong, happened
        self.checked = self.near = 0

    def compare(self, due: Due, reply: Reply, run: Run) -> None:
        """Compare a reply with what is due; ``run``: the last one, whose end a status may tell."""
        frame = due.frame
        head = (frame.command | REPLY, frame.sequence, frame.session, due.code)
        found = (reply.command, reply.sequence, reply.session, reply.code)
        if found != head:
            self._tell(f"a reply begins {found}, {head} is due")
            return
        if due.status is None:
            if reply.payload != due.payload or len(reply.pairs):
                self._tell(
                    f"a reply to {frame.command} says {reply.payload.hex()}, {due.payload.hex()} is due"
                )
        else:
            self._status(due, reply, run)
        self.checked += 1

    def _status(self, due: Due, reply: Reply, run: Run) -> None:
        assert due.status is not None
        rest = 5 if due.frame.command == Command.RESULTS else 0
        if len(reply.payload) != Status.SIZE + rest:
            self._tell(f"a status of {len(reply.payload)} bytes")
            return
        status = Status.unpack(reply.payload)
        expected = due.status
        if due.doubtful and status.flags >> Flag.FAULT & 1:
            expected = faulty(expected)
        if run.state == State.DONE and expected.state == State.DONE and not _ended_as(run, status):
            expected = expected._replace(end=RunEnd.ABORTED)
            if due.frame.command == Command.ABORT:
                self._happened("board_runs", f"{Mode(run.mode).name}, aborted")
            run.maybe_aborted = True
        stopped = run.end == RunEnd.FIRST and expected.end in (RunEnd.FIRST, RunEnd.FAULT)
        if run.maybe_aborted and status.state == State.DONE:
            expected = _some_zones(run, expected, status)
        if run.maybe_aborted or stopped:
            expected = _so_far(run, expected, status, stopped and not run.maybe_aborted)
        if status.state == State.DONE:
            self.near = status.near
        if status != expected:
            self._tell(f"{status}, {expected} is due")
        if rest:
            self._pairs(due, reply, run)

    def _pairs(self, due: Due, reply: Reply, run: Run) -> None:
        first, number = struct.unpack_from("<IB", reply.payload, Status.SIZE)
        if (first, number) != (due.first_pair, len(reply.pairs)) or number > MOST_NEAR:
            self._tell(f"near pairs from {first}, {number} of them, {len(reply.pairs)} were sent")
            return
        seen = first + number
        if seen > run.offered or not _taken(run, first, reply.pairs):
            self._tell(f"near pairs from {first} are not those of the scene: {reply.pairs.tolist()}")
        certain = due.status is not None and due.status.state == State.DONE and not run.maybe_aborted
        if number != (min(MOST_NEAR, run.offered - first) if certain and not run.overflow else number):
            self._tell(f"{number} near pairs from {first} of {run.offered}")
        run.written = max(run.written, seen)
        how_many = "32" if number == MOST_NEAR else "some" if number else "none"
        self._happened("board_near", f"{how_many}, {'run' if due.busy else 'ended'}")


def faulty(status: Status) -> Status:
    """Return a status as it is where a check has failed."""
    end = status.end if status.end == RunEnd.NONE else RunEnd.FAULT
    return status._replace(flags=status.flags | 1 << Flag.FAULT, end=end)


def _so_far(run: Run, expected: Status, status: Status, stopped: bool) -> Status:
    """Return what is expected of a run that ended early: how far it came only what it has tested tells.

    ``stopped``: by itself, at its first near pair.
    """
    answer, tested = run.answer, status.tested
    if answer is None or tested > answer.tested:
        return expected
    near = answer.near[tuple(answer.to_be_tested.T)]
    least = walked(answer, tested)
    most = {name: getattr(answer, name) for name in least}
    found = int(near[:tested].sum())
    # With zones the verdicts are not in the order of the scan.
    least |= {"tested": 0, "near": 0 if run.wider else found}
    most |= {"tested": tested, "near": min(tested, run.near) if run.wider else found}
    if stopped:
        least["tested"], least["near"] = 1 if run.wider else int(np.argmax(near)) + 1, 1
        most["tested"], most["near"] = tested if run.wider else least["tested"], 1
    for name, low in least.items():
        told = getattr(status, _NAMED.get(name, name))
        counted = told if low <= told <= most[name] else low
        expected = expected._replace(**{_NAMED.get(name, name): counted})
    return expected


def _some_zones(run: Run, expected: Status, status: Status) -> Status:
    """Return what is expected of a run that was cut off: in some of the zones something was found by then."""
    told = status.flags >> Flag.SLOW & ALL_ZONES
    least = ALL_ZONES if status.near else run.zones & ~run.wider
    # What is in a zone is in all around it.
    if told & run.wider & 1:
        least = ALL_ZONES
    if least & ~told or told & ~run.zones:
        return expected
    return expected._replace(flags=expected.flags & ~(ALL_ZONES << Flag.SLOW) | told << Flag.SLOW)


def _taken(run: Run, first: int, pairs: Integers) -> bool:
    """Return whether near pairs are those of the scene, as before where they were read; and note them.

    Without zones they come in the order of the scan.
    """
    if not run.wider:
        return not (pairs != run.pairs[first : first + len(pairs)]).any()
    for number, pair in enumerate(map(tuple, pairs.tolist()), first):
        if run.taken.setdefault(number, pair) != pair:
            return False
    return set(run.taken.values()) <= set(map(tuple, run.pairs.tolist())) and len(
        set(run.taken.values())
    ) == len(run.taken)


def _ended_as(run: Run, status: Status) -> bool:
    """Return whether a run ended by itself; only an abort that came in time ends it else."""
    if run.maybe_aborted and (status.end == RunEnd.ABORTED or (run.cut_off and status.end != RunEnd.FAULT)):
        return False
    if run.maybe_aborted and status.end == run.end:
        run.maybe_aborted = False
    return True
