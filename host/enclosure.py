"""Whether a part of one mesh is inside the other, where no facets of the two are near: exactly.

A shell is connected and meets nothing of the other mesh's surface, so it is inside as a whole or not at all,
and one of its vertices answers for it. Asked of the integer meshes, this answers for the real ones: the
margin covers what reading, turning and rounding moved, so facets further apart than it never met on the way.

Only closed shells have an inside (see `shells`). What is open, with gaps that nobody can tell from missing
facets, is taken as one body that may fill its box: where a box of the other mesh's shells lies within that
one, the answer is undecided.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from triaxis.golden.errors import InputError
from triaxis.host.broadphase import candidates
from triaxis.host.shells import Integers, Mask, Shells, inside, shells_of

# A mesh that stays where it is.
_STILL = np.zeros((1, 2, 3), np.int64)


class State(StrEnum):
    """What is known of insides."""

    NOT_ASKED = "not asked"
    OUTSIDE = "outside"
    INSIDE = "inside"
    UNDECIDED = "undecided"


@dataclass(frozen=True)
class Part:
    """A shell of mesh "a" or "b" that is inside the other, or may be: its lowest facet, its facets, and
    whether that is all of the mesh. ``why``: what is wrong with the other mesh, where it is undecided.
    """

    mesh: str
    state: State
    first_facet: int
    facets: int
    all_of_it: bool
    why: str | None = None

    def sentence(self, names: tuple[str, str]) -> str:
        """Return what is so, with the names of A and B."""
        inner, outer = names if self.mesh == "a" else names[::-1]
        some = (
            ""
            if self.all_of_it
            else f"a part of {inner}, {self.facets} facets from facet {self.first_facet} on, "
        )
        return f"{some or inner + ' '}{'is' if self.state == State.INSIDE else 'may be'} inside {outer}"


@dataclass(frozen=True)
class Enclosure:
    """What is known of insides, and the parts that it stands on: none where all is outside."""

    state: State
    parts: tuple[Part, ...] = ()

    def verdict(self, near: bool) -> str:
        """Return the verdict on two meshes of which facets are near, or not: clear, near or unknown."""
        if near or self.state == State.INSIDE:
            return "near"
        return "unknown" if self.state == State.UNDECIDED else "clear"

    def told(self, names: tuple[str, str]) -> list[str]:
        """Return a sentence for each part inside, with the names of A and B."""
        return [part.sentence(names) for part in self.parts if part.state == State.INSIDE]

    def refuse_undecided(self, files: Sequence[object]) -> None:
        """Raise InputError where it is undecided, naming the files of A and B."""
        if self.state != State.UNDECIDED:
            return
        part = self.parts[0]
        names = str(files[0]), str(files[1])
        outer = names[1] if part.mesh == "a" else names[0]
        raise InputError(
            f"{outer}: {part.why}, and {part.sentence(names)}: verdict unknown; repair it, or compare "
            "surfaces only, with --surfaces-only"
        )


NOT_ASKED = Enclosure(State.NOT_ASKED)


def enclosure(a: Integers, b: Integers, moves: Integers = _STILL) -> Enclosure:
    """Return whether a shell of A (N, 3, 3) is inside B (M, 3, 3), or one of B inside A; none of their facets
    may be near.

    ``moves`` (K, 2, 3): where A then goes without coming near B, as the least and the most translation from
    where it stands on each piece of its way. What is inside a closed shell at the start is so all along,
    what is not never; but into something open it may come by a gap.
    """
    shells_a, shells_b = shells_of(a), shells_of(b)
    parts = (
        *_parts("a", (a, shells_a), (b, shells_b), moves),
        *_parts("b", (b, shells_b), (a, shells_a), -moves[:, ::-1]),
    )
    for state in (State.INSIDE, State.UNDECIDED):
        found = tuple(part for part in parts if part.state == state)
        if found:
            return Enclosure(state, found)
    return Enclosure(State.OUTSIDE)


def _parts(
    mesh: str, inner: tuple[Integers, Shells], outer: tuple[Integers, Shells], moves: Integers
) -> list[Part]:
    """Return the shells of the inner mesh that are inside the outer one, or may be."""
    (facets, shells), (around, hulls) = inner, outer
    held, mixed = np.zeros((2, len(shells.first)), np.bool_)
    possible = np.flatnonzero(_fitting(shells.boxes, hulls.boxes[hulls.closed], _STILL))
    held[possible], mixed[possible] = inside(facets[shells.first[possible], 0], around, hulls)
    doubted = _fitting(shells.boxes, hulls.boxes[~hulls.closed], moves) & ~held
    opened = f"not closed: {int(hulls.open_edges.sum())} edges have an odd number of facets"
    turned = "closed, but neighbouring facets are not turned the same way"
    return [
        Part(
            mesh,
            State.INSIDE if held[k] else State.UNDECIDED,
            int(shells.first[k]),
            int(shells.facets[k]),
            len(shells.first) == 1,
            None if held[k] else opened if doubted[k] else turned,
        )
        for k in np.flatnonzero(held | mixed | doubted)
    ]


def _fitting(boxes: Integers, others: Integers, moves: Integers) -> Mask:
    """Return which boxes (S, 2, 3) lie, on one of the moves (K, 2, 3), within the box of all the others."""
    found = np.zeros(len(boxes), np.bool_)
    if not len(others):
        return found
    # A box fits where its translation is itself within a box.
    least, most = others[:, 0].min(0) - boxes[:, 0], others[:, 1].max(0) - boxes[:, 1]
    small = np.flatnonzero((least <= most).all(1))
    room = np.stack([least, most, most], 1)[small]
    for i, _ in candidates(room, moves[:, [0, 1, 1]], 0):
        found[small[i]] = True
    return found
