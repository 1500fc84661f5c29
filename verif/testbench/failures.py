"""How a run can fail, in types: no message needs to be read to know what a failure is about."""

from enum import StrEnum


class Blame(StrEnum):
    """What a failure that a scoreboard found speaks against."""

    DESIGN = "design"
    # Two judges of one answer disagree, or one gives no certificate.
    JUDGES = "judges"
    # The test itself: it checked nothing, or what was seen belongs to nothing that was asked for.
    TEST = "test"


class HungError(AssertionError):
    """What is under test does not come to the end of what it accepted."""
