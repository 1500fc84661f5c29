"""Asking a package about pairs of meshes: its time, its tests, and its answers against exact ones."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from triaxis.bench.error.peers.peer import PeerAbsentError
from triaxis.bench.skipping.clocked import clocked
from triaxis.bench.skipping.peers.mesh_peer import Counted, MeshPeer
from triaxis.host.broadphase import candidates
from triaxis.host.scene_engines import Integers


@dataclass(frozen=True)
class Meeting:
    """Two meshes, facets (N, 3, 3) and (M, 3, 3) in LSB, and the pairs that collide exactly: (K, 2)."""

    a: Integers
    b: Integers
    near: Integers


@dataclass(frozen=True)
class PeerRun:
    """What a package did about some pairs of meshes, in all.

    Seconds of processor time: to build its trees, and to ask. ``found``: different pairs that it returned;
    ``missed``, ``extra``: against the exact answer. ``volumes``, ``triangles``: comparisons of two bounding
    volumes, of two triangles; None where it does not tell.
    """

    name: str
    build_seconds: float
    ask_seconds: float
    found: int
    missed: int
    extra: int
    volumes: int | None
    triangles: int | None
    boxes_only: bool

    @property
    def contradicts(self) -> bool:
        """Return whether it compared boxes, which doubles do exactly here, and found others than we do."""
        return self.boxes_only and self.missed + self.extra > 0

    @property
    def seconds(self) -> float:
        """Return the time of all of it."""
        return self.build_seconds + self.ask_seconds


def contradiction(where: str, run: PeerRun) -> str:
    """Return a line about boxes that a package finds otherwise."""
    return (
        f"{where}: {run.name} misses {run.missed} pairs of boxes that we find, and finds {run.extra} others"
    )


@dataclass(frozen=True)
class Presence:
    """A package: its version, or why it is absent."""

    name: str
    distribution: str
    call: str
    version: str | None
    why_absent: str | None = None


def presence(peer: MeshPeer) -> Presence:
    """Return whether a package can be asked."""
    try:
        return Presence(peer.name, peer.distribution, peer.call, peer.version())
    except PeerAbsentError as error:
        return Presence(peer.name, peer.distribution, peer.call, None, str(error))


def ask_peer(peer: MeshPeer, meetings: Sequence[Meeting]) -> PeerRun:
    """Ask a package about all meetings, one after the other."""
    runs = [_ask(peer, meeting) for meeting in meetings]
    return PeerRun(
        peer.name,
        sum(run.build_seconds for run in runs),
        sum(run.ask_seconds for run in runs),
        sum(run.found for run in runs),
        sum(run.missed for run in runs),
        sum(run.extra for run in runs),
        _sum([run.volumes for run in runs]),
        _sum([run.triangles for run in runs]),
        peer.boxes_only,
    )


def _sum(counts: list[int | None]) -> int | None:
    known = [count for count in counts if count is not None]
    return sum(known) if len(known) == len(counts) else None


def _ask(peer: MeshPeer, meeting: Meeting) -> PeerRun:
    reals = meeting.a.astype(np.float64), meeting.b.astype(np.float64)
    question, build_seconds = clocked(lambda: peer.load(*reals))
    pairs, ask_seconds = clocked(question.ask)
    found, exact = _numbers(pairs, meeting), _numbers(_exact(peer, meeting), meeting)
    counted: Counted = question.count()
    return PeerRun(
        peer.name,
        build_seconds,
        ask_seconds,
        len(found),
        len(np.setdiff1d(exact, found, assume_unique=True)),
        len(np.setdiff1d(found, exact, assume_unique=True)),
        counted.volumes,
        counted.triangles,
        peer.boxes_only,
    )


def _exact(peer: MeshPeer, meeting: Meeting) -> Integers:
    if not peer.boxes_only:
        return meeting.near
    blocks = [np.stack(block, 1) for block in candidates(meeting.a, meeting.b, 0)]
    return np.concatenate([np.empty((0, 2), np.int64), *blocks])


def _numbers(pairs: Integers, meeting: Meeting) -> Integers:
    """Return a number for each different pair, ascending."""
    return np.unique(pairs[:, 0] * len(meeting.b) + pairs[:, 1])
