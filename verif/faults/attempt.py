"""What trying a fault gave, before its counterexample is made."""

from collections.abc import Callable
from dataclasses import dataclass

from triaxis.verif.faults.result import Catch, Example


def _no_example() -> None:
    return None


@dataclass(frozen=True)
class Attempt:
    """``catch`` is None where nothing caught the fault, and ``reason`` says why.

    ``clean``: all that was tried ended well, and passed. ``example`` makes the counterexample, in the main
    thread; None where there is none.
    """

    catch: Catch | None
    reason: str | None = None
    clean: bool = False
    example: Callable[[], Example | None] = _no_example
