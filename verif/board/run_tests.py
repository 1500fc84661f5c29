"""The board's tests of runs: ended at any clock, on full meshes, with every check tried."""

import struct

import numpy as np

from triaxis.golden.pairs import coordinate_range
from triaxis.sim.mesh_engine import NO_ZONES, Trial
from triaxis.verif.board.base_test import BOARD, ONE_SEED, PLAIN, SHIPPED, SHORT, BoardTest
from triaxis.verif.board.line_agent import Act, Until
from triaxis.verif.board.protocol import HEAD, LONGEST, RING, Command, Mode, framed, load_payload
from triaxis.verif.board.reference import EXECUTED
from triaxis.verif.mesh.items import WHICHES
from triaxis.verif.testbench.table import Runs, listed


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
        await self.line(ended[-1:], gap=SHORT)
        await self.line(gap=SHORT)
        await self.idle()
        reference = self.env.scoreboard.reference
        after = reference.arrived + EXECUTED - reference.run.start
        self.sequence = reference.sequence
        await self.status()
        return after


@listed(
    "V2",
    Runs((BOARD,), 60, seeds=1, smoke=(BOARD,)),
    why_seeds=ONE_SEED,
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
    why_seeds=ONE_SEED,
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
