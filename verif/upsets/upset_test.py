"""A talk with the board in which its registers and memories are upset, once in each of many copies.

The simulator's process forks where the talk begins: the copy goes through it, and forks again at each clock
at which there is an upset. What comes of that is a line in a file. Without an upset the talk is checked by
the environment, as all others are.
"""

import json
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from triaxis.host.link.messages import Mode, Pose, RunNumber, RunRequest
from triaxis.sim.player import Register
from triaxis.sim.simulated_board import EVENT, NEVER, BoardPlayer
from triaxis.verif.board.base_test import BoardTest
from triaxis.verif.board.line_agent import Until
from triaxis.verif.board.protocol import REPLY, Command, Integers, framed
from triaxis.verif.upsets.verdict import BUSY, GO, Asked, Events, Fate, Kind, Truth, times_of, upset_files

# Pairs of triangles, of which each second meets the core.
_PAIRS = 8
# Clocks from one command to the next: the longest frame and the longest answer take as many bytes.
_BYTES = 170
# Clocks after which a copy is compared with the talk without an upset: where all is as there, it stays so.
_STRIDE = 256
_BYTE_BITS = 10
# Where one pair is near, and where none is.
_NEAR = Pose(0, 0, 3)
_CLEAR = Pose(0, 0, 0)


# Of so many upsets one is of each of the other kinds than flips.
_OF_OTHERS = 12


@dataclass(frozen=True)
class Upset:
    """What happens to a bit of a register, or of an element of a memory, before a clock of the talk."""

    kind: Kind
    clock: int
    register: int
    element: int
    bit: int


@dataclass(frozen=True)
class Undisturbed:
    """The talk without an upset: all that was seen, and the state of all registers every so many clocks."""

    events: Events
    states: tuple[int, ...]


