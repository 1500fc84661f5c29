"""What the board must do, written from docs/board.md: from what goes over its lines, clock by clock.

It is told of bytes to the board, of the beginnings of replies, of pins that change and of the reset button,
and predicts pins and replies. Of the engine it knows what the exact answer to the scene says; how long a run
takes it does not know, but that it ends. Clocks of latency are of the RTL's headers, or were measured on it:
they pin today's timing, and are no word on whether it is right.
"""

import struct
import zlib
from collections.abc import Callable
from dataclasses import replace
from heapq import heappop, heappush
from itertools import count

import numpy as np

from triaxis.coverage.board_coverage import MARGINS, WIDER, ZONES, found_in
from triaxis.golden.pairs import coordinate_range
from triaxis.golden.scene import SceneAnswer, scene_answer
from triaxis.sim.board_parameters import BoardParameters
from triaxis.sim.mesh_engine import Trial
from triaxis.verif.board.board_state import ALL_ZONES, BEYOND, Due, Frame, Pins, Run
from triaxis.verif.board.frame_receiver import FrameReceiver
from triaxis.verif.board.protocol import (
    BEGUN,
    COUNTERS,
    END,
    HEAD,
    LOADED,
    LONGEST,
    MOST_ERRORS,
    MOST_TRIANGLES,
    RING,
    RUN,
    VERSION,
    Code,
    Command,
    Flag,
    Mode,
    Reply,
    State,
    Status,
    coordinate_bytes,
    loaded_triangles,
    triangle_bytes,
)
from triaxis.verif.board.protocol import End as RunEnd
from triaxis.verif.board.reply_check import ReplyCheck, faulty
from triaxis.verif.mesh.expectation import scrub_finds, tried
from triaxis.verif.mesh.items import WHICHES, ObservedRun, RunAccepted, RunRequest

# A frame is answered, and a run ends, within so many clocks; a run, for each of its pairs.
_ANSWERED, _RUN_ENDS, _PAIR = 4000, 1000, 4
# One that is cut off, when the pairs on their way have come out of the core: at most some 80 clocks.
_CUT_OFF = 256
# One that ends by itself, when it had come so far that an abort is no longer looked at: with pairs on their
# way where it stops at a near one.
_ENDS_BY_ITSELF = 96
# Clocks that the cycles of a run do not count: until the engine takes the run.
_NOT_COUNTED = 1

# Clocks from the end of a frame until it is executed: header, fields, verdict.
EXECUTED = 43
# Clocks from the verdict until then: what ends between changes nothing.
_JUDGED = 1
# How long HELLO and ABORT take where no run has to end first.
_LASTS: dict[int, int] = {Command.HELLO: 2, Command.ABORT: 1}
# Clocks from then until its reply's first bit begins; that is seen in its middle, and tells that it was.
REPLIED = 2

# Clocks from the beginning of a run until a check fails, where it fails at once: in the engine what two walks, or
# two intakes, have shown is compared, and told of; on the board a frame is, or two runners are.
_FAILS_AFTER = {Trial.WALK: 2, Trial.INTAKE: 2, Trial.BOARD: 1}
# Clocks from the end of a run until a scrub tells of what it tries, in meshes of one triangle.
_SCRUBBED_AFTER = 2

_NO_MESH = np.empty((0, 3, 3), np.int64)
_CLOCKS_PER_MS = 100_000
_NO_COUNTERS = (0,) * len(COUNTERS)


