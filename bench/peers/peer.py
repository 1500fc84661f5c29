"""Other packages that find collisions: optional, all behind one form, whether they are there or not.

Some are asked about pairs of triangles, some about two meshes: which of their facets collide, all pairs of
them. Meshes are the integers that our own broad phase takes, as float64: the same question, at margin 0.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np
import numpy.typing as npt

Reals = npt.NDArray[np.float64]

_INSTALL = "`make peers` installs it"


class PeerAbsentError(Exception):
    """The package is not installed, or does not start: why, and what would install it."""


@dataclass(frozen=True)
class Question:
    """What a package has made of its triangles: ready to be asked, again and again.

    ``ask`` returns, of pairs of triangles, which collide (N,); of two meshes, pairs of facets (K, 2) in any
    order, also more than once. ``count`` asks once more, and returns how often the package compared two
    bounding volumes, and two triangles; None where it does not tell.
    """

    ask: Callable[[], npt.NDArray[Any]]
    count: Callable[[], tuple[int | None, int | None]] = lambda: (None, None)


@dataclass(frozen=True)
class Peer:
    """A package's test of collisions.

    ``name`` for tables; ``distribution``: what it installs from; ``call``: the function that is timed.
    ``version`` returns the version; it raises PeerAbsentError where there is none. ``load`` makes the
    package's own objects of triangles (N, 3, 3) and (M, 3, 3), which is timed apart: of pairs, or of meshes.
    ``batched``: one call takes all pairs; otherwise each pair is a call, whose overhead has to be known.
    ``boxes_only``: it finds pairs whose boxes overlap, and leaves the triangles to others.
    """

    name: str
    distribution: str
    call: str
    version: Callable[[], str]
    load: Callable[[Reals, Reals], Question]
    batched: bool = False
    boxes_only: bool = False


@dataclass(frozen=True)
class Presence:
    """A package: its version, or why it is absent."""

    name: str
    distribution: str
    call: str
    version: str | None
    why_absent: str | None = None


def present(peers: Sequence[Peer]) -> tuple[list[tuple[Peer, str]], list[Presence]]:
    """Return the packages that are there with their versions, and what is to be said of each of all."""
    there: list[tuple[Peer, str]] = []
    told: list[Presence] = []
    for peer in peers:
        about = (peer.name, peer.distribution, peer.call)
        try:
            found = peer.version()
        except PeerAbsentError as error:
            told.append(Presence(*about, None, str(error)))
        else:
            there.append((peer, found))
            told.append(Presence(*about, found))
    return there, told


def imported(module: str) -> Any:
    """Return a module; raise PeerAbsentError where it is absent or does not start."""
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        raise PeerAbsentError(f"{error.name}: not installed: {_INSTALL}") from error
    # A library of the system that it needs may be missing.
    except (ImportError, OSError) as error:
        raise PeerAbsentError(f"{module}: installed, but does not start: {error}") from error


def installed_version(distribution: str, *modules: str) -> str:
    """Return the version of a package whose modules can be imported; raise PeerAbsentError otherwise."""
    for module in modules:
        imported(module)
    try:
        return version(distribution)
    except PackageNotFoundError as error:
        raise PeerAbsentError(f"{distribution}: not installed: {_INSTALL}") from error
