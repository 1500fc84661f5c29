"""A sample of the core's coverage model: N checked pairs as arrays, and what follows from them.

Everything here costs a few nanoseconds a pair, so arrays are bytes wherever they can be.
"""

from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property

import numpy as np
import numpy.typing as npt

from triaxis.golden.axes import BOX_AXES, NUM_AXES
from triaxis.golden.facts import Facts, Mask
from triaxis.sim.configuration import Configuration
from triaxis.sim.packing import PARITIES, WHICH_BITS, Try

Codes = npt.NDArray[np.uint8]

# The axes before the 18 edge x box axes.
SPACE_AXES = 14
# The result word, see docs/interface.md: bit 0 near; 1..3 flags; 12..8 the claim; others 0.
_CLAIM_SHIFT, _CLAIM_BITS, _FLAG_SHIFT, _RESERVED = 8, 0x1F, 1, 0xE0F0


def axes_of(configuration: Configuration) -> int:
    """Return how many axes a core has: the first of the 32."""
    return NUM_AXES if configuration.edge_box else SPACE_AXES


class Decision(IntEnum):
    """How a pair is decided."""

    BOX = 0
    OTHER = 1
    NEAR = 2


class Relation(IntEnum):
    """How two triangles lie, as closed sets; with a margin, "touching" is being exactly that far apart."""

    CLEAR = 0
    TOUCHING = 1
    A_IN_B = 2
    B_IN_A = 3
    IDENTICAL = 4
    COPLANAR = 5
    PENETRATING = 6


@dataclass(frozen=True)
class CoreSample:
    """N checked pairs in the order in which the core took them, all arrays of shape (N,).

    ``facts``: what the bulk checker says, over all 32 axes. ``margins``: in LSB. ``words``: TDATA of the
    results, bits as docs/interface.md lists them. ``waits_in``, ``waits_out``: clocks that a pair was offered
    to the core before it was taken, and a result by it; any integer type, narrow ones are faster. They may
    saturate, at 8 or more. ``clocks``: the clock at which each result was taken. ``attempts``: what each pair
    tried of a certified core, see `triaxis.sim.packing.Try`.
    """

    facts: Facts
    margins: npt.NDArray[np.integer]
    words: npt.NDArray[np.uint16]
    waits_in: npt.NDArray[np.integer]
    waits_out: npt.NDArray[np.integer]
    clocks: npt.NDArray[np.integer]
    attempts: Codes

    def __post_init__(self) -> None:
        """Refuse arrays of different lengths."""
        arrays = (self.margins, self.words, self.waits_in, self.waits_out, self.clocks, self.attempts)
        lengths = {len(self.facts), *map(len, arrays)}
        if len(lengths) > 1:
            raise ValueError(f"arrays of one sample have different lengths: {sorted(lengths)}")


