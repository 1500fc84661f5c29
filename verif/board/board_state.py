"""What the board shows and holds, as the reference follows it: pins, a frame, a run, a reply that is due."""

from dataclasses import dataclass, field

import numpy as np

from triaxis.golden.scene import SceneAnswer
from triaxis.verif.board.protocol import Code, Integers, Mode, State, Status
from triaxis.verif.board.protocol import End as RunEnd

# Of the pins the first that says beyond a zone; and the bits of both.
BEYOND, ALL_ZONES = 18, 3


@dataclass(frozen=True)
class Pins:
    """The pins, as the board's outputs and LEDs say them."""

    value: int

    def _bit(self, number: int) -> bool:
        return bool(self.value >> number & 1)

    @property
    def go(self) -> bool:
        """Return whether go is said."""
        return self._bit(0)

    @property
    def busy(self) -> bool:
        """Return whether a run is going on."""
        return self._bit(4)

    @property
    def waiting(self) -> bool:
        """Return whether near pairs wait."""
        return self._bit(6)

    @property
    def full(self) -> bool:
        """Return whether their ring is full."""
        return self._bit(7)

    @property
    def wrong(self) -> bool:
        """Return whether something went wrong, or a check failed."""
        return self._bit(9)

    @property
    def errors(self) -> int:
        """Return the low bits of the count of errors."""
        return self.value >> 10 & 0xFF

    @property
    def beyond(self) -> int:
        """Return which zones it is said to be beyond: bits, of slow and warn."""
        return self.value >> BEYOND & ALL_ZONES


@dataclass
class Frame:
    """A whole frame that the board holds, since ``end``; ``acted``: its effects were seen.

    ``due``: the clock in which it is executed; 0 where it waits for the reply before to end. ``silence``:
    that in which the watchdog's time is over if it is not.
    """

    command: int
    sequence: int
    session: int
    payload: bytes
    end: int
    acted: bool = False
    due: int = 0
    busy: bool = False
    state: str = ""
    silence: int = 0


@dataclass
class Run:
    """The last run, or none. ``written``: near pairs in the ring at least, ``ended``: clock or 0.

    ``fails``: a check fails in it, by its end, where nothing ends it before; ``may_fail``: one may, at any
    clock of it. ``comes``: it comes to what it tries, where nothing ends it before. ``persists``: it fails
    for as long as it goes on.
    ``scrub_finds``: one fails after it. ``hold``: for how long it permits, in the board's units; 0: without
    an end. ``margins``: how wide the zones are, from the innermost; ``found``: the outer ones in which any
    pair is, bits of slow and warn. ``taken``: near pairs that were read, by their number.
    """

    number: int = 0
    mode: int = 0
    margins: tuple[int, int, int] = (0, 0, 0)
    pose: tuple[int, int, int] = (0, 0, 0)
    tries: tuple[int, int] = (0, 0)
    hold: int = 0
    state: State = State.NEVER
    start: int = 0
    ended: int = 0
    overflow: bool = False
    maybe_aborted: bool = False
    # It was cut off so long before it ended that it cannot have ended by itself.
    cut_off: bool = False
    fails: bool = False
    may_fail: bool = False
    comes: bool = False
    persists: bool = False
    scrub_finds: bool = False
    # It began while a fault stood.
    spoiled: bool = False
    answer: SceneAnswer | None = None
    found: int = 0
    pairs: Integers = field(default_factory=lambda: np.empty((0, 2), np.int64))
    taken: dict[int, tuple[int, int]] = field(default_factory=dict)
    freed: int = 0
    written: int = 0

    @property
    def wider(self) -> int:
        """Return which zones are wider than the one within them, bits of slow and warn."""
        margin, slow, warn = self.margins
        return (slow > margin) + 2 * (warn > slow)

    @property
    def zones(self) -> int:
        """Return the bits of zones where the run ends by itself: no other zone was asked about."""
        return self.found | ~self.wider & ALL_ZONES

    @property
    def near(self) -> int:
        """Return how many pairs are near."""
        return int(self.answer.near.sum()) if self.answer else 0

    @property
    def offered(self) -> int:
        """Return how many near pairs go to the ring at most."""
        return 0 if self.mode == Mode.COUNT else min(self.near, 1) if self.mode == Mode.FIRST else self.near

    @property
    def end(self) -> RunEnd:
        """Return how it ends where nothing ends it before."""
        if self.overflow:
            return RunEnd.OVERFLOW
        return RunEnd.FIRST if self.mode == Mode.FIRST and self.near else RunEnd.COMPLETE


@dataclass(frozen=True)
class Due:
    """A reply that is due. ``status``: that it must have; None: the payload stands in ``payload``.

    ``doubtful``: whether a check has failed is what it says.
    """

    frame: Frame
    code: Code
    payload: bytes
    status: Status | None
    busy: bool
    first_pair: int = 0
    doubtful: bool = False
