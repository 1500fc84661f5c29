"""What a package is asked about two meshes: which of their facets collide, all pairs of them.

Meshes are the integers that our own broad phase takes, as float64: the same question, at margin 0.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

Reals = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Counted:
    """How often a package compared two bounding volumes, and two triangles; None where it does not tell."""

    volumes: int | None = None
    triangles: int | None = None


@dataclass(frozen=True)
class Question:
    """Two meshes as the package holds them: ready to be asked.

    ``ask`` returns facet pairs (K, 2), (number in A, in B), in any order, also more than once. ``count`` asks
    once more and counts.
    """

    ask: Callable[[], Integers]
    count: Callable[[], Counted]


class MeshPeer(Protocol):
    """A package's search for colliding facets."""

    @property
    def name(self) -> str:
        """Return its name, for tables."""
        ...

    @property
    def distribution(self) -> str:
        """Return what it installs from."""
        ...

    @property
    def call(self) -> str:
        """Return the function that is timed."""
        ...

    @property
    def boxes_only(self) -> bool:
        """Return whether it finds pairs whose boxes overlap, and leaves the triangles to others."""
        ...

    def version(self) -> str:
        """Return the version; raise PeerAbsentError where there is none."""
        ...

    def load(self, a: Reals, b: Reals) -> Question:
        """Build its trees over facets (N, 3, 3) and (M, 3, 3): timed as building."""
        ...
