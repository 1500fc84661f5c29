"""The board's tests by name. Each says what comes over the line; the environment checks everything."""

import struct
from collections.abc import Awaitable, Callable
from itertools import product

import numpy as np

from triaxis.golden.pairs import coordinate_range
from triaxis.sim.mesh_engine import NO_ZONES, Trial
from triaxis.verif.board.base_test import SESSION, BoardTest
from triaxis.verif.board.line_agent import Act, Until
from triaxis.verif.board.protocol import (
    HEAD,
    LONGEST,
    MOST_TRIANGLES,
    RING,
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
from triaxis.verif.mesh.items import WHICHES
from triaxis.verif.testbench.table import Runs, listed

# Coordinates with bits above them in their bytes, and more near pairs than the displays can show.
BOARD = "board_w12_m5_d128_g8_l4"
# The same, with a core that shows no "clear" again.
PLAIN = "board_w12_m5_d128_g8_l4_plain"
# The sizes that ship, as `fpga.board_build.SIGNED_OFF` has them, with the environment's short times, and the
# top's own: then a byte takes 83 clocks, and the watchdog ten million.
SHIPPED, REAL = "board_w16_m16_d4096_g8_l8", "board_w16_m16_d4096_g8_l8_real"

_SHORT = 200
_ONE_SEED = "One: what it sends is the same with every seed, but for places and moments."


@listed(
    "V1",
    Runs((BOARD, SHIPPED, REAL), 20, seeds=1, smoke=(BOARD, SHIPPED, REAL)),
    why_seeds=_ONE_SEED,
)
class BoardSmokeTest(BoardTest):
    """Sessions from HELLO to go, each command once and once again; what the displays say; silence."""

    async def stimulus(self) -> None:
        """Do the usual things."""
        await self.digits()
        await self.hello()
        await self.again(Command.HELLO)
        await self.scene(self.flat(), self.flat(5))
        self.move(1, -2, 3)
        for mode in Mode:
            payload = self.asked(mode)
            await self.start(mode)
            await self.again(Command.RUN, payload)
            await self.idle()
            await self.status()
            await self.digits()
        await self.again(Command.STATUS)
        await self.results(0)
        await self.again(Command.RESULTS, bytes(4))
        self.move(0, 0, 5)
        payload = self.asked()
        await self.start()
        await self.idle()
        await self.again(Command.RUN, payload)
        await self.status()
        await self.digits()
        await self.all_results()
        await self.again(Command.RESULTS, struct.pack("<I", 1))
        self.move(0, 0, 2)
        for zones in ((1, 4), (2, 3), (4, 1), (0, 4)):
            slow, warn = (min(zone, self.parameters.max_margin) for zone in zones)
            await self.run(Mode.COUNT, zones=(slow, warn))
        await self.ask(Command.ABORT)
        await self.again(Command.ABORT)
        await self.load(0, self.flat(0, 2))
        width = self.parameters.width
        await self.again(Command.LOAD, load_payload(0, 0, self.flat(0, 2), width))
        await self.ask(Command.LOAD, load_payload(0, 2, self.flat(9), width))
        await self.run()
        await self.hello()
        await self.status()
        await self.clear_scene()
        await self.clear_run()
        for kind in (Trial.WALK, Trial.BOARD):
            await self.run(Mode.ALL, 0, (kind, WHICHES - 1))
            await self.digits()
            await self.run()
            await self.hello()
            await self.clear_scene()
        await self.clear_run()
        await self.clocks(self.parameters.watchdog_clocks)
        await self.digits()


@listed(
    "V1",
    Runs((BOARD,), 180, seeds=3, smoke=(BOARD,)),
    Runs((SHIPPED,), 90, seeds=1, smoke=(SHIPPED,)),
    why_seeds="Three: it takes other moments of a run with each.",
)
class BoardGoTest(BoardTest):
    """Everything that ends go, while it is said and while a run goes on; a later clear run brings it back."""

    async def stimulus(self) -> None:
        """End go in every way."""
        await self.hello()
        for _, end in sorted(self.ends.items()):
            await self.needed(1)
            self.move(0, 0, int(self.rng.choice([0, 40])))
            await self.run(zones=self.some_zones(0))
            await end()
            await self.status()
            await self.digits()
            await self.results(0)
        await self.in_runs()

    async def in_runs(self, hold: int = 0) -> None:
        """Begin a clear run that takes some time, while go is said if it holds, and have it spoiled."""
        count = min(64, self.parameters.depth)
        for name, end in sorted(self.ends.items()):
            if name in ("load", "silence", "trial"):
                continue
            await self.needed(count)
            if hold:
                await self.start(hold=hold)
                await self.idle()
            await self.line(framed(self.frame(Command.RUN, self.asked(hold=hold))), Until.SENT)
            self.sequence += 1
            await self.line(until=Until.ANSWERED, gap=int(self.rng.integers(1, 400)))
            await end()
            await self.idle()
            await self.status()

    async def needed(self, count: int) -> None:
        """Load a clear scene of so many triangles, where it is not there any more."""
        a, b = self.env.scoreboard.reference.meshes
        self.move()
        if (len(a), len(b)) != (count, count):
            await self.scene(self.flat(0, count), self.corners(count))

    @property
    def ends(self) -> dict[str, Callable[[], Awaitable[object]]]:
        """Return them by name."""
        line, ask = self.silent, self.ask
        return {
            "load": lambda: self.load(0, self.flat()),
            "abort": lambda: ask(Command.ABORT),
            "hello": self.hello,
            "reset": self.pressed,
            "bad CRC": lambda: line(
                b"\xc0" + stuffed(b"\1" + checked(self.frame(Command.STATUS))[1:]) + b"\xc0"
            ),
            "bad stuffing": lambda: line(b"\xc0\x06\xdb\x06\xc0"),
            "stuffing at the end": lambda: line(b"\xc0\x06\xdb\xc0"),
            "too short": lambda: line(b"\xc0\x06\xc0"),
            "too long": lambda: line(b"\xc0" + bytes(LONGEST + 1) + b"\xc0"),
            "break": lambda: line(act=Act.BREAK, clocks=100),
            "noise": self.noise,
            "too early": self.too_early,
            "unknown": lambda: ask(0x20),
            "length": lambda: ask(Command.STATUS, b"\0"),
            "session": lambda: ask(Command.STATUS, session=1),
            "sequence": lambda: ask(Command.STATUS, ahead=2),
            "value": lambda: ask(Command.RUN, RUN.pack(3, 0, 0, 0, 1, 1, 0, 0, 0, 0, 0)),
            "counts": lambda: ask(Command.RUN, RUN.pack(0, 0, 0, 0, 9, 9, 0, 0, 0, 0, 0)),
            "place": lambda: ask(Command.LOAD, load_payload(0, 99, self.flat(), self.parameters.width)),
            "silence": lambda: self.clocks(self.parameters.watchdog_clocks),
            "trial": self.trial,
        }

    async def trial(self) -> None:
        """Have a check fail: no run gives go, until HELLO."""
        kind = self.rng.choice([Trial.WALK, Trial.INTAKE, Trial.BOARD])
        await self.run(Mode.ALL, 0, (int(kind), int(self.rng.integers(WHICHES))))
        await self.clear_run()
        await self.digits()
        await self.hello()

    async def pressed(self) -> None:
        """Press the button; take the board again."""
        await self.line(act=Act.RESET, clocks=int(self.rng.integers(1, 9)), until=Until.NOW)
        await self.hello()

    async def noise(self) -> None:
        """Have a level on the line long enough for a start bit; the frame after it ends what begins so."""
        await self.silent(act=Act.GLITCH, clocks=-(-self.parameters.clocks_per_three_bits // 3))
        await self.status()


@listed(
    "V1",
    Runs((BOARD,), 300, seeds=3, smoke=(BOARD,)),
    Runs((SHIPPED,), 150, seeds=1, smoke=(SHIPPED,)),
    why_seeds="Three: it takes other poses, holds and moments with each.",
)
class BoardHoldTest(BoardGoTest):
    """A machine that moves while its next segment is checked: go stays to a deadline, and ends as it must."""

    async def stimulus(self) -> None:
        """Have segments follow one another, and break them off in every way."""
        await self.hello()
        await self.needed(1)
        while self.unfinished:
            await self.followed()
            await self.broken_off()
            await self.late()
            await self.zoned()
        await self.at_the_deadline()
        await self.in_runs(hold=60)

    async def followed(self) -> None:
        """Go on without a stop, at any clear pose; once without a hold between, or with the longest."""
        await self.needed(1)
        for number in range(12):
            self.move(*self.rng.integers(20, 200, 3).tolist())
            if number == 6:
                await self.start(hold=int(self.rng.choice([0, 0xFFFF])))
                await self.idle()
            hold, zones = int(self.rng.integers(8, 30)), self.some_zones(0)
            await self.start(int(self.rng.integers(3)), hold=hold, zones=zones)
            await self.idle()
            if self.rng.integers(2):
                await self.status()

    async def broken_off(self) -> None:
        """Have a segment that is near, in each mode, or out of range; the next begins anew."""
        far = (1 << min(self.parameters.width, 31)) - 1
        for mode in Mode:
            for pose in ((0, 0, 0), (-4, -4, 0), (far, 0, 0)):
                await self.needed(1)
                await self.start(hold=40)
                await self.idle()
                self.move(*pose)
                await self.start(mode, self.parameters.max_margin, hold=40)
                await self.idle()
                await self.status()
                await self.all_results()

    async def late(self) -> None:
        """Let the deadline pass, at rest and in a run that takes longer; any hold that there is."""
        for hold in (1, 2, 5):
            await self.needed(1)
            await self.start(hold=hold)
            await self.idle()
            await self.clocks(hold * self.parameters.hold_clocks + 99)
            await self.status()
        count = min(64, self.parameters.depth)
        await self.needed(count)
        for hold in (3, 40):
            for _ in range(2):
                await self.start(hold=hold)
                await self.idle()
            await self.status()
        # Of go that has ended otherwise it is none: what goes on meanwhile is not late.
        for hold in range(8, 14):
            await self.run(hold=hold)
            await self.ask(Command.ABORT)
            await self.run(hold=40)

    async def zoned(self) -> None:
        """Be in each zone that is asked for; have segments go from each into each, and go end in each."""
        await self.clear_scene()
        # 5 apart where the pose is 0, and further at -6 and -20.
        for pose, zones in product((-20, -6, 0, 5), (NO_ZONES, (16, 0), (0, 16), (8, 16))):
            self.move(0, 0, pose)
            await self.run(Mode.COUNT, zones=zones)
        # Beyond both zones, beyond either, beyond none.
        places = ((-20, (8, 16)), (-6, (8, 16)), (-20, (0, 16)), (0, (8, 16)))
        for last, then in product(places, places):
            # The first does not hold: it ends go that is said.
            for (pose, zones), hold in ((last, 0), (then, 40)):
                self.move(0, 0, pose)
                await self.start(int(self.rng.integers(3)), hold=hold, zones=zones)
                await self.idle()
                await self.status()

    async def at_the_deadline(self) -> None:
        """Have a segment end at each clock around the deadline of the one before."""
        reference, hold, wait = self.env.scoreboard.reference, 13, 0
        await self.needed(min(64, self.parameters.depth))
        for number in range(9):
            await self.run(hold=hold)
            due = reference.run.ended + hold * self.parameters.hold_clocks
            frame = framed(self.frame(Command.RUN, self.asked(hold=hold)))
            await self.line(frame[:-1], Until.NOW, gap=self.lasts(60) + wait)
            await self.line(frame[-1:], gap=_SHORT)
            await self.idle()
            self.sequence = reference.sequence
            await self.status()
            after = reference.run.ended - due
            wait += 1 if number else -3 - after


@listed(
    "V2",
    Runs((BOARD,), 45, seeds=1, smoke=(BOARD,)),
    why_seeds=_ONE_SEED,
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
        await self.line(until=Until.NOW, act=Act.UNPLUG, gap=_SHORT)
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
    why_seeds=_ONE_SEED,
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
    why_seeds=_ONE_SEED,
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
                await self.line(frame[-1:], gap=_SHORT)
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
        await self.line(act=Act.RESET, clocks=5, until=Until.NOW, gap=_SHORT)


@listed(
    "V2",
    Runs((BOARD,), 100, seeds=3, smoke=(BOARD,)),
    why_seeds="Three: each takes other scenes and clocks.",
)
class BoardAbortTest(BoardTest):
    """ABORT and HELLO at clocks all over runs, also of ones that wait; the next run is whole."""

    async def stimulus(self) -> None:
        """Abort runs."""
        await self.hello()
        await self.ask(Command.ABORT)
        count = 56
        await self.scene(self.flat(0, count), self.corners(count))
        for command in (Command.ABORT, Command.ABORT, Command.HELLO):
            for _ in range(6):
                mode, wait = Mode(int(self.rng.integers(3))), int(self.rng.integers(2800))
                await self.ended_by(command, mode, wait, self.some_zones(0))
                if command == Command.HELLO:
                    await self.status()
                    await self.scene(self.flat(0, count), self.corners(count))
        await self.at_the_end(Command.ABORT)
        await self.at_the_end(Command.RUN)
        await self.clear_run()
        await self.scene(self.cloud(count, 20), self.cloud(count, 20))
        for _ in range(4):
            await self.ended_by(Command.ABORT, Mode.ALL, int(self.rng.integers(1300)), self.some_zones(0))
            await self.results(0)
        await self.run(Mode.ALL)
        await self.all_results()

    async def at_the_end(self, command: int) -> None:
        """Ask for what ends a clear run, or would disturb it, at each clock around its end."""
        await self.scene(self.flat(0, 64), self.corners(64))
        reference, wait = self.env.scoreboard.reference, 0
        for number in range(13):
            self.move()
            await self.clear_run()
            length = reference.run.ended - reference.run.start
            after = await self.ended_by(command, Mode.COUNT, wait)
            # How long after its run's beginning the first came says how long the others wait for the end.
            wait += 1 if number else length - 6 - after

    async def ended_by(self, command: int, mode: int, wait: int, zones: tuple[int, int] = NO_ZONES) -> int:
        """Begin a run and end it some time later; return how many clocks after its beginning."""
        payload = self.asked() if command == Command.RUN else b""
        ended = framed(self.frame(command, payload, ahead=2))
        frame = framed(self.frame(Command.RUN, self.asked(mode, zones=zones)))
        # The last byte of the one and the whole other come while the run goes on; the other's end at a clock
        # that does not depend on how many of its bytes are escaped.
        longest = self.lasts(22 + len(payload))
        await self.line(frame[:-1], Until.SENT)
        await self.line(frame[-1:] + ended[:-1], Until.NOW, gap=longest + wait)
        await self.line(ended[-1:], gap=_SHORT)
        await self.line(gap=_SHORT)
        await self.idle()
        reference = self.env.scoreboard.reference
        after = reference.arrived + EXECUTED - reference.run.start
        self.sequence = reference.sequence
        await self.status()
        return after


@listed(
    "V2",
    Runs((BOARD,), 60, seeds=1, smoke=(BOARD,)),
    why_seeds=_ONE_SEED,
)
class BoardFullTest(BoardTest):
    """Full meshes, a full ring that makes the engine wait and loses nothing, more pairs than are shown."""

    async def stimulus(self) -> None:
        """Fill everything."""
        depth = self.parameters.depth
        await self.hello()
        await self.scene(self.flat(0, depth), self.flat(0, depth))
        for first in (depth, 0):
            await self.ask(Command.LOAD, load_payload(0, first, self.flat(), self.parameters.width))
        await self.load(0, self.flat(0, depth))
        await self.run(Mode.COUNT)
        await self.digits()
        await self.run(Mode.FIRST)
        await self.all_results()
        payload = self.asked()
        await self.start(Mode.ALL)
        await self.clocks(8000)
        await self.again(Command.RUN, payload)
        await self.busy()
        await self.read_again()
        await self.ask(Command.ABORT)
        await self.results(8 + 16)
        # Silence while a run waits, which could have ended well.
        await self.start(Mode.ALL)
        await self.clocks(self.parameters.watchdog_clocks)
        await self.status()
        await self.ask(Command.ABORT)
        await self.start(Mode.ALL)
        await self.clocks(8000)
        await self.hello()
        await self.status()
        await self.just_full()
        await self.numbers()
        await self.meanwhile()
        await self.every_pair()
        await self.counts()
        await self.longest()
        await self.errors()
        await self.often()

    async def every_pair(self) -> None:
        """Take near pairs from all over the longest list that there is, and pass over the others."""
        depth = self.parameters.depth
        self.move()
        await self.scene(self.flat(0, depth), self.flat(0, depth))
        await self.start(Mode.ALL)
        for first in range(RING, depth * depth + 1, RING):
            # Until the ring is full again.
            await self.clocks(2 * RING)
            if first % (2 * RING):
                await self.results(first - depth // 4)
            await self.results(first)
        await self.idle()
        await self.status()
        # Another of about as many clocks, most of which it waits: ones where the other's number has zeros.
        await self.start(Mode.ALL)
        await self.clocks(0x58000)
        await self.ask(Command.ABORT)

    async def counts(self) -> None:
        """Count powers of two: groups that are skipped, pairs that are, near ones."""
        depth = self.parameters.depth
        await self.load(1, self.flat(100, depth))
        await self.clear_run()
        await self.scene(self.comb(depth, 0), self.comb(depth, 4))
        for mesh, count in ((1, depth), (0, depth // 2), (1, depth // 2), (0, depth // 4), (1, depth // 4)):
            await self.load(mesh, self.comb(count, 4 * mesh))
            await self.clear_run()
        for count_a, count_b in ((depth // 2, depth), (depth // 4, depth), (depth // 4, depth // 2)):
            await self.scene(self.flat(0, count_a), self.flat(100, count_b))
            await self.clear_run()
        await self.load(1, self.flat(100, depth // 4))
        await self.clear_run()
        await self.scene(self.flat(0, depth // 2), self.flat(0, depth // 2))
        await self.run(Mode.COUNT)
        await self.digits()

    async def longest(self) -> None:
        """Send frames as long as there are, of all ones and zeros and of any bytes, with unknown commands."""
        size = LONGEST - HEAD.size - 4
        for payload in (bytes(size), b"\xff" * size, bytes(size), *(self.rng.bytes(size) for _ in range(20))):
            await self.ask(int(self.rng.integers(8, 256)), payload)

    async def often(self) -> None:
        """Run more often than half of what the number of a run can show; then be some other hosts."""
        await self.scene(self.flat(), self.flat())
        await self.run(Mode.ALL)
        await self.all_results()
        for _ in range(130):
            await self.start(Mode.COUNT)
            await self.idle()
        await self.status()
        for session in (2**32 - 1, *self.rng.integers(1, 2**32, 4).tolist()):
            await self.line(act=Act.RESET, clocks=3, until=Until.NOW)
            self.session = session
            await self.hello()
            await self.status()

    async def errors(self) -> None:
        """Begin and end frames of a byte each, which are too short."""
        await self.silent(b"\xc0" + b"\x41\xc0" * 4200)
        await self.status()

    async def busy(self) -> None:
        """Ask for what would disturb a run that goes on."""
        await self.load(0, self.flat())
        self.move(1, 1, 1)
        await self.start()
        await self.status()
        await self.again(Command.STATUS)
        await self.digits()
        await self.silent(b"\xc0" + bytes(LONGEST + 1) + b"\xc0")

    async def read_again(self) -> None:
        """Read near pairs again while the run goes on, and free some."""
        for first in (0, 0, 7, 8):
            await self.results(first)
        await self.again(Command.RESULTS, struct.pack("<I", 8))
        await self.results(7)
        await self.results(8 + 16)

    async def just_full(self) -> None:
        """As many near pairs as the ring holds."""
        side = int(RING**0.5)
        await self.scene(self.flat(0, side), self.flat(0, side))
        await self.run(Mode.ALL)
        await self.digits()
        await self.all_results()
        await self.results(RING + 1)
        await self.run(Mode.ALL)
        await self.run(Mode.FIRST)
        await self.all_results()

    async def meanwhile(self) -> None:
        """Ask for near pairs while a long run goes on that has none, and while one goes on that has a few."""
        self.move()
        between = np.tile(np.array([[10, 3, 0], [3, 10, 0], [9, 5, 0]], np.int64), (63, 1, 1))
        for a, b in (
            (self.flat(0, 64), self.corners(64)),
            (self.flat(0, 64), np.concatenate([self.corners(63), self.flat(0)])),
            (np.concatenate([self.flat(0, 9), self.corners(55)]), np.concatenate([self.flat(), between])),
        ):
            await self.scene(a, b)
            await self.start(Mode.ALL)
            await self.all_results()

    async def numbers(self) -> None:
        """Show numbers with all digits, and count more than fit into them."""
        for count_a, count_b in (
            (7, 11),
            (31, 7),
            (31, 29),
            (5, 113),
            (97, 26),
            (98, 86),
            (99, 101),
            (100, 100),
        ):
            await self.scene(self.flat(0, count_a), self.flat(0, count_b))
            await self.run(Mode.COUNT)
            await self.digits()
        self.move(0, 0, 9)
        await self.clear_run()
        await self.digits()


@listed(
    "V2",
    Runs((BOARD,), 900, seeds=3, smoke=(BOARD,)),
    Runs((PLAIN,), 900, seeds=1, smoke=(PLAIN,)),
    Runs((SHIPPED,), 900, seeds=1),
    why_seeds="Three: each takes other modes, scenes and moments.",
)
class BoardTrialsTest(BoardTest):
    """Every check is tried: each kind, and which; its fault ends the run, stands until HELLO, gives no go."""

    async def stimulus(self) -> None:
        """Try them, and what comes while a fault stands."""
        await self.hello()
        for kind in Trial:
            for which in range(WHICHES):
                await self.tried((kind, which))
        await self.unused()
        await self.modes()
        await self.stands()
        await self.hidden()
        await self.ended()
        await self.begun_again()
        await self.clear_run()

    async def needed(self) -> None:
        """Begin again where a fault stands; have a clear pair that boxes do not decide."""
        reference = self.env.scoreboard.reference
        if reference.fault:
            await self.hello()
        if not all(map(len, reference.meshes)):
            await self.scene(self.flat(), self.corners(1))

    async def tried(self, tries: tuple[int, int], mode: int = Mode.ALL) -> None:
        """Try a check; where it fails, often run again."""
        await self.needed()
        await self.run(mode, 0, tries, zones=self.some_zones(0, tries[0]))
        if self.env.scoreboard.reference.fault and not self.rng.integers(8):
            await self.clear_run()
            await self.digits()

    async def unused(self) -> None:
        """Take words as broken that no run looks at: of groups, and of boxes, where others decide."""
        far = self.flat(99), self.flat(99, 2)
        # Boxes of groups that overlap, of triangles that do not.
        crossed = np.concatenate([self.flat(0), self.flat(40)]), self.flat(20)
        for a, b in (far, crossed):
            for which in (*range(6), WHICHES - 1):
                await self.hello()
                await self.scene(a, b)
                self.move(0, 0, -1)
                await self.run(Mode(int(self.rng.integers(3))), 0, (Trial.MEMORY, which))

    async def modes(self) -> None:
        """Try checks in runs that stop at a near pair, or cannot be: first it is near, then it may be."""
        count = min(12, self.parameters.depth)
        for _ in range(6):
            for kind in list(Trial)[1:]:
                await self.hello()
                await self.scene(self.cloud(count, 30), self.cloud(count, 30))
                await self.run(Mode.FIRST, 0, (kind, int(self.rng.integers(6))))
                await self.all_results()
        await self.hello()
        for kind in list(Trial)[1:]:
            await self.needed()
            self.move(0, 0, (1 << min(self.parameters.width, 31)) - 1)
            await self.run(Mode.COUNT, 0, (kind, 1))
            self.move()

    async def stands(self) -> None:
        """Have a fault outlast runs, refusals, silence, ABORT; any HELLO ends it, and so does the button."""
        for end in (self.hello, self.another, self.pressed):
            await self.needed()
            await self.run(Mode.COUNT, 0, (Trial.WALK, 3))
            await self.ask(Command.ABORT)
            await self.ask(0x20)
            await self.digits()
            for mode in Mode:
                await self.run(mode)
            await self.silent(b"\xc0\x06\xc0")
            await self.clocks(self.parameters.watchdog_clocks)
            await self.digits()
            await self.status()
            await self.run()
            await end()
            await self.status()
            await self.digits()
            await self.needed()
            # The first after silence is no more than a sign of life.
            for _ in range(2):
                await self.clear_run()

    async def another(self) -> None:
        """Be another host, after silence."""
        await self.clocks(self.parameters.watchdog_clocks)
        self.session ^= 1
        await self.hello()

    async def pressed(self) -> None:
        """Press the button; take the board again."""
        await self.line(act=Act.RESET, clocks=3, until=Until.NOW, gap=_SHORT)
        await self.hello()

    async def hidden(self) -> None:
        """Have something go wrong on the line in a run whose checks fail, or may."""
        count = min(56, self.parameters.depth)
        for kind in list(Trial)[1:]:
            for mode in (Mode.ALL, Mode.FIRST):
                await self.hello()
                await self.scene(self.flat(0, count), self.corners(count))
                await self.start(mode, 0, (kind, 4))
                await self.silent(b"\xc0\x06\xc0")
                await self.idle()
                await self.status()
                await self.run(Mode.COUNT)

    async def ended(self) -> None:
        """End runs whose checks fail, or may, by ABORT and by HELLO: not the end of what goes on failing."""
        count = min(56, self.parameters.depth)
        for kind in list(Trial)[1:]:
            for command in (Command.ABORT, Command.HELLO, Command.HELLO):
                await self.hello()
                await self.scene(self.flat(0, count), self.corners(count))
                frame = framed(self.frame(Command.RUN, self.asked(Mode.ALL, 0, (kind, 4))))
                ending = framed(self.frame(command, ahead=2))
                if self.rng.integers(2):
                    # It waits for the reply to the other.
                    await self.line(frame + ending)
                else:
                    await self.line(frame)
                    await self.line(ending, Until.NOW, gap=self.lasts(len(ending)))
                await self.line()
                self.sequence = self.env.scoreboard.reference.sequence
                await self.status()
                await self.needed()
                await self.run()
        await self.hello()

    async def begun_again(self) -> None:
        """Find the first run after HELLO as ever."""
        await self.scene(self.flat(0, 3), self.flat(0, 2))
        await self.run()
        await self.all_results()
        await self.scene(self.flat(0, 3), self.corners(2))
        await self.status()


@listed(
    "V2",
    Runs((BOARD, SHIPPED), 20, seeds=1, smoke=(SHIPPED,)),
    why_seeds=_ONE_SEED,
)
class BoardDepthTest(BoardTest):
    """Each mesh with all the triangles that there is place for, of which the last alone is near the other."""

    async def stimulus(self) -> None:
        """Fill one mesh, then the other."""
        await self.hello()
        low, high = coordinate_range(self.parameters.width)
        corner = np.array([[[low, low, high], [low + 9, low, high], [low, low + 9, high]]], np.int64)
        for mesh in (0, 1):
            await self.load(1 - mesh, corner)
            await self.load(mesh, self.flat(0, self.parameters.depth - 1))
            await self.clear_run()
            # The last place; then there is none.
            for first in (self.parameters.depth - 1, self.parameters.depth):
                await self.ask(Command.LOAD, load_payload(mesh, first, corner, self.parameters.width))
            await self.run()
            await self.all_results()
            await self.digits()


@listed(
    "V2",
    Runs((BOARD,), 60, seeds=3, smoke=(BOARD,)),
    why_seeds="Three: each takes other moments.",
)
class BoardResetsTest(BoardTest):
    """The reset button at any moment: of a frame, a load, a run, a reply, and of go."""

    async def stimulus(self) -> None:
        """Press it; on the pins, where a clock is dear, at few of the moments."""
        self.stride = 29 if self.on_pins else 1
        while self.unfinished:
            await self.hello()
            await self.scene(self.flat(0, 4), self.flat(5, 4))
            await self.clear_run()
            kind = int(self.rng.integers(4))
            if kind == 0:
                frame = framed(self.frame(Command.RUN, self.asked()))
            elif kind == 1:
                frame = framed(
                    self.frame(Command.LOAD, load_payload(0, 0, self.flat(), self.parameters.width))
                )
            else:
                frame = framed(self.frame(Command.STATUS)) if kind == 2 else b""
            await self.line(frame, Until.NOW, gap=int(self.rng.integers(1, 40 * len(frame) + 600)))
            await self.line(act=Act.RESET, clocks=int(self.rng.integers(1, 6)), until=Until.NOW, gap=_SHORT)
            # What was queued is what it is: the rest of a frame.
            await self.silent(b"\xc0", gap=6000)
            # The board is nobody's.
            for session in (self.session, 0xFFFFFFFF):
                await self.ask(Command.STATUS, session=session)
            self.sequence = int(self.rng.integers(2**32))
        await self.at_each_clock()
        await self.executing()
        await self.shown()

    async def executing(self) -> None:
        """Press it at the clocks in which commands are executed, after a run of which nothing is 0."""
        width = self.parameters.width
        for command, clocks in (
            (Command.LOAD, range(0, 130, 2)), (Command.RUN, range(110)), (Command.HELLO, range(0, 50, 2)),
            (Command.ABORT, range(48, 88, 12)),
        ):  # fmt: skip
            # What is cut off goes on for some time.
            going = command == Command.ABORT
            count = min(64, self.parameters.depth) if going else 2
            for clock in clocks[:: self.stride]:
                await self.hello()
                self.move(3, 2, 1)
                await self.scene(self.flat(0, count), self.corners(count) if going else self.flat(9, count))
                most = self.parameters.max_margin
                await self.start(Mode.COUNT, most & 3, (0, 9), 9, (most // 2, most))
                if not going:
                    await self.idle()
                payload = {
                    Command.LOAD: load_payload(0, 0, self.flat(0, 2), width),
                    Command.RUN: self.asked(),
                }.get(command, b"")
                frame = framed(self.frame(command, payload))
                await self.line(frame, Until.NOW, gap=self.lasts(len(frame)) + clock)
                await self.line(act=Act.UNPLUG, until=Until.NOW)
                await self.line(act=Act.RESET, clocks=2, until=Until.NOW, gap=self.lasts(1))

    async def shown(self) -> None:
        """Press it while near pairs are shown, some of them freed, in a frame too long, and after a fault."""
        await self.hello()
        await self.scene(self.flat(0, 3), self.flat(0, 3))
        await self.run()
        await self.results(4)
        await self.digits()
        await self.line(act=Act.RESET, clocks=3, until=Until.NOW, gap=_SHORT)
        await self.digits()
        await self.line(b"\xc0" + bytes(LONGEST + 9), gap=_SHORT)
        await self.line(act=Act.RESET, clocks=3, until=Until.NOW, gap=_SHORT)
        await self.hello()
        await self.scene(self.flat(0, 3), self.flat(9, 3))
        await self.start(tries=(Trial.BOARD, 3))
        await self.idle()
        await self.digits()
        await self.line(act=Act.RESET, clocks=3, until=Until.NOW, gap=_SHORT)
        await self.digits()
        await self.hello()

    async def at_each_clock(self) -> None:
        """Press it at each clock of a byte: of a frame, of what is wrong with one, before and in a reply."""
        # Of no session: refused.
        status = framed(self.frame(Command.STATUS))
        whole, byte = self.lasts(len(status)), self.lasts(1) + 5
        for data, first, clocks in (
            (status[:5], self.lasts(1), byte), (b"\xc0\xdb\x01", self.lasts(3) - 5, byte),
            (status, whole - 5, byte), (status, whole + self.lasts(10), byte),
        ):  # fmt: skip
            for clock in range(first, first + clocks, self.stride):
                await self.line(data, Until.NOW, gap=clock)
                await self.line(act=Act.UNPLUG, until=Until.NOW)
                await self.line(act=Act.RESET, clocks=2, until=Until.NOW, gap=self.lasts(1))
                await self.ask(Command.STATUS)


@listed(
    "V1",
    Runs((BOARD,), 400, seeds=8, smoke=(BOARD,)),
    Runs((SHIPPED,), 150, seeds=1, smoke=(SHIPPED,)),
    why_seeds="Eight: each is another talk.",
)
class BoardMixedTest(BoardTest):
    """A host that does anything in any order: scenes, runs, repeats, refusals, damage, silence, resets."""

    async def stimulus(self) -> None:
        """Go on until enough was answered."""
        await self.hello()
        while self.unfinished:
            await self.some_scene()
            for _ in range(int(self.rng.integers(1, 8))):
                kinds = (
                    self.some_run, self.some_run, self.some_talk, self.some_damage, self.some_move,
                    self.some_trial,
                )  # fmt: skip
                await kinds[int(self.rng.integers(len(kinds)))]()
            if not self.rng.integers(6):
                await self.clocks(self.parameters.watchdog_clocks + int(self.rng.integers(-3000, 3000)))
            if not self.rng.integers(8):
                await self.pressed()
        await self.pressed()
        await self.status()

    async def pressed(self) -> None:
        """Press the button; take the board again."""
        await self.line(act=Act.RESET, clocks=int(self.rng.integers(1, 9)), until=Until.NOW)
        await self.hello()

    async def some_scene(self) -> None:
        """Load one or both meshes."""
        # No corner of `cloud` beyond the range, however few bits it has.
        most = 3 * coordinate_range(self.parameters.width)[1] // 4
        spread = min(int(self.rng.choice([10, 100, 2 * most // 5])), most)
        counts = self.rng.integers(1, min(20, self.parameters.depth), 2).tolist()
        for mesh in (0, 1):
            await self.load(mesh, self.cloud(counts[mesh], spread))

    async def some_run(self) -> None:
        """Run in some mode at some margins, at times one that is too wide, and read what is near."""
        most = self.parameters.max_margin
        margin, hold = int(self.rng.choice([0, 0, most])), int(self.rng.choice([0, 0, 1, 9, 60]))
        margins = [margin, *self.some_zones(margin)]
        if not self.rng.integers(8):
            margins[int(self.rng.integers(3))] = int(self.rng.integers(most + 1, 2**32))
        await self.start(int(self.rng.integers(3)), margins[0], hold=hold, zones=(margins[1], margins[2]))
        if self.rng.integers(2):
            await self.idle()
        await self.all_results()
        await self.status()

    async def some_trial(self) -> None:
        """Try a check in a run of some mode; mostly be told of what has failed, and begin again."""
        kind, which = int(self.rng.integers(1, len(Trial))), int(self.rng.choice([0, 1, 2, 4, 31]))
        mode, zones = int(self.rng.integers(3)), self.some_zones(0, kind)
        await self.start(mode, 0, (kind, which), zones=zones)
        if self.rng.integers(2):
            await self.idle()
        await self.all_results()
        await self.status()
        if self.rng.integers(4):
            await self.hello()
            await self.some_scene()

    async def some_move(self) -> None:
        """Run far away, or near."""
        reach = int(self.rng.choice([20, 700, 1 << self.parameters.width - 1]))
        self.move(*self.rng.integers(-reach, reach, 3).tolist())
        await self.run(zones=self.some_zones(0))

    async def some_talk(self) -> None:
        """Send what changes nothing, twice, or at another number."""
        await self.ask(Command.STATUS, gap=int(self.rng.integers(1, 900)))
        await self.again(Command.STATUS)
        if not self.rng.integers(3):
            await self.ask(int(self.rng.integers(9)), ahead=int(self.rng.integers(-1, 3)))
            self.sequence = self.env.scoreboard.reference.sequence

    async def some_damage(self) -> None:
        """Damage a frame."""
        frame = bytearray(framed(self.frame(Command.STATUS)))
        for _ in range(int(self.rng.integers(1, 3))):
            frame[int(self.rng.integers(1, len(frame) - 1))] ^= 1 << int(self.rng.integers(8))
        # The same bit twice is no damage.
        frame[1] ^= bytes(frame) == framed(self.frame(Command.STATUS))
        await self.silent(bytes(frame) + b"\xc0", gap=6000)
        self.sequence = self.env.scoreboard.reference.sequence
