"""The families of pairs by name, and their mixture at the rate of a simulation.

A family is a function of a random generator, a count, a width and the largest margin, and returns pairs with
margins (`Stimulus`), all in range. Sizes are drawn over the whole range, so that near and clear pairs both
come up at every scale.

In a mixture base pairs, which may cost microseconds each, are used several times, under the exact symmetries
of `symmetry`: in another vertex order, with A and B swapped or not, under another symmetry of the cube and,
every second time, in another place. To the core these are new inputs: other numbers in other places of
its arithmetic. Margins go with their pairs, and no verdict changes.
"""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from triaxis.golden.pairs import Pairs
from triaxis.verif.core.stimulus.contact import (
    FEATURE_PAIRS,
    Contact,
    contained_pairs,
    one_step,
    penetrating_pairs,
    sharing_edge,
    touching,
)
from triaxis.verif.core.stimulus.flat import (
    coplanar_near_miss,
    coplanar_pairs,
    degenerate_pairs,
    sliver_pairs,
)
from triaxis.verif.core.stimulus.general import (
    at_corners,
    extreme_pairs,
    far_pairs,
    random_pairs,
    shared_pairs,
    tiny_pairs,
)
from triaxis.verif.core.stimulus.margins import at_any_margin
from triaxis.verif.core.stimulus.near_miss import (
    Construction,
    family_of,
    near_box,
    near_edge,
    near_edge_box,
    near_face,
    sole_axis_small,
)
from triaxis.verif.core.stimulus.stimulus import (
    Family,
    PairFamily,
    Rng,
    Stimulus,
    divided,
    joined,
)
from triaxis.verif.core.stimulus.symmetry import (
    centred,
    random_translations,
    random_variants,
)

# How often a base pair is used, on average.
TIMES = 16

# Base pairs made at a time: enough that a family's cost is that of its arithmetic, not of its calls.
_BLOCK = 4096


def varied(rng: Rng, base: Stimulus, rows: npt.NDArray[np.integer], width: int) -> Stimulus:
    """Return the pairs in these rows, each under a random symmetry; of the array a quarter is also moved, and
    one centred.
    """
    pairs = random_variants(rng, base.pairs, rows)
    half, rest = len(pairs) // 2, len(pairs) * 3 // 4
    pairs[half:rest] = random_translations(rng, pairs[half:rest], width)
    pairs[rest:] = centred(pairs[rest:])
    return Stimulus(pairs, base.margins.take(rows))


def mixed_once(rng: Rng, families: Sequence[Family], count: int, width: int, largest_margin: int) -> Stimulus:
    """Return the families in equal shares and random order, each base pair used up to TIMES times."""
    base_count = max(len(families), -(-count // TIMES))
    counts = divided(base_count, [1] * len(families))
    base = joined([f(rng, n, width, largest_margin) for f, n in zip(families, counts, strict=True)])
    chosen = rng.permutation(TIMES * base_count)[:count] % base_count
    return varied(rng, base, chosen, width)


class Mixture:
    """An endless supply of bursts of all families.

    It keeps a pool of one block of base pairs for each family given, draws bursts from all of it, and
    renews blocks in turn, so that a base pair is drawn TIMES times on average before it goes. The same
    generator and the same calls give the same bursts.
    """

    def __init__(self, rng: Rng, families: Sequence[Family], width: int, largest_margin: int) -> None:
        """Make the first pool; a family that is given twice has twice the share."""
        self._rng, self._families = rng, tuple(families)
        self._width, self._largest = width, largest_margin
        self._pool = joined([self._block(number) for number in range(len(self._families))])
        self._next, self._drawn = 0, 0

    def burst(self, count: int) -> Stimulus:
        """Return the next pairs with their margins."""
        chosen = self._rng.integers(0, len(self._pool), count, np.uint32)
        stimulus = varied(self._rng, self._pool, chosen, self._width)
        self._drawn += count
        while self._drawn >= TIMES * _BLOCK:
            self._drawn -= TIMES * _BLOCK
            self._renew()
        return stimulus

    def _block(self, number: int) -> Stimulus:
        return self._families[number](self._rng, _BLOCK, self._width, self._largest)

    def _renew(self) -> None:
        place = slice(self._next * _BLOCK, (self._next + 1) * _BLOCK)
        block = self._block(self._next)
        self._pool.pairs[place], self._pool.margins[place] = block.pairs, block.margins
        self._next = (self._next + 1) % len(self._families)


def with_margins(pairs: PairFamily) -> Family:
    """Return the family of these pairs at margins of every kind."""

    def family(rng: Rng, count: int, width: int, largest_margin: int) -> Stimulus:
        made = np.ascontiguousarray(pairs(rng, count, width), np.int32)
        return Stimulus(made, at_any_margin(rng, made, largest_margin).astype(np.uint32))

    return family


def and_one_step(construction: Construction) -> Construction:
    """Return the construction with half of the contacts missed, or passed, by one unit."""

    def make(rng: Rng, count: int, width: int) -> Contact:
        contact = construction(rng, count, width)
        half = len(contact.away) // 2
        moved = one_step(rng, contact[:half])
        return Contact(
            np.concatenate([moved.pairs, contact.pairs[half:]]),
            np.concatenate([moved.away, contact.away[half:]]),
        )

    return make


TOUCHING: dict[str, Construction] = {f"{a}-{b}": touching(a, b) for a, b in FEATURE_PAIRS}
TOUCHING["shared edge"] = sharing_edge

FAMILIES: dict[str, Family] = {
    "random": with_margins(random_pairs),
    "shared": with_margins(shared_pairs),
    "far": with_margins(far_pairs),
    "degenerate": with_margins(degenerate_pairs),
    "coplanar": with_margins(coplanar_pairs),
    "coplanar near-miss": family_of([(coplanar_near_miss, 1)]),
    "contained": with_margins(contained_pairs),
    "penetrating": with_margins(penetrating_pairs),
    "slivers": with_margins(sliver_pairs),
    "extremes": with_margins(extreme_pairs),
    "corners": at_corners,
    "tiny": with_margins(tiny_pairs),
    **{f"touching {name}": family_of([(and_one_step(made), 1)]) for name, made in TOUCHING.items()},
    "near-miss face": near_face,
    "near-miss edge": near_edge,
    "near-miss edge x box": near_edge_box,
    "near-miss box": near_box,
    "near-miss small": sole_axis_small,
}


def mixed(rng: Rng, count: int, width: int, largest_margin: int) -> Stimulus:
    """Return pairs of all families in random order; for long runs `mixture` is faster."""
    return mixed_once(rng, tuple(FAMILIES.values()), count, width, largest_margin)


def mixed_pairs(rng: Rng, count: int, width: int) -> Pairs:
    """Return the pairs of `mixed` for margin 0, as int64."""
    return mixed(rng, count, width, 0).pairs.astype(np.int64)


def mixture(rng: Rng, width: int, largest_margin: int) -> Mixture:
    """Return an endless supply of bursts of all families."""
    return Mixture(rng, tuple(FAMILIES.values()), width, largest_margin)
