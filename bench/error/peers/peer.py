"""What a package is asked: whether the triangles of each pair collide, in its cheapest way."""

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from triaxis.bench.error.truth import Triangles

# Asks about all pairs once more, and returns the verdicts (N,), true: they collide.
Ask = Callable[[], npt.NDArray[np.bool_]]


class PeerAbsentError(Exception):
    """The package is not installed, or does not start: why, and what would install it."""


class Peer(Protocol):
    """A package's test of two triangles.

    ``name`` for tables; ``distribution``: what it installs from; ``call``: the function that is timed.
    ``batched``: one call takes all pairs; otherwise each pair is a call, whose overhead has to be known.
    """

    name: str
    distribution: str
    call: str
    batched: bool

    def version(self) -> str:
        """Return the version; raise PeerAbsentError where there is none."""
        ...

    def load(self, a: Triangles, b: Triangles) -> Ask:
        """Make the package's own objects of the pairs (N, 3, 3) twice, which is not its kernel's time."""
        ...


def doubles(triangles: Triangles) -> npt.NDArray[np.float64]:
    """Return triangles as the float64 that most packages take: the same numbers."""
    return np.ascontiguousarray(triangles, np.float64)


def one_by_one(call: Callable[..., Any], arguments: list[tuple[Any, ...]]) -> Ask:
    """Return what calls a function on each pair's arguments; anything that is true is a collision."""

    def ask() -> npt.NDArray[np.bool_]:
        return np.array([call(*pair) for pair in arguments], dtype=object).astype(np.bool_)

    return ask
