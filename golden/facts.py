"""What the bulk checker says about pairs: more than verdicts, so that coverage needs no second pass.

Masks are over the 32 axes: bit n is axis n (see `triaxis.golden.axes`). For an axis c, the projections
of A and B are intervals; ``up`` = min(c.B) - max(c.A) is the gap where B lies above A, ``down`` =
min(c.A) - max(c.B) where below, and excess = max(up, down) - margin * |c|1. The axis separates where its
excess is positive. Excesses of an axis are multiples of g, the greatest common divisor of its
components, so +g and -g are the smallest steps on either side of the decision.

up + down is less than 0 by the lengths of the two intervals. So both are 0 only where all six vertices
fall together, on a zero or a flat axis; elsewhere a level axis is level on one side only.
"""

from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from triaxis.golden.pairs import NO_AXIS, VERDICT, Verdicts

Mask = npt.NDArray[np.uint32]
Small = npt.NDArray[np.uint8]

KIND_BITS = 18


@dataclass(frozen=True)
class Facts:
    """Facts of N pairs, each field of shape (N,).

    above, below: axes that separate by more than the margin, B above A or below it.
    upper, lower: axes with up >= down, down >= up: the excess is that of B above A, of B below A. Where
    the two are equal, as on zero and flat axes, the axis is in both.
    level: axes that are not zero, not flat, and whose excess is 0: a near pair with one is exactly at the
    margin.
    clear_step, near_step: axes that are not zero and not flat, and whose excess is +g, -g.
    flat: axes that are not zero and on which all six vertices fall together.
    support_a, support_b: vertices of A and of B (bit v is vertex v) that are outermost towards the
    other triangle on every level axis: of A the highest and of B the lowest where B is above, the other
    way round where below; 7 where no axis is level. With margin 0, for a near pair, they span the smallest
    faces of A and B that hold all the points where the two touch.
    rank_a, rank_b: 0 point, 1 segment, 2 triangle.
    order_a, order_b: which of the six permutations sorts the vertices by (x, y, z): 0..5, numbered as
    itertools.permutations(range(3)) lists them, the first that fits where vertices coincide.
    coplanar: all six vertices lie in one plane.
    a_in_b, b_in_a: A is a part of B (as closed sets), B of A.
    low, high: the smallest and the largest of the 18 coordinates.
    extent: the largest difference of two vertices in x, in y or in z: what translations leave alone.
    kind: a number for the kind of situation, below 2^KIND_BITS: from the lowest bits on, how many vertices
    are in support_b (2 bits) and in support_a (2); whether flat, near_step, clear_step on an axis that
    separates, level are not 0; rank_b (2), rank_a (2), and the claim + 1.
    """

    above: Mask
    below: Mask
    upper: Mask
    lower: Mask
    level: Mask
    clear_step: Mask
    near_step: Mask
    flat: Mask
    support_a: Small
    support_b: Small
    rank_a: Small
    rank_b: Small
    order_a: Small
    order_b: Small
    coplanar: Small
    a_in_b: Small
    b_in_a: Small
    low: npt.NDArray[np.int32]
    high: npt.NDArray[np.int32]
    extent: npt.NDArray[np.uint32]
    kind: npt.NDArray[np.uint32]

    def __len__(self) -> int:
        """Return the number of pairs."""
        return len(self.above)

    def __getitem__(self, chosen: slice | npt.NDArray[np.bool_] | npt.NDArray[np.intp]) -> "Facts":
        """Return the facts of the chosen pairs."""
        return Facts(*(getattr(self, field.name)[chosen] for field in fields(self)))

    @property
    def separating(self) -> Mask:
        """Return the axes that separate, on either side."""
        return self.above | self.below

    @property
    def near(self) -> npt.NDArray[np.bool_]:
        """Return the verdict: no axis separates."""
        return self.separating == 0

    @property
    def claim(self) -> npt.NDArray[np.int16]:
        """Return the lowest-numbered separating axis, NO_AXIS where none separates."""
        return lowest_axis(self.separating)

    @property
    def verdicts(self) -> Verdicts:
        """Return the verdicts in the form that the judge gives them."""
        verdicts = np.zeros(len(self), VERDICT)
        verdicts["near"] = self.near
        verdicts["axis"] = self.claim
        verdicts["coplanar"] = self.coplanar != 0
        verdicts["degenerate_a"] = self.rank_a < 2
        verdicts["degenerate_b"] = self.rank_b < 2
        return verdicts


def lowest_axis(mask: Mask) -> npt.NDArray[np.int16]:
    """Return the number of the lowest bit of each mask (N,), NO_AXIS where it is 0."""
    lowest = mask & (~mask + np.uint32(1))
    # A float32 holds powers of two exactly, and 0; its exponent is the logarithm plus 127.
    exponent = (lowest.astype(np.float32).view(np.uint32) >> np.uint32(23)).astype(np.int16)
    return np.where(mask == 0, np.int16(NO_AXIS), exponent - np.int16(127))
