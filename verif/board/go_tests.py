"""The board's tests of sessions and of go: what brings it, what ends it, what it stays through."""

import struct
from collections.abc import Awaitable, Callable
from itertools import product

from triaxis.sim.mesh_engine import NO_ZONES, Trial
from triaxis.verif.board.base_test import BOARD, ONE_SEED, REAL, SHIPPED, SHORT, BoardTest
from triaxis.verif.board.line_agent import Act, Until
from triaxis.verif.board.protocol import LONGEST, RUN, Command, Mode, checked, framed, load_payload, stuffed
from triaxis.verif.mesh.items import WHICHES
from triaxis.verif.testbench.table import Runs, listed


@listed(
    "V1",
    Runs((BOARD, SHIPPED, REAL), 20, seeds=1, smoke=(BOARD, SHIPPED, REAL)),
    why_seeds=ONE_SEED,
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
            await self.line(frame[-1:], gap=SHORT)
            await self.idle()
            self.sequence = reference.sequence
            await self.status()
            after = reference.run.ended - due
            wait += 1 if number else -3 - after
