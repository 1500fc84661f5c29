"""Checks that need no golden model: variants of a pair must be answered alike.

Of a pair, its 72 orders, its images under the 48 symmetries of the cube and translations have the same
distance, so near and coplanar stay, and the degenerate flags follow A and B. Each variant maps the axes of a
kind (box, normals, edge x edge, edge x box) to each other, and kinds are numbered one after the other, so the
kind of the lowest separating axis stays too; more than the kind where the variant lets A and B, or the
coordinates, be. With operand gating the flags of pairs that a box axis decides read 0; whether one
does is as invariant. All this holds of cores without the edge x box axes as well.
"""

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from pyuvm import uvm_component, uvm_subscriber

from triaxis.coverage.core_sample import CoreSample
from triaxis.golden.axes import BOX_AXES, NUM_AXES
from triaxis.sim.result import AXIS_MASK, AXIS_SHIFT, COPLANAR, DEGENERATE_A, DEGENERATE_B, NEAR
from triaxis.verif.core.stimulus.symmetry import (
    NUM_ORDERS,
    NUM_SYMMETRIES,
    SWAPPED,
    all_cube_symmetries,
    all_orders,
    random_translations,
)
from triaxis.verif.testbench.environment import settings_of

PairArray = npt.NDArray[np.int32]
Words = npt.NDArray[np.uint16]
Maker = Callable[[np.random.Generator, PairArray, int], PairArray]

# Translations of each pair, itself among them.
TRANSLATIONS = 8

_FLAGS = COPLANAR | DEGENERATE_A | DEGENERATE_B
_BOX_X, _NORMALS, _EDGE_EDGE, _EDGE_BOX_A = 0, 3, 5, 14


def _signatures(groups_of_axes: Sequence[range]) -> Words:
    """Return, for each result word, what must not change where axes of a group may stand for each other.

    That is the word, with the first axis of the group in the place of the claimed one. (65536,)
    """
    first = np.arange(NUM_AXES)
    for axes in groups_of_axes:
        first[axes.start : axes.stop] = axes.start
    words = np.arange(1 << 16)
    rest = words & ~(AXIS_MASK << AXIS_SHIFT)
    clear = rest | first[words >> AXIS_SHIFT & AXIS_MASK] << AXIS_SHIFT
    # Where near, no axis is claimed, and its bits read 0.
    return np.where(words & NEAR, words, clear).astype(np.uint16)


def _flags_exchanged(words: Words) -> Words:
    """Return the words with the degenerate flags of A and B exchanged."""
    rest = words & np.uint16(0xFFFF ^ (DEGENERATE_A | DEGENERATE_B))
    a, b = words & np.uint16(DEGENERATE_A), words & np.uint16(DEGENERATE_B)
    return rest | a << np.uint16(1) | b >> np.uint16(1)


@dataclass(frozen=True)
class Group:
    """A kind of variants: how to make them, and what of their result words is the same for all.

    ``size`` variants of each pair follow each other; the first is the pair itself. ``signatures``: what
    must not change, by result word (65536,); ``swapped``: variants in which A and B are swapped, (size,).
    """

    name: str
    size: int
    make: Maker
    signatures: Words
    swapped: npt.NDArray[np.bool_]


def _translations(rng: np.random.Generator, pairs: PairArray, width: int) -> PairArray:
    variants = np.repeat(pairs, TRANSLATIONS, 0)
    moved = random_translations(rng, variants, width)
    moved[::TRANSLATIONS] = pairs
    return moved


# In another order, edges change their numbers, and the swap also exchanges A and B.
ORDERS = Group(
    "orders",
    NUM_ORDERS,
    lambda _rng, pairs, _width: all_orders(pairs),
    _signatures([range(_NORMALS, _EDGE_EDGE), range(_EDGE_EDGE, _EDGE_BOX_A), range(_EDGE_BOX_A, NUM_AXES)]),
    SWAPPED,
)
# A symmetry exchanges coordinates, and keeps edges.
SYMMETRIES = Group(
    "symmetries",
    NUM_SYMMETRIES,
    lambda _rng, pairs, _width: all_cube_symmetries(pairs),
    _signatures(
        [range(_BOX_X, _NORMALS)] + [range(start, start + 3) for start in range(_EDGE_BOX_A, NUM_AXES, 3)]
    ),
    np.zeros(NUM_SYMMETRIES, np.bool_),
)
# A translation changes no axis at all.
MOVES = Group("translations", TRANSLATIONS, _translations, _signatures([]), np.zeros(TRANSLATIONS, np.bool_))
GROUPS = (ORDERS, SYMMETRIES, MOVES)


def answered_alike(words: Words, group: Group, gating: bool) -> npt.NDArray[np.bool_]:
    """Return, for the words of all variants of N pairs (N * size,), which are as the first of their pair
    demands, and, with operand gating, have no flag where a box axis is claimed: (N, size).
    """
    signatures = group.signatures[words].reshape(-1, group.size)
    # The axes that a swap exchanges have one signature: only the flags have to follow.
    signatures[:, group.swapped] = _flags_exchanged(signatures[:, group.swapped])
    good = signatures == signatures[:, :1]
    if gating:
        boxed = (words & NEAR == 0) & (words >> AXIS_SHIFT & AXIS_MASK < BOX_AXES)
        good &= (~boxed | (words & _FLAGS == 0)).reshape(good.shape)
    return good


class MetamorphicCheck(uvm_subscriber):
    """Takes the answers in order, from the worker's thread; fails in check_phase."""

    def __init__(self, name: str, parent: uvm_component) -> None:
        """Start with nothing expected."""
        super().__init__(name, parent)
        self.gating = settings_of(self).configuration.gating
        self.compared = 0
        self.failed = 0
        # Groups that were sent and are not compared yet, with their numbers of pairs.
        self._due: deque[tuple[Group, int]] = deque()
        self._words = np.zeros(0, np.uint16)

    def expect(self, group: Group, bases: int) -> None:
        """Take note that the variants of so many pairs are about to be sent."""
        self._due.append((group, bases))

    def write(self, tt: CoreSample) -> None:  # pyright: ignore[reportIncompatibleMethodOverride]
        """Compare what is complete."""
        self._words = np.concatenate([self._words, tt.words])
        while self._due and len(self._words) >= self._due[0][0].size * self._due[0][1]:
            group, bases = self._due.popleft()
            words, self._words = np.split(self._words, [group.size * bases])
            good = answered_alike(words, group, self.gating)
            self.compared += good.size
            self.failed += int((~good).sum())

    def check_phase(self) -> None:
        """Fail where variants were answered differently, or were not compared."""
        if self.failed:
            raise AssertionError(f"{self.failed} of {self.compared} variants answered unlike their pair")
        if self._due or len(self._words) or not self.compared:
            raise AssertionError(f"{self.compared} variants compared, {len(self._words)} answers left over")
