"""Which facet pairs can be near at all, and which is found near first.

Which boxes of two sets overlap is found without comparing all with all, by two trees of boxes, opened
together. A tree stands over its boxes in Morton order (G. M. Morton, A computer oriented geodetic data base
and a new technique in file sequencing, 1966: the bits of the three coordinates are interleaved, the highest
first); `FAN` neighbours make a node, `FAN` nodes a node above them. Pairs of nodes that overlap are opened
from the roots to the leaves, the larger node first, as in S. Gottschalk, M. C. Lin, D. Manocha, OBBTree,
SIGGRAPH 1996, but with axis-parallel boxes; natively, by broadphase.cpp. A box of a node holds those of its
leaves: no order of the leaves can lose a pair. All comparisons are of integers.
"""

import ctypes
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import numpy.typing as npt

from triaxis.golden.errors import InputError
from triaxis.golden.native import native_library
from triaxis.golden.pairs import MAX_WIDTH, coordinate_range
from triaxis.sim.paths import ROOT

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
    centres count: all of them for coordinates of 32 bits. Equal centres keep their order. N is at least 1.
    """
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


# Nodes below a node, and the most near pairs of an answer, as broadphase.cpp has them.
FAN, _FEW = 4, 64
# Fields of a search: comparisons of two boxes, and pairs of nodes that are still to be opened.
_COMPARED, _OPEN = 0, 1
# A corner beyond all coordinates: what is padded with it overlaps nothing.
_BEYOND = 1 << 62
# Pairs in a block: they stay in the processor's cache.
_BLOCK = 1 << 14


@cache
def _native() -> ctypes.CDLL:
    """Return broadphase.cpp with the bulk checker's claims."""
    golden = ROOT / "golden"
    sources = Path(__file__).with_suffix(".cpp"), golden / "bulk_claims.cpp"
    library = native_library("broadphase", sources, sorted(golden.glob("bulk_*.h")))
    # The type of each argument: "p" an address, "i" an integer of 64 bits.
    for name, arguments in {
        "triaxis_search_size": "",
        "triaxis_search": "ppippipp",
        "triaxis_search_next": "pipp",
        "triaxis_first_near": "ppppippippp",
    }.items():
        function = getattr(library, name)
        function.argtypes = [ctypes.c_void_p if kind == "p" else ctypes.c_int64 for kind in arguments]
        function.restype = ctypes.c_int64
    return library