class CoreView:
    """A sample as a core of that build sees it.

    Without the edge x box axes those axes decide nothing: masks of axes are cut down to those of the build,
    here and nowhere else. What the triangles are to each other, `relation` and `support`, is geometry and
    taken from all 32 axes.
    """

    def __init__(self, build: Configuration, sample: CoreSample) -> None:
        """Compute nothing yet."""
        self.build = build
        self.sample = sample
        self.facts = sample.facts

    def _of_build(self, mask: Mask) -> Mask:
        return mask if self.build.edge_box else mask & np.uint32((1 << SPACE_AXES) - 1)

    @cached_property
    def below(self) -> Mask:
        """Return the axes on which B lies below A."""
        return self._of_build(self.facts.below)

    @cached_property
    def separating(self) -> Mask:
        """Return the axes that separate."""
        return self._of_build(self.facts.separating)

    @cached_property
    def near(self) -> Codes:
        """Return 1 where no axis separates."""
        return (self.separating == 0).view(np.uint8)

    @cached_property
    def decision(self) -> Codes:
        """Return how pairs are decided: see `Decision`."""
        boxes = np.uint32((1 << BOX_AXES) - 1)
        return (self.separating & boxes == 0).view(np.uint8) + self.near

    @cached_property
    def lowest(self) -> Codes:
        """Return the lowest-numbered separating axis; 0 where none separates."""
        mask = self.separating
        return _bit_number(mask & (~mask + np.uint32(1))) * (1 - self.near)

    @cached_property
    def several(self) -> Codes:
        """Return 1 where more than one axis separates."""
        mask = self.separating
        return (mask & (mask - np.uint32(1)) != 0).view(np.uint8)

    def _axis_where(self, condition: Codes, axis: Codes) -> Codes:
        """Return the axis where the condition is 1, the number of axes where it is 0."""
        # n | 255 is 255, cut down to the number of axes: no branch, no gather.
        return np.minimum(axis | (condition - np.uint8(1)), np.uint8(axes_of(self.build)))

    @cached_property
    def sole(self) -> Codes:
        """Return the only axis that separates; the number of axes where there is not exactly one."""
        return self._axis_where(1 - (self.several | self.near), self.lowest)

    @cached_property
    def sole_step(self) -> Codes:
        """Return the sole axis where it separates by the smallest step, as `sole` does."""
        stepped = (self.facts.clear_step & self.separating != 0).view(np.uint8)
        return self._axis_where(stepped, self.sole)

    @cached_property
    def side(self) -> Codes:
        """Return 0 where B is above A on every separating axis or none separates, otherwise 1."""
        return (self.below != 0).view(np.uint8)

    def near_only(self, mask: Mask) -> Mask:
        """Return the mask where pairs are near, 0 elsewhere: there an error on any axis shows."""
        return self._of_build(mask) * self.near

    @cached_property
    def flat_at_zero(self) -> Mask:
        """Return the flat axes of near pairs at margin 0: both gaps are 0, and neither separates."""
        return self.near_only(self.facts.flat) * (1 - self.margin_positive)

    @cached_property
    def touching(self) -> Codes:
        """Return 1 where pairs are exactly as far apart as the margin."""
        facts = self.facts
        return ((facts.separating == 0) & (facts.level != 0)).view(np.uint8)

    @cached_property
    def relation(self) -> Codes:
        """Return how the triangles lie: see `Relation`."""
        facts = self.facts
        key = (facts.separating == 0).view(np.uint8) * np.uint8(8)
        key += facts.coplanar * np.uint8(4)
        key += facts.a_in_b * np.uint8(2)
        key += facts.b_in_a
        key |= self.touching << np.uint8(4)
        return _RELATIONS.take(key)

    @cached_property
    def triangles(self) -> Codes:
        """Return 1 where neither is degenerate."""
        return self.facts.rank_a & self.facts.rank_b & np.uint8(2)

    @cached_property
    def contact(self) -> Codes:
        """Return 1 for two proper triangles that touch."""
        return self.touching & (self.triangles >> np.uint8(1))

    def support(self, support: Codes) -> Codes:
        """Return the set of touching vertices less one, 0..6; 7 where not two triangles touch."""
        return np.minimum((support - np.uint8(1)) | (self.contact - np.uint8(1)), np.uint8(7))

    def features(self, support: Codes) -> Codes:
        """Return 0 vertex, 1 edge, 2 face: what touches; 3 where not two triangles touch."""
        count = np.bitwise_count(support) - np.uint8(1)
        return np.minimum(count | (self.contact - np.uint8(1)), np.uint8(3))

    @cached_property
    def margin_positive(self) -> Codes:
        """Return 1 where the margin is not 0."""
        return (self.sample.margins != 0).view(np.uint8)

    @cached_property
    def size(self) -> Codes:
        """Return 0 tiny, 1 small, 2 large, 3 reaching both limits: the numbers of a pair."""
        low, high = self.facts.low, self.facts.high
        limit = np.int32((1 << (self.build.width - 1)) - 1)
        # ~x = -1 - x: no overflow at the lowest 32-bit number; |low| is at most 1 more.
        code = _beyond(low, high, 8) + _beyond(low, high, 1 << (self.build.width // 2))
        both = ((low == ~limit) & (high == limit)).view(np.uint8)
        return np.maximum(code, both * np.uint8(3))

    @cached_property
    def wide(self) -> Codes:
        """Return 1 where a difference of two vertices is a quarter of the range or more."""
        return (self.facts.extent >= np.uint32(1 << (self.build.width - 2))).view(np.uint8)

    @cached_property
    def answered_near(self) -> Codes:
        """Return 1 where the core says near."""
        return self.sample.words.astype(np.uint8) & np.uint8(1)

    @cached_property
    def answered_axis(self) -> Codes:
        """Return the claim of the core."""
        return (self.sample.words >> np.uint16(_CLAIM_SHIFT)).astype(np.uint8) & np.uint8(_CLAIM_BITS)

    @cached_property
    def answered_flags(self) -> Codes:
        """Return the flags that the core gives: bit 0 coplanar, 1 A degenerate, 2 B degenerate."""
        return (self.sample.words.astype(np.uint8) >> np.uint8(_FLAG_SHIFT)) & np.uint8(7)

    @cached_property
    def tried(self) -> Codes:
        """Return 1 where a check was tried: the answer is not the core's own."""
        return (self.sample.attempts != 0).view(np.uint8)

    @cached_property
    def claim(self) -> Codes:
        """Return 0 where the core says near, 1 + its claim otherwise; 1 + axes for none of its own."""
        claimed = (self.answered_axis + np.uint8(1)) * (1 - self.answered_near)
        none = np.uint8(axes_of(self.build) + 1)
        return np.minimum(np.maximum(claimed, none * self.tried), none)

    @cached_property
    def answer(self) -> Codes:
        """Return 1 for near, plus 2 where that is right, 4 where it is but the axis or spare bits are not; 6
        where a check was tried.
        """
        reserved = self.sample.words & np.uint16(_RESERVED) != 0
        wrong = ((self.answered_axis != self.lowest) | reserved).view(np.uint8)
        agrees = (self.answered_near == self.near).view(np.uint8)
        answer = self.answered_near + agrees * (wrong + np.uint8(1)) * np.uint8(2)
        return np.where(self.tried, np.uint8(6), answer)

    def _which(self, kind: Try, none: int) -> Codes:
        """Return the number that an attempt of that kind has; ``none`` for others."""
        attempts = self.sample.attempts
        which = attempts & np.uint8((1 << WHICH_BITS) - 1)
        return np.where(attempts >> np.uint8(WHICH_BITS) == kind, which, np.uint8(none))

    @cached_property
    def tried_claim(self) -> Codes:
        """Return the axis that was claimed on trial; the number of all axes where none was."""
        return self._which(Try.CLAIM, NUM_AXES)

    @cached_property
    def tried_distance(self) -> Codes:
        """Return how far the axis claimed on trial separates.

        0: not; 1: exactly by the margin; 2: by the smallest step more; 3: by more than that.
        """
        axis = np.minimum(self.tried_claim, np.uint8(NUM_AXES - 1)).astype(np.uint32)

        def on_axis(mask: Mask) -> Codes:
            return (mask >> axis & np.uint32(1)).astype(np.uint8)

        facts = self.facts
        holds = on_axis(facts.separating)
        return on_axis(facts.level) * (1 - holds) + holds * (np.uint8(3) - on_axis(facts.clear_step))

    @cached_property
    def tried_parity(self) -> Codes:
        """Return which of the parity bits was inverted, in their order; their number where none was."""
        return _PARITY_PLACES.take(self._which(Try.PARITY, _NO_PARITY))

    @cached_property
    def tried_number(self) -> Codes:
        """Return which bit of the pair's number was inverted; 7 where none was."""
        return self._which(Try.NUMBER, 7) & np.uint8(7)

    @cached_property
    def blind(self) -> Codes:
        """Return 1 where only axes that this core lacks separate."""
        return self.near * (self.facts.separating != 0).view(np.uint8)

    @cached_property
    def previous(self) -> Codes:
        """Return the decision of the pair before; 3 for the first of the sample."""
        before = np.empty_like(self.decision)
        before[:1] = 3
        before[1:] = self.decision[:-1]
        return before

    @cached_property
    def runs(self) -> npt.NDArray[np.intp]:
        """Return the lengths of the longest runs of pairs of which none waited, on neither side, and whose
        results were taken in one clock after the other: any number of them.
        """
        # What runs on beyond the sample is cut there: a length is never overstated.
        sample = self.sample
        waited = (sample.waits_in != 0) | (sample.waits_out != 0)
        cut = waited[1:] | waited[:-1] | (np.diff(sample.clocks) != 1)
        bounds = np.concatenate([[0], np.flatnonzero(cut) + 1, [len(waited)]])
        # A pair that waited is a piece of its own.
        return np.diff(bounds)[~waited[bounds[:-1]]] if len(waited) else bounds[:0]


def _relations() -> Codes:
    """Return the relation for each key of `CoreView.relation`: touching, near, coplanar, A in B, B in A."""
    table = np.zeros(32, np.uint8)
    for key in range(32):
        touching, near, coplanar, a_in_b, b_in_a = (bool(key >> bit & 1) for bit in (4, 3, 2, 1, 0))
        if not near:
            table[key] = Relation.CLEAR
        elif touching:
            table[key] = Relation.TOUCHING
        elif a_in_b or b_in_a:
            both = Relation.IDENTICAL if b_in_a else Relation.A_IN_B
            table[key] = both if a_in_b else Relation.B_IN_A
        else:
            table[key] = Relation.COPLANAR if coplanar else Relation.PENETRATING
    return table


_RELATIONS = _relations()

# The place of each parity bit among those that there are.
_NO_PARITY = 1 << WHICH_BITS
_PARITY_PLACES = np.full(_NO_PARITY + 1, len(PARITIES), np.uint8)
_PARITY_PLACES[list(PARITIES)] = np.arange(len(PARITIES))


def _bit_number(powers: Mask) -> Codes:
    """Return the logarithms of powers of two, and something for 0.

    A float32 holds every power of two below 2^32 exactly, and its exponent is the logarithm plus 127.
    """
    exponents = powers.astype(np.float32).view(np.uint32) >> np.uint32(23)
    return exponents.astype(np.uint8) - np.uint8(127)


def _beyond(low: npt.NDArray[np.int32], high: npt.NDArray[np.int32], limit: int) -> Codes:
    """Return 1 where a number between low and high is at least ``limit`` in size."""
    return ((low <= np.int32(-limit)) | (high >= np.int32(limit))).view(np.uint8)


def classes(values: npt.NDArray[np.integer], *starts: int) -> Codes:
    """Return how many of the ascending ``starts`` each value reaches."""
    code = (values >= starts[0]).view(np.uint8)
    for start in starts[1:]:
        code = code + (values >= start).view(np.uint8)
    return code
