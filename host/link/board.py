"""The board as an object: each method is one command, checked to have been done."""

import zlib
from contextlib import suppress
from typing import Self, TypeVar

import numpy as np
import numpy.typing as npt

from triaxis.host.engines import Progress, unwatched
from triaxis.host.link.audit import BoardRun, check_description, check_later, check_results, check_status
from triaxis.host.link.exchange import Exchange, Line, LinkError, SessionLostError
from triaxis.host.link.messages import (
    LOADED_POSE,
    NO_ZONES,
    PROTOCOL,
    Begun,
    Code,
    Command,
    Description,
    Loaded,
    LoadHead,
    Mesh,
    Mode,
    Pose,
    Results,
    ResultsRequest,
    RunRequest,
    State,
    Status,
    once,
    pack_triangles,
    triangles_per_load,
)  # fmt: skip
from triaxis.host.link.wire import LayoutError, Record

# A dead master's board is free once its watchdog has run out. With a simulated one that takes as long as its
# machine is slow: so not seconds are counted, but its refusals. One takes its line 600 clocks at the least,
# and its watchdog has 100,000.
_REFUSALS, _BETWEEN_HELLOS = 200, 0.025
_SILENT_HELLO_SECONDS = 5.0
# A run without news: one clock a facet pair, and a simulated board of 50,000 clocks a second.
_SILENT_SECONDS, _SECONDS_PER_PAIR = 30.0, 20e-6
# The engine reads its meshes again a triangle a clock.
_SECONDS_PER_TRIANGLE = 10e-9

# Codes by which the board tells that it has forgotten, or never had, what we have sent.
_LOST = (Code.BAD_SEQUENCE, Code.OUT_OF_PLACE, Code.COUNTS_DIFFER, Code.EMPTY_MESH, Code.BUSY)

_Answer = TypeVar("_Answer", bound=Record | Results)


