"""The board's tests of what comes over the line: damaged frames, commands to refuse, silence."""

import struct
from itertools import product

import numpy as np

from triaxis.golden.pairs import coordinate_range
from triaxis.verif.board.base_test import BOARD, ONE_SEED, SESSION, SHORT, BoardTest
from triaxis.verif.board.line_agent import Act, Until
from triaxis.verif.board.protocol import (
    LONGEST,
    MOST_TRIANGLES,
    RUN,
    Command,
    Mode,
    checked,
    coordinate_bytes,
    framed,
    load_payload,
    stuffed,
)
from triaxis.verif.board.reference import EXECUTED
from triaxis.verif.testbench.table import Runs, listed


@listed(
    "V2",
    Runs((BOARD,), 45, seeds=1, smoke=(BOARD,)),
    why_seeds=ONE_SEED,
)
class BoardFramesTest(BoardTest):
    """Frames of every length, damaged in every way, truncated, stuffed; breaks, noise and floods."""

    async def stimulus(self) -> None:
        """Send them, between commands that show what the board thinks of them."""
        # Before the first END nothing is a frame, nor is it after a reset.
        await self.silent(framed(self.frame(Command.HELLO))[3:])
        await self.silent(b"\x55\xdb\x55")
        self.session = 0xC0DBDCDD
        await self.hello()
        await self.clear_scene()
        await self.clear_run()
        for length in range(9):
            await self.silent(framed(bytes(range(length))))
        await self.lengths()
        await self.damaged()
        await self.cut_off()
        await self.levels()
        self.move()
        await self.too_early()
        await self.clear_run()

    async def lengths(self) -> None:
        """Send the longest frame, and longer ones; a good one after each."""
        most = LONGEST - len(self.frame(0)) - 4
        for command, length in ((Command.STATUS, most), (0x55, most)):
            await self.ask(command, bytes(length))
        for length in (most + 1, most + 40):
            await self.silent(framed(self.frame(Command.STATUS, bytes(length))))
            await self.status()

    async def damaged(self) -> None:
        """Flip a bit of each byte; what the framing means anywhere."""
        for place in range(17):
            frame = bytearray(checked(self.frame(Command.ABORT)))
            frame[place % len(frame)] ^= 1 << int(self.rng.integers(8))
            await self.silent(b"\xc0" + stuffed(bytes(frame)) + b"\xc0")
        await self.status()
        for noise in (
            b"\xc0\x01\xdb\x01\x02\x03\xc0", b"\xc0\x01\xdb\xdb\x01\xdc\xc0", b"\xc0\xdb\xc0", b"\xdb\xc0",
            b"\xc0\x01\xdb\x01\xdb\xdc\xdb\x02\xc0", b"\xc0\xdc\xdd\xc0", b"\xc0\xc0\xc0",
        ):  # fmt: skip
            await self.silent(noise)
            await self.status()
        # A wrong escape drops the frame up to its end; a good frame's bytes in it are none.
        await self.silent(b"\xc0\xdb\x01" + framed(self.frame(Command.ABORT))[1:])
        await self.status()
        # An END after an ESC is wrong, and yet ends the frame: the next may begin with it.
        await self.line(b"\xc0\x01\xdb" + framed(self.frame(Command.STATUS)))
        self.sequence += 1
        await self.status()

    async def cut_off(self) -> None:
        """Cut a frame off, anywhere: the next one's beginning ends it; so does a break."""
        whole = framed(self.frame(Command.ABORT))
        for cut in range(2, len(whole) - 1, 3):
            await self.silent(whole[:cut])
            await self.status()
        await self.silent(whole[:7], gap=0)
        await self.line(until=Until.NOW, act=Act.UNPLUG, gap=SHORT)
        await self.status()
        await self.line(whole[:12], Until.NOW, gap=self.lasts(5))
        await self.silent(act=Act.BREAK, clocks=self.lasts(10), gap=self.lasts(10))
        await self.status()

    async def levels(self) -> None:
        """Levels for every number of clocks, low on the idle line, and high within a frame."""
        for clocks in (1, 2, 3, 4, 5, 30, 36, 37, 40, 45):
            await self.silent(act=Act.GLITCH, clocks=clocks, gap=self.lasts(3))
            await self.status()
        for clocks in (1, 2, 4, 9):
            await self.line(
                framed(self.frame(Command.STATUS)), Until.NOW, gap=int(self.rng.integers(99, 400))
            )
            await self.line(until=Until.ANSWERED, act=Act.GLITCH, clocks=clocks)
            await self.resumed()
        await self.single()
        await self.soon()

    async def single(self) -> None:
        """Invert the line at each single clock of a byte: in the middle of a bit alone that changes it."""
        for clock in range(0, self.lasts(1), 29 if self.on_pins else 1):
            frame = framed(self.frame(Command.STATUS))
            await self.line(frame, Until.NOW, gap=self.lasts(6) + clock)
            # The rest of it, and an answer, where there is one.
            await self.line(act=Act.GLITCH, clocks=1, until=Until.NOW, gap=self.lasts(len(frame) + 80))
            self.sequence = self.env.scoreboard.reference.sequence
            await self.status()

    async def soon(self) -> None:
        """Begin a byte each number of clocks after noise, after a break, after another byte."""
        for gap in range(9):
            for act, clocks in ((Act.GLITCH, 1), (Act.BREAK, self.lasts(2))):
                await self.line(act=act, clocks=clocks, until=Until.NOW, gap=clocks + gap)
                await self.line(b"\xc0" + framed(self.frame(Command.STATUS)))
                await self.resumed()
            frame = framed(self.frame(Command.STATUS))
            for noise in (0, 1):
                await self.line(frame[:-1], Until.NOW, gap=self.lasts(len(frame) - 1) + noise)
                await self.line(act=Act.GLITCH, clocks=noise, until=Until.NOW, gap=noise + gap)
                await self.line(frame[-1:])
                await self.resumed()

    async def resumed(self) -> None:
        """Go on with the number that is due, whether or not the last frame was executed."""
        self.sequence = self.env.scoreboard.reference.sequence
        await self.silent(b"\xc0")
        await self.status()


