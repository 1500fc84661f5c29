"""The shells of a mesh: which are closed, which way they are turned, and where something is missing.

A shell is the facets of a mesh that hang together by shared vertices. It is closed when each of its edges
belongs to an even number of facets: its boundary modulo 2 is zero, which is what makes the number of facets
that a ray crosses even or odd whatever the ray. It is oriented when its facets also run along each edge as
often one way as the other: then the signed crossings are a winding number. Edges without length belong to no
boundary, and facets without area count with their edges like any other.

What is missing of an open shell is taken to lie in the box of its open edges, the *rim*. Edges in one line
are a crack: nothing is in it that is not within 1 LSB of a facet, which no margin is below.

A *double* surface is facets that are written twice, turned alike or not, and have a rim, where an edge
belongs to an odd number of them, each counted once, and to nothing else. With other diagonals no facet is
there twice, but at the rim the surface is folded upon itself: all facets of an edge lie on one side of it, in
a plane but for rounding. Rounding folds thin facets of good meshes, too. So edges of folds are a rim only
where they run round, and somewhere no facet is thin. All of the shell is a double surface then.
"""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

Integers = npt.NDArray[np.int64]
Mask = npt.NDArray[np.bool_]

# Beyond all coordinates.
_FAR = 1 << 62


@dataclass(frozen=True)
class Shells:
    """The S shells of a mesh of N facets, in the order of their first facets.

    ``number`` (N,): the shell of each facet. ``boxes`` (S, 2, 3): low and high corner, in LSB. ``facets``:
    how many each has. ``open_edges`` (S,): edges that belong to an odd number of facets. ``oriented`` (S,):
    closed ones only. ``doubles`` (D, 2, 3): boxes of double surfaces. ``rim``, ``doubles_rim`` (0 or 1, 2,
    3): the box of all open edges, and of the rims of double surfaces, but for cracks.
    """

    number: Integers
    first: Integers
    facets: Integers
    boxes: Integers
    open_edges: Integers
    oriented: Mask
    doubles: Integers
    rim: Integers
    doubles_rim: Integers

    @property
    def closed(self) -> Mask:
        """Return which shells are closed: (S,)."""
        return self.open_edges == 0


@dataclass(frozen=True)
class Solid:
    """A mesh (N, 3, 3), N at least 1, and its shells."""

    facets: Integers
    shells: Shells

    def moved(self, translation: Integers) -> "Solid":
        """Return it elsewhere."""
        boxes = ("boxes", "doubles", "rim", "doubles_rim")
        there = {name: getattr(self.shells, name) + translation for name in boxes}
        return Solid(self.facets + translation, replace(self.shells, **there))


def solid_of(facets: Integers) -> Solid:
    """Return a mesh with its shells."""
    return Solid(facets, shells_of(facets))


def shells_of(facets: Integers) -> Shells:
    """Return the shells of facets (N, 3, 3), N at least 1."""
    corners = _numbered(facets)
    _, first, number, count = np.unique(
        _connected(corners), return_index=True, return_inverse=True, return_counts=True
    )
    # By the lowest facet, whatever its vertices' numbers.
    order = np.argsort(first)
    number = np.argsort(order)[number]
    boxes = _boxes(facets, number, len(first))
    unmatched, turned, rim = _boundary(corners, number, len(first))
    oriented = (unmatched == 0) & (turned == 0)
    points = np.empty((int(corners.max()) + 1, 3), np.int64)
    points[corners.reshape(-1)] = facets.reshape(-1, 3)
    doubles, doubles_rim = _doubles(corners, facets)
    folds = _folded_rim(corners, points)
    if len(folds):
        shell = np.empty(len(points), np.int64)
        shell[corners] = number[:, None]
        doubles = np.concatenate([doubles, boxes[np.unique(shell[folds[:, 0]])]])
        doubles_rim = np.concatenate([doubles_rim, folds])
    if len(rim) and len(doubles_rim):
        # What is missing may lie between the two.
        rim = doubles_rim = np.concatenate([rim, doubles_rim])
    return Shells(
        number, first[order], count[order], boxes, unmatched, oriented, doubles, _rim_box(rim, points),
        _rim_box(doubles_rim, points),
    )  # fmt: skip


