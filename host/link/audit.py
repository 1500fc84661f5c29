"""Whether what the board says can be, and whether it is enough for a verdict.

What it may never say, whatever it was asked, are fields of a reply against each other. A run must be the one
that was asked for, and complete: one that left pairs out cannot pass for clear.
"""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from triaxis.golden.errors import InputError
from triaxis.host.group_pairs import group_pair_sizes, have_pairs, most_pairs
from triaxis.host.link.exchange import LinkError
from triaxis.host.link.messages import (
    ZONES,
    Description,
    Flag,
    Mode,
    Results,
    RunEnd,
    RunRequest,
    State,
    Status,
)  # fmt: skip
from triaxis.sim.board_parameters import BoardParameters

_FLAGS = int(Flag.GO | Flag.NEAR_WAITING | Flag.WATCHDOG_EXPIRED | Flag.FAULT | ZONES)
# At which the board's count of errors stays.
_MOST_ERRORS = 4095
# Ends of which the engine counts every pair that it was given; of runs that it refused.
_WHOLE = (RunEnd.COMPLETE, RunEnd.FIRST)
_REFUSED = (RunEnd.OVERFLOW, RunEnd.OVERFULL, RunEnd.BAD_MODE)


def contradiction(what: str) -> LinkError:
    """Return the error of an answer that cannot be."""
    return LinkError(f"the board's answer contradicts itself or us: {what}; verdict unknown")


class FaultError(LinkError):
    """A check of the board's own has failed: nothing counts that it said."""

    def __init__(self) -> None:
        """Say what to do."""
        super().__init__(
            "the board has found a fault in itself: run the command again, which begins with HELLO and loads "
            "anew; where it comes again, load the bitstream again; verdict unknown"
        )


def must_be(what: str, found: object, wanted: object) -> None:
    """Raise LinkError where the board says something else than it must."""
    if found != wanted:
        raise contradiction(f"{what}: {found}, must be {wanted}")


def check_description(board: Description) -> None:
    """Raise LinkError where no board can be so: the limits are those that the RTL elaborates with."""
    try:
        BoardParameters(board.width, board.margin_bits, board.depth, board.group, board.lanes)
    except InputError as error:
        raise contradiction(str(error)) from error
    if board.watchdog_ms == 0:
        raise contradiction("no watchdog")
    if board.certifies > 1:
        raise contradiction(f"certifies {board.certifies}, must be 0 or 1")


def check_status(status: Status, group: int, holds: bool = False) -> None:
    """Raise LinkError where the fields of a status contradict each other.

    ``group``: triangles of one; ``holds``: go may be said while the run goes on.
    """
    for what, value, known in (("state", status.state, State), ("end", status.end, RunEnd),
                               ("mode", status.mode, Mode)):  # fmt: skip
        if value not in set(known):
            raise contradiction(f"{what} {value}")
    if status.flags & ~_FLAGS:
        raise contradiction(f"flags {status.flags:#04x}")
    if status.errors > _MOST_ERRORS:
        raise contradiction(f"{status.errors} errors, at most {_MOST_ERRORS} are counted")
    if status.state != State.DONE:
        _check_unfinished(status)
    elif status.end == RunEnd.NONE:
        raise contradiction("a run that is done and has no end")
    elif (status.end == RunEnd.FAULT) != bool(status.flags & Flag.FAULT):
        raise contradiction(f"end {RunEnd(status.end).name}, flags {status.flags:#04x}")
    elif status.end in _WHOLE:
        _check_counters(status, group)
    if status.flags & Flag.GO:
        _check_go(status, holds)


def _check_unfinished(status: Status) -> None:
    counters = ("cycles", "groups_skipped", "groups_opened", "pairs_skipped", "tested", "near")
    none = replace(status, end=RunEnd.NONE, **dict.fromkeys(counters, 0))
    if status.state == State.IDLE:
        none = replace(none, run=0, mode=0, x=0, y=0, z=0, margin=0)
    empty = status.state == State.IDLE or status.mode == Mode.COUNT
    if status != none or status.flags & (ZONES | (Flag.NEAR_WAITING if empty else 0)):
        raise contradiction(f"numbers of a run in state {State(status.state).name}")


def _check_go(status: Status, holds: bool) -> None:
    if holds and status.state == State.RUNNING:
        # Of the runs before: this one may have found what ends it.
        if status.flags & ~Flag.NEAR_WAITING != Flag.GO:
            raise contradiction("go, although the watchdog has run out, or a check has failed")
        return
    if (status.state, status.end, status.near) != (State.DONE, RunEnd.COMPLETE, 0):
        raise contradiction("go, and no complete run that found nothing near")
    if status.flags & ~ZONES != Flag.GO:
        raise contradiction("go, although near pairs wait, the watchdog has run out, or a check has failed")


