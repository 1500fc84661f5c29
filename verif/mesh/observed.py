"""What monitors of the engine publish, and a run as the scoreboard puts it together."""

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from triaxis.verif.mesh.items import RunRequest

Integers = npt.NDArray[np.int64]

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
    """A run was accepted. ``idle_abort``: abort was high since the run before had ended."""

    request: RunRequest
    idle_abort: bool = False


@dataclass(frozen=True)
class AbortAsked:
    """Abort was high at the clocks ``at`` after the run's acceptance, the first being 0."""

    at: int


@dataclass(frozen=True)
class NearTaken:
    """Near pairs (K, 2) as (index in A, index in B); ``wait``: clocks that they waited, at most."""

    pairs: Integers
    wait: int | None = None


@dataclass(frozen=True)
class CorePairs:
    """Pairs (K, 2) that the core accepted, as (index in A, index in B)."""

    pairs: Integers


@dataclass(frozen=True)
class Summary:
    """A summary that was taken. ``status`` as on the pins.

    ``offered_after``: clocks from the run's acceptance until it was offered; ``wait``: clocks that it waited;
    ``held``: triangles held in A and B, and ``overfull`` on the pins. None: not measured.
    """

    status: int
    cycles: int
    group_pairs_skipped: int
    group_pairs_opened: int
    pairs_skipped: int
    tested: int
    near: int
    offered_after: int | None = None
    wait: int | None = None
    held: tuple[int, int] | None = None
    overfull: int | None = None

    @property
    def last_abort(self) -> int:
        """Return the last clock after the run's acceptance at which an abort still had something to end."""
        return (self.cycles if self.offered_after is None else self.offered_after) - 2


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
    """A run with everything that was seen of it, until its summary. ``a``, ``b``: (N, 3, 3), (M, 3, 3)."""

    accepted: RunAccepted
    a: Integers
    b: Integers
    overfull: tuple[bool, bool]
    reloaded: tuple[bool, bool]
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
    def core_pairs(self) -> Integers:
        """Return the pairs that the core accepted: (K, 2)."""
        return np.concatenate([NO_PAIRS, *(part.pairs for part in self.reached)])

    @property
    def near_wait(self) -> int | None:
        """Return the longest that a near pair waited; None: none was measured."""
        waits = [part.wait for part in self.near if part.wait is not None]
        return max(waits) if waits else None
