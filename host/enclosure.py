"""Whether a part of one mesh is inside the other, where no facets of the two are near: exactly.

A shell, see `shells`, is connected and meets nothing of the other mesh's surface, so it is inside as a whole
or not at all, and one of its vertices answers for it. Asked of the integer meshes, this answers for the real
ones: the margin covers what reading, turning and rounding moved, so facets further apart than it never met on
the way.
Rounding vertices to a grid, which may merge some, is a map of vertices. The boundary of the image is the
image of the boundary, so what was closed, or oriented, still is. Gaps wider than the rounding stay open.

Only closed shells have an inside. What is open, with gaps that nobody can tell from missing facets, is taken
as one body that may fill its box: where a box of the other mesh's shells lies within that one, the answer is
undecided. And what is missing is taken to lie in the box of the rim: a part that overlaps that, as a drill
whose shank looks out, may go through it.

Numbers that say "outside" are believed where they must be right. A shell from which a ray leaves without
meeting it holds nothing there, whatever its facets tell of their sides. Where one whose own number is 0, or
even, meets all rays of all vertices that are tried, it may be several bodies that share a vertex, one of them
mirrored, or both sides of a surface: undecided. So is a part that lies deep in a bent hole.

A solid that is written with both sides of its surface, in parts, is closed, and its winding number is 0
everywhere. A ray from within passes an odd number of *sheets*, where crossings in one plane cancel, outside
of all else, and where two such solids overlap an even one. Where it passes any in one of six directions the
answer is undecided, as sheets may have gaps. Walls between solids that touch are no sheets: there the ray is
inside before and after. So it is within the box of a double surface, and in the box of the rims of all.

A shell that is turned inside out is a cavity where it lies within another. Where the two cross it is none,
but a solid that was mirrored, and in the overlap the winding number is 0: undecided, too. So it is where the
other lies within the one that is turned inside out.
"""

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from fractions import Fraction
from itertools import product
from typing import Any

import numpy as np
import numpy.typing as npt

from triaxis.golden.errors import InputError
from triaxis.host.broadphase import all_candidates, candidates
from triaxis.host.scene import bulk_near, near_facets
from triaxis.host.shells import Integers, Mask, Shells, Solid, exact_type

# Sides to which rays go; vertices of a part from which they do.
_WAYS, _TRIED = 6, 256
# Points, facets and signs.
_Crossings = tuple[Integers, Integers, Integers]


def inside(points: Integers, facets: Integers, shells: Shells) -> tuple[Mask, Mask, Mask]:
    """Return which points (K, 3) are inside the closed shells of facets (N, 3, 3), and which may be: (K,).

    No point may be on a facet. Inside is where the winding number of the oriented shells is not zero: so the
    overlap of two solids is inside, and a cavity is not. A shell that is closed and not oriented tells
    odd from even only. Where it holds a point and the sum of all is even, that may be an overlap or a cavity:
    the second. The third: where shells turned against each other make the sum zero, and are not what they
    would be of a solid with cavities, see `_is_cavity`.
    """
    of, shell, turns, passed = _turns(points, facets, shells)
    winding, held = np.zeros((2, len(points)), np.int64)
    np.add.at(winding, of, turns)
    np.add.at(held, of, passed)
    odd = (winding + held) % 2 == 1
    cancelled, crossing = np.zeros(len(points), np.bool_), dict[tuple[int, int], bool]()

    def crosses(pair: tuple[int, int]) -> bool:
        if pair not in crossing:
            crossing[pair] = _cross(*(facets[shells.number == one] for one in pair))
        return crossing[pair]

    # By point, as the keys are.
    rows = np.flatnonzero((turns != 0) & (winding[of] == 0))
    for some in np.split(rows, np.flatnonzero(np.diff(of[rows])) + 1) if len(rows) else ():
        cancelled[of[some[0]]] = not _is_cavity(shell[some], turns[some], shells.boxes, crosses)
    return np.where(held > 0, odd, winding != 0), (held > 0) & ~odd, cancelled


def _turns(
    points: Integers, facets: Integers, shells: Shells
) -> tuple[Integers, Integers, Integers, Integers]:
    """Return of points and closed shells whose facets are above: both numbers, how often the shell winds
    around the point where it is oriented, and 1 where it is not and passed an odd number of times.
    """
    used = np.flatnonzero(shells.closed[shells.number])
    number = shells.number[used]
    point, facet, sign = _crossings(points, facets[used])
    oriented = shells.oriented[number[facet]]
    key, place = np.unique(point * len(shells.first) + number[facet], return_inverse=True)
    turns, passed = np.zeros((2, len(key)), np.int64)
    np.add.at(turns, place[oriented], sign[oriented])
    np.add.at(passed, place[~oriented], 1)
    return key // max(1, len(shells.first)), key % max(1, len(shells.first)), turns, passed % 2


