"""How a run can fail, in types: no message needs to be read to know what a failure is about."""

from collections.abc import Callable
from enum import StrEnum

# Failures that a scoreboard describes in full; beyond that they are only counted.
DESCRIBED = 10
# After so many no test goes on until enough has come out right: it may never.
HOPELESS = 100


class Blame(StrEnum):
    """What a failure that a scoreboard found speaks against."""

    DESIGN = "design"
    # Two judges of one answer disagree, or one gives no certificate.
    JUDGES = "judges"
    # The test itself: it checked nothing, or what was seen belongs to nothing that was asked for.
    TEST = "test"


class HungError(AssertionError):
    """What is under test does not come to the end of what it accepted."""


_listener: Callable[[str, int], None] | None = None


def listen(conclude: Callable[[str, int], None]) -> None:
    """Have every failure told at once, with the pairs that were checked until then."""
    global _listener
    _listener = conclude


def ends_at_first() -> bool:
    """Return whether the run ends at its first failure: nothing else of it is looked at."""
    return _listener is not None


def report_failure(message: str, pairs: int = 0) -> None:
    """Tell of a failure whoever listens; to a run that goes on to its end nobody does."""
    if _listener:
        _listener(message, pairs)
