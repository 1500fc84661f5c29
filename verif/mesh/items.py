"""Sequence items of the engine, beats on its pins, and what its monitors publish."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt
from pyuvm import uvm_sequence_item

from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.mesh_engine import NO_ZONES, Mode, Move
from triaxis.sim.packing import WHICH_BITS
from triaxis.verif.core.items import FULL_SPEED, Pace

Integers = npt.NDArray[np.int64]
# Of a run: its mode; above it what it tries, a kind, and which of so many.
_MODE_BITS, WHICHES = 2, 1 << WHICH_BITS


class LoadItem(uvm_sequence_item):
    """Triangles (N, 3, 3) for mesh 0 (A) or 1 (B), with gaps; more than fit are allowed.

    ``clear``: the mesh is emptied first; otherwise they are appended. ``clocks``: what it took,
    the driver's answer.
    """

    def __init__(
        self,
        mesh: int,
        triangles: npt.NDArray[np.integer[Any]],
        gaps: Pace = FULL_SPEED,
        clear: bool = True,
    ) -> None:
        """Hold the triangles."""
        super().__init__("load")
        self.mesh = mesh
        self.triangles = triangles
        self.gaps = gaps
        self.clear = clear
        self.clocks = 0


@dataclass(frozen=True)
class RunRequest:
    """What a run is asked for: ``mode`` may be 3, which is refused. ``tries``: a `Trial`, and which;
    ``zones``: margins of the zones slow and warn.
    """

    translation: Move = (0, 0, 0)
    margin: int = 0
    mode: int = int(Mode.ALL)
    tries: tuple[int, int] = (0, 0)
    zones: tuple[int, int] = NO_ZONES

    @property
    def margins(self) -> tuple[int, int, int]:
        """Return how wide the zones are, from the innermost: none is narrower than the one within it."""
        slow = max(self.margin, self.zones[0])
        return self.margin, slow, max(slow, self.zones[1])

    @property
    def not_wider(self) -> int:
        """Return bits of the zones slow and warn: those that are no wider than the one within them."""
        margin, slow, warn = self.margins
        return (slow == margin) | (warn == slow) << 1

    @property
    def zoned(self) -> bool:
        """Return whether any zone is wider than the margin."""
        return max(self.zones) > self.margin

    @property
    def trial(self) -> int:
        """Return what it tries, as on the pins."""
        kind, which = self.tries
        return kind * WHICHES + which


@dataclass(frozen=True)
class RunTraffic:
    """How a run's streams are treated. ``aborts``: clocks after its acceptance at which it is aborted.

    ``idle_abort``: abort is high for a clock before the run is offered, when there is none to abort;
    ``acknowledge``: acknowledge is, so that a fault is forgotten.
    """

    near: Pace = FULL_SPEED
    done: Pace = FULL_SPEED
    aborts: tuple[int, ...] = ()
    idle_abort: bool = False
    acknowledge: bool = False


class RunItem(uvm_sequence_item):
    """A run, and how its streams are treated.

    ``following``: a run that is offered as soon as this one is accepted, and waits for its end. ``clocks``:
    from its acceptance until its summary was taken; the driver's answer.
    """

    def __init__(self, request: RunRequest, traffic: RunTraffic | None = None) -> None:
        """Hold the request."""
        super().__init__("run")
        self.request = request
        self.traffic = traffic or RunTraffic()
        self.following: RunItem | None = None
        self.clocks = 0


@dataclass(frozen=True)
class Scene:
    """A whole scene: meshes to load, None where the one that is there stays, and the runs on them.

    ``gaps``: on loading. ``early``: the first run is offered together with the last mesh's triangles, and
    takes what is there when the engine accepts it. ``chained``: each run but the first is offered while
    the one before goes on. ``append``: triangles are added to the meshes that are there.
    """

    a: Integers | None
    b: Integers | None
    runs: tuple[tuple[RunRequest, RunTraffic], ...]
    gaps: Pace = FULL_SPEED
    early: bool = False
    chained: bool = False
    append: bool = False
    kind: str = field(default="", compare=False)


def _packed(values: Iterable[int], bits: int) -> int:
    mask = (1 << bits) - 1
    return sum((value & mask) << bits * n for n, value in enumerate(values))


def _unpacked(word: int, bits: int, count: int) -> list[int]:
    """Return signed numbers, the lowest first."""
    sign, mask = 1 << (bits - 1), (1 << bits) - 1
    return [((word >> bits * n & mask) ^ sign) - sign for n in range(count)]


def pack_triangle(triangle: Sequence[int], width: int) -> int:
    """Return tdata for nine coordinates."""
    return _packed(triangle, width)


def unpack_triangle(data: int, width: int) -> Integers:
    """Return a triangle (3, 3)."""
    return np.array(_unpacked(data, width, 9), np.int64).reshape(3, 3)


def pack_run(request: RunRequest, configuration: MeshConfiguration) -> tuple[int, int]:
    """Return tdata and tuser of a run."""
    data = _packed(request.translation, configuration.width + 1)
    user = request.trial << _MODE_BITS | request.mode
    for margin in (*request.zones[::-1], request.margin):
        user = user << configuration.margin_bits | margin
    return data, user


def unpack_run(data: int, user: int, configuration: MeshConfiguration) -> RunRequest:
    """Return what a beat asks for."""
    x, y, z = _unpacked(data, configuration.width + 1, 3)
    bits = configuration.margin_bits
    margin, slow, warn = (user >> bits * zone & configuration.max_margin for zone in range(3))
    rest = user >> 3 * bits
    trial = divmod(rest >> _MODE_BITS, WHICHES)
    return RunRequest((x, y, z), margin, rest % (1 << _MODE_BITS), trial, (slow, warn))


def unpack_pair(data: int, configuration: MeshConfiguration) -> tuple[int, int]:
    """Return (index in A, index in B) of a near pair's tdata."""
    return data & (configuration.depth - 1), data >> configuration.index_bits


