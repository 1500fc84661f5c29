"""The families of pairs by name, and their mixture.

A family is a function of a random generator, a count, a width and the largest margin, and returns pairs with
margins (`Stimulus`), all in range. Sizes are drawn over the whole range, so that near and clear pairs both
come up at every scale.
"""

import numpy as np

from triaxis.golden.pairs import Pairs
from triaxis.verif.core.stimulus.contact import Contact, one_step
from triaxis.verif.core.stimulus.containment import contained_pairs
from triaxis.verif.core.stimulus.coplanar import coplanar_near_miss, coplanar_pairs
from triaxis.verif.core.stimulus.corners import at_corners
from triaxis.verif.core.stimulus.degenerate import degenerate_pairs
from triaxis.verif.core.stimulus.margins import at_any_margin, random_margins
from triaxis.verif.core.stimulus.mixture import Mixture, mixed_once
from triaxis.verif.core.stimulus.penetrating import penetrating_pairs
from triaxis.verif.core.stimulus.random_pairs import (
    extreme_pairs,
    far_pairs,
    random_pairs,
    shared_pairs,
    tiny_pairs,
)
from triaxis.verif.core.stimulus.slivers import sliver_pairs
from triaxis.verif.core.stimulus.sole_axis import (
    Construction,
    family_of,
    near_box,
    near_edge,
    near_edge_box,
    near_face,
    sole_axis_small,
)
from triaxis.verif.core.stimulus.stimulus import Family, PairFamily, Rng, Stimulus
from triaxis.verif.core.stimulus.symmetry import all_orders
from triaxis.verif.core.stimulus.touching import FEATURE_PAIRS, sharing_edge, touching

__all__ = [
    "FAMILIES",
    "TOUCHING",
    "all_orders",
    "mixed",
    "mixed_pairs",
    "mixture",
    "random_margins",
]


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