class Talk:
    """The board's model on its way through the script, from the clock at which that begins."""

    def __init__(self, player: BoardPlayer, script: Sequence[Asked], end: int) -> None:
        """Begin at the clock at which the player stands."""
        self._player, self._end, self._start = player, end, player.clocks
        self._left = list(script)
        self._seen = [np.zeros(0, EVENT)]
        self.clock = 0

    @property
    def events(self) -> Events:
        """Return all that was seen, in clocks of the script."""
        new = self._player.events()
        new["clock"] -= self._start
        self._seen = [np.concatenate([*self._seen, new])]
        return self._seen[0]

    def forward(self, until: int) -> None:
        """Go on to a clock."""
        while self.clock < until or (self._left and self._left[0].clock <= self.clock):
            if self._left and self._left[0].clock <= self.clock:
                self._player.send(self._left.pop(0).data)
                continue
            next_ = min(until, self._left[0].clock if self._left else until)
            self._player.run(next_ - self.clock, NEVER)
            self.clock = next_

    def strides(self) -> Iterator[int]:
        """Go on to the end; yield the number of each stride at its end."""
        for number in range(self.clock // _STRIDE + 1, self._end // _STRIDE + 1):
            self.forward(number * _STRIDE)
            yield number
        self.forward(self._end)

    def upset(self, upset: Upset, without: Undisturbed, truth: Truth) -> tuple[Fate, str]:
        """Upset the board, go to the end, or until all is as without it; return what came of it."""
        self._player.upset(upset.kind, upset.register, upset.element, upset.bit)
        for number in self.strides():
            # What sticks may do so again.
            if upset.kind != Kind.STICK and self._player.state() == without.states[number]:
                events, due = self.events, without.events
                if np.array_equal(events, due[due["clock"] <= self.clock]):
                    return Fate.NO_EFFECT, ""
        return truth.judge(self.events)


class BoardUpsetsTest(BoardTest):
    """Clear and go, near and stop, clear and go again, until the host is silent.

    ``pairs``: so many upsets.
    """

    async def stimulus(self) -> None:
        """Load the meshes; upset copies of the board in a talk; have the talk itself checked."""
        await self.hello()
        await self.scene(*self.meshes())
        await self.ask(Command.MOVE, _CLEAR.pack())
        script = self.script()
        # Until after the watchdog has run out.
        end = script[-1].clock + self.parameters.watchdog_clocks + 3 * self.step
        self.upset(script, end)
        for asked, after in zip(script, [*script[1:], None], strict=True):
            gap = (after.clock if after else end) - asked.clock
            await self.line(asked.data, Until.NOW, gap=gap)

    @property
    def step(self) -> int:
        """Return the clocks from one command to the next."""
        return _BYTES * _BYTE_BITS * self.parameters.clocks_per_bit

    def meshes(self) -> tuple[Integers, Integers]:
        """Return two meshes that are clear, and of which one pair is near at the other pose.

        Of each pair the boxes meet, or do not; pairs of different numbers are far apart.
        """
        low = -(1 << self.parameters.width - 1)
        places = np.stack([low + 12 + 28 * np.arange(_PAIRS), np.zeros(_PAIRS), np.zeros(_PAIRS)], -1)
        places = places.astype(np.int64)[:, None]
        second = np.where(np.arange(_PAIRS)[:, None, None] % 2, self.corners(_PAIRS), self.flat(9, _PAIRS))
        second[2] = self.flat(3)[0]
        return self.flat(0, _PAIRS) + places, second + places

    def script(self) -> tuple[Asked, ...]:
        """Return the commands of the talk."""
        request = RunRequest(Mode.ALL, 0, _PAIRS, _PAIRS)
        asked: list[Asked] = []

        def ask(command: Command, payload: bytes, near: bool) -> Asked:
            body = self.frame(command, payload, len(asked) + 1)
            sequence = (self.sequence + len(asked) + 1) % 2**32
            head = command | REPLY, sequence, self.session
            return Asked(len(asked) * self.step, framed(body), head, near, request=request)

        for number, pose in enumerate((_CLEAR, _NEAR, _CLEAR), 1):
            near = pose is _NEAR
            if number > 1:
                asked.append(replace(ask(Command.MOVE, pose.pack(), near), record=pose))
            run = RunNumber(number)
            asked.append(replace(ask(Command.RUN, request.pack(), near), record=run))
            results = ask(Command.RESULTS, bytes(4), near)
            asked.append(replace(results, pose=pose, number=number))
        return tuple(asked)

    def upset(self, script: tuple[Asked, ...], end: int) -> None:
        """Play the talk in copies of this process, one upset in each; what came of them is in the files."""
        assert self.bfm
        player, files = self.bfm.player, upset_files(Path(self.settings.folder))
        registers = player.registers()
        without = _without_upsets(player, script, end, files[0].with_name("undisturbed.npz"))
        runs = [one.clock for one in script if isinstance(one.record, RunNumber) and not one.near]
        gos = [last for _, last in times_of(GO, without.events, end)]
        truth = Truth(script, self.parameters.group, tuple(zip(runs, gos, strict=True)), end)
        fate, how = truth.judge(without.events)
        assert fate is Fate.NO_EFFECT, f"without an upset: {fate}: {how}"
        upsets = self.chosen(registers, without.events, end)
        for number, file in enumerate(files):
            if os.fork() == 0:
                status = 1
                try:
                    _upset_all(player, script, upsets[number :: len(files)], without, truth, registers, file)
                    status = 0
                finally:
                    os._exit(status)
        assert not any(os.wait()[1] for _ in files), "a copy with an upset came to no end"

    def chosen(self, registers: Sequence[Register], events: Events, end: int) -> list[Upset]:
        """Return the upsets in the order of their clocks: of each kind, of no bit more than of another.

        One half while a run goes on, which is a small part of the time.
        """
        sizes = np.array([one.elements * one.bits for one in registers])
        first = np.concatenate([[0], np.cumsum(sizes)])
        count, total = self.settings.pairs, int(first[-1])
        others = count // _OF_OTHERS
        counts = {Kind.FLIP: count - 2 * others, Kind.STICK: others, Kind.MISS: others}
        kinds = np.concatenate([np.full(many, kind) for kind, many in counts.items()])
        bits = np.concatenate([_all_alike(self.rng, total, many) for many in counts.values()])
        number = np.searchsorted(first, bits, "right") - 1
        running = np.concatenate([np.arange(*times) for times in times_of(BUSY, events, end)])
        clocks = self.rng.integers(0, end, count)
        half = self.rng.permutation(count) < count // 2
        clocks[half] = self.rng.choice(running, int(half.sum()))
        found: list[Upset] = []
        for at in np.argsort(clocks, kind="stable").tolist():
            register = int(number[at])
            element, bit = divmod(int(bits[at] - first[register]), registers[register].bits)
            found.append(Upset(Kind(kinds[at]), int(clocks[at]), register, element, bit))
        return found


def _all_alike(rng: np.random.Generator, total: int, count: int) -> Integers:
    """Return so many numbers below ``total``, (count,), none of them more than once oftener than another."""
    orders = [rng.permutation(total) for _ in range(-(-count // total))]
    return np.concatenate([np.zeros(0, np.int64), *orders])[:count]


def _without_upsets(player: BoardPlayer, script: Sequence[Asked], end: int, file: Path) -> Undisturbed:
    """Return what is seen where nothing is upset: a copy of this process goes through the talk."""
    if os.fork() == 0:
        talk = Talk(player, script, end)
        states = [player.state(), *(player.state() for _ in talk.strides())]
        np.savez(file, events=talk.events, states=np.array(states, np.uint64))
        os._exit(0)
    assert os.wait()[1] == 0, "the talk without an upset came to no end"
    with np.load(file) as kept:
        return Undisturbed(kept["events"], tuple(kept["states"].tolist()))


def _upset_all(
    player: BoardPlayer, script: Sequence[Asked], upsets: Sequence[Upset], without: Undisturbed,
    truth: Truth, registers: Sequence[Register], file: Path,
) -> None:  # fmt: skip
    """Go through the talk, and leave a copy with an upset behind at each of these clocks."""
    talk = Talk(player, script, truth.end)
    with file.open("w") as lines:
        for upset in upsets:
            talk.forward(upset.clock)
            if os.fork() == 0:
                fate, how = talk.upset(upset, without, truth)
                register = registers[upset.register]
                row = (upset.kind.name, register.name, upset.element, upset.bit, upset.clock, fate, how)
                lines.write(json.dumps(row) + "\n")
                lines.flush()
                os._exit(0)
            assert os.wait()[1] == 0, f"{registers[upset.register].name}: no end after an upset"