@listed(
    "V2",
    Runs((BOARD,), 185, seeds=1, smoke=(BOARD,)),
    why_seeds=ONE_SEED,
)
class BoardRefusalsTest(BoardTest):
    """Every refusal at the ends of what is allowed: codes, payloads, and that nothing changes by it."""

    async def stimulus(self) -> None:
        """Ask for what must be refused, and for what must just not be."""
        await self.sessions()
        await self.scene(self.flat(0, 3), self.flat(5, 2))
        await self.lengths()
        await self.loads()
        await self.moves()
        await self.runs()
        if self.parameters.width % 8:
            await self.ended_late()
        await self.clear_scene()
        await self.clear_run()

    async def sessions(self) -> None:
        """Ask without a session, of no session, of another; with numbers that are not due."""
        for command in range(2, 7):
            await self.ask(command)
        for command in (Command.STATUS, Command.HELLO):
            await self.ask(command, session=0)
        self.sequence = 2**32 - 4
        await self.hello()
        for command in range(1, 7):
            await self.ask(command, session=SESSION + 1)
            await self.ask(command, session=SESSION ^ 1 << 31)
        for ahead in (2, 3, 128, 256, 257, 1 << 16, 1 << 24, 1 << 31, -1, 0):
            # 0 is the number of the last command, but of another one.
            await self.ask(Command.ABORT, ahead=ahead)
            await self.status()
        for command in (Command.LOAD, Command.RUN, Command.RESULTS):
            await self.ask(command, ahead=2)
        await self.ask(Command.HELLO, ahead=-5)
        for command in (0, 7, 8, 0x0F, 0x7F, 0x81, 0xFF):
            await self.ask(command)
        await self.status()

    async def lengths(self) -> None:
        """Ask with payloads of other lengths than there are."""
        right = {Command.HELLO: 0, Command.RUN: RUN.size, Command.RESULTS: 4, Command.STATUS: 0}
        for command, length in {**right, Command.ABORT: 0}.items():
            for wrong in sorted({0, 1, length - 1, length + 1, 100} - {length, -1}):
                await self.ask(command, bytes(wrong))
        two = load_payload(0, 0, self.flat(0, 2), self.parameters.width)
        for payload in (b"", two[:3], two[:4], two[:-1], two + b"\0", two[:3] + b"\xff" + two[4:]):
            await self.ask(Command.LOAD, payload)
        # Repeats, too, are of the right length.
        await self.status()
        await self.ask(Command.STATUS, b"\0", ahead=0)
        await self.status()

    async def loads(self) -> None:
        """Load out of place, too much, nothing, nowhere, and coordinates of one bit too many."""
        width, depth = self.parameters.width, self.parameters.depth
        low, high = coordinate_range(width)
        one = load_payload(0, 0, self.flat(), width)
        for mesh, first, count in (
            (0, 4, 1), (1, 3, 1), (0, 65535, 1), (2, 0, 1), (128, 0, 1), (255, 0, 1), (0, 0, 0),
            (1, depth, 1),
            # Of the place each bit that is wrong alone.
            *((0, 3 ^ 1 << bit, 1) for bit in range(16)),
        ):  # fmt: skip
            payload = struct.pack("<BHB", mesh, first, count) + one[4:] * count
            await self.ask(Command.LOAD, payload)
        if 235 // len(one[4:]) > MOST_TRIANGLES:
            await self.ask(
                Command.LOAD, one[:3] + bytes([MOST_TRIANGLES + 1]) + one[4:] * (MOST_TRIANGLES + 1)
            )
        ends = self.flat(0, 2)
        ends[0, 0], ends[1, 2] = (low, high, 0), (high, low, low)
        await self.load(1, ends)
        if width % 8:
            for place in range(9):
                for wrong in (low - 1, high + 1, (1 << 8 * coordinate_bytes(width) - 1) - 1):
                    bad = self.flat(1, 3)
                    bad[int(self.rng.integers(3))].reshape(-1)[place] = wrong
                    await self.ask(Command.LOAD, load_payload(0, 0, bad, width))
        await self.status()
        # A repeat of a load that was refused is refused again.
        await self.load(0, ends)
        await self.run(Mode.COUNT)
        await self.status()

    async def moves(self) -> None:
        """Run at the ends of the range, and a step beyond."""
        reach = 1 << self.parameters.width
        for place in range(3):
            for value in (reach, -reach - 1, 2**31 - 1, -(2**31)):
                if -(2**31) <= value < 2**31:
                    self.move(*np.roll([value, 0, 0], place).tolist())
                    await self.start()
            ends = np.roll([min(reach, 2**31) - 1, -min(reach, 2**31), 0], place).tolist()
            self.move(*ends)
            await self.run(Mode(place))
        # As far as 32 bits reach: without the sign it would be a step.
        below = -self.flat(0, 3)
        await self.scene(below, below)
        self.move(min(reach, 2**31) - 1)
        await self.run()
        self.move()

    async def runs(self) -> None:
        """Run in modes and with margins that there are not, of other counts, of nothing."""
        await self.scene(self.flat(0, 3), self.flat(5, 2))
        most = self.parameters.max_margin
        for mode, a, b in (
            (3, 3, 2), (4, 3, 2), (255, 3, 2), (1, 2, 2), (1, 3, 3), (1, 2, 3), (1, 3 + 256, 2),
            (1, 3, 2 + 256), (1, 0, 0),
        ):  # fmt: skip
            await self.ask(Command.RUN, RUN.pack(mode, 0, 0, 0, a, b, 0, 0, 0, 0, 0))
        for place, wide in product(range(3), (most + 1, 1 << 31)):
            margins = np.roll([wide, most, 0], place).tolist()
            await self.ask(Command.RUN, RUN.pack(1, *margins, 3, 2, 0, 0, 0, 0, 0))
        for margin in sorted({0, min(4, most), min(5, most), most}):
            await self.run(Mode.ALL, margin)
            await self.run(Mode.ALL, margin, zones=(most, most))
        # Of each bit of the number one that is set alone.
        for pairs in (99, *(1 << bit for bit in range(3, 32))):
            await self.results(pairs)
        await self.all_results()
        await self.results(7)
        await self.forgotten()
        await self.hello()
        await self.start()
        await self.load(1, self.flat())
        await self.start()
        await self.hello()
        await self.load(0, self.flat())
        await self.start()
        await self.results(1)

    async def forgotten(self) -> None:
        """Run at a pose with a margin, say HELLO: the last run, then nothing, is at that pose."""
        self.move(1, -2, 3)
        most = self.parameters.max_margin
        await self.run(Mode.COUNT, most, zones=(most, most))
        await self.status()
        self.move()
        await self.hello()
        await self.status()
        await self.scene(self.flat(0, 3), self.flat(5, 2))
        await self.run()
        await self.status()

    async def ended_late(self) -> None:
        """Load what does not fit at its end: go ends when it is refused, and nothing was loaded."""
        bad = self.flat(0, 3)
        bad[2, 2, 2] = coordinate_range(self.parameters.width)[1] + 1
        for first in (0, 1):
            await self.clear_scene()
            await self.clear_run()
            await self.ask(Command.LOAD, load_payload(0, first, bad, self.parameters.width))
            await self.status()


