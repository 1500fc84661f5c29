"""A board of a few lines that says what it is told to say: for what no real board may answer."""

import zlib
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from triaxis.host.link.messages import (
    PROTOCOL,
    REPLY,
    ZONES,
    Begun,
    Code,
    Command,
    Description,
    Flag,
    Loaded,
    LoadHead,
    ReplyHead,
    RequestHead,
    Results,
    ResultsRequest,
    RunRequest,
    Status,
    twice,
)
from triaxis.host.link.wire import Deframer, encode

BOARD = Description(PROTOCOL, 16, 16, 64, 4, 4, 0xCAFE, 100, 1)
# Two meshes of 6 and 5 triangles, in groups of 4: 4 group pairs, 30 pairs; half of the groups skipped.
CLEAR = Status(1, 2, 1, Flag.GO | ZONES, 1, 0, 0, 0, 3, 99, 2, 2, 8, 4, 0, 0, 6, 5)

Answer = tuple[Code, bytes]


@dataclass
class ScriptedLine:
    """A line to it. ``lies``: fields of the status; ``answers``: what is said to a command instead."""

    board: Description = BOARD
    status: Status = CLEAR
    near: list[tuple[int, int]] = field(default_factory=list)
    answers: dict[Command, Callable[[], Answer | None]] = field(default_factory=dict)
    name: str = "scripted"
    time: float = 0.0
    heard: bytearray = field(default_factory=bytearray)
    frames: list[bytes] = field(default_factory=list)
    signature: int = 0

    def lie(self, **fields: Any) -> "ScriptedLine":
        """Say other numbers in the status, and stop where they are not of a clear run."""
        clear = self.status.near == fields.get("near", 0) and self.status.end == fields.get("end", 1)
        flags = self.status.flags if clear else ZONES
        self.status = replace(self.status, **{"flags": flags, **fields})
        return self

    def send(self, data: bytes) -> None:
        self.frames.append(data)
        for body in Deframer().feed(data):
            head, payload = RequestHead.split(body)
            command = Command(head.command)
            answer = self.answers[command]() if command in self.answers else self.answer(command, payload)
            if answer:
                code, rest = answer
                reply = ReplyHead(command | REPLY, head.sequence, head.session, code)
                self.heard += encode(reply.pack() + rest)

    def answer(self, command: Command, payload: bytes) -> Answer:
        if command == Command.HELLO:
            return Code.OK, twice(self.board.pack())
        if command == Command.LOAD:
            head, triangles = LoadHead.split(payload)
            self.signature = zlib.crc32(triangles, self.signature if head.first else 0)
            return Code.OK, twice(Loaded(head.first + head.count, self.signature).pack())
        if command == Command.RUN:
            run = RunRequest.unpack(payload)
            self.status = replace(self.status, mode=run.mode)
            return Code.OK, twice(Begun(1, run.hold).pack())
        if command == Command.RESULTS:
            start = ResultsRequest.unpack(payload).start
            some = np.array(self.near[start : start + 3], np.int64).reshape(-1, 2)
            flags = self.status.flags | (Flag.NEAR_WAITING if len(some) else 0)
            return Code.OK, Results(replace(self.status, flags=flags), start, some).pack()
        return Code.OK, twice(self.status.pack())

    def receive(self, seconds: float) -> bytes:
        self.time += 0.02 if self.heard else seconds
        data = bytes(self.heard)
        self.heard.clear()
        return data

    def drop_input(self) -> None:
        self.heard.clear()

    def now(self) -> float:
        return self.time

    def wait(self, seconds: float) -> None:
        self.time += seconds

    def close(self) -> None:
        self.name = "closed"
