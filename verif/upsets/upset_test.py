"""A talk with the board in which its registers and memories are upset, once in each of many copies.

The simulator's process forks where the talk begins: the copy goes through it, and forks again at each clock
at which there is an upset. What comes of that is a line in a file. Without an upset the talk is checked by
the environment, as all others are.
"""

import json
import os
import re
import traceback
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import astuple, dataclass, replace
from functools import partial
from heapq import heapify, heappop, heappush
from itertools import count, pairwise
from pathlib import Path

import numpy as np
import numpy.typing as npt

from triaxis.host.link.messages import Begun, Loaded, Mode, Pose, RunRequest
from triaxis.sim.player import Register
from triaxis.sim.simulated_board import EVENT, NEVER, BoardPlayer
from triaxis.verif.board.base_test import BoardTest
from triaxis.verif.board.line_agent import Until
from triaxis.verif.board.protocol import REPLY, Command, Integers, framed, load_payload, triangle_bytes
from triaxis.verif.board.reference import EXECUTED
from triaxis.verif.upsets.verdict import (
    Asked,
    AskedRun,
    Events,
    Fate,
    Kind,
    Truth,
    Upset,
    permitted,
    read_upsets,
    runs,
    upset_files,
)

# Triangles of each mesh, the number of the one in B that comes near, and where it does.
_TRIANGLES, _NEAREST = 8, 2
_NEAR, _CLEAR, _FURTHER = Pose(0, 0, 3), Pose(0, 0, 0), Pose(0, 0, -9)
# Of all runs, as far as they fit: where it is clear is beyond the one, and further beyond both.
_SLOW, _WARN = 2, 8
# Of a run: until the next one has ended, and until before that one begins.
_HOLD, _SHORT_HOLD = 20, 3
# Bytes of the longest frame and its answer, and of the longest answer: RESULTS.
_SHORT, _LONG = 130, 170
_BYTE_BITS = 10
# Clocks after which a copy is compared with the talk without an upset: more than a byte takes, so that what
# is on the line by then has been seen by the stride after.
_STRIDE = 256
# Of so many upsets one is of each of the other kinds than flips, and one of a command that asks for a run.
_OF_OTHERS = 33
# What a command is gathered and judged in.
_COMMAND = re.compile(r".*\.u_command\.(g_request\[\d\]\.u_request\.)?\w+")
# Upsets that are tried in one copy, where that suffices; the memories of meshes, of which each run makes use.
_TOGETHER, _ALWAYS_USED = 32, ".u_store_"


@dataclass(frozen=True)
class Undisturbed:
    """The talk without an upset: all that was seen, and the state of all registers every so many clocks."""

    events: Events
    states: tuple[int, ...]


