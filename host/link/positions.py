"""Where the tool is, by lines that a control writes."""

import os
import re
import select
import stat
import threading
import time
from collections.abc import Iterator
from fractions import Fraction

from triaxis.golden.errors import InputError
from triaxis.host.motion.follow import Report
from triaxis.host.quantise import Vector, vector

# What a control prints; none of them takes long to read.
_NUMBER = re.compile(r"[+-]?(\d{1,20}\.?\d{0,40}|\.\d{1,40})([eE][+-]?\d\d?)?", re.ASCII)
# Of X, Y, Z; the tool's number; of A, B, C.
Position = tuple[Vector, int | None, Vector | None]
# Bytes that are read at a time: as many as a pipe holds.
_PART = 1 << 16
# In which another line comes, most likely, of a control that writes as often as it can.
_SOON_SECONDS = 0.002
# Between two looks: what has come is no older than the look before.
_LOOK_SECONDS = 0.0005


class Positions:
    """The last of the positions that a control writes, a line each, and when it came.

    ``tool``: the number of the tool that was in the spindle then; ``angles``: of A, B and C, in degrees; None
    where lines do not say it.
    """

    tool: int | None = None
    angles: Vector | None = None

    def __init__(self, descriptor: int) -> None:
        """Begin to read from a pipe, or what is like one, until it ends; pass over what is in it already.

        Of that nobody knows how old it is. Raises InputError where it is an ordinary file, as all of that is.
        """
        if stat.S_ISREG(os.fstat(descriptor).st_mode):
            raise InputError(
                "positions: an ordinary file does not say when the tool was there: give a pipe, or a FIFO, "
                "that the control writes"
            )
        self._descriptor, self._changed = descriptor, threading.Condition()
        part = b""
        while self._is_there(0) and (more := os.read(descriptor, _PART)):
            part = more
        # Whether the next line has begun before.
        self._cut = part[-1:] not in (b"", b"\n")
        self._last: tuple[Report, int | None, Vector | None] | None = None
        self._wrong: InputError | None = None
        self._ended = False
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        wrong = None
        try:
            for (position, tool, angles), since in self._arrived():
                with self._changed:
                    self._last = (position, since), tool, angles
                    self._changed.notify()
        except InputError as error:
            wrong = error
        except (OSError, ValueError) as error:
            why = getattr(error, "strerror", None) or error
            wrong = InputError(f"positions: cannot read: {why}: the machine is stopped")
        with self._changed:
            self._ended, self._wrong = True, wrong
            self._changed.notify()

    def _arrived(self) -> Iterator[tuple[Position, float]]:
        """Yield the last position of all lines that are there, and a time at which it was not written yet.

        That is when it was looked last and there was nothing: a reading takes all that is there of a pipe,
        and a line of a terminal. Lines that waited, as this process did not run or a control writes faster
        than they are read, are passed over where others are about to come.
        """
        last: tuple[Position, float] | None = None
        # What has come of a line, and the time of that.
        rest, begun, waited = b"", 0.0, False
        empty = time.monotonic()
        while True:
            looked, waits = time.monotonic(), self._is_there(0)
            if not waits:
                empty = looked
            others = not waited if waits else waited and self._is_there(_SOON_SECONDS)
            if last is not None and not others:
                yield last
                last = None
            waited, looked = waits, time.monotonic()
            while not (waits or self._is_there(_LOOK_SECONDS)):
                empty, looked = looked, time.monotonic()
            since = empty
            part = os.read(self._descriptor, _PART)
            *lines, left = (rest + part).split(b"\n")
            begins = begun if rest else since
            if self._cut and lines:
                del lines[0]
                self._cut, begins = False, since
            for number, line in enumerate(lines):
                position = read_position(line.decode(errors="replace"))
                last = position, since if number else begins
            # What has no end is cut off.
            if not part:
                if last is not None:
                    yield last
                return
            rest, begun = left, since if b"\n" in part or not rest else begun
            if len(rest) > _PART:
                raise InputError("positions: a line without an end; the machine is stopped")

    def _is_there(self, seconds: float) -> bool:
        """Return whether there is something to read within a time."""
        return bool(select.select([self._descriptor], [], [], seconds)[0])

    def wait(self, seconds: float) -> bool:
        """Return whether a position has come, or none will, within a time."""
        with self._changed:
            return self._changed.wait_for(lambda: self._last is not None or self._ended, seconds)

    def report(self) -> Report:
        """Return the last position and when it came; None where they have ended.

        Raises InputError where any line is none.
        """
        # Nothing may come between: the last of all would be lost.
        with self._changed:
            last = self.look()
            if self._ended:
                self._last = None
        return last

    def look(self) -> Report:
        """Return what `report` will, which may be later by then."""
        self.wait(threading.TIMEOUT_MAX)
        with self._changed:
            if self._wrong is not None:
                raise self._wrong
            if self._last is None:
                return None
            last, self.tool, self.angles = self._last
            return last


def read_position(line: str) -> Position:
    """Return position, tool and angles of a line; raise InputError where it is none."""
    # A control character that parts others may stand for the end of a line.
    words = re.split(r"[ \t]+", line.strip(" \t\r"))
    try:
        if len(words) not in (3, 4, 7) or not all(map(_NUMBER.fullmatch, words)):
            raise ValueError
        angles = vector(map(Fraction, words[4:])) if words[4:] else None
        return vector(map(Fraction, words[:3])), int(words[3]) if words[3:] else None, angles
    except ValueError as error:
        raise InputError(
            f"position {line.strip()[:60]!r}: must be X Y Z in mm, as in 12.5 -3 40, X Y Z and the tool's "
            "number, or these and A B C in degrees: the machine is stopped"
        ) from error
