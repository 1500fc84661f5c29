"""The board's tests of the reset button at any moment, and of all that there is in any order."""

from triaxis.golden.pairs import coordinate_range
from triaxis.sim.mesh_engine import Trial
from triaxis.verif.board.base_test import BOARD, SHIPPED, SHORT, BoardTest
from triaxis.verif.board.line_agent import Act, Until
from triaxis.verif.board.protocol import LONGEST, Command, Mode, framed, load_payload
from triaxis.verif.testbench.table import Runs, listed


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
            await self.line(act=Act.RESET, clocks=int(self.rng.integers(1, 6)), until=Until.NOW, gap=SHORT)
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
        await self.line(act=Act.RESET, clocks=3, until=Until.NOW, gap=SHORT)
        await self.digits()
        await self.line(b"\xc0" + bytes(LONGEST + 9), gap=SHORT)
        await self.line(act=Act.RESET, clocks=3, until=Until.NOW, gap=SHORT)
        await self.hello()
        await self.scene(self.flat(0, 3), self.flat(9, 3))
        await self.start(tries=(Trial.BOARD, 3))
        await self.idle()
        await self.digits()
        await self.line(act=Act.RESET, clocks=3, until=Until.NOW, gap=SHORT)
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
