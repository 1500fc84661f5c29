"""Contacts: pairs at the decision for margin 0, and the same at any margin, by moving B away.

Let A and B be on either side of a plane with normal c, from A to B, with a gap in the direction of c (0,
touching; or a step more or less). Moving B by m * sign(c), a corner of the cube [-m, m]^3, adds m * |c|1 to
that gap. So the excess at margin m is the gap at margin 0, and a pair that touches comes to a distance
of exactly m. Where a component of c is 0, B may go anywhere in -m..m.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from triaxis.verif.core.stimulus.draws import around, chance, up_to
from triaxis.verif.core.stimulus.stimulus import (
    Ints,
    Mask,
    Rng,
    Stimulus,
    chosen_rows,
    largest_extents,
    largest_span,
)
from triaxis.verif.core.stimulus.symmetry import random_cube_symmetries, random_orders, random_translations


@dataclass(frozen=True)
class Contact:
    """Pairs (N, 2, 3, 3) somewhere in space, and sign(c) (N, 3), -1, 0 or 1, from A to B."""

    pairs: Ints
    away: Ints

    def __getitem__(self, chosen: slice | Mask | npt.NDArray[np.integer]) -> "Contact":
        """Return the chosen contacts."""
        return Contact(chosen_rows(self.pairs, chosen), chosen_rows(self.away, chosen))


def _log_uniform(rng: Rng, limit: Ints) -> Ints:
    """Return integers in 1..limit at every scale, 0 where the limit is 0."""
    drawn = np.exp2(rng.random(len(limit)) * np.log2(limit + 1.0)).astype(np.int64)
    return np.minimum(drawn, limit)


def placed(rng: Rng, contact: Contact, width: int, largest_margin: int, least_margin: int = 0) -> Stimulus:
    """Return what fits the width, at margins in least..largest, in any order, orientation and place."""
    room = np.minimum(largest_span(width) - largest_extents(contact.pairs.reshape(-1, 6, 3)), largest_margin)
    fits = np.flatnonzero(room >= least_margin)
    contact, room = contact[fits], room[fits]
    count = len(room)
    margin = np.where(chance(rng, count, 8), room, _log_uniform(rng, room))
    if least_margin == 0:
        margin[chance(rng, count, 4)] = 0
    # Every second pair stays where it is instead: in the plane of A, if it was there.
    free = around(rng, (margin >> 1)[:, None] * chance(rng, count, 2)[:, None], (count, 3))
    shift = np.where(contact.away == 0, free, margin[:, None] * contact.away)
    pairs = contact.pairs
    pairs[:, 1] += shift[:, None]
    small = random_translations(rng, pairs, width).astype(np.int32)
    return Stimulus(random_cube_symmetries(rng, random_orders(rng, small)), margin.astype(np.uint32))


def one_step(rng: Rng, contact: Contact) -> Contact:
    """Return the contacts with B moved by one unit along one coordinate: a third nearer, a third farther."""
    count = len(contact.away)
    rows, coordinate = np.arange(count), up_to(rng, 2, (count,))
    step = around(rng, 1, (count,)) * contact.away[rows, coordinate]
    pairs = contact.pairs.copy()
    pairs[rows, 1, :, coordinate] += step[:, None]
    return Contact(pairs, contact.away)