class BoxTree:
    """Boxes (N, 2, 3), low and high corner in LSB, below 2^60 in size, under a tree. N is at least 1.

    ``levels`` are the nodes by height, leaves first: (L, 8), the low corner and minus the high corner, so
    that the box of a node is the minimum of those below it, each with its first coordinate again, to fill a
    register. All levels but the root's are padded to a multiple of `FAN`. ``order``: the number of the box of
    each leaf, (N,).
    """

    def __init__(self, boxes: Integers) -> None:
        """Build the tree."""
        self.order = np.ascontiguousarray(morton_order(boxes))
        level = _rows(boxes[:, 0], -boxes[:, 1])[self.order]
        self.levels: list[Integers] = []
        while len(level) > 1:
            padded = np.full((-(-len(level) // FAN) * FAN, 8), _BEYOND)
            padded[: len(level)] = level
            self.levels.append(padded)
            level = padded.reshape(-1, FAN, 8).min(1)
        self.levels.append(level)
        self._addresses = np.array([level.ctypes.data for level in self.levels], np.uint64)
        # What broadphase.cpp is given.
        self.native = self._addresses.ctypes.data, len(self.levels) - 1, self.order.ctypes.data

    @property
    def low(self) -> Integers:
        """Return the low corner (3,) of all boxes."""
        return self.levels[-1][0, :3]

    @property
    def high(self) -> Integers:
        """Return their high corner (3,)."""
        return -self.levels[-1][0, 4:7]


def _rows(low: Integers, minus_high: Integers) -> Integers:
    """Return corners (N, 3) as rows (N, 8) of broadphase.cpp."""
    return np.concatenate([low, low[:, :1], minus_high, minus_high[:, :1]], 1)


@dataclass
class Work:
    """What a search did: ``compared`` counts comparisons of two boxes, of nodes or of leaves."""

    compared: int = 0


class FacetTrees:
    """The facets of two meshes (N, 3, 3), (M, 3, 3), in LSB, below 2^60 in size, under trees built once.

    They serve all translations of A, and all margins.
    """

    def __init__(self, a: Integers, b: Integers) -> None:
        """Build the trees."""
        self._a, self._b = (np.ascontiguousarray(facets, np.int64) for facets in (a, b))
        empty = not len(a) or not len(b)
        self._trees = None if empty else (BoxTree(_boxes(self._a)), BoxTree(_boxes(self._b)))

    def candidates(
        self, move: Integers, margin: int, work: Work | None = None, block: int = _BLOCK
    ) -> Iterator[tuple[Integers, Integers]]:
        """Yield what `candidates` does, of A translated by ``move`` (3,), in blocks of so many pairs.

        Those whose boxes, and those above them, overlap by most come early.
        """
        if self._trees is None:
            return
        search = self._search(move, margin)
        found = np.empty((2, block), np.int64)
        i, j = (numbers.ctypes.data for numbers in found)
        while count := _native().triaxis_search_next(search.ctypes.data, block, i, j):
            yield found[0, :count].copy(), found[1, :count].copy()
        if work is not None:
            work.compared += int(search[_COMPARED])

    def first_near(self, move: Integers, margin: int, likely: Integers) -> tuple[Integers, int]:
        """Decide pairs of A translated by ``move`` (3,) until some are near: ``likely`` (K, 2), then all.

        Returns what is near (L, 2), nothing where all pairs are clear, and how many pairs were decided:
        without the likely ones where these did not suffice. Raises InputError where 32 bits do not.
        """
        found, count = np.empty((2, _FEW), np.int64), np.zeros(1, np.int64)
        if self._trees is None or not (search := self._search(move, margin))[_OPEN]:
            return found[:, :0].T, 0
        a, b = self._trees
        least, most = coordinate_range(MAX_WIDTH)
        low, high = np.minimum(a.low + move, b.low), np.maximum(a.high + move, b.high)
        if low.min() < least or high.max() > most or not 0 <= margin < 1 << MAX_WIDTH:
            raise InputError(f"coordinates {low.min()}..{high.max()}, margin {margin}: 32 bits are the most")
        before = np.ascontiguousarray(likely.T, np.int64)
        near = _native().triaxis_first_near(
            search.ctypes.data, self._a.ctypes.data, self._b.ctypes.data, move.ctypes.data, margin,
            before[0].ctypes.data, before[1].ctypes.data, len(likely),
            found[0].ctypes.data, found[1].ctypes.data, count.ctypes.data,
        )  # fmt: skip
        return found[:, :near].T, int(count[0])

    def _search(self, move: Integers, margin: int) -> Integers:
        """Return a search that has begun."""
        assert self._trees
        a, b = self._trees
        # By what corners of A may exceed their limits in B.
        room = _rows((margin - move)[None], (margin + move)[None])
        search = np.empty(_native().triaxis_search_size() // 8, np.int64)
        _native().triaxis_search(search.ctypes.data, *a.native, *b.native, room.ctypes.data)
        return search


def candidates(
    a: Integers, b: Integers, margin: int, work: Work | None = None
) -> Iterator[tuple[Integers, Integers]]:
    """Yield facet numbers (i of A, j of B) whose boxes come within the margin, block by block, in no order.

    ``a`` and ``b`` have shape (N, 3, 3), in LSB, below 2^60 in size. Exact: all pairs but those that a box
    axis separates by more than the margin, each once. Time grows like (N + M) log (N + M) and the number of
    pairs, where facets are spread as on surfaces; ``work`` is told what was compared.
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


def all_candidates(a: Integers, b: Integers, margin: int) -> Integers:
    """Return those of all blocks, (K, 2), in order."""
    blocks = [np.stack(block, 1) for block in candidates(a, b, margin)]
    return in_order(np.concatenate([np.empty((0, 2), np.int64), *blocks]))


def in_order(pairs: Integers) -> Integers:
    """Return facet pairs (K, 2) by their number in A, then in B."""
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]


def _boxes(facets: Integers) -> Integers:
    """Return the boxes (N, 2, 3) of facets (N, 3, 3)."""
    return np.stack([facets.min(1), facets.max(1)], 1)


def _reaching(boxes: Integers, others: Integers, margin: int) -> Integers:
    """Return the numbers of boxes (N, 2, 3) within a margin of the box of all the others (M, 2, 3)."""
    low, high = others[:, 0].min(0) - margin, others[:, 1].max(0) + margin
    return np.flatnonzero(((boxes[:, 0] <= high) & (low <= boxes[:, 1])).all(1))