def _check_counters(status: Status, group: int) -> None:
    """Every pair was in a skipped group pair, skipped by its boxes, or tested; or the run stopped at one."""
    if status.near > status.tested:
        raise contradiction(f"{status.near} near pairs of {status.tested} tested")
    if status.near and status.flags & ZONES != ZONES:
        raise contradiction(f"flags {status.flags:#04x}, {status.near} near pairs")
    # The core takes at most a pair a clock.
    if status.tested >= status.cycles:
        raise contradiction(f"{status.tested} pairs tested in {status.cycles} clocks")
    if status.flags & Flag.NEAR_WAITING and (status.mode == Mode.COUNT or not status.near):
        raise contradiction("near pairs wait of a run that only counts them, or found none")
    if status.mode == Mode.FIRST or status.end == RunEnd.FIRST:
        must_be("mode of a run that stopped", status.mode, Mode.FIRST)
        must_be("near pairs of a run that stops at the first", status.near, int(status.end == RunEnd.FIRST))
    sizes = group_pair_sizes(status.count_a, status.count_b, group)
    group_pairs = sum(count for _, count in sizes)
    seen, opened = status.groups_skipped + status.groups_opened, status.pairs_skipped + status.tested
    if status.end == RunEnd.FIRST:
        if seen > group_pairs or opened > most_pairs(status.groups_opened, sizes):
            raise contradiction(f"{seen} group pairs of {group_pairs}, {opened} pairs skipped or tested")
        return
    must_be("group pairs", seen, group_pairs)
    if not have_pairs(status.groups_opened, opened, sizes):
        raise contradiction(
            f"{opened} pairs skipped or tested: no {status.groups_opened} of these group pairs have so many"
        )


def check_results(results: Results, group: int, holds: bool = False) -> None:
    """Raise LinkError where the status of an answer to RESULTS contradicts itself or its near pairs."""
    check_status(results.status, group, holds)
    # What has been taken is freed, so that what waits is here.
    must_be("near pairs wait", bool(results.status.flags & Flag.NEAR_WAITING), len(results.near) > 0)


def check_later(before: Status, now: Status) -> None:
    """Raise LinkError where a status is not that of a finished run again: but for what may happen since."""
    if now.flags & Flag.FAULT:
        raise FaultError
    if replace(now, flags=before.flags, errors=before.errors) != before:
        raise contradiction("the status of another run")
    # An error ends go, which does not come back without a run.
    if now.errors < before.errors or (now.errors > before.errors and now.flags & Flag.GO):
        raise contradiction(f"{now.errors} errors after {before.errors}, flags {now.flags:#04x}")
    begun, ended = now.flags & ~before.flags, before.flags & ~now.flags
    if begun not in (0, Flag.WATCHDOG_EXPIRED) or ended & (Flag.WATCHDOG_EXPIRED | ZONES):
        raise contradiction(f"flags {now.flags:#04x} after {before.flags:#04x}")


_MEANING = {
    RunEnd.ABORTED: "the run was aborted",
    RunEnd.OVERFLOW: "A leaves the board's coordinates when moved: move less, or use a coarser resolution",
    RunEnd.OVERFULL: "a mesh has more triangles than the board holds",
    RunEnd.BAD_MODE: "the board does not know the mode",
}


@dataclass(frozen=True)
class BoardRun:
    """What was asked for, and what came back. ``near``: (i in A, j in B) as loaded, shape (K, 2)."""

    request: RunRequest
    number: int
    status: Status
    near: npt.NDArray[np.int64]


def audit(run: BoardRun) -> None:
    """Raise LinkError where a run, whose status does not contradict itself, is not what was asked for."""
    status, request = run.status, run.request
    if status.flags & Flag.FAULT or status.end == RunEnd.FAULT:
        raise FaultError
    must_be("state", status.state, State.DONE)
    must_be("run number", status.run, run.number)
    must_be("mode", status.mode, request.mode)
    must_be("pose", (status.x, status.y, status.z), (request.x, request.y, request.z))
    must_be("margin", status.margin, request.margin)
    must_be("triangles", (status.count_a, status.count_b), (request.count_a, request.count_b))
    _check_zones(status, request)
    if status.end in _MEANING:
        raise LinkError(f"{_MEANING[RunEnd(status.end)]}; verdict unknown")
    must_be("near pairs received", len(run.near), 0 if request.mode == Mode.COUNT else status.near)
    if (run.near >= (request.count_a, request.count_b)).any():
        raise contradiction("a near pair of triangles that were not loaded")
    if len(np.unique(run.near, axis=0)) != len(run.near):
        raise contradiction("a near pair twice")


def _check_zones(status: Status, request: RunRequest) -> None:
    """Nothing is said of a zone that is not asked about; what is in the inner one is in the outer, too.

    A run that was cut off may have found what it had not counted yet.
    """
    asked = request.asked
    found, others = status.flags & asked, ZONES & ~asked
    uncounted = status.end in _REFUSED or (status.end in _WHOLE and not status.tested)
    alone = found & Flag.SLOW and not status.flags & Flag.WARN
    if status.flags & others != others or alone or (found and uncounted):
        widths = f"{request.margin}, {request.slow}, {request.warn}"
        raise contradiction(
            f"flags {status.flags:#04x} of zones within {widths} steps, {status.tested} tested, "
            f"{RunEnd(status.end).name}"
        )