def _is_cavity(
    shell: Integers, turns: Integers, boxes: Integers, crosses: Callable[[tuple[int, int]], bool]
) -> bool:
    """Return whether shells that wind around a point, in sum 0 times, leave a cavity there.

    Those turned against each other do not cross, so one is within the other; and from outside in, no more
    are turned inside out than are not: a cavity needs what it is in.
    """
    up, down = (shell[way * turns > 0].tolist() for way in (1, -1))
    if any(map(crosses, product(up, down))):
        return False
    # What is within another, and meets nothing of it, has the smaller box.
    size = (boxes[shell, 1] - boxes[shell, 0]).sum(1)
    return bool((np.cumsum(turns[np.argsort(-size, kind="stable")]) >= 0).all())


def _cross(a: Integers, b: Integers) -> bool:
    """Return whether facets of the one touch any of the other."""
    return any(len(near) for _, near in near_facets(a, b, 0, bulk_near))


def _crossings(points: Integers, facets: Integers) -> _Crossings:
    """Return where rays from points (K, 3) along +z cross facets (N, 3, 3): point, facet, and +1 where its
    vertices run counterclockwise seen from above, -1 otherwise.

    The ray is moved off by (d, e) in x and y, e far below d, d far below 1 LSB: it meets no edge then, and
    no facet that is seen edge on. No number need be chosen: comparisons that tie at (0, 0) are decided by
    d and e. As no point is on a facet, that little moves no crossing from above a point to below it.
    """
    if not len(points) or not len(facets):
        none = np.empty(0, np.int64)
        return none, none, none
    ends = points.copy()
    ends[:, 2] = np.maximum(ends[:, 2], facets[..., 2].max())
    point, facet = all_candidates(np.stack([points, ends, ends], 1), facets, 0).T
    corners = np.concatenate([points, facets.reshape(-1, 3)])
    exact = exact_type(int((corners.max(0) - corners.min(0)).max()))
    sign = _seen(facets[facet].astype(exact), points[point].astype(exact))
    met = np.flatnonzero(sign)
    point, facet, sign = point[met], facet[met], sign[met]
    above = _side(facets[facet].astype(exact), points[point].astype(exact)) == sign
    return point[above], facet[above], sign[above]


def _six_ways(points: Integers, facets: Integers) -> Iterator[tuple[Integers, Integers, _Crossings]]:
    """Yield points (K, 3) and facets (N, 3, 3), turned to six sides, and what rays upwards cross there."""
    for axis in range(3):
        for side in (1, -1):
            # The axis last, and upwards: a turn, or one and a reflection, which turns all facets round.
            here, there = (side * np.roll(one, 2 - axis, -1) for one in (points, facets))
            yield here, there, _crossings(here, there)


def _doubted(inner: Solid, parts: Integers, outer: Solid) -> tuple[Mask, Mask]:
    """Return which shells (K,) of the inner mesh, outside of the closed ones of the outer, may be inside
    sheets of theirs; and which one of these has around it, though by its own winding number, or odd and even,
    it does not hold it.

    The inner shell meets nothing of the outer mesh, so it is where any of its vertices is.
    """
    facets, hulls = outer.facets, outer.shells
    firsts = inner.facets[inner.shells.first[parts], 0]
    of, shell, turns, passed = _turns(firsts, facets, hulls)
    holds = turns + passed != 0
    holding = set(zip(of[holds].tolist(), shell[holds].tolist(), strict=True))
    used = np.flatnonzero(hulls.closed[hulls.number])
    number, oriented = hulls.number[used], hulls.oriented[hulls.number[used]]
    double, seen = np.zeros(len(parts), np.bool_), Counter[tuple[int, int]]()
    for here, there, (point, facet, sign) in _six_ways(firsts, facets[used]):
        seen.update(set(zip(point.tolist(), number[facet].tolist(), strict=True)))
        order = np.argsort(point, kind="stable")
        for rows in np.split(order, np.flatnonzero(np.diff(point[order])) + 1) if len(order) else ():
            k, met = int(point[rows[0]]), facet[rows]
            double[k] |= _has_sheet(here[k], there[met], sign[rows], oriented[met])
    shut = np.zeros(len(parts), np.bool_)
    for (k, one), count in sorted(seen.items()):
        if count == _WAYS and (k, one) not in holding and not shut[k]:
            vertices = np.unique(inner.facets[inner.shells.number == parts[k]].reshape(-1, 3), axis=0)
            shut[k] = _all_meet(_some_of(vertices), facets[hulls.number == one])
    return double, shut