class Talk:
    """The board's model on its way through the script, from the clock at which that begins.

    The host in it says nothing more once it has not believed an answer, or has none in time.
    """

    def __init__(self, player: BoardPlayer, truth: Truth) -> None:
        """Begin at the clock at which the player stands."""
        self._player, self._truth, self._start = player, truth, player.clocks
        self._end, self._script = truth.end, truth.script
        self._silent = False
        self._seen = np.zeros(0, EVENT)
        self.clock = self.sent = 0

    @property
    def events(self) -> Events:
        """Return all that was seen, in clocks of the script."""
        new = self._player.events()
        new["clock"] -= self._start
        self._seen = np.concatenate([self._seen, new])
        return self._seen

    def forward(self, until: int) -> None:
        """Go on to a clock."""
        while not self._silent and self.sent < len(self._script) and self._script[self.sent].clock <= until:
            self._run(self._script[self.sent].clock)
            self._silent = self._truth.told(self.events, self.sent)[0] is Fate.DETECTED
            if not self._silent:
                self._player.send(self._script[self.sent].data)
                self.sent += 1
        self._run(until)

    def _run(self, until: int) -> None:
        progress = self._player.run(until - self.clock, NEVER)
        if progress.symptom:
            raise RuntimeError(f"the board {progress.symptom}")
        self.clock = until

    def strides(self) -> Iterator[int]:
        """Go on to the end, or until a host that is silent has been so for long enough to be seen.

        Yields the number of each stride at its end.
        """
        for number in range(self.clock // _STRIDE + 1, self._end // _STRIDE + 1):
            if self._silent and self.clock > self._truth.quiet(self.sent):
                return
            self.forward(number * _STRIDE)
            yield number
        self.forward(self._end)

    def upset(self, upset: Upset, register: int, without: Undisturbed) -> tuple[Fate, str]:
        """Upset the board, go to the end, or until all is as without it; return what came of it.

        ``register``: its number in the player.
        """
        self._player.upset(upset.kind, register, upset.element, upset.bit)
        once = upset.kind in (Kind.FLIP, Kind.MISSED_EDGE)
        alike = 0
        for number in self.strides():
            alike = alike + 1 if once and self._player.state() == without.states[number] else 0
            # The second time nothing is on the line any more that was sent before.
            if alike == 2:
                events, due = self.events, without.events
                if np.array_equal(events, due[due["clock"] <= self.clock]):
                    return Fate.NO_EFFECT, ""
        return self._truth.judge(self.events, self.sent)

    def alike(self, upsets: Sequence[Upset], numbers: Mapping[str, int], file: Path) -> bool:
        """Return whether all goes on as without these, each in a word of its own, at its clock.

        Nothing was made of any of the words then: all else is compared, at each stride, with a copy that goes
        on undisturbed, and so is all that is seen. ``file``: what that copy writes.
        """
        for upset in upsets:
            self._player.ignore(numbers[upset.register], upset.element)
        _in_copies([lambda: np.savez(file, states=self._followed((), numbers), events=self.events)])
        states = self._followed(upsets, numbers)
        with np.load(file) as kept:
            same = np.array_equal(states, kept["states"]) and np.array_equal(self.events, kept["events"])
        file.unlink()
        return same

    def _followed(self, upsets: Sequence[Upset], numbers: Mapping[str, int]) -> npt.NDArray[np.uint64]:
        """Go on to the end, with upsets at their clocks; return the state at the end of each stride."""
        left, states = list(upsets), list[int]()
        for end in [*range((self.clock // _STRIDE + 1) * _STRIDE, self._end, _STRIDE), self._end]:
            while left and left[0].clock <= end:
                upset = left.pop(0)
                self.forward(upset.clock)
                self._player.upset(upset.kind, numbers[upset.register], upset.element, upset.bit)
            self.forward(end)
            states.append(self._player.state())
        return np.array(states, np.uint64)


class BoardUpsetsTest(BoardTest):
    """Clear and go, near and stop, by a pose and by a load; go that one run leaves to the next, and that a
    near one, a deadline, a damaged frame end; then silence.

    ``pairs``: so many upsets, drawn at random; those of a file to ``replay``, one a line, where there is one.
    """

    async def stimulus(self) -> None:
        """Load the meshes; upset copies of the board in a talk; have the talk itself checked."""
        await self.hello()
        await self.scene(*self.meshes())
        script = self.script()
        # Until after the watchdog has run out.
        end = script[-1].clock + self.parameters.watchdog_clocks + 2 * self.clocks_of(_LONG)
        self.upset(script, end)
        for asked, after in zip(script, [*(one.clock for one in script[1:]), end], strict=True):
            await self.line(asked.data, Until.NOW, gap=after - asked.clock)

    def clocks_of(self, count: int) -> int:
        """Return how long so many bytes are on the line."""
        return -(-count * _BYTE_BITS * self.parameters.clocks_per_three_bits // 3)

    def meshes(self, near: bool = False) -> tuple[Integers, Integers]:
        """Return two meshes of which no pair is near, or one; at the other pose one is in any case.

        Of each pair the boxes meet, or do not; pairs of different numbers are far apart.
        """
        low = -(1 << self.parameters.width - 1)
        numbers = np.arange(_TRIANGLES)
        places = np.stack([low + 12 + 28 * numbers, 0 * numbers, 0 * numbers], -1)[:, None]
        corners, flat = self.corners(_TRIANGLES), self.flat(9, _TRIANGLES)
        second = np.where(numbers[:, None, None] % 2, corners, flat)
        second[_NEAREST] = self.flat(0 if near else _NEAR.z)[0]
        return self.flat(0, _TRIANGLES) + places, second + places

    def script(self) -> tuple[Asked, ...]:
        """Return what a host sends, one after another."""
        script: list[Asked] = []
        clock = ahead = number = 0
        slow, warn = (min(zone, self.parameters.max_margin) for zone in (_SLOW, _WARN))

        def ask(
            command: Command,
            payload: bytes,
            answer: Begun | Loaded | None = None,
            run: AskedRun | None = None,
        ) -> None:
            nonlocal clock, ahead
            ahead += 1
            head = command | REPLY, (self.sequence + ahead) % 2**32, self.session
            script.append(Asked(clock, framed(self.frame(command, payload, ahead)), head, answer, run))
            clock += self.clocks_of(_LONG if run else _SHORT)

        def run(pose: Pose, near: bool, hold: int = 0) -> None:
            nonlocal number
            number += 1
            request = RunRequest(Mode.ALL, 0, slow, warn, _TRIANGLES, _TRIANGLES, 0, *pose, hold)
            ask(Command.RUN, request.pack(), Begun(number, hold))
            ask(Command.RESULTS, bytes(4), run=AskedRun(request, number, near))

        def load(near: bool) -> None:
            second = self.meshes(near)[1]
            payload = load_payload(1, 0, second, self.parameters.width)
            held = triangle_bytes(second, self.parameters.width)
            ask(Command.LOAD, payload, Loaded(_TRIANGLES, zlib.crc32(held)))

        run(_CLEAR, near=False)
        run(_NEAR, near=True)
        run(_CLEAR, near=False, hold=_HOLD)
        run(_FURTHER, near=False, hold=_HOLD)
        run(_NEAR, near=True, hold=_HOLD)
        run(_CLEAR, near=False, hold=_SHORT_HOLD)
        run(_CLEAR, near=False)
        damaged = bytearray(framed(self.frame(Command.STATUS)))
        damaged[3] ^= 1
        script.append(Asked(clock, bytes(damaged)))
        clock += self.clocks_of(_SHORT)
        run(_CLEAR, near=False)
        load(near=True)
        run(_CLEAR, near=True)
        load(near=False)
        run(_CLEAR, near=False)
        return tuple(script)

    def upset(self, script: tuple[Asked, ...], end: int) -> None:
        """Play the talk in copies of this process, one upset in each; what came of them is in the files."""
        assert self.bfm
        player, files = self.bfm.player, upset_files(Path(self.settings.folder))
        registers = player.registers()
        file = files[0].with_name("undisturbed.npz")
        truth = Truth(script, {}, self.parameters.group, self.parameters.watchdog_clocks, end)
        _in_copies([partial(_undisturbed, player, truth, registers, file)])
        with np.load(file) as kept:
            without = Undisturbed(kept["events"], tuple(kept["states"].tolist()))
        due = permitted(without.events, end)
        asked = [one.run for one in script if one.run]
        clear = sum(not run.near for run in asked)
        kept = sum(run.request.hold > 0 and not (before.near or run.near) for before, run in pairwise(asked))
        times = len(due["go"])
        assert times == clear - kept, f"go {times} times, {clear} runs are clear, {kept} keep it"
        truth = replace(truth, due=due)
        fate, how = truth.judge(without.events, len(script))
        assert fate is Fate.NO_EFFECT, f"without an upset: {fate}: {how}"
        replay = self.settings.replay
        upsets = (
            read_upsets(Path(replay)) if replay else self.chosen(registers, runs(without.events, end), end)
        )
        share = len(files)
        _in_copies(
            [
                partial(_upset_all, player, upsets[number::share], without, truth, registers, to)
                for number, to in enumerate(files)
            ]
        )

    def chosen(
        self, registers: Sequence[Register], running: Sequence[tuple[int, int]], end: int
    ) -> list[Upset]:
        """Return the upsets in the order of their clocks.

        Bits that are inverted are first those of all flip-flops, then some of memories; where there are fewer
        upsets than flip-flops, any. No bit, and for edges no register, is taken more than once oftener than
        another. One half is while a run goes on, which is a small part of the time; some are of a command
        that asks for one, from when it is gathered until it is executed, which is a smaller one.
        """
        sizes = np.array([one.elements * one.bits for one in registers])
        first = np.concatenate([[0], np.cumsum(sizes)])
        count, total, rng = self.settings.pairs, int(first[-1]), self.rng
        others = count // _OF_OTHERS
        missing = _evenly(rng, len(registers), others)
        drawn = count - others
        kinds = np.repeat(
            [Kind.FLIP, Kind.STUCK_AT_0, Kind.STUCK_AT_1, Kind.MISSED_EDGE, Kind.FLIP],
            [drawn - 3 * others, *[others] * 4],
        )
        memory = np.repeat([one.elements > 1 for one in registers], sizes)
        command = np.repeat([bool(_COMMAND.fullmatch(one.name)) for one in registers], sizes)
        bits = np.concatenate(
            [
                _in_order(rng, memory, drawn - 3 * others),
                *(_evenly(rng, total, others) for _ in ("stuck at 0", "stuck at 1")),
                first[missing] + rng.integers(0, sizes[missing]),
                rng.choice(np.flatnonzero(command), others),
            ]
        )
        number = np.searchsorted(first, bits, "right") - 1
        begins = np.array([begin for begin, _ in running]) - 1
        clocks = np.concatenate(
            [rng.integers(0, end, drawn), rng.choice(begins, others) - rng.integers(0, EXECUTED + 1, others)]
        )
        half = np.zeros(count, bool)
        half[:drawn] = rng.permutation(drawn) < count // 2
        clocks[half] = rng.choice(np.concatenate([np.arange(*times) for times in running]), int(half.sum()))
        found: list[Upset] = []
        for at in np.argsort(clocks, kind="stable").tolist():
            register = registers[int(number[at])]
            element, bit = divmod(int(bits[at] - first[number[at]]), register.bits)
            found.append(Upset(Kind(kinds[at]), register.name, element, bit, int(clocks[at]), bool(half[at])))
        return found


def _evenly(rng: np.random.Generator, total: int, count: int) -> Integers:
    """Return so many numbers below ``total``, (count,), none of them more than once oftener than another."""
    orders = [rng.permutation(total) for _ in range(-(-count // total))]
    return np.concatenate([np.zeros(0, np.int64), *orders])[:count]


def _in_order(rng: np.random.Generator, later: npt.NDArray[np.bool_], count: int) -> Integers:
    """Return so many numbers of bits, (count,): all that are not for later, then those; then all again."""
    if count < np.count_nonzero(~later):
        return _evenly(rng, len(later), count)
    order = [rng.permutation(np.flatnonzero(later == part)) for part in (False, True)]
    return np.resize(np.concatenate(order), count)


def _in_copies(work: Sequence[Callable[[], None]]) -> None:
    """Do all of this at a time, in copies of this process; raise AssertionError where one fails."""
    for one in work:
        if os.fork() == 0:
            status = 1
            try:
                one()
                status = 0
            except BaseException:
                traceback.print_exc()
            finally:
                # No copy may go on as the simulator.
                os._exit(status)
    failed = [status for status in [os.wait()[1] for _ in work] if status]
    assert not failed, "a copy of the simulator came to no end: see the log"


def _undisturbed(player: BoardPlayer, truth: Truth, registers: Sequence[Register], file: Path) -> None:
    """Write down what is seen where nothing is upset."""
    talk = Talk(player, truth)
    states = [player.state(), *(player.state() for _ in talk.strides())]
    names, sizes = [one.name for one in registers], [(one.elements, one.bits) for one in registers]
    np.savez(file, events=talk.events, states=np.array(states, np.uint64), names=names, sizes=sizes)


def _upset_all(
    player: BoardPlayer, upsets: Sequence[Upset], without: Undisturbed, truth: Truth,
    registers: Sequence[Register], file: Path,
) -> None:  # fmt: skip
    """Go through the talk, and leave a copy with an upset behind at each of these clocks."""
    talk = Talk(player, truth)
    numbers = {register.name: number for number, register in enumerate(registers)}
    simulator = os.getppid()
    with file.open("w") as lines:

        def told(upset: Upset) -> None:
            came = talk.upset(upset, numbers[upset.register], without)
            lines.write(json.dumps([*astuple(upset), *came]) + "\n")
            lines.flush()

        def told_together(some: Sequence[Upset], apart: Path) -> None:
            if not talk.alike(some, numbers, apart.with_suffix(".npz")):
                apart.touch()
                return
            for upset in some:
                lines.write(json.dumps([*astuple(upset), Fate.NO_EFFECT, ""]) + "\n")
            lines.flush()

        waiting = [(some[0].clock, number, some) for number, some in enumerate(grouped(upsets, registers))]
        heapify(waiting)
        apart, more = file.with_name(f"{file.stem}_apart"), count(len(waiting))
        while waiting:
            clock, _, some = heappop(waiting)
            if os.getppid() != simulator:
                raise RuntimeError("the simulator has ended, so this copy of it does")
            talk.forward(clock)
            if len(some) == 1:
                _in_copies([partial(told, some[0])])
                continue
            _in_copies([partial(told_together, some, apart)])
            if apart.exists():
                apart.unlink()
                for upset in some:
                    heappush(waiting, (upset.clock, next(more), [upset]))


def grouped(upsets: Sequence[Upset], registers: Sequence[Register]) -> list[list[Upset]]:
    """Return upsets, each alone but for bits inverted in words of memories of which mostly nothing is made.

    So many of these that follow one another are together, no two of them in the same word.
    """
    memories = {one.name for one in registers if one.elements > 1 and _ALWAYS_USED not in one.name}
    groups: list[list[Upset]] = []
    group: dict[tuple[str, int], Upset] = {}
    for upset in upsets:
        if upset.kind is not Kind.FLIP or upset.register not in memories:
            groups.append([upset])
            continue
        word = upset.register, upset.element
        if word in group or len(group) == _TOGETHER:
            groups.append(list(group.values()))
            group = {}
        group[word] = upset
    return [*groups, list(group.values())] if group else groups
