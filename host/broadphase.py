"""Which facet pairs can be near at all.

Which boxes of two sets overlap is found without comparing all with all, by two trees of boxes, opened
together. A tree stands over its boxes in Morton order (G. M. Morton, A computer oriented geodetic data base
and a new technique in file sequencing, 1966: the bits of the three coordinates are interleaved, the highest
first); `FAN` neighbours make a node, `FAN` nodes a node above them. Pairs of nodes that overlap are opened
from the roots to the leaves, the larger nodes first, as in S. Gottschalk, M. C. Lin, D. Manocha, OBBTree,
SIGGRAPH 1996, but with axis-parallel boxes, and a whole level of pairs at a time, so that NumPy has long
arrays to work at. A box of a node holds those of its leaves: no order of the leaves can lose a pair. All
comparisons are of integers.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Integers = npt.NDArray[np.int64]

# Bits of a coordinate that one 64-bit key takes, three coordinates to a key.
_KEY_BITS = 21
# Two zero bits are put behind each bit by moving halves, quarters, .. apart: shift and mask of each step.
_SPREAD = (
    (32, 0x001F00000000FFFF),
    (16, 0x001F0000FF0000FF),
    (8, 0x100F00F00F00F00F),
    (4, 0x10C30C30C30C30C3),
    (2, 0x1249249249249249),
)


def morton_order(boxes: Integers) -> Integers:
    """Return the numbers (N,) of boxes (N, 2, 3), low and high corner in LSB, by where their centres lie.

    All three coordinates keep one scale, so that the cells of the order are cubes. 42 bits of twice the
    centres count: all of them for coordinates of 32 bits. Equal centres keep their order.
    """
    if not len(boxes):
        return np.zeros(0, np.int64)
    # Twice the centres: whole numbers.
    place = boxes[:, 0] + boxes[:, 1]
    place -= place.min(0)
    bits = int(place.max()).bit_length()
    place >>= max(0, bits - 2 * _KEY_BITS)
    low_key = _interleaved(place & ((1 << _KEY_BITS) - 1))
    if bits <= _KEY_BITS:
        return np.argsort(low_key, kind="stable")
    return np.lexsort((low_key, _interleaved(place >> _KEY_BITS)))


def _interleaved(place: Integers) -> npt.NDArray[np.uint64]:
    """Return numbers (N,) made of the bits of coordinates (N, 3) of at most 21 bits."""
    spread = place.astype(np.uint64)
    for shift, mask in _SPREAD:
        spread = (spread | spread << np.uint64(shift)) & np.uint64(mask)
    return spread[:, 0] | spread[:, 1] << np.uint64(1) | spread[:, 2] << np.uint64(2)


# Nodes below a node: of 2, 4, 8 and 16 the fastest on noisy spheres of 10^5 and 10^6 facets.
FAN = 4
# Pairs of nodes opened at a time, such that the arrays stay in the processor's cache.
_SLICE = 1 << 12
# A corner beyond all coordinates: what is padded with it overlaps nothing.
_BEYOND = 1 << 62


class BoxTree:
    """Boxes (N, 2, 3), low and high corner in LSB, below 2^60 in size, under a tree. N is at least 1.

    ``levels`` are the nodes by height, leaves first: (L, 6), the low corner and minus the high corner, so
    that the box of a node is the minimum of those below it. All levels but the root's are padded to a
    multiple of `FAN`. ``order``: the number of the box of each leaf, (N,). ``sizes``: the mean of the sum of
    the three sides, of the nodes at each height.
    """

    def __init__(self, boxes: Integers) -> None:
        """Build the tree."""
        self.order = morton_order(boxes)
        level = np.concatenate([boxes[:, 0], -boxes[:, 1]], 1)[self.order]
        self.levels: list[Integers] = []
        self.sizes = [_size(level)]
        while len(level) > 1:
            padded = np.full((-(-len(level) // FAN) * FAN, 6), _BEYOND)
            padded[: len(level)] = level
            self.levels.append(padded)
            level = padded.reshape(-1, FAN, 6).min(1)
            self.sizes.append(_size(level))
        self.levels.append(level)


def _size(level: Integers) -> float:
    """Return the mean of the sum of the three sides of boxes (L, 6)."""
    return float(-level.sum(1, np.float64).mean())


@dataclass
class Work:
    """What a search did: ``compared`` counts comparisons of two boxes, of nodes or of leaves."""

    compared: int = 0


@dataclass(frozen=True)
class Poses:
    """Translations of A (P, 3) from where its tree has it, each with its margin (P,)."""

    moves: Integers
    margins: Integers

    def room(self, sign: int) -> Integers:
        """Return what corners of A, or with -1 of B, may exceed their limits in the other by: (6, P)."""
        move = sign * self.moves
        return np.concatenate([self.margins[:, None] - move, self.margins[:, None] + move], 1).T

    def __getitem__(self, chosen: Integers) -> "Poses":
        """Return some of them."""
        return Poses(self.moves[chosen], self.margins[chosen])

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self.margins)


# Numbers of poses, of boxes of A and of boxes of B, (K,) each.
Meetings = tuple[Integers, Integers, Integers]


def overlapping(
    a: BoxTree, b: BoxTree, poses: Poses, most: int | None, work: Work, partly: bool = False
) -> tuple[Meetings, npt.NDArray[np.bool_]] | None:
    """Return pairs of boxes that come within a pose's margin, in no order, and at which poses all are there.

    ``most``: pairs of nodes that are followed on at a pose. Where there are more, the others are left out if
    ``partly``: those that overlap by less along the axis where they do least. Else None is returned. So the
    memory is bounded.
    """
    height_a, height_b = len(a.levels) - 1, len(b.levels) - 1
    room_a, room_b = poses.room(1), poses.room(-1)
    complete = np.ones(len(poses), bool)
    # The roots themselves: each is its tree's only node, but they may be apart.
    limits = room_a - np.roll(b.levels[-1][0], 3)[:, None]
    pose = np.flatnonzero((limits >= a.levels[-1].T).all(0))
    i = j = np.zeros(len(pose), np.int64)
    while len(pose) and (height_a or height_b):
        # The larger nodes are opened: small ones that meet a large one are as many as they are for long.
        if not height_a or (height_b and b.sizes[height_b] > a.sizes[height_a]):
            height_b -= 1
            pose, j, i = _opened(b.levels[height_b], a.levels[height_a], (pose, j, i), room_b, work)
        else:
            height_a -= 1
            pose, i, j = _opened(a.levels[height_a], b.levels[height_b], (pose, i, j), room_a, work)
        if most is None or len(pose) <= most:
            continue
        many = np.bincount(pose, minlength=len(poses)) > most
        if many.any():
            if not partly:
                return None
            complete &= ~many
            kept = _deepest(a.levels[height_a], b.levels[height_b], (pose, i, j), room_a, many, most)
            pose, i, j = pose[kept], i[kept], j[kept]
    return (pose, a.order[i], b.order[j]), complete


def _deepest(
    level_a: Integers,
    level_b: Integers,
    met: Meetings,
    room: Integers,
    many: npt.NDArray[np.bool_],
    most: int,
) -> Integers:
    """Return which pairs of nodes are followed on: all at most poses, at those with many the deepest."""
    among = many[met[0]]
    chosen = np.flatnonzero(among)
    pose, i, j = (numbers[chosen] for numbers in met)
    # A corner of the one and the opposite corner of the other: how far they are beyond the margin.
    apart = np.ascontiguousarray(level_a[i].T)
    apart += np.roll(level_b[j].T, 3, 0)
    apart -= room[:, pose]
    order = np.lexsort((apart.max(0), pose))
    counts = np.bincount(pose, minlength=len(many))[many]
    rank = np.arange(len(pose)) - np.repeat(np.cumsum(counts) - counts, counts)
    return np.concatenate([np.flatnonzero(~among), chosen[order[rank < most]]])


def _opened(below: Integers, other: Integers, met: Meetings, room: Integers, work: Work) -> Meetings:
    """Return which nodes of ``below``, the level under those of ``met``, overlap their node's opposite one.

    The opposite ones are nodes of the level ``other``; ``room`` (6, P): what a corner may exceed its limit by
    at each pose.
    """
    families, room_across = below.reshape(-1, FAN * 6), np.roll(room, 3, 0)
    parts: list[Meetings] = []
    for start in range(0, len(met[0]), _SLICE):
        pose, parent, facing = (numbers[start : start + _SLICE] for numbers in met)
        count = len(parent)
        # Corners first and pairs last: the comparisons run along contiguous memory.
        children = np.ascontiguousarray(families[parent].T).reshape(FAN, 6, count)
        limits = np.ascontiguousarray(other[facing].T)
        # One pose serves all pairs.
        np.subtract(room_across if len(room.T) == 1 else room_across[:, pose], limits, out=limits)
        overlap = children[:, 0] <= limits[3]
        for corner in range(1, 6):
            overlap &= children[:, corner] <= limits[(corner + 3) % 6]
        hit = np.flatnonzero(overlap)
        child = hit // count
        pair = hit - child * count
        parts.append((pose[pair], parent[pair] * FAN + child, facing[pair]))
        work.compared += FAN * count
    pose, node, opposite = (np.concatenate(part) for part in zip(*parts, strict=True))
    return pose, node, opposite


# Pairs in a block, and facets of A in it: they bound the memory, whatever the meshes.
_BLOCK = 1 << 20
_FACETS = 1 << 14


class FacetTrees:
    """The facets of two meshes (N, 3, 3), (M, 3, 3), in LSB, below 2^60 in size, under trees built once.

    They serve all translations of A, and all margins.
    """

    def __init__(self, a: Integers, b: Integers) -> None:
        """Build the trees: of A a tree over each few of its facets in turn, to be opened in that order."""
        self._a, self._count_b = _boxes(a), len(b)
        self._b = BoxTree(_boxes(b)) if len(b) else None
        # By the first facet and the one after the last.
        self._kept: dict[tuple[int, int], BoxTree] = {}

    def candidates(
        self, move: Integers, margin: int, work: Work | None = None, in_order: bool = True
    ) -> Iterator[tuple[Integers, Integers]]:
        """Yield what `candidates` does, of A translated by ``move`` (3,).

        ``in_order``: within a block, too.
        """
        work = Work() if work is None else work
        pose = Poses(move[None], np.array([margin], np.int64))
        for start, end in self._pieces():
            for i, j in self._of(start, end, pose, work):
                if in_order:
                    # One number a pair sorts several times faster than two.
                    key = np.sort(i * self._count_b + j)
                    i = key // self._count_b
                    yield i, key - i * self._count_b
                else:
                    yield i, j

    def some(self, poses: Poses, most: int) -> tuple[Meetings, npt.NDArray[np.bool_]]:
        """Return candidates of each pose, and at which all are there: where they are at most so many."""
        complete, work = np.ones(len(poses), bool), Work()
        none = np.empty(0, np.int64)
        found: list[Meetings] = [(none, none, none)]
        for start, end in self._pieces():
            assert self._b
            met = overlapping(self._tree(start, end), self._b, poses, most, work, partly=True)
            assert met
            (pose, i, j), whole = met
            found.append((pose, i + start, j))
            complete &= whole
        pose, i, j = (np.concatenate(part) for part in zip(*found, strict=True))
        return (pose, i, j), complete

    def _pieces(self) -> Iterator[tuple[int, int]]:
        """Yield which facets of A have a tree of their own."""
        for start in range(0, len(self._a) if self._b else 0, _FACETS):
            yield start, min(start + _FACETS, len(self._a))

    def _tree(self, start: int, end: int) -> BoxTree:
        if (start, end) not in self._kept:
            self._kept[start, end] = BoxTree(self._a[start:end])
        return self._kept[start, end]

    def _of(self, start: int, end: int, pose: Poses, work: Work) -> Iterator[tuple[Integers, Integers]]:
        assert self._b
        most = _BLOCK if end - start > 1 else None
        found = overlapping(self._tree(start, end), self._b, pose, most, work)
        if found is None:
            middle = (start + end) // 2
            yield from self._of(start, middle, pose, work)
            yield from self._of(middle, end, pose, work)
        elif len(found[0][0]):
            yield found[0][1] + start, found[0][2]


def candidates(
    a: Integers, b: Integers, margin: int, work: Work | None = None
) -> Iterator[tuple[Integers, Integers]]:
    """Yield facet numbers (i of A, j of B) whose boxes come within the margin, block by block, in order.

    ``a`` and ``b`` have shape (N, 3, 3), in LSB, below 2^60 in size. Exact: all pairs but those that a box
    axis separates by more than the margin, each once, by i and then by j. A block has at most 2^20 pairs,
    or those of a single facet of A. Time grows like (N + M) log (N + M) and the number of pairs, where
    facets are spread as on surfaces; ``work`` is told what was compared.
    """
    if not len(a) or not len(b):
        return
    boxes_a, boxes_b = _boxes(a), _boxes(b)
    # Who asks once need not put a tree over what is far from the other mesh.
    number_a, number_b = _reaching(boxes_a, boxes_b, margin), _reaching(boxes_b, boxes_a, margin)
    if not len(number_a) or not len(number_b):
        return
    trees = FacetTrees(a[number_a], b[number_b])
    for i, j in trees.candidates(np.zeros(3, np.int64), margin, work):
        yield number_a[i], number_b[j]


def _boxes(facets: Integers) -> Integers:
    """Return the boxes (N, 2, 3) of facets (N, 3, 3)."""
    return np.stack([facets.min(1), facets.max(1)], 1)


def _reaching(boxes: Integers, others: Integers, margin: int) -> Integers:
    """Return the numbers of boxes (N, 2, 3) within a margin of the box of all the others (M, 2, 3)."""
    low, high = others[:, 0].min(0) - margin, others[:, 1].max(0) + margin
    return np.flatnonzero(((boxes[:, 0] <= high) & (low <= boxes[:, 1])).all(1))
