"""What all tests of the board share: its builds, a host that keeps to no rule but the test's."""

import struct

import numpy as np

from triaxis.golden.pairs import coordinate_range
from triaxis.sim.mesh_engine import NO_ZONES, Trial
from triaxis.verif.board.env import BoardEnv
from triaxis.verif.board.line_agent import Act, BoardBfm, LineItem, Until
from triaxis.verif.board.pin_agents import PinBoardBfm
from triaxis.verif.board.protocol import (
    HEAD,
    MOST_TRIANGLES,
    RUN,
    Code,
    Command,
    Integers,
    Mode,
    Reply,
    Status,
    coordinate_bytes,
    framed,
    load_payload,
)
from triaxis.verif.mesh.expectation import ATTEMPTS
from triaxis.verif.mesh.items import WHICHES
from triaxis.verif.testbench.environment import EnvironmentTest, ItemsSequence, create
from triaxis.verif.testbench.failures import HOPELESS

# Coordinates with bits above them in their bytes, and more near pairs than the displays can show.
BOARD = "board_w12_m5_d128_g8_l4"
# The same, with a core that shows no "clear" again.
PLAIN = "board_w12_m5_d128_g8_l4_plain"
# The sizes that ship, as `fpga.board_build.SIGNED_OFF` has them, with the environment's short times, and the
# top's own: then a byte takes 83 clocks, and the watchdog ten million.
SHIPPED, REAL = "board_w16_m16_d4096_g8_l8", "board_w16_m16_d4096_g8_l8_real"
# Why one seed is enough for most tests.
ONE_SEED = "One: what it sends is the same with every seed, but for places and moments."

# Clocks after which what was done on the line or with the button shows.
SHORT = 200
# Clocks after the last item in which anything too many would show.
_SURPLUS_CYCLES = 6000
# In which the number is in decimal; before that and after it all eight digits are shown.
_DECIMAL_CYCLES = 60
# Between triangles of `comb`.
_PITCH = 8
SESSION = 0x11DBC022