def _rim_box(edges: Integers, points: Integers) -> Integers:
    """Return the box (1, 2, 3) of edges (E, 2) between numbered points, (0, 2, 3) where all are cracks."""
    if not len(edges):
        return np.empty((0, 2, 3), np.int64)
    number = _connected(edges)
    order = np.argsort(number, kind="stable")
    joined = np.split(points[edges[order]], np.flatnonzero(np.diff(number[order])) + 1)
    wide = [some.reshape(-1, 3) for some in joined if not _is_crack(some)]
    if not wide:
        return np.empty((0, 2, 3), np.int64)
    return np.stack([np.concatenate(wide).min(0), np.concatenate(wide).max(0)])[None]


def _is_crack(edges: Integers) -> bool:
    """Return whether edges (E, 2, 3) that hang together have all that is between them within 1 LSB of one.

    So it is where no end is further than that from a single edge, the longest; where there is none from end
    to end, where none is further than half of it from the line between the outermost ends.
    """
    points = edges.reshape(-1, 3)
    axis = int(np.ptp(points, axis=0).argmax())
    first, last = int(points[:, axis].argmin()), int(points[:, axis].argmax())
    away = points.astype(object) - points[first]
    whole = away[last]
    single = (np.sort(edges[..., axis], 1) == points[[first, last], axis]).all(1)
    exact = [{tuple(one), tuple(other)} for one, other in edges[single].tolist()]
    allowed = 2 if {tuple(points[first].tolist()), tuple(points[last].tolist())} in exact else 1
    off = 2 * np.abs(away * whole[axis] - away[:, [axis]] * whole)
    return bool((off <= allowed * whole[axis]).all())


def _boxes(facets: Integers, number: Integers, count: int) -> Integers:
    """Return the boxes (S, 2, 3) of facets (N, 3, 3) with each number (N,)."""
    boxes = np.stack([np.full((count, 3), _FAR), np.full((count, 3), -_FAR)], 1)
    np.minimum.at(boxes[:, 0], number, facets.min(1))
    np.maximum.at(boxes[:, 1], number, facets.max(1))
    return boxes


def _doubles(corners: Integers, facets: Integers) -> tuple[Integers, Integers]:
    """Return the boxes (D, 2, 3) of double surfaces: of those that hang together and have a rim; and the
    edges (E, 2) of these.
    """
    triples = np.sort(corners, 1)
    real = np.flatnonzero((np.diff(triples, axis=1) > 0).all(1))
    some, first, count = np.unique(triples[real], axis=0, return_index=True, return_counts=True)
    twice = np.flatnonzero(count % 2 == 0)
    if not len(twice):
        return np.empty((0, 2, 3), np.int64), np.empty((0, 2), np.int64)
    edges, edge, uses = np.unique(
        some[:, [[0, 1], [1, 2], [0, 2]]].reshape(-1, 2), axis=0, return_inverse=True, return_counts=True
    )
    edge = edge.reshape(-1, 3)[twice]
    own = np.bincount(edge.ravel(), minlength=len(edges))
    # The wall between two solids has edges with facets of these.
    single = ((uses == own) & (own % 2 == 1))[edge]
    rim = single.any(1)
    _, number = np.unique(_connected(some[twice]), return_inverse=True)
    count = int(number.max()) + 1
    boxes = _boxes(facets[real[first[twice]]], number, count)[np.bincount(number[rim], minlength=count) > 0]
    return boxes, edges[edge[single]]


def _folded_rim(corners: Integers, points: Integers) -> Integers:
    """Return the edges (E, 2) of folds that are rims of surfaces written twice with other diagonals."""
    edges, broad = _folds(corners, points)
    while True:
        _, place, count = np.unique(edges, return_inverse=True, return_counts=True)
        round_ = (count[place.reshape(-1, 2)] > 1).all(1)
        if round_.all():
            break
        edges, broad = edges[round_], broad[round_]
    if not broad.any():
        return edges[:0]
    number = _connected(edges)
    return edges[np.isin(number, number[broad])]