class Board:
    """A board on a line; `hello` comes first.

    Every method raises LinkError where the board does not do what it is asked, or says that it did not.
    """

    def __init__(self, line: Line) -> None:
        """Use an open line."""
        self._line = line
        self._exchange = Exchange(line)
        self._forget()

    def __enter__(self) -> Self:
        """Return the board."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the line."""
        self._line.close()

    def _forget(self) -> None:
        self._counts = [0, 0]
        self._runs = 0
        self._holds = False

    def hello(self) -> Description:
        """Take the board in a new session, empty; where another master has it, wait for its end."""
        self._exchange.renew()
        self._forget()
        frame = self._exchange.next_frame(Command.HELLO, b"")
        self._line.drop_input()
        deadline, refusals = self._line.now() + _SILENT_HELLO_SECONDS, 0
        while self._line.now() < deadline:
            reply = self._exchange.send(Command.HELLO, frame, 8 * _BETWEEN_HELLOS)
            if reply and reply.head.code == Code.OK:
                return self._described(reply.payload)
            if reply and reply.head.code == Code.OTHER_SESSION:
                deadline, refusals = self._line.now() + _SILENT_HELLO_SECONDS, refusals + 1
            if refusals == _REFUSALS:
                raise LinkError(
                    f"{self._line.name}: the board belongs to another master: end that program, then repeat"
                )
            if reply:
                self._line.wait(_BETWEEN_HELLOS)
        raise LinkError(
            f"{self._line.name}: no answer in {_SILENT_HELLO_SECONDS:g} s: check that this is the board's "
            "port, that it has power and that its bitstream is loaded"
        )

    def _described(self, payload: bytes) -> Description:
        if payload[:1] != bytes([PROTOCOL]):
            raise LinkError(
                f"{self._line.name}: the board speaks protocol {payload[:1].hex() or 'none'}, this program "
                f"{PROTOCOL:02x}: load the bitstream of this version"
            )
        self.description = self._read(Description, payload)
        check_description(self.description)
        return self.description

    def take_again(self) -> None:
        """Take the same board in a new session, empty; raise LinkError where another one answers."""
        before = self.description
        if self.hello() != before:
            raise LinkError(f"{self._line.name}: another board answers than before; verdict unknown")

    def begin_again(self) -> None:
        """Empty the board within the session; a fault is forgotten."""
        self._expect("board", self._ask(Command.HELLO, Description), self.description)
        self._forget()

    def load(self, mesh: Mesh, triangles: npt.NDArray[np.int64], progress: Progress = unwatched) -> None:
        """Replace a mesh by triangles (N, 3, 3), N at least 1; ``progress`` is told of each step's size.

        The board refuses more than it holds.
        """
        width = self.description.width
        step, signature = triangles_per_load(width), 0
        for first in range(0, len(triangles), step):
            some = triangles[first : first + step]
            head = LoadHead(mesh, first, len(some))
            packed = pack_triangles(some, width)
            signature = zlib.crc32(packed, signature)
            loaded = self._ask(Command.LOAD, Loaded, head.pack() + packed)
            self._expect("triangles loaded", loaded.count, first + len(some))
            self._expect("signature of the mesh loaded", loaded.signature, signature)
            progress(len(some))
        # The engine reads it again meanwhile: see the assumptions of docs/safety.md.
        self._line.wait(self.description.depth * _SECONDS_PER_TRIANGLE)
        self._counts[mesh] = len(triangles)

    def run(
        self,
        mode: Mode,
        margin: int,
        pose: Pose = LOADED_POSE,
        progress: Progress = unwatched,
        trial: int = 0,
        hold: int = 0,
        zones: tuple[int, int] = NO_ZONES,
    ) -> BoardRun:
        """Run to the end; ``progress`` is told of near pairs. The caller audits what comes back.

        ``trial``, ``hold``, ``zones`` (slow, warn): see `RunRequest`.
        """
        request = RunRequest(
            mode, margin, *zones, *self._counts, trial=trial, x=pose.x, y=pose.y, z=pose.z, hold=hold
        )
        begun = self._ask(Command.RUN, Begun, request)
        self._runs += 1
        self._expect("run number and hold", begun, Begun(self._runs % 256, hold))
        self._holds = hold > 0
        try:
            status, near = self._results(progress)
        except KeyboardInterrupt:
            with suppress(LinkError):
                self.abort()
            raise
        return BoardRun(request, begun.number, status, near)

    def _results(self, progress: Progress) -> tuple[Status, npt.NDArray[np.int64]]:
        parts = [np.empty((0, 2), np.int64)]
        count = 0
        silence = _SILENT_SECONDS + _SECONDS_PER_PAIR * self._counts[0] * self._counts[1]
        deadline = self._line.now() + silence
        while True:
            results = self._ask(Command.RESULTS, Results, ResultsRequest(count))
            check_results(results, self.description.group, self._holds)
            self._expect("first near pair", results.start, count)
            if len(results.near):
                deadline = self._line.now() + silence
                parts.append(results.near)
                count += len(results.near)
                progress(len(results.near))
            elif results.status.state != State.RUNNING:
                return results.status, np.concatenate(parts)
            if self._line.now() > deadline:
                self.abort()
                raise LinkError(
                    f"{self._line.name}: a run without end in {silence:.0f} s: aborted; reset the board; "
                    "verdict unknown"
                )

    def status(self) -> Status:
        """Return the board's status; this also keeps the link alive."""
        return self._status(Command.STATUS)

    def still(self, run: Status) -> Status:
        """Return the status again of a run that has ended so; raises LinkError where it is another."""
        status = self.status()
        check_later(run, status)
        return status

    def stop(self) -> None:
        """Have the output say stop, if the board hears it, without an answer."""
        with suppress(LinkError):
            self._exchange.tell(Command.ABORT)

    def abort(self) -> Status:
        """End a run that goes on, whether or not the board got what was asked last; return its status."""
        try:
            return self._status(Command.ABORT)
        except SessionLostError:
            self._exchange.go_back()
            return self._status(Command.ABORT)

    def _status(self, command: Command) -> Status:
        status = self._ask(command, Status)
        check_status(status, self.description.group, self._holds)
        return status

    def _ask(self, command: Command, answer: type[_Answer], request: Record | bytes = b"") -> _Answer:
        reply = self._exchange.ask(command, request)
        code = Code(reply.head.code)
        if code == Code.OTHER_SESSION:
            raise LinkError(
                f"{self._line.name}: the board was reset, or another master has taken it; verdict unknown"
            )
        if code in _LOST:
            raise SessionLostError(
                f"{self._line.name}: {command.name}: {code.name}: state lost; verdict unknown"
            )
        if code != Code.OK:
            raise LinkError(f"{self._line.name}: {command.name} was refused: {code.name}; verdict unknown")
        return self._read(answer, reply.payload)

    def _read(self, answer: type[_Answer], payload: bytes) -> _Answer:
        try:
            # Near pairs, which come once, follow what the answer to RESULTS has twice.
            return answer.unpack(payload if answer is Results else once(payload))
        except LayoutError as error:
            raise LinkError(
                f"{self._line.name}: {error}: not this protocol, or altered on its way; verdict unknown"
            ) from error

    def _expect(self, what: str, found: object, wanted: object) -> None:
        if found != wanted:
            raise SessionLostError(
                f"{self._line.name}: {what}: {found}, expected {wanted}: state lost; verdict unknown"
            )