@listed(
    "V2",
    Runs((BOARD,), 45, seeds=1, smoke=(BOARD,)),
    why_seeds=ONE_SEED,
)
class BoardSilenceTest(BoardTest):
    """Silence just short of the watchdog's time and beyond; who repeats himself, or is refused, is silent."""

    async def stimulus(self) -> None:
        """Be silent."""
        await self.hello()
        await self.clear_scene()
        await self.clear_run()
        await self.kept_alive()
        await self.clocks(self.parameters.watchdog_clocks)
        await self.digits()
        # A run that is itself the first sign of life gives no go; the next one does.
        for mode in Mode:
            await self.start(mode)
            await self.idle()
            await self.status()
            await self.clocks(self.parameters.watchdog_clocks)
        await self.status()
        await self.clear_run()
        await self.digits()
        await self.not_executed()
        await self.clocks(self.parameters.watchdog_clocks)
        await self.alone()
        await self.others()
        await self.at_the_end()

    async def kept_alive(self) -> None:
        """Speak just in time, by every command that changes nothing."""
        for command, payload in ((Command.STATUS, b""), (Command.RESULTS, bytes(4)), (Command.STATUS, b"")):
            await self.clocks(self.parameters.watchdog_clocks - 7000)
            await self.ask(command, payload)
        # What means nothing ends nothing.
        await self.silent(b"\xc0\xc0")
        await self.silent(act=Act.GLITCH, clocks=1)

    async def not_executed(self) -> None:
        """Send again and again what is not executed."""
        old = framed(self.frame(Command.STATUS, ahead=0))
        for frame in (old, framed(self.frame(Command.STATUS, ahead=7)), framed(self.frame(0x30))):
            await self.clear_run()
            for _ in range(3):
                await self.clocks(self.parameters.watchdog_clocks // 2)
                await self.line(frame)
            await self.status()

    async def alone(self) -> None:
        """Take the board and say no more: that was the one sign of life."""
        self.session += 1
        await self.hello()
        await self.clocks(self.parameters.watchdog_clocks)
        self.session -= 1
        await self.hello()
        await self.clear_scene()
        await self.clear_run()

    async def at_the_end(self) -> None:
        """Let another master try, and ask for a run, at each clock around the end of the watchdog's time."""
        reference = self.env.scoreboard.reference
        await self.hello()
        for command in (Command.HELLO, Command.RUN):
            # The clocks from the last sign of life to this one, but for those of the gap before it.
            usual = 0
            for number in range(11):
                await self.clear_scene()
                await self.status()
                if command == Command.HELLO:
                    self.session ^= 1
                kicked = reference.kicked
                frame = framed(self.frame(command, self.asked() if command == Command.RUN else b""))
                # An answer or a frame with stuffed bytes takes longer than another.
                spoken = reference.clock - kicked + self.lasts(len(frame))
                wait = (
                    self.parameters.watchdog_clocks - 6 + number - spoken - usual
                    if number
                    else self.lasts(60)
                )
                await self.line(frame[:-1], Until.NOW, gap=wait)
                await self.line(frame[-1:], gap=SHORT)
                usual = reference.arrived + EXECUTED - kicked - spoken - wait
                await self.idle()
                self.session, self.sequence = reference.session, reference.sequence
                await self.status()

    async def others(self) -> None:
        """Let another master try, while the board has one and when it has none."""
        master, self.session = self.session, 99
        kept, self.sequence = self.sequence, 0x01020304
        await self.hello()
        await self.clocks(self.parameters.watchdog_clocks)
        # HELLO alone is one sign of life, and the same number from another master is no repeat of it.
        self.session, self.sequence = master, kept
        await self.hello()
        await self.clocks(self.parameters.watchdog_clocks)
        self.session = 99
        await self.ask(Command.HELLO, ahead=0)
        await self.status()
        await self.clocks(self.parameters.watchdog_clocks)
        self.session, self.sequence = 98, 0
        # Dead, and yet of the right length.
        await self.ask(Command.HELLO, b"\0")
        await self.hello()
        await self.status()
        self.session = master
        await self.ask(Command.STATUS)
        self.session = 98
        await self.clear_scene()
        await self.clear_run()
        self.session, self.sequence = master, kept
        await self.clocks(self.parameters.watchdog_clocks)
        await self.line(act=Act.RESET, clocks=5, until=Until.NOW, gap=SHORT)
