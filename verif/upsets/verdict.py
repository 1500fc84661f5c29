"""The kinds of upsets, and what came of one: what the pins and a host say, against what is true."""

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import astuple, dataclass
from enum import IntEnum, StrEnum
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from triaxis.host.link.audit import BoardRun, audit, check_results
from triaxis.host.link.exchange import LinkError
from triaxis.host.link.messages import Begun, Loaded, Results, RunRequest, twice
from triaxis.sim.simulated_board import PINS, TX
from triaxis.verif.board.board_state import BEYOND
from triaxis.verif.board.protocol import END, Code, Reply

Events = npt.NDArray[np.void]
# Of the pins: the levels of go and stop, of which nothing but these permits the machine to move, and the bits
# that permit it, with them, what is for beyond a zone alone; and the LED of a run that goes on.
_LEVELS, _PERMITTED = 0b11, 0b01
_PERMISSIONS = {"go": 0, "beyond slow": 1 << BEYOND, "beyond warn": 1 << BEYOND + 1}
_BUSY = 1 << 4
# Go may end so many clocks later than without an upset, a hundredth of the time in which a machine must stop;
# and begin so many earlier, where a byte is heard at another moment of its last bit.
LATE, EARLY = 1000, 8


class Kind(IntEnum):
    """What an upset does: inverts a bit; holds it at 0 or 1 from then on; has a word miss an edge."""

    FLIP = 0
    STUCK_AT_0 = 1
    STUCK_AT_1 = 2
    MISSED_EDGE = 3


class Fate(StrEnum):
    """What comes of an upset."""

    NO_EFFECT = "no effect"
    FALSE_STOP = "false stop"
    DETECTED = "detected"
    DANGEROUS = "dangerous"


@dataclass(frozen=True)
class Upset:
    """What happens to a word of a register or memory, or to a bit of it, before a clock of the talk.

    ``running``: the clock was drawn from those of runs.
    """

    kind: Kind
    register: str
    element: int
    bit: int
    clock: int
    running: bool


def write_upsets(upsets: Sequence[Upset], file: Path) -> None:
    """Write upsets, one a line, for `read_upsets`."""
    file.write_text("".join(json.dumps(astuple(upset)) + "\n" for upset in upsets), encoding="utf-8")


def read_upsets(file: Path) -> list[Upset]:
    """Return the upsets of a file, in the order of their clocks."""
    lines = file.read_text(encoding="utf-8").splitlines()
    return sorted((upset_of(json.loads(line)) for line in lines), key=lambda one: one.clock)


def upset_of(row: Sequence[Any]) -> Upset:
    """Return an upset from its values, as JSON has them."""
    kind, *rest = row
    return Upset(Kind(kind), *rest)


def upset_files(folder: Path) -> list[Path]:
    """Return the files of what came of the upsets: one a line, a file for each of so many processes."""
    return [folder / f"upsets_{number}.jsonl" for number in range(os.cpu_count() or 1)]


@dataclass(frozen=True)
class AskedRun:
    """A run, whose results are asked for; ``near``: whether anything is near then."""

    request: RunRequest
    number: int
    near: bool


@dataclass(frozen=True)
class Asked:
    """What a host sends, so many clocks after the talk began.

    ``head``: of the answer, command, sequence and session; None where there is none. ``answer``: what it must
    say; of results, ``run`` is what they are of.
    """

    clock: int
    data: bytes
    head: tuple[int, int, int] | None = None
    answer: Begun | Loaded | None = None
    run: AskedRun | None = None


def _times(events: Events, mask: int, value: int, end: int) -> list[tuple[int, int]]:
    """Return when some of the pins have a value, from a clock to before another; not so at the start."""
    pins = events[events["kind"] == PINS]
    times: list[tuple[int, int]] = []
    since: int | None = None
    for clock, level in zip(pins["clock"].tolist(), (pins["value"] & mask == value).tolist(), strict=True):
        if level and since is None:
            since = clock
        elif not level and since is not None:
            times.append((since, clock))
            since = None
    return [*times, (since, end)] if since is not None else times