def _all_meet(points: Integers, facets: Integers) -> bool:
    """Return whether all rays from points (K, 3) to six sides meet one of the facets."""
    return all(len(np.unique(of)) == len(points) for _, _, (of, _, _) in _six_ways(points, facets))


def _some_of(vertices: Integers) -> Integers:
    """Return the outermost of some vertices (K, 3), and of the others no more than can be tried."""
    outermost = [*vertices.argmin(0), *vertices.argmax(0)]
    return vertices[np.unique([*outermost, *range(0, len(vertices), -(-len(vertices) // _TRIED))])]


def _has_sheet(point: Integers, facets: Integers, signs: Integers, oriented: Mask) -> bool:
    """Return whether a ray from a point along +z passes a sheet, of the facets (N, 3, 3) that it meets."""
    planes: dict[tuple[Fraction, ...], list[int]] = {}
    for k, (a, b, c) in enumerate(facets.astype(object)):
        u, v, w = b - a, c - a, a - point
        x, y, z = u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]
        height = Fraction(int(x * w[0] + y * w[1] + z * w[2]), int(z))
        planes.setdefault((height, Fraction(int(x), int(z)), Fraction(int(y), int(z))), []).append(k)
    winding = odd = 0
    # From above; of those of one height at the point that which the moved ray meets first, see `_crossings`.
    for plane in sorted(planes, key=lambda of: (-of[0], of[1], of[2])):
        met = np.array(planes[plane])
        turned, others = int(signs[met][oriented[met]].sum()), int((~oriented[met]).sum()) % 2
        if not (turned or others or winding or odd):
            return True
        winding, odd = winding + turned, (odd + others) % 2
    return False


def _seen(facets: npt.NDArray[Any], points: npt.NDArray[Any]) -> Integers:
    """Return how often facets (K, 3, 3), seen from above, wind around the moved points (K, 3): -1, 0 or 1."""
    x, y = (facets[..., k] - points[:, None, k] for k in (0, 1))
    next_x, next_y = np.roll(x, -1, 1), np.roll(y, -1, 1)
    turn = x * next_y - next_x * y
    # The point is e above y = 0, so a vertex there is below it, and d to the right of a line through (0, 0).
    up, down = (y <= 0) & (next_y > 0), (next_y <= 0) & (y > 0)
    return ((up & (turn > 0)).sum(1) - (down & (turn < 0)).sum(1)).astype(np.int64)


def _side(facets: npt.NDArray[Any], points: npt.NDArray[Any]) -> Integers:
    """Return the sign of (b - a) x (c - a) . (a - p) of facets (K, 3, 3) and points (K, 3)."""
    a = facets[:, 0]
    (ux, uy, uz), (vx, vy, vz), (wx, wy, wz) = (facets[:, 1] - a).T, (facets[:, 2] - a).T, (a - points).T
    volume = (uy * vz - uz * vy) * wx + (uz * vx - ux * vz) * wy + (ux * vy - uy * vx) * wz
    return (volume > 0).astype(np.int64) - (volume < 0)


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
    """What is known of insides, and the parts that it stands on: none where all is outside.

    ``open_edges``: of A and of B, edges with an odd number of facets, where it was asked.
    """

    state: State
    parts: tuple[Part, ...] = ()
    open_edges: tuple[int, int] = (0, 0)

    def verdict(self, near: bool) -> str:
        """Return the verdict on two meshes of which facets are near, or not: clear, near or unknown."""
        if near or self.state == State.INSIDE:
            return "near"
        return "unknown" if self.state == State.UNDECIDED else "clear"

    def told(self, names: tuple[str, str]) -> list[str]:
        """Return a sentence for each part inside, with the names of A and B."""
        return [part.sentence(names) for part in self.parts if part.state == State.INSIDE]

    def notes(self, names: tuple[str, str]) -> list[str]:
        """Return a sentence for each mesh that is not closed, with the names of A and B."""
        return [
            f"{name} is not closed: {edges} edges have an odd number of facets: the verdict is unknown as "
            "soon as something may be inside it"
            for name, edges in zip(names, self.open_edges, strict=True)
            if edges
        ]

    def refuse_undecided(self, files: Sequence[object], by_surfaces: bool = True, at: str = "") -> None:
        """Raise InputError where it is undecided, naming the files of A and B.

        ``by_surfaces``: these alone may be compared instead; ``at``: where it was asked.
        """
        if self.state != State.UNDECIDED:
            return
        part = self.parts[0]
        names = str(files[0]), str(files[1])
        outer = names[1] if part.mesh == "a" else names[0]
        instead = ", or compare surfaces only, with --surfaces-only" if by_surfaces else ""
        raise InputError(
            f"{outer}: {part.why}, and {part.sentence(names)}{at}: verdict unknown; repair it{instead}"
        )


NOT_ASKED = Enclosure(State.NOT_ASKED)


def enclosure(a: Solid, b: Solid, moves: Integers = _STILL) -> Enclosure:
    """Return whether a shell of A is inside B, or one of B inside A; none of their facets may be near.

    ``moves`` (K, 2, 3): where A then goes without coming near B, as the least and the most translation from
    where it stands on each piece of its way. What is inside a closed shell at the start is so all along,
    what is not never; but into something open it may come by a gap.
    """
    parts = (*_parts("a", a, b, moves), *_parts("b", b, a, -moves[:, ::-1]))
    edges = int(a.shells.open_edges.sum()), int(b.shells.open_edges.sum())
    for state in (State.INSIDE, State.UNDECIDED):
        found = tuple(part for part in parts if part.state == state)
        if found:
            return Enclosure(state, found, edges)
    return Enclosure(State.OUTSIDE, (), edges)


def _parts(mesh: str, inner: Solid, outer: Solid, moves: Integers) -> list[Part]:
    """Return the shells of the inner mesh that are inside the outer one, or may be."""
    facets, shells, hulls = inner.facets, inner.shells, outer.shells
    held, mixed, mirrored = np.zeros((3, len(shells.first)), np.bool_)
    possible = np.flatnonzero(_fitting(shells.boxes, hulls.boxes[hulls.closed], _STILL))
    found = inside(facets[shells.first[possible], 0], outer.facets, hulls)
    held[possible], mixed[possible], mirrored[possible] = found
    doubted = _fitting(shells.boxes, hulls.boxes[~hulls.closed], moves)
    doubted = (doubted | _overlapping(shells.boxes, hulls.rim, moves)) & ~held
    opened = f"not closed: {int(hulls.open_edges.sum())} edges have an odd number of facets"
    turned = "closed, but neighbouring facets are not turned the same way"
    both = (
        "closed, but written with both sides of its surface, or flattened by the grid (then a finer "
        "resolution helps), so that nothing tells its inside"
    )
    crossed = "closed, but parts of it that cross, or hold each other, are turned inside out"
    around = "closed, but on all sides of something that its facets alone do not show to be outside"
    double, shut = np.zeros((2, len(shells.first)), np.bool_)
    possible = possible[~held[possible]]
    if len(possible):
        double[possible], shut[possible] = _doubted(inner, possible, outer)
    least = np.diff(shells.boxes, axis=1).min(0)
    for one in hulls.doubles[(np.diff(hulls.doubles, axis=1) >= least).all((1, 2))]:
        double |= _fitting(shells.boxes, one[None], moves) & ~held
    double |= _overlapping(shells.boxes, hulls.doubles_rim, moves) & ~held
    whys = (
        (held, None), (doubted, opened), (mirrored, crossed), (double, both), (mixed, turned), (shut, around),
    )  # fmt: skip
    return [
        Part(
            mesh,
            State.INSIDE if held[k] else State.UNDECIDED,
            int(shells.first[k]),
            int(shells.facets[k]),
            len(shells.first) == 1,
            next(why for mask, why in whys if mask[k]),
        )
        for k in np.flatnonzero(held | mixed | doubted | double | mirrored | shut)
    ]


def _fitting(boxes: Integers, others: Integers, moves: Integers) -> Mask:
    """Return which boxes (S, 2, 3) lie, on one of the moves (K, 2, 3), within the box of all the others."""
    found = np.zeros(len(boxes), np.bool_)
    if not len(others):
        return found
    # A box fits where its translation is itself within a box.
    least, most = others[:, 0].min(0) - boxes[:, 0], others[:, 1].max(0) - boxes[:, 1]
    small = np.flatnonzero((least <= most).all(1))
    found[small] = _reached(least[small], most[small], moves)
    return found


def _overlapping(boxes: Integers, rim: Integers, moves: Integers) -> Mask:
    """Return which boxes (S, 2, 3) overlap, on one of the moves (K, 2, 3), that of a rim, if there is one."""
    if not len(rim):
        return np.zeros(len(boxes), np.bool_)
    return _reached(rim[0, 0] - boxes[:, 1], rim[0, 1] - boxes[:, 0], moves)


def _reached(least: Integers, most: Integers, moves: Integers) -> Mask:
    """Return which translations, of S between least and most (S, 3), one of the moves (K, 2, 3) may have."""
    found = np.zeros(len(least), np.bool_)
    for i, _ in candidates(np.stack([least, most, most], 1), moves[:, [0, 1, 1]], 0):
        found[i] = True
    return found
