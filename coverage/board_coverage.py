"""What the board must have been seen doing. A transaction is what happened: (item, bin), by name."""

from collections.abc import Iterator, Sequence
from functools import cache
from itertools import product

import numpy as np

from triaxis.coverage.counts import Counts
from triaxis.coverage.cover_model import Codes, CoverItem, CoverModel, Coverpoint
from triaxis.sim.validity import Sources

Happened = tuple[str, str]
View = Sequence[Happened]

# See core_coverage.py.
_SOURCES = Sources(("triaxis.coverage.board_coverage", "triaxis.verif.board.reference"))

COMMANDS = ("HELLO", "LOAD", "RUN", "RESULTS", "STATUS", "ABORT")
GO, RUNNING, STOP = STATES = ("go", "run", "stop")
LINE = (
    "bad CRC", "too short", "too long", "bad stuffing", "END after ESC", "no stop bit", "frame still held",
)  # fmt: skip
MODES = ("FIRST", "ALL", "COUNT")
MARGINS = ("margin", "slow", "warn")
# Zones that are wider than the one within them; where a complete run found something; what is said of the
# zones while go is, by bits of slow and warn, which it is not beyond.
WIDER = ("none", "slow", "warn", "both")
NOWHERE, IN_WARN, IN_SLOW, NEAR = ("nowhere", "in warn", "in slow", "within the margin")
ZONES = ("beyond both", "beyond warn", "beyond slow", "beyond none")
# What a run tries; of each kind one of so many. The last three always fail.
TRIALS = ("CLAIM", "PARITY", "NUMBER", "MEMORY", "WALK", "INTAKE", "BOARD")
_WHICHES, _ALWAYS_FAIL = 32, 3


def _done() -> Iterator[str]:
    """Executed in a state, or sent again in it. What changes something is refused during a run."""
    for command, state in product(COMMANDS, STATES):
        if state != RUNNING or command not in ("LOAD", "RUN"):
            yield f"{command}, {state}"
        # The last command was another one where go is said, or a run goes on, but for these.
        if state == STOP or command in ("RUN", "RESULTS", "STATUS"):
            yield f"{command} again, {state}"


def _refused() -> Iterator[str]:
    for command in COMMANDS:
        yield from (f"{code} of {command}" for code in ("LENGTH", "SESSION", "SEQUENCE"))
    yield from (f"BUSY of {command}" for command in ("LOAD", "RUN"))
    yield from (f"VALUE of {command}" for command in ("HELLO", "LOAD", "RUN", "RESULTS"))
    yield from ("UNKNOWN of another", "PLACE of LOAD", "OVERFULL of LOAD", "COUNTS of RUN", "EMPTY of RUN")
    yield from (f"{margin} too wide" for margin in MARGINS)


def _ends() -> Iterator[str]:
    what = ("HELLO", "LOAD", "RUN", "ABORT", "refusal", "line", "watchdog", "fault")
    yield from (f"{one} ends {state}" for one, state in product(what, ("go", "a promise of go")))
    yield from (f"{one} ends go" for one in ("deadline", "end of a run"))


def _moments() -> Iterator[str]:
    """Clocks from the end of a run, of the watchdog's time, or of a hold, to what would end or need it."""
    yield from (f"end of a run {clocks:+d}, deadline" for clocks in range(-2, 1))
    for command, what in (("ABORT", "run"), ("RUN", "run"), ("HELLO", "silence"), ("RUN", "silence")):
        # An ABORT two clocks before the end ends the run itself, later.
        for clocks in range(-1 if command == "ABORT" else -2, 3):
            yield f"{command} {clocks:+d}, {what}"


def _runs() -> Iterator[str]:
    for mode in MODES:
        yield from (
            f"{mode}, clear, go",
            f"{mode}, clear, no go",
            f"{mode}, out of range",
            f"{mode}, aborted",
        )
        yield f"{mode}, near"
        yield f"{mode}, fault"


def _tried() -> Iterator[str]:
    yield from (f"{kind}, fault" for kind in TRIALS)
    yield from (f"{kind}, no fault" for kind in TRIALS[:-_ALWAYS_FAIL])


def _holds() -> Iterator[str]:
    """How runs end that hold, while go is said from the one before."""
    yield from ("begun while go is said", "late, rest", "late, run")
    yield from (f"clear, go, {when}" for when in ("in time", "last clock"))
    yield from (f"{how}, in time" for how in ("near", "out of range"))


def found_in(zones: int, near: int) -> str:
    """Return where a complete run found something; ``zones``: bits of those in which any pair is."""
    return NEAR if near else {0: NOWHERE, 2: IN_WARN}.get(zones, IN_SLOW)


def _zones() -> Iterator[str]:
    """Where something may be found, by the zones that are asked for: the others are as wide as one within."""
    found = {"none": (), "slow": (IN_SLOW,), "warn": (IN_WARN,), "both": (IN_WARN, IN_SLOW)}
    for asked in WIDER:
        yield from (f"{asked}, {where}" for where in (NOWHERE, *found[asked], NEAR))


def _beyond() -> Iterator[str]:
    yield from (f"go, {one}" for one in ZONES)
    yield from (f"{one}, then {other}" for one, other in product(ZONES, (*ZONES, "stop")))


_FAULTS = (
    "a run while it stands",
    "found between runs",
    "HELLO acknowledges it",
    "HELLO while it goes on",
    "go after it was acknowledged",
)


@cache
def board_model() -> CoverModel[View]:
    """Return the coverage model of a board, of any size."""
    ring = (*product(("none", "some", "32"), ("run", "ended")),)
    items = (
        ("board_done", "commands executed, or sent again x what the outputs say", _done()),
        ("board_refused", "codes of refusals x command", _refused()),
        ("board_ends", "what ends go, or a run or its result that could still give it", _ends()),
        (
            "board_moments",
            "commands, ends of runs: clocks from the end of a run, of the watchdog's time, of a hold",
            _moments(),
        ),
        ("board_holds", "runs that hold: when one begins, how it ends, what comes late", _holds()),
        ("board_runs", "mode x how a run ended", _runs()),
        ("board_zones", "zones that a run asks for x where a complete one found something", _zones()),
        ("board_beyond", "what is said of the zones: as go begins, is held, ends", _beyond()),
        (
            "board_line",
            "what is wrong on the line x what the outputs say",
            map(", ".join, product(LINE, STATES)),
        ),
        (
            "board_trials",
            "what a run came to try: kind x which",
            (f"{kind} {which}" for kind, which in product(TRIALS, range(_WHICHES))),
        ),
        ("board_tried", "kind of what a run tries x whether it was a fault", _tried()),
        ("board_faults", "what comes while a fault stands, and after", iter(_FAULTS)),
        ("board_near", "near pairs in a reply x whether the run goes on", map(", ".join, ring)),
    )
    return CoverModel("board", tuple(_item(*item) for item in items), _SOURCES)


def _item(name: str, meaning: str, bins: Iterator[str]) -> CoverItem[View]:
    names = tuple(bins)
    numbers = {(name, one): number for number, one in enumerate(names)}

    def codes(view: View) -> Codes:
        return np.array([numbers.get(one, len(names)) for one in view], np.uint8)

    return CoverItem(name, meaning, (Coverpoint(name, names, codes, partial=True),))


class BoardCoverage:
    """Collects the coverage of a board."""

    def __init__(self) -> None:
        """Start with zero counts."""
        self.model = board_model()
        self.counts = Counts.empty(self.model)

    def sample(self, happened: View) -> None:
        """Count what happened."""
        if happened:
            self.counts.sample(self.model, happened)
