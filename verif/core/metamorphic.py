"""Checks that need no golden model: variants of a pair must be answered alike.

Of a pair, its 72 orders, its images under the 48 symmetries of the cube and translations have the same
distance, so near and coplanar stay, and the degenerate flags follow A and B. Each variant maps the axes of a
kind (box, normals, edge x edge, edge x box) to each other, and kinds are numbered one after the other, so the
kind of the lowest separating axis stays too; more than the kind where the variant lets A and B, or the
coordinates, be. With operand gating the flags of pairs that a box axis decides read 0; whether one
does is as invariant. All this holds of cores without the edge x box axes as well.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from triaxis.golden.axes import BOX_AXES, NUM_AXES
from triaxis.sim.configuration import Configuration
from triaxis.sim.result import AXIS_MASK, AXIS_SHIFT, COPLANAR, DEGENERATE_A, DEGENERATE_B, NEAR
from triaxis.verif.core.stimulus.symmetry import (
    NUM_ORDERS,
    NUM_SYMMETRIES,
    SWAPPED,
    all_cube_symmetries,
    all_orders,
    random_translations,
)

PairArray = npt.NDArray[np.int32]
Margins = npt.NDArray[np.integer]
Words = npt.NDArray[np.uint16]
# The result words of pairs (N, 2, 3, 3) at margins (N,).
Run = Callable[[PairArray, Margins], Words]
Maker = Callable[[np.random.Generator, PairArray, int], PairArray]

# Translations of each pair, itself among them.
TRANSLATIONS = 8
# Variants in one call of `Run`, about.
_BLOCK = 1 << 16
# Failures described in full; beyond that they are only counted.
_DESCRIBED = 10

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


def groups_agree(words: Words, group: Group) -> npt.NDArray[np.bool_]:
    """Return, for the words of all variants of N pairs (N * size,), which are as the first of their pair
    demands: (N, size).
    """
    signatures = group.signatures[words].reshape(-1, group.size)
    # The axes that a swap exchanges have one signature: only the flags have to follow.
    signatures[:, group.swapped] = _flags_exchanged(signatures[:, group.swapped])
    return signatures == signatures[:, :1]


def gated_flags_are_zero(words: Words) -> npt.NDArray[np.bool_]:
    """Return which words (N,) obey operand gating: no flag where a box axis is claimed."""
    boxed = (words & NEAR == 0) & (words >> AXIS_SHIFT & AXIS_MASK < BOX_AXES)
    return ~boxed | (words & _FLAGS == 0)


@dataclass(frozen=True)
class VariantFailure:
    """A variant that was answered otherwise than its pair: (2, 3, 3) each, and their result words."""

    group: str
    base: int
    variant: int
    margin: int
    base_pair: PairArray
    variant_pair: PairArray
    base_word: int
    variant_word: int

    def __str__(self) -> str:
        """Return one line that says it all."""
        return (
            f"{self.group}: variant {self.variant} of pair {self.base} is answered {self.variant_word:#06x}, "
            f"the pair {self.base_word:#06x}: margin {self.margin}, {self.variant_pair.tolist()}, the pair "
            f"is {self.base_pair.tolist()}"
        )


@dataclass
class MetamorphicReport:
    """How many variants were compared, by group, how many failed, and the first failures."""

    compared: dict[str, int] = field(default_factory=dict)
    failed: int = 0
    failures: list[VariantFailure] = field(default_factory=list)

    @property
    def variants(self) -> int:
        """Return how many variants were compared."""
        return sum(self.compared.values())

    @property
    def room(self) -> int:
        """Return how many more failures are described."""
        return _DESCRIBED - len(self.failures)

    def count(self, group: str, good: npt.NDArray[np.bool_]) -> None:
        """Count variants of a group, those that failed among them."""
        self.compared[group] = self.compared.get(group, 0) + good.size
        self.failed += int((~good).sum())


def check_variants(
    run: Run,
    pairs: PairArray,
    margins: Margins,
    configuration: Configuration,
    rng: np.random.Generator,
    groups: Sequence[Group] = GROUPS,
) -> MetamorphicReport:
    """Run all variants of pairs (N, 2, 3, 3) at their margins (N,), and compare."""
    report = MetamorphicReport()
    for group in groups:
        step = max(1, _BLOCK // group.size)
        for start in range(0, len(pairs), step):
            block = slice(start, start + step)
            variants = group.make(rng, pairs[block], configuration.width)
            words = run(variants, np.repeat(margins[block], group.size))
            good = groups_agree(words, group)
            if configuration.gating:
                good &= gated_flags_are_zero(words).reshape(good.shape)
            report.count(group.name, good)
            for base, variant in np.argwhere(~good)[: report.room].tolist():
                first = base * group.size
                failure = VariantFailure(
                    group.name,
                    start + base,
                    variant,
                    int(margins[start + base]),
                    variants[first],
                    variants[first + variant],
                    int(words[first]),
                    int(words[first + variant]),
                )
                report.failures.append(failure)
    return report
