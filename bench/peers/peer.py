"""Other packages that find collisions: optional, all behind one form, whether they are there or not.

Some are asked about pairs of triangles, some about two meshes: which of their facets collide, all pairs of
them. Meshes are the integers that our own broad phase takes, as float64: the same question, at margin 0.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

Singles = npt.NDArray[np.float32]
Reals = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

# Asks about all pairs once more, and returns the verdicts (N,), true: they collide.
Ask = Callable[[], npt.NDArray[np.bool_]]

_INSTALL = "`make peers` installs it"


class PeerAbsentError(Exception):
    """The package is not installed, or does not start: why, and what would install it."""


@dataclass(frozen=True)
class Peer:
    """A package's test of collisions.

    ``name`` for tables; ``distribution``: what it installs from; ``call``: the function that is timed.
    ``version`` returns the version; it raises PeerAbsentError where there is none.
    """

    name: str
    distribution: str
    call: str
    version: Callable[[], str]


@dataclass(frozen=True)
class TrianglePeer(Peer):
    """A package's test of two triangles.

    ``load`` makes the package's own objects of the pairs, (N, 3, 3) twice, which is not its kernel's time.
    ``batched``: one call takes all pairs; otherwise each pair is a call, whose overhead has to be known.
    """

    load: Callable[[Singles, Singles], Ask]
    batched: bool = False


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
    count: Callable[[], Counted] = Counted


@dataclass(frozen=True)
class MeshPeer(Peer):
    """A package's search for colliding facets.

    ``load`` builds its trees over facets (N, 3, 3) and (M, 3, 3): timed as building. ``boxes_only``: it finds
    pairs whose boxes overlap, and leaves the triangles to others.
    """

    load: Callable[[Reals, Reals], Question]
    boxes_only: bool = False


@dataclass(frozen=True)
class Presence:
    """A package: its version, or why it is absent."""

    name: str
    distribution: str
    call: str
    version: str | None
    why_absent: str | None = None


AnyPeer = TypeVar("AnyPeer", bound=Peer)


def presence(peer: Peer) -> Presence:
    """Return whether a package can be asked."""
    try:
        return Presence(peer.name, peer.distribution, peer.call, peer.version())
    except PeerAbsentError as error:
        return Presence(peer.name, peer.distribution, peer.call, None, str(error))


def present(peers: Sequence[AnyPeer]) -> tuple[list[tuple[AnyPeer, str]], list[Presence]]:
    """Return the packages that are there with their versions, and what is to be said of each of all."""
    found = [presence(peer) for peer in peers]
    there = [
        (peer, each.version) for peer, each in zip(peers, found, strict=True) if each.version is not None
    ]
    return there, found


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
