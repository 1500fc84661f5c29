"""A sample of the mesh engine's coverage model: finished runs, one row of numbers each, and what follows."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum, IntFlag

import numpy as np
import numpy.typing as npt

Codes = npt.NDArray[np.uint8]
Column = npt.NDArray[np.int64]

# A number that nobody could measure, as the wait of near pairs where there was none.
UNKNOWN = -1


@dataclass(frozen=True)
class MeshBuild:
    """The parameters of the engine that decide what can happen in it. ``pins``: driven pin by pin too.

    ``certified``: its core is.
    """

    name: str
    width: int
    margin_bits: int
    depth: int
    group: int
    lanes: int
    cycle_bits: int
    pins: bool = True
    certified: bool = False

    @property
    def largest_margin(self) -> int:
        """Return the largest margin that the engine can be given."""
        return (1 << self.margin_bits) - 1

    @property
    def groups(self) -> int:
        """Return how many groups a mesh can have."""
        return self.depth // self.group


class AbortSeen(IntFlag):
    """When an abort was asked for: while triangles settle, while pairs are scanned, once more while it is
    being done, when the summary waits, and when no run is going on.
    """

    STARTING = 1
    SCANNING = 2
    DRAINING = 4
    REPORTING = 8
    IDLE = 16


class Before(IntEnum):
    """What a run found: no fault, or one from before that stays, was acknowledged, or ended by a reset."""

    NO_FAULT = 0
    STAYS = 1
    ACKNOWLEDGED = 2
    RESET = 3


class Reloaded(IntEnum):
    """Which meshes were loaded since the run before."""

    NONE = 0
    ONLY_A = 1
    ONLY_B = 2
    BOTH = 3


@dataclass(frozen=True)
class MeshRow:
    """One run. Counts are those of the summary, ``rows_skipped`` of the exact answer.

    ``overfull``: bit 0 A, bit 1 B. ``fits``, ``beyond``: bit 2k+s, A moved ends exactly at the low (s = 0) or
    high end of the range on axis k, or one step beyond it, on that axis and side alone. ``row_gaps``,
    ``group_gaps``, ``pair_gaps``: bit 4k+2s+e, an axis k alone separates boxes by the margin (e = 0) or the
    smallest step more, B below (s = 0) or above. ``first_at``: number among the pairs tested. ``tried``,
    ``which``: what it tries, and which. ``scrubbed``: which the run before tried that only scrubbing finds.
    ``slow``, ``warn``: margins of zones, as asked for; ``zones``: bits of those in which something was
    found, or that are no wider than the one within; ``asked_again``: how often a pair was put to the core
    once more.
    """

    mode: int
    status: int
    count_a: int
    count_b: int
    overfull: int = 0
    margin: int = 0
    slow: int = 0
    warn: int = 0
    move_x: int = 0
    move_y: int = 0
    move_z: int = 0
    near: int = 0
    zones: int = 0
    asked_again: int = 0
    group_pairs_skipped: int = 0
    group_pairs_opened: int = 0
    rows: int = 0
    rows_skipped: int = 0
    pairs_skipped: int = 0
    tested: int = 0
    fits: int = 0
    beyond: int = 0
    row_gaps: int = 0
    group_gaps: int = 0
    pair_gaps: int = 0
    aborts: int = 0
    reloaded: int = int(Reloaded.BOTH)
    first_at: int = UNKNOWN
    saturated: int = 0
    loaded_with_run: int = 0
    near_wait: int = UNKNOWN
    done_wait: int = UNKNOWN
    tried: int = 0
    which: int = 0
    before: int = int(Before.NO_FAULT)
    scrubbed: int = UNKNOWN


class MeshView:
    """The columns of rows, by their names, in one build."""

    def __init__(self, build: MeshBuild, rows: Sequence[MeshRow]) -> None:
        """Turn rows into columns (N,)."""
        self.build = build
        names = MeshRow.__dataclass_fields__
        self._columns = {
            name: np.array([getattr(row, name) for row in rows], np.int64).reshape(-1) for name in names
        }

    def __getattr__(self, name: str) -> Column:
        """Return a column."""
        try:
            return self.__dict__["_columns"][name]
        except KeyError:
            raise AttributeError(name) from None