NO_PAIRS = np.empty((0, 2), np.int64)


@dataclass(frozen=True)
class Loaded:
    """Triangles (N, 3, 3) that mesh 0 or 1 accepted, after it was emptied where ``clear`` says so."""

    mesh: int
    clear: bool
    triangles: Integers
    with_run: bool = False


@dataclass(frozen=True)
class RunAccepted:
    """A run was accepted. ``idle_abort``, ``acknowledged``: these were high since the run before."""

    request: RunRequest
    idle_abort: bool = False
    acknowledged: bool = False


@dataclass(frozen=True)
class AbortAsked:
    """Abort was high at the clocks ``at`` after the run's acceptance, the first being 0."""

    at: int


@dataclass(frozen=True)
class NearTaken:
    """Near pairs (K, 2) as (index in A, index in B); ``wait``: clocks that they waited, at most."""

    pairs: Integers
    wait: int = 0


@dataclass(frozen=True)
class CorePairs:
    """Pairs (K, 2) that the core accepted, as (index in A, index in B)."""

    pairs: Integers


@dataclass(frozen=True)
class Summary:
    """A summary that was taken. ``status``, and ``zones``, bits of slow and warn, as on the pins: of a
    complete run 0 where nothing is in a zone that is wider than the one within it.

    ``offered_after``: clocks from the run's acceptance until it was offered; ``wait``: clocks that it waited;
    ``held``: triangles held in A and B; ``signatures``: of these; ``overfull``, ``fault``: on the pins;
    ``clock``: at which it was taken, the first of the run of the test being 0.
    """

    status: int
    cycles: int
    group_pairs_skipped: int
    group_pairs_opened: int
    pairs_skipped: int
    tested: int
    near: int
    zones: int
    offered_after: int
    wait: int
    held: tuple[int, int]
    signatures: tuple[int, int]
    overfull: int
    fault: int
    clock: int

    @property
    def last_abort(self) -> int:
        """Return the last clock after the run's acceptance at which an abort still had something to end."""
        return self.offered_after - 2


@dataclass
class MeshState:
    """What a mesh must hold: the first ``depth`` triangles given since it was emptied."""

    depth: int
    parts: list[Integers] = field(default_factory=list)
    given: int = 0
    reloaded: bool = False

    def take(self, loaded: Loaded) -> None:
        """Follow a load."""
        self.reloaded = True
        if loaded.clear:
            self.empty()
        self.parts.append(loaded.triangles)
        self.given += len(loaded.triangles)

    def empty(self) -> None:
        """Forget everything."""
        self.parts, self.given = [], 0

    @property
    def overfull(self) -> bool:
        """Return whether more were given than fit."""
        return self.given > self.depth

    @property
    def triangles(self) -> Integers:
        """Return what it holds: (N, 3, 3)."""
        if len(self.parts) != 1:
            self.parts = [np.concatenate([np.empty((0, 3, 3), np.int64), *self.parts])]
        return self.parts[0][: self.depth]


@dataclass
class ObservedRun:
    """A run with everything that was seen of it, until its summary. ``a``, ``b``: (N, 3, 3), (M, 3, 3).

    ``after_reset``: no run was accepted since.
    """

    accepted: RunAccepted
    a: Integers
    b: Integers
    overfull: tuple[bool, bool]
    reloaded: tuple[bool, bool]
    after_reset: bool = False
    loaded_with_run: bool = False
    near: list[NearTaken] = field(default_factory=list)
    reached: list[CorePairs] = field(default_factory=list)
    aborts: list[int] = field(default_factory=list)

    @property
    def request(self) -> RunRequest:
        """Return what was asked for."""
        return self.accepted.request

    @property
    def near_pairs(self) -> Integers:
        """Return the near pairs taken: (K, 2)."""
        return np.concatenate([NO_PAIRS, *(part.pairs for part in self.near)])

    @property
    def asked(self) -> Integers:
        """Return the pairs that the core accepted, (K, 2), as often as it did."""
        return np.concatenate([NO_PAIRS, *(part.pairs for part in self.reached)])

    @property
    def core_pairs(self) -> Integers:
        """Return the pairs that the core accepted, (K, 2), each where it was asked first."""
        if not self.request.zoned:
            return self.asked
        return self.asked[np.sort(np.unique(self.asked, axis=0, return_index=True)[1])]

    @property
    def times_asked(self) -> Integers:
        """Return how often the core was asked about each of them, (K,), in no order."""
        return np.unique(self.asked, axis=0, return_counts=True)[1]

    @property
    def asked_again(self) -> int:
        """Return how often the core was asked about a pair once more."""
        return len(self.asked) - len(self.core_pairs)