def permitted(events: Events, end: int) -> dict[str, tuple[tuple[int, int], ...]]:
    """Return when the machine may move: go is said, and stop is not; and when it is beyond each zone then."""
    return {
        what: tuple(_times(events, _LEVELS | bits, _PERMITTED | bits, end))
        for what, bits in _PERMISSIONS.items()
    }


def runs(events: Events, end: int) -> list[tuple[int, int]]:
    """Return when a run goes on."""
    return _times(events, _BUSY, _BUSY, end)


@dataclass(frozen=True)
class Truth:
    """The talk, and when what may be said in it, as by `permitted` without an upset: ``due``.

    ``group``: triangles of a group of the board; ``watchdog``: clocks of silence that end go; ``end``: the
    last clock.
    """

    script: tuple[Asked, ...]
    due: Mapping[str, tuple[tuple[int, int], ...]]
    group: int
    watchdog: int
    end: int

    def quiet(self, sent: int) -> int:
        """Return the clock by which go must have ended where only so many frames are sent."""
        return self.script[sent].clock + self.watchdog + 2 * LATE

    def judge(self, events: Events, sent: int) -> tuple[Fate, str]:
        """Return what came of an upset, and how it showed, where so many frames of the script were sent."""
        said = permitted(events, self.end)
        # A host that says no more leaves go that was said to the watchdog, and is due no other.
        silent = self.script[sent].clock if sent < len(self.script) else self.end
        heard = silent + self.watchdog if silent < self.end else 0
        for what, times in said.items():
            for first, last in times:
                if not any(
                    begin - EARLY <= first <= end and last <= max(end, heard) + LATE and begin <= silent
                    for begin, end in self.due[what]
                ):
                    return Fate.DANGEROUS, f"{what} from clock {first} to {last}"
        fate, how = self.told(events, sent)
        if fate is not Fate.NO_EFFECT:
            return fate, how
        for what, times in self.due.items():
            for begin, end in times:
                if not any(first <= begin + LATE and last >= end - LATE for first, last in said[what]):
                    return Fate.FALSE_STOP, f"no {what} all the time from clock {begin} to {end}"
        return Fate.NO_EFFECT, ""

    def told(self, events: Events, sent: int) -> tuple[Fate, str]:
        """Return what a host makes of the answers to so many frames, up to the first not believed."""
        lines = iter(_lines(events["value"][events["kind"] == TX].tolist()))
        alarm = ""
        for asked in self.script[:sent]:
            if asked.head is None:
                continue
            try:
                near = _near(asked, Reply.of(next(lines)), self.group)
            except StopIteration:
                return Fate.DETECTED, "no answer"
            except (ValueError, LinkError) as error:
                return Fate.DETECTED, str(error)
            if asked.run and asked.run.near and not near:
                return Fate.DANGEROUS, "a host is told clear"
            if asked.run and near and not asked.run.near:
                alarm = alarm or "a host is told near"
        return (Fate.FALSE_STOP, alarm) if alarm else (Fate.NO_EFFECT, "")


def _lines(data: Sequence[int]) -> list[bytes]:
    """Return what stands between two ENDs."""
    return [part for part in bytes(data).split(bytes([END])) if part]


def _near(asked: Asked, reply: Reply, group: int) -> int:
    """Return how many pairs are near by the results of a run; 0 where other things were asked for.

    Raises what a host raises where it does not believe an answer.
    """
    if (reply.command, reply.sequence, reply.session) != asked.head or reply.code != Code.OK:
        raise ValueError(f"no answer to what was asked, or code {reply.code}")
    if asked.answer is not None:
        if reply.payload != asked.answer.pack():
            raise ValueError("another answer than what was asked for")
        return 0
    assert asked.run
    results = Results.unpack(twice(reply.payload) + reply.pairs.astype("<u2").tobytes())
    run = asked.run
    check_results(results, group, run.request.hold > 0)
    if results.start:
        raise ValueError(f"near pairs from {results.start} on")
    audit(BoardRun(run.request, run.number, results.status, results.near))
    return results.status.near