class BoardReference:
    """Follows a board; tells ``wrong`` of everything that must not be."""

    def __init__(
        self,
        parameters: BoardParameters,
        wrong: Callable[[str], None],
        happened: Callable[[str, str], None] = lambda *_: None,
    ) -> None:
        """Begin with a board in reset. ``happened``: told of what happens, by item and bin of coverage."""
        self.parameters, self._tell, self._happened = parameters, wrong, happened
        self.reply_check = ReplyCheck(self._wrong, happened)
        self.runs = self.gos = self.resets = 0
        self._numbers = count()
        self._untold = REPLIED + parameters.clocks_per_three_bits // 6 + 1
        # No reply takes longer: its bytes, were all of them escaped, and both ENDs.
        self._longest = (2 * LONGEST + 2) * (10 * parameters.clocks_per_three_bits // 3 + 1)
        self.pins = Pins(0b1010)
        self.beat_level = False
        # The clock, and the one in which the last frame had come.
        self.clock = self.arrived = 0
        # Clocks in which the button is going to be pressed, as far as they are known.
        self.presses: list[int] = []
        self._reset()

    def _reset(self) -> None:
        self._timers: list[tuple[int, int, Callable[[int], None]]] = []
        self._receiver = FrameReceiver(self._failed)
        self.held: Frame | None = None
        self._answered: Frame | None = None
        self._line = bytearray()
        self._spoke = self._begun = 0
        self._replying = self._opened = False
        self._due: Due | None = None
        self.session = self.sequence = self.command = 0
        self._forget()
        self.go = self.armed = self.alive = self.expired = self.error = False
        # A check has failed; in doubt: nobody can know, since an error before it lights the same LED.
        self.fault = self.in_doubt = self._acknowledged = False
        self.errors = 0
        # The clock from which go is not said any more, and the zones that it is not said to be beyond.
        self.deadline: int | None = None
        self.inside = ALL_ZONES
        self.kicked = self._silent = -1
        self._beat_due, self._go_number = False, next(self._numbers)

    @property
    def replies(self) -> int:
        """Return how many replies were checked."""
        return self.reply_check.checked

    def _forget(self) -> None:
        self.reply_check.near = 0
        self.meshes = [_NO_MESH, _NO_MESH]
        self.run = Run()

    def _wrong(self, what: str) -> None:
        self._tell(f"clock {self.clock}: {what}")

    def _at(self, clock: int, do: Callable[[int], None]) -> None:
        heappush(self._timers, (clock, next(self._numbers), do))

    # --- Time ---------------------------------------------------------------------------------------------

    def pass_time(self, clock: int) -> None:
        """Let everything before a clock happen; what was seen until then must be what is due."""
        if clock > self.clock:
            self._settle()
        while self._timers and self._timers[0][0] < clock:
            self.clock = self._timers[0][0]
            self._now()
            self._settle()
        self.clock = max(self.clock, clock)
        self._now()

    def _now(self) -> None:
        while self._timers and self._timers[0][0] <= self.clock:
            heappop(self._timers)[2](self.clock)

    def _settle(self) -> None:
        """Compare the pins with what they must be at the end of this clock."""
        pins, run = self.pins, self.run
        self._look_for_fault()
        self._look_at_deadline()
        if self.held and any(0 < press - self.clock <= self._untold for press in self.presses):
            # It may have been executed, and the button takes the reply that would tell.
            return
        held = self.held
        if held and not held.due and not held.acted and pins.value != self._expected() and self._early(held):
            self._act(held)
        expected = self._expected()
        if pins.value != expected:
            self._wrong(f"beyond, LEDs, stop and go are {pins.value:020b}, {expected:020b} is due")
            # Not to be told again and again.
            self.errors += pins.errors - self.errors & 0xFF
            self.go, self.inside = pins.go, ~pins.beyond & ALL_ZONES
        if self.beat_level != self._beat_due:
            self._wrong(f"the beat is {self.beat_level}, {self._beat_due} is due")
            self._beat_due = self.beat_level
        if pins.busy != (run.state == State.RUNNING):
            self._wrong(f"a run is {'' if pins.busy else 'not '}going on")
            run.state = State.RUNNING if pins.busy else State.DONE

    def _expected(self) -> int:
        """Return the pins that are due; of the ring, what they are while nobody can know."""
        pins, run = self.pins, self.run
        waiting, full = pins.waiting, pins.full
        if run.state != State.RUNNING and not run.maybe_aborted and not (self.held and self.held.acted):
            held = (run.offered if run.state == State.DONE and not run.overflow else 0) - run.freed
            waiting, full = held > 0, held == RING
        said = int(self.go) | (not self.go) << 1
        return (
            said | said << 2 | pins.busy << 4 | self.alive << 5 | waiting << 6 | full << 7
            | self.expired << 8 | self._wrong_shown << 9 | (self.errors & 0xFF) << 10
            | (~self.inside & ALL_ZONES if self.go else 0) << BEYOND
        )  # fmt: skip

    @property
    def _wrong_shown(self) -> bool:
        return self.error or self.fault

    def _look_for_fault(self) -> None:
        """See whether a check has failed, where it may at any clock."""
        failing = self.busy and self.run.may_fail
        if self.fault or not (failing or self.in_doubt):
            return
        self.in_doubt = self.error
        if self.pins.wrong and not self.error:
            self._fail()

    def _look_at_deadline(self) -> None:
        """End go at its deadline, and what a run that goes on promises."""
        if self.go and self.deadline is not None and self.clock >= self.deadline:
            self._happened("board_holds", f"late, {'run' if self.busy else 'rest'}")
            self._disturb("deadline")

    def _fail(self) -> None:
        """Let a check fail: from the next clock on there is no go, until the next HELLO."""
        if not self.fault:
            self.fault, self.in_doubt, self._acknowledged = True, False, False
            self._at(self.clock + 1, lambda _: self._disturb("fault"))

    # --- What is seen -------------------------------------------------------------------------------------

    def pressed(self, down: bool) -> None:
        """Take the reset button: while it is down nothing else is seen."""
        self.pins = Pins(self.pins.value)
        if down:
            self.resets += 1
            self.presses = [press for press in self.presses if press > self.clock]
            self._reset()

    def see(self, value: int) -> None:
        """Take new pins."""
        was, self.pins = self.pins, Pins(value)
        self._look_for_fault()
        if was.busy and not self.pins.busy and self.run.state == State.RUNNING:
            self._run_ended()

    def _run_ended(self) -> None:
        run = self.run
        run.state, run.ended = State.DONE, self.clock
        self.runs += 1
        cut = self.held if self.held and self.held.command in (Command.ABORT, Command.HELLO) else None
        run.maybe_aborted = cut is not None
        run.cut_off = bool(cut and cut.due and self.clock > cut.due + _ENDS_BY_ITSELF)
        if run.fails and not run.maybe_aborted:
            self._fail()
        if run.scrub_finds and not run.maybe_aborted:
            self._at(self.clock + _SCRUBBED_AFTER, lambda _: self._scrub(run))
        self._tell_trial()
        clear = run.end == RunEnd.COMPLETE and not run.near
        said = (
            "fault"
            if self.fault
            else "out of range"
            if run.overflow
            else "near"
            if run.near
            else f"clear, {'' if self.armed else 'no '}go"
        )
        self._moment(self.held or self._answered)
        if not run.maybe_aborted:
            self._happened("board_runs", f"{Mode(run.mode).name}, {said}")
            if run.end == RunEnd.COMPLETE and not self.fault:
                self._happened("board_zones", f"{WIDER[run.wider]}, {found_in(run.found, run.near)}")
        was_go, due = self.go, self.deadline
        if self.armed and clear and (not run.maybe_aborted or self.pins.go):
            self._say_go()
        elif self.go:
            self._disturb("end of a run")
        if was_go:
            self._happened(
                "board_holds", f"{said}, {'in time' if due is None or self.clock < due else 'last clock'}"
            )
            if due is not None:
                self._happened("board_moments", f"end of a run {self.clock - due:+d}, deadline")

    def _tell_trial(self) -> None:
        """Tell what came of what a run has tried, or of a fault before it."""
        run = self.run
        kind, which = Trial(run.tries[0]), run.tries[1]
        if run.spoiled:
            self._happened("board_faults", "a run while it stands")
        elif kind != Trial.NOTHING and run.comes and (self.fault or not run.maybe_aborted):
            self._happened("board_trials", f"{kind.name} {which}")
            # An error that nobody took back hides it.
            if not self.in_doubt:
                self._happened("board_tried", f"{kind.name}, {'fault' if self.fault else 'no fault'}")

    def _scrub(self, run: Run) -> None:
        """Let a scrub find what the last run tries."""
        if self.run is run and not self.fault:
            self._happened("board_faults", "found between runs")
            self._fail()

    def _say_go(self) -> None:
        """Say go from this clock on, for as long as the run holds; the beat begins with it."""
        hold = self.run.hold * self.parameters.hold_clocks
        self.deadline = self.clock + hold if hold else None
        if self.deadline:
            # It is looked at where anything happens.
            self._at(self.deadline, lambda _: None)
        was, self.inside = self.inside, self.run.zones
        if self.go:
            self._happened("board_beyond", f"{ZONES[was]}, then {ZONES[self.inside]}")
            return
        self._happened("board_beyond", f"go, {ZONES[self.inside]}")
        self.go = True
        if self._acknowledged:
            self._happened("board_faults", "go after it was acknowledged")
            self._acknowledged = False
        self.gos += 1
        number = self._go_number = next(self._numbers)

        def edge(now: int) -> None:
            if number == self._go_number:
                self._beat_due = not self._beat_due
                self._at(now + self.parameters.beat_clocks, edge)

        self._at(self.clock + self.parameters.beat_clocks, edge)

    def _end_beat(self, _: int) -> None:
        self._beat_due, self._go_number = False, next(self._numbers)

    def byte(self, value: int) -> None:
        """Take a byte that has come to the board."""
        frame = self._receiver.byte(value, self.held is not None)
        if frame is None:
            return
        self.arrived = self.clock
        command, sequence, session = HEAD.unpack(frame[:9])
        silence = self.kicked + self.parameters.watchdog_clocks
        self.held = Frame(
            command, sequence, session, frame[9:-4], self.clock, busy=self.pins.busy, silence=silence
        )
        self._expect_answer(self.held)
        if not self._replying:
            self.held.due = self.clock + EXECUTED
            load = command == Command.LOAD and len(self.held.payload) > 3
            looked_at = self._pass(self.held.payload[3]) if load else 0
            self._at(self.held.due + looked_at, lambda _, frame=self.held: self._execute_lasting(frame))

    def broken(self) -> None:
        """Take a byte without a stop bit."""
        self._receiver.drop("no stop bit")

    def _execute_lasting(self, frame: Frame) -> None:
        """Let what takes some time begin; a LOAD changes nothing before all of it was looked at."""
        if frame is self.held and self._early(frame):
            self._act(frame)

    def _pass(self, triangles: int) -> int:
        """Return the clocks in which so many triangles of a LOAD are looked at once."""
        return triangles * (9 * coordinate_bytes(self.parameters.width) + 1)

    def _lasts(self, frame: Frame, code: Code, repeats: bool) -> int | None:
        """Return the clocks that a frame's execution takes; None where a run has to end first."""
        command, payload = frame.command, frame.payload
        if frame.busy and command in (Command.HELLO, Command.ABORT):
            return None
        if command == Command.LOAD and code == Code.VALUE and self._place_code(payload) == Code.OK:
            return self._pass(1 + (self._beyond(payload) or 0))
        if code != Code.OK or repeats:
            return 0
        if command == Command.LOAD:
            return 2 * self._pass(payload[3]) + (payload[1:3] == bytes(2))
        return _LASTS.get(command, 0)

    def _expect_answer(self, frame: Frame) -> None:
        def late(clock: int) -> None:
            if self.held is frame:
                if not self._replying:
                    self._wrong("a frame is not answered")
                    self.held = None
                else:
                    self._at(clock + _ANSWERED, late)

        self._at(self.clock + _ANSWERED, late)

    @property
    def _state(self) -> str:
        return "go" if self.go else "run" if self.busy else "stop"

    def _failed(self, what: str) -> None:
        """Something is wrong on the line."""
        self._happened("board_line", f"{what}, {self._state}")
        self.errors = min(self.errors + 1, MOST_ERRORS)
        self._fault("line")

    def _fault(self, what: str) -> None:
        self._disturb(what)
        self.error = True

    def _disturb(self, what: str) -> None:
        if self.go or self.armed:
            self._happened("board_ends", f"{what} ends {'go' if self.go else 'a promise of go'}")
        if self.go:
            self._happened("board_beyond", f"{ZONES[self.inside]}, then stop")
            self._at(self.clock + 1, self._end_beat)
        self.go = self.armed = False

    # --- What a frame does --------------------------------------------------------------------------------

    @property
    def busy(self) -> bool:
        """Return whether a run is going on."""
        return self.run.state == State.RUNNING

    def _repeats(self, frame: Frame) -> bool:
        return (frame.session, frame.sequence, frame.command) == (self.session, self.sequence, self.command)

    def judge(self, frame: Frame) -> Code:
        """Return the code of the answer to a frame, as things stood when it was judged."""
        judged = (frame.due or self.clock) - _JUDGED
        alive, busy = self.alive or self._silent >= judged, self.busy or self.run.ended >= judged
        command, payload = frame.command, frame.payload
        hello, mine = command == Command.HELLO, frame.session == self.session != 0
        if hello and not frame.session:
            return Code.VALUE
        if not mine and (not hello or alive):
            return Code.SESSION
        if command not in list(Command):
            return Code.UNKNOWN
        if mine and frame.sequence != (self.sequence + 1) % 2**32 and not self._repeats(frame):
            return Code.SEQUENCE
        if len(payload) != self._length(command, payload):
            return Code.LENGTH
        if command == Command.RESULTS:
            (first,) = struct.unpack("<I", payload)
            return Code.OK if self.run.freed <= first <= self._last_pair() else Code.VALUE
        if hello or self._repeats(frame):
            return Code.OK
        if command in (Command.LOAD, Command.RUN):
            return Code.BUSY if busy else self._command_code(command, payload)
        return Code.OK

    def _last_pair(self) -> int:
        run = self.run
        certain = run.state == State.DONE and not run.maybe_aborted
        if run.overflow or certain:
            return 0 if run.overflow else run.offered
        return max(run.written, run.freed + RING if self.pins.full else 0)

    def _length(self, command: int, payload: bytes) -> int:
        if command == Command.LOAD:
            triangles = payload[3] if len(payload) > 3 else 0
            return 4 + triangles * 9 * coordinate_bytes(self.parameters.width)
        return {Command.RUN: RUN.size, Command.RESULTS: 4}.get(Command(command), 0)

    def _command_code(self, command: int, payload: bytes) -> Code:
        if command == Command.LOAD:
            return self._load_code(payload)
        mode, margin, slow, warn, *counts, _, x, y, z, _ = RUN.unpack(payload)
        reach = 1 << self.parameters.width
        if mode > Mode.COUNT or max(margin, slow, warn) > self.parameters.max_margin:
            return Code.VALUE
        if not all(-reach <= value < reach for value in (x, y, z)):
            return Code.VALUE
        if counts != [len(mesh) for mesh in self.meshes]:
            return Code.COUNTS
        return Code.OK if all(counts) else Code.EMPTY

    def _load_code(self, payload: bytes) -> Code:
        code = self._place_code(payload)
        return Code.VALUE if code == Code.OK and self._beyond(payload) is not None else code

    def _place_code(self, payload: bytes) -> Code:
        """Return the code of the answer to a LOAD whose coordinates are all in range."""
        mesh, first, triangles = struct.unpack_from("<BHB", payload)
        if mesh > 1 or not 1 <= triangles <= MOST_TRIANGLES:
            return Code.VALUE
        if first not in (0, len(self.meshes[mesh])):
            return Code.PLACE
        if first + triangles > self.parameters.depth:
            return Code.OVERFULL
        return Code.OK

    def _beyond(self, payload: bytes) -> int | None:
        """Return which triangle of a LOAD is the first with a coordinate out of range."""
        low, high = coordinate_range(self.parameters.width)
        given = loaded_triangles(payload, self.parameters.width).reshape(-1, 9)
        wrong = np.flatnonzero(np.any((given < low) | (given > high), axis=1))
        return int(wrong[0]) if len(wrong) else None

    def _early(self, frame: Frame) -> bool:
        """Return whether a frame's effects may be seen some clocks before its answer begins."""
        lasting = frame.command in (Command.HELLO, Command.LOAD, Command.ABORT)
        return lasting and self.judge(frame) == Code.OK and not self._repeats(frame)

    def _act(self, frame: Frame) -> None:
        """Let a frame that is executed have the effects that come first."""
        frame.acted, frame.state = True, self._state
        self._look_at_deadline()
        holds = frame.command == Command.RUN and RUN.unpack(frame.payload)[-1]
        if holds and self.go:
            self._happened("board_holds", "begun while go is said")
        if frame.command not in (Command.RESULTS, Command.STATUS) and not (holds and self.go):
            self._disturb(Command(frame.command).name)
        if frame.command in (Command.HELLO, Command.RUN):
            # Silence that is noticed in the same clock is not forgotten.
            self.expired, self.error = self._silent == self.clock, False
        if frame.command == Command.HELLO:
            self._acknowledge(frame)
            self.session, self.sequence, self.command = frame.session, frame.sequence, frame.command
            self._kick(self.clock)

    def _acknowledge(self, frame: Frame) -> None:
        """Forget a fault, by HELLO; not one of a run that goes on, and fails for as long."""
        going = self.busy or self.run.ended >= self.clock
        if self.fault and frame.busy and not frame.due:
            # Nobody knows at which clock it came, but the LED.
            self.fault, self.in_doubt = False, True
        elif self.fault and going and self.run.persists:
            self._happened("board_faults", "HELLO while it goes on")
        elif not (going and self.run.may_fail and not self.fault):
            if self.fault:
                self._happened("board_faults", "HELLO acknowledges it")
            self._acknowledged |= self.fault
            self.fault = self.in_doubt = False

    def _kick(self, clock: int) -> None:
        self.alive, self.kicked = True, clock

        def out(now: int) -> None:
            if self.kicked != clock:
                return
            self.alive, self.expired, self._silent = False, True, now
            self._at(now + 1, lambda _: self._disturb("watchdog"))

        self._at(clock + self.parameters.watchdog_clocks, out)

    def begin(self) -> None:
        """Take the beginning of a reply: two clocks before its first bit its frame has been executed."""
        self.finish()
        frame, self.held = self.held, None
        self._replying, self._opened, self._line = True, False, bytearray()
        self._begun = begun = next(self._numbers)
        self._at(self.clock + self._longest, lambda _: self.finish() if self._begun == begun else None)
        if frame is None:
            self._wrong("a reply that nothing asked for")
            return
        alive = self.alive
        # HELLO of a new session has taken the board already where its effects were seen.
        code = Code.OK if frame.acted else self.judge(frame)
        repeats = not frame.acted and self._repeats(frame)
        lasts = self._lasts(frame, code, repeats)
        if frame.due and lasts is not None and self.clock != frame.due + lasts:
            self._wrong(f"a reply begins, due at {frame.due + lasts}")
        elif frame.due and lasts is None and code == Code.OK and self.clock > frame.due + _CUT_OFF:
            self._wrong("a run that is cut off does not end")
        self._answered = frame
        self._moment(frame)
        name = Command(frame.command).name if frame.command in list(Command) else "another"
        if code == Code.OK:
            state = frame.state if frame.acted else self._state
            self._happened("board_done", f"{name}{' again' if repeats else ''}, {state}")
        else:
            self._happened("board_refused", f"{code.name} of {name}")
            if (frame.command, code) == (Command.RUN, Code.VALUE):
                self._tell_wide(frame)
        if code == Code.OK and not repeats:
            self._execute(frame, alive)
        elif code != Code.OK:
            self._at(self.clock + 1, lambda _: self._refuse(code))
        # After the pins of this clock.
        self._pending = lambda: self._answer(frame, code)

    def _moment(self, frame: Frame | None) -> None:
        """Tell of a frame that was executed, or refused, about when a run or the watchdog's time ended."""
        if frame is None or not frame.due or frame.command not in list(Command):
            return
        for what, end in (("run", self.run.ended), ("silence", frame.silence)):
            self._happened("board_moments", f"{Command(frame.command).name} {frame.due - end:+d}, {what}")

    def _tell_wide(self, frame: Frame) -> None:
        """Tell which margin alone is too wide, where a run is refused."""
        margins = RUN.unpack(frame.payload)[1:4]
        wide = [
            name for name, margin in zip(MARGINS, margins, strict=True) if margin > self.parameters.max_margin
        ]
        if len(wide) == 1:
            self._happened("board_refused", f"{wide[0]} too wide")

    def _refuse(self, code: Code) -> None:
        if code == Code.SESSION:
            self.errors = min(self.errors + 1, MOST_ERRORS)
        self._fault("refusal")

    def _execute(self, frame: Frame, alive: bool) -> None:
        command, payload = frame.command, frame.payload
        if command == Command.HELLO and not frame.acted:
            # The engine's meshes are emptied between: three clocks, where no run has to end first.
            self._act(frame)
            if not frame.busy:
                self._kick(self.clock - 3)
        elif not frame.acted:
            self._act(frame)
        self.session, self.sequence, self.command = frame.session, frame.sequence, command
        if command == Command.HELLO:
            self._forget()
            return
        # A sign of life in the last clock of the watchdog's time is in time.
        self.kicked = self.clock + 1
        self._at(self.kicked, self._kick)
        if command == Command.LOAD:
            mesh, first = payload[0], struct.unpack_from("<H", payload, 1)[0]
            given = loaded_triangles(payload, self.parameters.width)
            self.meshes[mesh] = np.concatenate([self.meshes[mesh], given]) if first else given
        elif command == Command.RUN:
            mode, margin, slow, warn, _, _, trial, *pose, hold = RUN.unpack(payload)
            number = (self.run.number + 1) % 256
            tries = divmod(trial, WHICHES)
            # No zone is narrower than the one within it.
            margins = margin, max(margin, slow), max(margin, slow, warn)
            self._start(Run(number, mode, margins, tuple(pose), tries, hold, State.RUNNING, self.clock))
            self.armed = alive and not self.fault
        elif command == Command.RESULTS:
            (self.run.freed,) = struct.unpack("<I", payload)
            self._expect_end(self.run)

    def _start(self, run: Run) -> None:
        a, b = self.meshes
        moved = a + np.array(run.pose, np.int64)
        low, high = coordinate_range(self.parameters.width)
        run.overflow = bool(moved.min() < low or moved.max() > high)
        answers: list[SceneAnswer] = []
        if not run.overflow:
            found = {
                margin: scene_answer(moved, b, margin, self.parameters.group) for margin in set(run.margins)
            }
            answers = [found[margin] for margin in run.margins]
            # What is skipped is further than the widest zone, and what is near within the margin.
            run.answer = replace(answers[-1], near=answers[0].near)
        self._try(run)
        if run.answer:
            run.pairs = run.answer.near_pairs
            # What is in a zone is in all around it.
            for bit, answer in enumerate(answers[1:]):
                run.found |= bool(run.near or answer.near.any()) << bit
        self.run = run
        self._expect_end(run)

    def _try(self, run: Run) -> None:
        """Make out what comes of what a run tries."""
        run.spoiled = self.fault
        if Trial(run.tries[0]) in _FAILS_AFTER:
            run.fails = run.persists = run.comes = True
            after = _FAILS_AFTER[Trial(run.tries[0])]
            self._at(self.clock + after, lambda _: self._fail() if self.run is run else None)
        else:
            (a, b), no = self.meshes, (False, False)
            margin, *zones = run.margins
            request = RunRequest(run.pose, margin, run.mode, run.tries, (zones[0], zones[1]))
            observed = ObservedRun(RunAccepted(request), a, b, no, no)
            outcome = tried(observed, run.answer, self.parameters.engine)
            run.answer, run.fails, run.may_fail = outcome.answer, outcome.fails, outcome.may_fail
            run.comes = outcome.comes
            run.scrub_finds = scrub_finds(observed)

    def _expect_end(self, run: Run) -> None:
        """A run ends in time, but where it waits for near pairs to be taken."""
        freed = run.freed

        def late(_: int) -> None:
            if self.run is run and run.state == State.RUNNING and run.freed == freed and not self.pins.full:
                self._wrong("a run does not end")

        self._at(self.clock + _RUN_ENDS + _PAIR * len(self.meshes[0]) * len(self.meshes[1]), late)

    # --- Replies ------------------------------------------------------------------------------------------

    def clock_ends(self) -> None:
        """Take the end of a clock: what is answered in it is so now."""
        if self._pending:
            pending, self._pending = self._pending, None
            pending()

    _pending: Callable[[], None] | None = None

    def finish(self) -> None:
        """Nothing more comes of the reply that was under way."""
        if self._replying:
            self._wrong("a reply does not end")
            self._replying = False

    def _answer(self, frame: Frame, code: Code) -> None:
        """Make out what the reply must be, from the state as it is."""
        command, status, payload = frame.command, None, b""
        self._look_for_fault()
        if code == Code.PLACE or (code == Code.OK and command == Command.LOAD):
            mesh = self.meshes[frame.payload[0] & 1]
            payload = LOADED.pack(len(mesh), zlib.crc32(triangle_bytes(mesh, self.parameters.width)))
        elif code == Code.SEQUENCE:
            payload = struct.pack("<I", (self.sequence + 1) % 2**32)
        elif code == Code.OK:
            if command == Command.HELLO:
                payload = self._description()
            elif command == Command.RUN:
                payload = BEGUN.pack(self.run.number, self.run.hold)
            else:
                status = self._status()
        first = struct.unpack("<I", frame.payload)[0] if command == Command.RESULTS and status else 0
        self._due = Due(frame, code, payload, status, self.busy, first, self.in_doubt)

    @property
    def shown(self) -> str:
        """Return what the displays must show while nothing changes: a word, and the near pairs."""
        wrong = self._wrong_shown or self.expired
        word = "  Go" if self.go else " run" if self.busy else " Err" if wrong else "StoP"
        near = self.reply_check.near if self.run.state == State.DONE else 0
        return word + (f"{near:04}" if near < 10_000 else "----")

    def _description(self) -> bytes:
        p = self.parameters
        return struct.pack(
            "<BBBHBBIHB", VERSION, p.width, p.margin_bits, p.depth, p.group, p.lanes, p.build_id,
            -(-p.watchdog_clocks // _CLOCKS_PER_MS), p.certify,
        )  # fmt: skip

    def _status(self) -> Status:
        """Return the status; counters as they are due where the run has ended by itself."""
        run = self.run
        flags = self.pins.go << Flag.GO | self.pins.waiting << Flag.WAITING | self.expired << Flag.EXPIRED
        counters, end = _NO_COUNTERS, RunEnd.NONE
        if run.state == State.DONE:
            flags |= run.zones << Flag.SLOW
            end = run.end
            cycles = run.ended - run.start - _NOT_COUNTED
            counters = (cycles, 0, 0, 0, 0, 0)
            if run.answer:
                answer = run.answer
                skipped, opened = answer.group_pairs_skipped, answer.group_pairs_opened
                counters = (cycles, skipped, opened, answer.pairs_skipped, answer.tested, run.near)
        fields = (
            run.number, run.state, end, flags, run.mode, *run.pose, run.margins[0], *counters, self.errors,
            *(len(mesh) for mesh in self.meshes),
        )  # fmt: skip
        status = Status._make(fields)
        return faulty(status) if self.fault else status

    def spoken(self, value: int) -> None:
        """Take a byte of the board's: those of a reply follow one another without a gap."""
        after, self._spoke = self.clock - self._spoke, self.clock
        if self._opened and after != 10 * self.parameters.clocks_per_three_bits // 3 + 1:
            self._wrong(f"a byte of a reply comes {after} clocks after the one before it")
        if value != END:
            if not self._opened:
                self._wrong("a reply without an END before it")
            self._opened = True
            self._line.append(value)
        elif not self._line:
            self._opened = True
        else:
            self._replying = False
            due, self._due = self._due, None
            if due is None:
                return
            try:
                reply = Reply.of(bytes(self._line))
            except ValueError as error:
                self._wrong(str(error))
                return
            self.reply_check.compare(due, reply, self.run)
