"""The kinds of upsets, and what came of one: what the pins and a host say, against what is true."""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum, StrEnum
from pathlib import Path

import numpy as np
import numpy.typing as npt

from triaxis.host.link.audit import BoardRun, audit, check_status
from triaxis.host.link.exchange import LinkError
from triaxis.host.link.messages import Pose, RunNumber, RunRequest, Status
from triaxis.sim.simulated_board import PINS, TX
from triaxis.verif.board.protocol import Code, Reply
from triaxis.verif.board.protocol import Status as StatusBlock

Events = npt.NDArray[np.void]
_END = 0xC0
# Bits of the pins: go, and the LED of a run that goes on.
GO, BUSY = 1, 1 << 4
# Go may end so many clocks later than without an upset: a hundredth of the time in which a machine must stop.
LATE = 1000


class Kind(IntEnum):
    """What an upset does: inverts a bit, holds it inverted from then on, has its element miss an edge."""

    FLIP = 0
    STICK = 1
    MISS = 2


class Fate(StrEnum):
    """What comes of an upset."""

    NO_EFFECT = "no effect"
    FALSE_STOP = "false stop"
    DETECTED = "detected"
    DANGEROUS = "dangerous"


def upset_files(folder: Path) -> list[Path]:
    """Return the files of what came of the upsets: one a line, a file for each of so many processes."""
    return [folder / f"upsets_{number}.jsonl" for number in range(os.cpu_count() or 1)]


@dataclass(frozen=True)
class Asked:
    """A command of the script: so many clocks after its begin these bytes.

    ``head``: of the answer, command, sequence and session. ``record``: what the answer must say, the pose or
    the number of the run; None where it has the results of that run, of ``request`` at ``pose``. ``near``:
    whether anything is near in the scene at the pose that there is then.
    """

    clock: int
    data: bytes
    head: tuple[int, int, int]
    near: bool
    record: Pose | RunNumber | None = None
    request: RunRequest | None = None
    pose: Pose | None = None
    number: int = 0


def times_of(bit: int, events: Events, end: int) -> list[tuple[int, int]]:
    """Return when a bit of the pins is set, from a clock to before another; it is not at the start."""
    pins = events[events["kind"] == PINS]
    times: list[tuple[int, int]] = []
    since: int | None = None
    for clock, value in zip(pins["clock"].tolist(), pins["value"].tolist(), strict=True):
        if value & bit and since is None:
            since = clock
        elif not value & bit and since is not None:
            times.append((since, clock))
            since = None
    return [*times, (since, end)] if since is not None else times


@dataclass(frozen=True)
class Truth:
    """The script, and the times within which go may be said: from a command to run, to its usual end.

    ``group``: triangles of a group of the board; ``end``: the last clock.
    """

    script: tuple[Asked, ...]
    group: int
    allowed: tuple[tuple[int, int], ...]
    end: int

    def judge(self, events: Events) -> tuple[Fate, str]:
        """Return what came of an upset, and how it showed."""
        said = times_of(GO, events, self.end)
        for first, last in said:
            within = any(begin <= first and last <= end + LATE for begin, end in self.allowed)
            if not within:
                return Fate.DANGEROUS, f"go from clock {first} to {last}"
        fate, how = self._told(events)
        if fate is not Fate.NO_EFFECT:
            return fate, how
        for begin, end in self.allowed:
            if not any(begin <= first and last <= end + LATE for first, last in said):
                return Fate.FALSE_STOP, f"no go from clock {begin} to {end}"
        return Fate.NO_EFFECT, ""

    def _told(self, events: Events) -> tuple[Fate, str]:
        """Return what a host makes of the answers, up to the first that it does not believe."""
        replies = iter(_frames(events["value"][events["kind"] == TX].tolist()))
        alarm = ""
        for asked in self.script:
            try:
                near = _answer(asked, Reply.of(next(replies)), self.group)
            except StopIteration:
                return Fate.DETECTED, "no answer"
            except (ValueError, LinkError) as error:
                return Fate.DETECTED, str(error)
            if near is not None and asked.near and not near:
                return Fate.DANGEROUS, "a host is told clear"
            if near and not asked.near:
                alarm = alarm or "a host is told near"
        return (Fate.FALSE_STOP, alarm) if alarm else (Fate.NO_EFFECT, "")


def _frames(data: Sequence[int]) -> list[bytes]:
    """Return what stands between two ENDs."""
    return [part for part in bytes(data).split(bytes([_END])) if part]


def _answer(asked: Asked, reply: Reply, group: int) -> int | None:
    """Return how many pairs are near by an answer to RESULTS; None of others.

    Raises what a host raises where it does not believe an answer.
    """
    if (reply.command, reply.sequence, reply.session, reply.code) != (*asked.head, Code.OK):
        raise ValueError(f"no answer to what was asked, or code {reply.code}")
    if asked.record is not None:
        if reply.payload != asked.record.pack():
            raise ValueError("another pose, or run, than asked for")
        return None
    assert asked.request and asked.pose
    status = Status.unpack(reply.payload[: StatusBlock.SIZE])
    check_status(status, group)
    audit(BoardRun(asked.request, asked.pose, asked.number, status, reply.pairs))
    return status.near