def _folds(corners: Integers, points: Integers) -> tuple[Integers, Mask]:
    """Return the edges (E, 2) at which a surface is folded upon itself; and which of these have two facets,
    not the same, that are further across, everywhere, than rounding moves them: (E,).
    """
    real = corners[(np.diff(np.sort(corners, 1), axis=1) > 0).all(1)]
    ends = np.sort(np.stack([real, np.roll(real, -1, 1)], -1).reshape(-1, 2), 1)
    apex = np.roll(real, -2, 1).reshape(-1)
    _, first, edge, uses = np.unique(
        ends[:, 0] * len(points) + ends[:, 1], return_index=True, return_inverse=True, return_counts=True
    )
    # Each facet of an edge with the first one.
    later = np.flatnonzero((first[edge] != np.arange(len(edge))) & (uses[edge] % 2 == 0))
    edge, apexes = edge[later], np.stack([apex[first[edge[later]]], apex[later]])
    exact = exact_type(int(np.ptp(points, axis=0).max(initial=0)))
    a, b, p, q = (points[one].astype(exact) for one in (*ends[later].T, *apexes))
    along, to_p, to_q = b - a, p - a, q - a
    left, right, over = np.cross(along, to_p), np.cross(along, to_q), np.cross(to_p, to_q)
    axis = np.abs(left).argmax(1)[:, None]
    one_side = (np.take_along_axis(left, axis, 1) > 0) == (np.take_along_axis(right, axis, 1) > 0)
    # Of four points in a plane, moved by half an LSB each, this determinant changes by half the sum of the
    # absolute components of the four areas, and terms of higher order, which count no more than that where
    # facets are broad.
    areas = sum(np.abs(one).sum(1) for one in (left, right, over, left - right + over))
    flat = one_side[:, 0] & (np.abs((left * to_q).sum(1)) <= areas)
    # Across: more than 4 / sqrt(3) LSB.
    sides = ((left, (along, to_p, to_p - along)), (right, (along, to_q, to_q - along)))
    broad = [
        np.abs(area).max(1) > 4 * np.max([np.abs(one).max(1) for one in some], axis=0) for area, some in sides
    ]
    folded, wide = uses % 2 == 0, np.zeros(len(first), np.bool_)
    np.logical_and.at(folded, edge, flat)
    np.logical_or.at(wide, edge, broad[0] & broad[1] & (apexes[0] != apexes[1]))
    return ends[first[folded]], wide[folded]


def _numbered(facets: Integers) -> Integers:
    """Return the numbers (N, 3) of the facets' vertices: equal where these are."""
    points = facets.reshape(-1, 3)
    order = np.lexsort(points.T)
    ordered = points[order]
    number = np.empty(len(points), np.int64)
    number[order[0]] = 0
    number[order[1:]] = np.cumsum((ordered[1:] != ordered[:-1]).any(1))
    return number.reshape(-1, 3)


def _connected(corners: Integers) -> Integers:
    """Return a number for each facet (N,), the same where facets with vertices (N, 3) hang together."""
    root = np.arange(int(corners.max()) + 1)
    while True:
        lowest = root[corners].min(1)
        if (root[corners] == lowest[:, None]).all():
            return lowest
        # Trees hang their roots under the lowest root next to them, until each has one only.
        np.minimum.at(root, root[corners], lowest[:, None])
        while (root != root[root]).any():
            root = root[root]


def _boundary(corners: Integers, number: Integers, shells: int) -> tuple[Integers, Integers, Integers]:
    """Return how many edges of each shell have an odd number of facets, and how many run unequally: (S,); and
    the first ones, (E, 2).
    """
    start, end = corners.reshape(-1), np.roll(corners, -1, 1).reshape(-1)
    real = start != end
    start, end, shell = start[real], end[real], np.repeat(number, 3)[real]
    if not len(start):
        return np.zeros(shells, np.int64), np.zeros(shells, np.int64), np.empty((0, 2), np.int64)
    key = np.minimum(start, end) * (int(corners.max()) + 1) + np.maximum(start, end)
    order = np.argsort(key)
    first = np.flatnonzero(np.diff(key[order], prepend=-1))
    uses = np.diff(first, append=len(key))
    balance = np.add.reduceat(np.where(start < end, 1, -1)[order], first)
    shell, odd = shell[order][first], uses % 2 == 1
    return (
        np.bincount(shell[odd], minlength=shells),
        np.bincount(shell[balance != 0], minlength=shells),
        np.stack([start, end], 1)[order][first][odd],
    )


def exact_type(reach: int) -> type:
    """Return a type that holds six products of three differences, of which none exceeds ``reach``.

    Python's integers serve where int64 does not.
    """
    return np.int64 if 6 * reach**3 < 1 << 63 else object
