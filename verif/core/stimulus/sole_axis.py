"""Pairs whose decision hangs on one axis alone, for every axis, side, rank and smallest step.

With A a triangle, the faces of the Minkowski difference of A, B and the cube are of few kinds: face of A and
vertex of B; edge and edge; edge of A, vertex of B and edge of the cube; vertex, vertex and face of the cube.
A contact inside such a face, moved by the smallest step, is decided by its normal alone, unless another
axis is parallel to it. Placing them in all orders and symmetries reaches all 32 axes on either side.
"""

from collections.abc import Callable, Sequence
from functools import partial

from triaxis.golden.pairs import MIN_WIDTH
from triaxis.verif.core.stimulus.contact import Contact, placed
from triaxis.verif.core.stimulus.near_miss import edge_edge, edge_edge_level, face_vertex, face_vertex_level
from triaxis.verif.core.stimulus.near_miss_box import box, edge_box, edge_box_level
from triaxis.verif.core.stimulus.stimulus import Family, Rng, Stimulus, collected, divided, joined

Construction = Callable[[Rng, int, int], Contact]
FlatOrNot = Callable[[Rng, int, int, bool], Contact]


def family_of(parts: Sequence[tuple[Construction, int]], least_margin: int = 0) -> Family:
    """Return the family of pairs from constructions, each with its share."""

    def family(rng: Rng, count: int, width: int, largest_margin: int) -> Stimulus:
        def make(construction: Construction, asked: int) -> Stimulus:
            contact = construction(rng, asked, width)
            return placed(rng, contact, width, largest_margin, least_margin)

        counts = divided(count, [share for _, share in parts])
        return joined([collected(n, partial(make, made)) for (made, _), n in zip(parts, counts, strict=True)])

    return family


def _with(construction: FlatOrNot, flat: bool) -> Construction:
    return lambda rng, count, width: construction(rng, count, width, flat)


def with_flat(parts: Sequence[tuple[FlatOrNot, int]]) -> Family:
    """Return the family of box contacts: flat without a margin; with one in space, or flat (one in 8)."""
    flat = family_of([(_with(made, True), share) for made, share in parts])
    space = family_of([(_with(made, False), share) for made, share in parts], least_margin=1)

    def family(rng: Rng, count: int, width: int, largest_margin: int) -> Stimulus:
        if largest_margin == 0:
            return flat(rng, count, width, 0)
        without, within, apart = divided(count, (2, 1, 5))
        return joined(
            [
                flat(rng, without, width, 0),
                flat(rng, within, width, largest_margin),
                space(rng, apart, width, largest_margin),
            ]
        )

    return family


near_face = family_of([(face_vertex, 2), (face_vertex_level, 1)])
near_edge = family_of([(edge_edge, 2), (edge_edge_level, 1)])
near_edge_box = with_flat([(edge_box, 2), (edge_box_level, 1)])
near_box = with_flat([(box, 1)])


def sole_axis(rng: Rng, count: int, width: int, largest_margin: int) -> Stimulus:
    """Return all of these in random order: one part each of faces and boxes, two each of the edges, of which
    there are more.
    """
    kinds = (near_face, near_edge, near_edge_box, near_box)
    counts = divided(count, (1, 2, 2, 1))
    parts = joined([kind(rng, n, width, largest_margin) for kind, n in zip(kinds, counts, strict=True)])
    return parts[rng.permutation(count)]


def sole_axis_small(rng: Rng, count: int, width: int, largest_margin: int) -> Stimulus:
    """Return the same as the narrowest width has it: small numbers, where any width has few."""
    return sole_axis(rng, count, MIN_WIDTH, min(largest_margin, (1 << MIN_WIDTH) - 1))
