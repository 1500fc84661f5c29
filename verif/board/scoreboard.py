"""Holds what is seen of the board against the reference, clock by clock."""

from collections.abc import Callable
from typing import Any

import numpy as np
from pyuvm import uvm_analysis_port

from triaxis.sim.simulated_board import BEAT, BEGIN, LIT, PINS, RESET, RX, RX_BROKEN, TX, TX_BROKEN
from triaxis.verif.board.line_agent import Seen
from triaxis.verif.board.reference import REPLIED, BoardReference
from triaxis.verif.testbench.environment import CountingScoreboard, Export, settings_of
from triaxis.verif.testbench.failures import DESCRIBED, Blame, report_failure
from triaxis.verif.testbench.reports import ERROR, report

# Clocks between a byte that is seen on the line and what the pins say of it: it goes through synchroniser,
# SLIP and frame.
_HEARD = 4
_LINE = (RX, RX_BROKEN, TX, TX_BROKEN)
# Of what happens in one clock: lines first, pins last.
_ORDER = {RESET: 0, RX: 1, RX_BROKEN: 1, TX: 1, TX_BROKEN: 1, BEGIN: 2, LIT: 3, BEAT: 3, PINS: 4}
_ORDERS = np.array([_ORDER[kind] for kind in range(len(_ORDER))])
# From the button's release: stages of its synchroniser, and the register of the displays.
_LIT_AFTER = 4


class BoardScoreboard(CountingScoreboard):
    """Lets the reference see what the monitor publishes, in the order of clocks; fails in check_phase.

    What happened is published on ``checked_port``, as the coverage takes it.
    """

    def build_phase(self) -> None:
        """Make the exports, the port for what was checked, the reference."""
        self.settings = settings_of(self)
        self.checked_port = uvm_analysis_port("checked_port", self)
        self.reference = BoardReference(
            self.settings.board_parameters, self.fail, lambda *happened: self.checked_port.write(happened)
        )
        # A reply's first bit is seen in its middle, and begins some clocks after its frame was executed.
        begun = -(REPLIED + self.settings.board_parameters.clocks_per_three_bits // 6)
        latencies = {RX: _HEARD, RX_BROKEN: _HEARD, BEGIN: begun}
        self._shifts = np.array([latencies.get(kind, 0) for kind in range(len(_ORDER))])
        # More than any of them.
        self._hold = _HEARD - begun
        self.seen_export = Export("seen_export", self, self.see)
        # What is wrong, and the clock at which that was known.
        self.failures: list[tuple[str, int]] = []
        self.failed = 0
        self._released: int | None = None
        self._waiting: list[tuple[int, int, int, int]] = []
        self._pins: Seen | None = None

    def fail(self, what: str) -> None:
        """Note that something is wrong."""
        self.failed += 1
        report_failure(what, self.reference.replies)
        if len(self.failures) < DESCRIBED:
            self.failures.append((what, self.reference.clock))

    def see(self, seen: Seen) -> None:
        """Take what was seen; what may not be complete yet waits."""
        pins, before = seen.pins, self._pins
        for name in ("bad_clocks", "bad_scans", "framing_errors"):
            if getattr(pins, name) != (getattr(before.pins, name) if before else 0):
                self.fail(f"until clock {seen.clock}: {name} {getattr(pins, name)}")
        self._pins = seen
        events = seen.events
        kinds = events["kind"]
        rows = np.stack(
            [events["clock"] + self._shifts[kinds], _ORDERS[kinds], kinds, events["value"]], 1
        ).tolist()
        # Stable: events of one kind stay in their order.
        self._waiting = sorted([*self._waiting, *map(tuple, rows)], key=lambda row: row[:2])
        # What had not come to the pins yet when the button was pressed is lost; so is a byte's end just then.
        presses = events["clock"][(kinds == RESET) & (events["value"] == 1)].tolist()
        self.reference.presses += presses
        for pressed in presses:
            self._waiting = [
                row
                for row in self._waiting
                if row[2] not in _LINE or not row[0] - self._shifts[row[2]] <= pressed <= row[0]
            ]
        self._take(seen.clock - self._hold)

    def _take(self, until: int) -> None:
        reference = self.reference
        due = sum(row[0] <= until for row in self._waiting)
        for clock, _, kind, value in self._waiting[:due]:
            if clock > reference.clock:
                reference.clock_ends()
            reference.pass_time(clock)
            self._handlers[kind](self, clock, value)
        self._waiting = self._waiting[due:]
        reference.clock_ends()
        reference.pass_time(until)

    def _reset(self, clock: int, down: int) -> None:
        self.reference.pressed(bool(down))
        self._released = None if down else clock

    def _lit(self, clock: int, _: int) -> None:
        if self._released is None or clock != self._released + _LIT_AFTER:
            self.fail(f"clock {clock}: the displays begin, the button was let go at {self._released}")
        self._released = None

    def _beat(self, _: int, level: int) -> None:
        self.reference.beat_level = bool(level)

    _handlers: tuple[Callable[[Any, int, int], None], ...] = (
        lambda s, _, v: s.reference.byte(v),
        lambda s, _, v: s.reference.broken(),
        lambda s, _, v: s.reference.begin(),
        lambda s, _, v: s.reference.spoken(v),
        lambda s, _, v: None,
        lambda s, _, v: s.reference.see(v),
        _beat,
        _reset,
        _lit,
    )

    def check_digits(self) -> None:
        """Compare what the displays show, where all has been as it is for a while."""
        if self._pins is None:
            return
        shown, due = self._pins.pins.digits, self.reference.shown
        if self.settings.four_state:
            # No reset reaches what makes the number decimal: with four states it stays unknown.
            shown, due = shown[:4], due[:4]
        if shown != due:
            self.fail(f"clock {self._pins.clock}: the displays show {shown!r}, {due!r} is due")

    def check_phase(self) -> None:
        """Write the counts, and fail where anything did."""
        if self._pins:
            self._take(self._pins.clock)
        reference = self.reference
        reference.finish()
        counts = {
            "sent": reference.replies,
            "accepted": reference.replies,
            "checked": reference.replies,
            "runs": reference.runs,
            "gos": reference.gos,
            "resets": reference.resets,
            "clocks": reference.clock,
            "failed": self.failed,
            "failures": [
                {"blame": Blame.DESIGN, "message": message, "clock": clock}
                for message, clock in self.failures
            ],
        }
        self.write_counts(counts)
        for message, _ in self.failures:
            report(ERROR, message, "SCOREBOARD")
        if self.failed:
            raise AssertionError(f"{self.failed} failures, first: {self.failures[0][0]}")
        if not reference.replies or not reference.gos:
            raise AssertionError(f"{reference.replies} replies and {reference.gos} gos: nothing was checked")