class BoardTest(EnvironmentTest):
    """Resets the board and runs `stimulus`; what it sends is all the same to the scoreboard."""

    # But for the segments: no reset reaches what makes the number decimal.
    outputs = dict.fromkeys(
        ("go_o", "stop_o", "beat_o", "beyond_slow_o", "beyond_warn_o", "uart_tx_o", "led_o", "an_no")
    )
    # The button's own synchroniser begins with values; what it releases has none before.
    clock_and_reset = "clk_100mhz_i", "rst_n"

    def build_phase(self) -> None:
        """Make the environment."""
        super().build_phase()
        self.parameters = self.settings.board_parameters
        self.env = create(BoardEnv, "env", self)
        self.session, self.sequence = SESSION, 0
        # Where A is in the runs to come.
        self.pose = (0, 0, 0)

    def pin_model(self) -> BoardBfm:
        """Return the pins in the place of the board's model."""
        return PinBoardBfm(self.dut, self.settings.board_parameters)

    def fast_model(self) -> BoardBfm:
        """Return the board's model."""
        return BoardBfm(self.settings.board_parameters.clocks_per_three_bits)

    async def traffic(self) -> None:
        """Run `stimulus`; a reply too many would show after it."""
        await self.stimulus()
        await self.clocks(_SURPLUS_CYCLES)

    @property
    def unfinished(self) -> bool:
        """Return whether fewer replies were checked than the test was asked for, and may still be."""
        scoreboard = self.env.scoreboard
        return scoreboard.reference.replies < self.settings.pairs and scoreboard.failed < HOPELESS

    # --- The line -----------------------------------------------------------------------------------------

    def lasts(self, count: int) -> int:
        """Return how many clocks so many bytes take, one after the other, rounded up."""
        return -(-10 * count * self.parameters.clocks_per_three_bits // 3)

    async def line(
        self,
        data: bytes = b"",
        until: Until = Until.ANSWERED,
        gap: int = 0,
        act: Act = Act.NONE,
        clocks: int = 0,
    ) -> list[bytes]:
        """Put bytes on the line; return what the board said meanwhile."""
        item = LineItem(data, until, gap, act, clocks)
        await ItemsSequence([item]).start(self.env.line.sequencer)
        return item.replies

    async def silent(self, data: bytes = b"", act: Act = Act.NONE, clocks: int = 0, gap: int = SHORT) -> None:
        """Put bytes on the line that nobody answers."""
        await self.line(data, Until.SENT, gap + clocks, act, clocks)

    def frame(self, command: int, payload: bytes = b"", ahead: int = 1, session: int | None = None) -> bytes:
        """Return a frame's body; ``ahead``: of the number of the last command."""
        whose = self.session if session is None else session
        return HEAD.pack(command, (self.sequence + ahead) % 2**32, whose) + payload

    async def ask(
        self, command: int, payload: bytes = b"", ahead: int = 1, session: int | None = None, gap: int = 0
    ) -> Reply | None:
        """Send a command; return its reply. An executed one counts."""
        body = self.frame(command, payload, ahead, session)
        replies = await self.line(framed(body), gap=gap)
        try:
            reply = Reply.of(replies[0]) if replies else None
        except ValueError:
            return None
        if reply and reply.code == Code.OK:
            self.sequence = reply.sequence
        return reply

    async def again(self, command: int, payload: bytes = b"") -> None:
        """Send the last command's frame again."""
        await self.line(framed(self.frame(command, payload, 0)))

    async def too_early(self) -> None:
        """Send three frames without a pause: the third finds no place."""
        frames = [framed(self.frame(Command.STATUS, ahead=ahead)) for ahead in (1, 2, 3)]
        await self.line(b"".join(frames))
        await self.line()
        self.sequence += 2

    async def digits(self) -> None:
        """Look at the displays."""
        await self.clocks(2 * 8 * self.parameters.digit_clocks + _DECIMAL_CYCLES)
        self.env.scoreboard.check_digits()

    async def pressed(self) -> None:
        """Press the button; take the board again."""
        await self.line(act=Act.RESET, clocks=int(self.rng.integers(1, 9)), until=Until.NOW)
        await self.hello()

    # --- Commands -----------------------------------------------------------------------------------------

    async def hello(self) -> None:
        """Take the board; runs to come are where meshes were loaded."""
        await self.ask(Command.HELLO)
        self.move()

    async def status(self) -> None:
        """Ask for the status."""
        await self.ask(Command.STATUS)

    async def load(self, mesh: int, triangles: Integers) -> None:
        """Replace a mesh by triangles (N, 3, 3)."""
        step = min(MOST_TRIANGLES, 235 // (9 * coordinate_bytes(self.parameters.width)))
        for first in range(0, len(triangles), step):
            part = triangles[first : first + step]
            await self.ask(Command.LOAD, load_payload(mesh, first, part, self.parameters.width))

    async def scene(self, a: Integers, b: Integers) -> None:
        """Replace both meshes."""
        await self.load(0, a)
        await self.load(1, b)

    def move(self, x: int = 0, y: int = 0, z: int = 0) -> None:
        """Have the runs to come at a pose."""
        self.pose = (x, y, z)

    def asked(
        self, mode: int = Mode.ALL, margin: int = 0, tries: tuple[int, int] = (0, 0), hold: int = 0,
        zones: tuple[int, int] = NO_ZONES,
    ) -> bytes:  # fmt: skip
        """Return the payload of a RUN on the meshes that the board holds.

        ``tries``: a `Trial`, and which; ``zones``: margins of the zones slow and warn.
        """
        counts = (len(mesh) for mesh in self.env.scoreboard.reference.meshes)
        kind, which = tries
        return RUN.pack(mode, margin, *zones, *counts, kind * WHICHES + which, *self.pose, hold)

    async def start(
        self, mode: int = Mode.ALL, margin: int = 0, tries: tuple[int, int] = (0, 0), hold: int = 0,
        zones: tuple[int, int] = NO_ZONES,
    ) -> None:  # fmt: skip
        """Start a run; its reply has come."""
        await self.ask(Command.RUN, self.asked(mode, margin, tries, hold, zones))

    async def idle(self) -> None:
        """Wait until no run goes on."""
        await self.line(until=Until.IDLE)

    async def run(
        self, mode: int = Mode.ALL, margin: int = 0, tries: tuple[int, int] = (0, 0), hold: int = 0,
        zones: tuple[int, int] = NO_ZONES,
    ) -> None:  # fmt: skip
        """Run to the end, and ask how it ended."""
        await self.start(mode, margin, tries, hold, zones)
        await self.idle()
        await self.status()

    async def results(self, first: int) -> Reply | None:
        """Ask for near pairs."""
        return await self.ask(Command.RESULTS, struct.pack("<I", first))

    async def all_results(self) -> None:
        """Take all near pairs of a run, from the first on."""
        first = 0
        # Of a run that never ends each question is a failure.
        while self.env.scoreboard.failed < HOPELESS:
            reply = await self.results(first)
            # A payload that is too short is a failure already.
            if reply is None or reply.code != Code.OK or len(reply.payload) < Status.SIZE:
                return
            first += len(reply.pairs)
            if not len(reply.pairs) and Status.unpack(reply.payload).state != 1:
                return

    # --- Scenes -------------------------------------------------------------------------------------------

    def flat(self, z: int = 0, count: int = 1) -> Integers:
        """Return ``count`` times the same triangle, of 10 by 10 at height ``z``."""
        return np.tile(np.array([[0, 0, z], [10, 0, z], [0, 10, z]], np.int64), (count, 1, 1))

    def corners(self, count: int) -> Integers:
        """Return ``count`` triangles that the boxes of `flat`'s overlap, and that are not near them at 0."""
        return np.tile(np.array([[10, 10, 0], [10, 6, 0], [6, 10, 0]], np.int64), (count, 1, 1))

    def comb(self, count: int, shift: int) -> Integers:
        """Return ``count`` small triangles, none of whose boxes is near one of another shift by half a pitch.

        Each group of them spans the same space, so that no box of groups tells them apart.
        """
        number, group = np.arange(count), self.parameters.group
        low, high = coordinate_range(self.parameters.width)
        step = (high - low - 2 * _PITCH) // group
        x = low + step // _PITCH * _PITCH * (number % group) + _PITCH * (number // group) + shift
        corner = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.int64)
        return corner + np.stack([x, 0 * x, 0 * x], -1)[:, None]

    def cloud(self, count: int, spread: int) -> Integers:
        """Return ``count`` small triangles (count, 3, 3) anywhere within ``spread``."""
        centres = self.rng.integers(-spread, spread + 1, (count, 1, 3))
        size = max(2, spread // 3)
        return np.asarray(centres + self.rng.integers(-size, size + 1, (count, 3, 3)), np.int64)

    def some_zones(self, margin: int, trial: int = Trial.NOTHING) -> tuple[int, int]:
        """Return margins of the zones slow and warn: often none, or wider by little or much, also no wider.

        None for what the core tries: what comes of that depends on how it is asked, and so on the moment.
        """
        most = self.parameters.max_margin
        if trial in ATTEMPTS or not self.rng.integers(3):
            return NO_ZONES
        steps = self.rng.integers(1, max(2, most // int(self.rng.choice([2, 8])) + 1), 2)
        slow, warn = (min(margin + int(step), most) for step in np.cumsum(steps))
        kinds = (
            (slow, warn),
            (slow, 0),
            (slow, slow),
            (0, warn),
            (warn, slow),
            (margin, margin),
            (most, most),
        )
        return kinds[int(self.rng.integers(len(kinds)))]

    async def clear_scene(self) -> None:
        """Load two triangles 5 apart."""
        await self.scene(self.flat(), self.flat(5))

    async def clear_run(self) -> None:
        """Run to go: what is there is clear."""
        await self.run()
