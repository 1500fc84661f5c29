"""What the numbers in requests and replies stand for."""

from enum import IntEnum, IntFlag

# The version of the protocol, and what a reply adds to its command.
PROTOCOL = 3
REPLY = 0x80


class Command(IntEnum):
    """What the host may ask for."""

    HELLO = 1
    LOAD = 2
    MOVE = 3
    RUN = 4
    RESULTS = 5
    STATUS = 6
    ABORT = 7


class Code(IntEnum):
    """What the board says to it."""

    OK = 0
    UNKNOWN_COMMAND = 1
    BAD_LENGTH = 2
    OTHER_SESSION = 3
    BAD_SEQUENCE = 4
    BUSY = 5
    BAD_VALUE = 6
    OUT_OF_PLACE = 7
    COUNTS_DIFFER = 8
    EMPTY_MESH = 9
    OVERFULL = 10


class Mesh(IntEnum):
    """The board's two memories."""

    A = 0
    B = 1


class Mode(IntEnum):
    """What a run looks for."""

    FIRST = 0
    ALL = 1
    COUNT = 2


class State(IntEnum):
    """Where the board's last run stands."""

    IDLE = 0
    RUNNING = 1
    DONE = 2


class RunEnd(IntEnum):
    """How the engine ended a run."""

    NONE = 0
    COMPLETE = 1
    FIRST = 2
    ABORTED = 3
    OVERFLOW = 4
    OVERFULL = 5
    BAD_MODE = 6


class Flag(IntFlag):
    """Bits of a status."""

    GO = 1
    NEAR_WAITING = 2
    WATCHDOG_EXPIRED = 4
