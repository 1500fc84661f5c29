"""Tests whose monitor lies: they must fail, which shows that the scoreboard's checks can."""

from collections.abc import Callable
from dataclasses import replace
from itertools import count

import numpy as np

from triaxis.sim.simulated_board import BEAT, BEGIN, LIT, PINS, RX, TX
from triaxis.verif.board.board_state import BEYOND
from triaxis.verif.board.go_tests import BoardSmokeTest
from triaxis.verif.board.line_agent import LineMonitor, Seen
from triaxis.verif.testbench.sabotage import lie_about

_GO, _STOP = 0b101, 0b1010


class _SabotagedTest(BoardSmokeTest):
    """Sends what the smoke test sends to a scoreboard that is told one lie about events of one kind."""

    kind: int
    # From an event of that kind, those that are told in its place; and of which of them, counted from 0.
    falsify: Callable[[np.void], list[np.void]]
    which: range

    def build_phase(self) -> None:
        """Put the liar in the place of the honest monitor."""
        super().build_phase()
        numbers, which = count(), type(self).which

        def told(event: np.void) -> list[np.void]:
            chosen = event["kind"] == self.kind and next(numbers) in which
            return type(self).falsify(event.copy()) if chosen else [event]

        def lie(seen: Seen) -> list[Seen]:
            events = [one for event in seen.events for one in told(event)]
            return [replace(seen, events=np.array(events, seen.events.dtype))]

        lie_about(LineMonitor, lie, range(1 << 30))


def _changed(name: str, change: Callable[[int], int]) -> Callable[[np.void], list[np.void]]:
    def falsify(event: np.void) -> list[np.void]:
        event[name] = change(int(event[name]))
        return [event]

    return staticmethod(falsify)  # pyright: ignore[reportReturnType]


_lost = staticmethod(lambda _: [])


class BoardGoTooMuchTest(_SabotagedTest):
    """Go is seen where stop is said."""

    kind, which, falsify = PINS, range(3, 4), _changed("value", lambda pins: pins & ~_STOP | _GO)


class BoardBeyondTooMuchTest(_SabotagedTest):
    """Beyond a zone is seen where stop is said."""

    kind, which, falsify = PINS, range(3, 4), _changed("value", lambda pins: pins | 1 << BEYOND)


class BoardGoLateTest(_SabotagedTest):
    """Pins are seen to change a clock late."""

    kind, which, falsify = PINS, range(6, 7), _changed("clock", lambda clock: clock + 1)


class BoardPinsLostTest(_SabotagedTest):
    """A change of the pins is not seen."""

    kind, which, falsify = PINS, range(5, 6), _lost


class BoardByteLostTest(_SabotagedTest):
    """A byte to the board is not seen: its frame is damaged, and must not be answered."""

    kind, which, falsify = RX, range(80, 81), _lost


class BoardOtherReplyTest(_SabotagedTest):
    """A bit of a byte of a reply is seen otherwise."""

    kind, which, falsify = TX, range(110, 111), _changed("value", lambda byte: byte ^ 1)


class BoardReplyCutTest(_SabotagedTest):
    """From some byte on nothing of any reply is seen but that it begins."""

    kind, which, falsify = TX, range(110, 1 << 30), _lost


class BoardReplyUnaskedTest(_SabotagedTest):
    """A reply begins twice."""

    kind, which = BEGIN, range(4, 5)
    falsify = staticmethod(lambda event: [event, event])


class BoardReplyLostTest(_SabotagedTest):
    """The beginning of a reply is not seen."""

    kind, which, falsify = BEGIN, range(4, 5), _lost


class BoardBeatLostTest(_SabotagedTest):
    """An edge of the beat is not seen."""

    kind, which, falsify = BEAT, range(2, 3), _lost


class BoardLitLateTest(_SabotagedTest):
    """The displays are seen to begin a clock late after the reset."""

    kind, which, falsify = LIT, range(1), _changed("clock", lambda clock: clock + 1)


class BoardNothingTest(BoardSmokeTest):
    """Nothing is sent, so nothing is checked."""

    async def stimulus(self) -> None:
        """Send nothing."""
