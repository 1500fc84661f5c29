"""Smaller pairs to try in place of a pair that fails: thousands at a time, each a simple change.

Along one coordinate axis, every subset of the six vertices moves by every step that is a power of two,
or that brings some vertex to 0 or onto another. Beyond one axis: vertices made equal, whole pairs
moved, halved and divided, one value replaced by another wherever it stands, margins made smaller.

Which is smaller? The order compares, one after the other: the sum of the bit lengths of the coordinates and
the margin; the largest absolute coordinate; the number of distinct coordinates; the margin; the sum of the
absolute coordinates; the number of negative ones; the coordinates themselves. The last makes it total, so
that shrinking is deterministic; nothing in it ever grows without bound, so that shrinking ends.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from triaxis.golden.pairs import Pairs


def bit_lengths(values: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """Return the bit length of each absolute value, which must be below 2^53."""
    # frexp is exact there: 2^(e-1) <= value < 2^e.
    return np.frexp(np.abs(values).astype(np.float64))[1].astype(np.int64)


def sizes(pairs: Pairs, margins: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """Return the sizes of pairs (N, 2, 3, 3) at margins (N,): rows (N, K), to be compared from the left."""
    flat = pairs.reshape(-1, 18)
    absolute = np.abs(flat)
    ordered = np.sort(flat, axis=1)
    summary = [
        bit_lengths(flat).sum(1) + bit_lengths(margins),
        absolute.max(1),
        1 + (np.diff(ordered, axis=1) != 0).sum(1),
        margins,
        absolute.sum(1),
        (flat < 0).sum(1),
    ]
    return np.column_stack([*summary, flat])


def smallest_first(keys: npt.NDArray[Any]) -> npt.NDArray[np.intp]:
    """Return the order that sorts rows of sizes (N, K)."""
    return np.lexsort(keys.T[::-1])


def smaller(keys: npt.NDArray[np.int64], than: npt.NDArray[np.int64]) -> npt.NDArray[np.bool_]:
    """Return which rows of sizes (N, K) are strictly smaller than the one row (K,)."""
    differs = keys != than
    first = differs.argmax(1)
    rows = np.arange(len(keys))
    return differs.any(1) & (keys[rows, first] < than[first])


# Six vertices: those of A, then those of B; a pair as (6, 3).
_VERTICES = 6
_Points = npt.NDArray[np.int64]

# Every subset of the vertices but the empty one: (63, 6).
_SUBSETS = (np.arange(1, 1 << _VERTICES)[:, None] >> np.arange(_VERTICES)) & 1


def _halved(values: _Points) -> _Points:
    """Halve towards 0."""
    return np.sign(values) * (np.abs(values) // 2)


def _steps(values: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """Return the steps (S,) by which coordinates (6,) along one axis may move."""
    powers = np.left_shift(np.int64(1), np.arange(int(bit_lengths(values).max()) + 1))
    meeting = (values[:, None] - values[None, :]).ravel()
    onto_halves = (_halved(values) - values).ravel()
    return np.unique(np.concatenate([powers, -powers, -values, meeting, onto_halves]))


def _moved(points: _Points) -> Iterator[_Points]:
    """Yield the pair with subsets of its vertices moved along one axis."""
    for k in range(3):
        steps = _steps(points[:, k])
        moves = (_SUBSETS[:, None, :] * steps[None, :, None]).reshape(-1, _VERTICES)
        moved = np.repeat(points[None], len(moves), 0)
        moved[:, :, k] += moves
        yield moved


def _single_coordinates(points: _Points) -> Iterator[_Points]:
    """Yield the pair with one coordinate replaced: by its highest bit, by another coordinate, by -x."""
    flat = points.ravel()
    for index, value in enumerate(flat.tolist()):
        top = (1 << abs(value).bit_length()) >> 1
        others = np.unique(np.concatenate([flat, [top, -top, top - 1, 1 - top, -value, 0, 1, -1]]))
        changed = np.repeat(flat[None], len(others), 0)
        changed[:, index] = others
        yield changed.reshape(-1, _VERTICES, 3)


def _traded(points: _Points) -> Iterator[_Points]:
    """Yield the pair with one coordinate made smaller, and another as large as it may be in return.

    What fails for large products only gets fewer numbers so, not smaller ones.
    """
    flat = points.ravel()
    low, high = _limits(points)
    for index in np.flatnonzero(flat):
        for value in (low, -high, high):
            changed = np.repeat(flat[None], len(flat), 0)
            np.fill_diagonal(changed, value)
            for less in (0, int(_halved(flat[index])), int(_halved(_halved(flat[index])))):
                changed[:, index] = less
                yield changed.reshape(-1, _VERTICES, 3).copy()


def _values_replaced(points: _Points) -> Iterator[_Points]:
    """Yield the pair with one value replaced by another wherever it stands."""
    values = np.unique(points)
    for value in values.tolist():
        sign = int(np.sign(value))
        less = (value - sign * (1 << k) for k in range(abs(value).bit_length()))
        for other in {*values.tolist(), 0, sign * (abs(value) // 2), *less, value + sign, -value} - {value}:
            yield np.where(points == value, other, points)[None]


def _whole(points: _Points) -> Iterator[_Points]:
    """Yield the pair with whole vertices, whole axes or everything changed."""
    for u in range(_VERTICES):
        for target in (*points, np.zeros(3, np.int64), _halved(points[u])):
            changed = points.copy()
            changed[u] = target
            yield changed[None]
        yield (points - points[u])[None]
    for part in (slice(0, 3), slice(3, 6), slice(0, 6)):
        for axis in (slice(0, 1), slice(1, 2), slice(2, 3), slice(0, 3)):
            yield from _scaled(points, part, axis)
    middle = (points.min(0) + points.max(0)) // 2
    yield (points - middle)[None]


def _scaled(points: _Points, part: slice, axis: slice) -> Iterator[_Points]:
    """Yield the pair with a block of coordinates set to 0, negated, halved, divided by its gcd, .."""
    block = points[part, axis]
    divisor = max(int(np.gcd.reduce(block, axis=None)), 1)
    for new in (np.zeros_like(block), -block, _halved(block), block >> 1, block // divisor):
        changed = points.copy()
        changed[part, axis] = new
        yield changed[None]


def _smaller_margins(margin: int) -> npt.NDArray[np.int64]:
    powers = [margin - (1 << k) for k in range(margin.bit_length())]
    return np.unique(np.array([0, margin // 2, *powers], np.int64))


def _with_margins(points: _Points, margin: int) -> Iterator[tuple[_Points, npt.NDArray[np.int64]]]:
    """Yield the pair at smaller margins, and with one more change made along with the margin."""
    margins = _smaller_margins(margin)
    yield np.repeat(points[None], len(margins), 0), margins
    for divisor in (2, 3, 5, margin):
        shrunk = np.sign(points) * (np.abs(points) // divisor)
        yield shrunk[None], np.array([margin // divisor])
    for moved in _moved(points):
        for less in {1, margin - (margin >> 1), margin}:
            yield moved, np.full(len(moved), margin - less)


def _proposals(points: _Points, margin: int) -> Iterator[tuple[_Points, npt.NDArray[np.int64]]]:
    for family in (_moved, _single_coordinates, _traded, _values_replaced, _whole):
        for proposed in family(points):
            yield proposed, np.full(len(proposed), margin, np.int64)
    if margin:
        yield from _with_margins(points, margin)


def _limits(points: _Points) -> tuple[int, int]:
    """Return the range of the fewest signed bits that hold the pair."""
    bits = int(bit_lengths(np.where(points < 0, ~points, points)).max())
    return -(1 << bits), (1 << bits) - 1


def candidates(pair: Pairs, margin: int) -> tuple[Pairs, npt.NDArray[np.int64]]:
    """Return pairs (N, 2, 3, 3) and margins (N,) smaller than the pair (2, 3, 3), smallest first.

    None is proposed twice, and none needs more bits than the pair itself: what fitted a core fits it
    still. N is up to some 20,000, and 0 for the smallest pair of all.
    """
    points = np.ascontiguousarray(pair, np.int64).reshape(_VERTICES, 3)
    proposed = list(_proposals(points, margin))
    pairs = np.concatenate([p for p, _ in proposed])
    margins = np.concatenate([m for _, m in proposed])
    low, high = _limits(points)
    fits = ((pairs >= low) & (pairs <= high)).all((1, 2))
    pairs, margins = pairs[fits], margins[fits]

    keys = sizes(pairs, margins)
    wanted = smaller(keys, sizes(points[None], np.array([margin]))[0])
    pairs, margins, keys = pairs[wanted], margins[wanted], keys[wanted]
    order = smallest_first(keys)
    pairs, margins, keys = pairs[order], margins[order], keys[order]
    fresh = np.ones(len(keys), np.bool_)
    fresh[1:] = (keys[1:] != keys[:-1]).any(1)
    return pairs[fresh].reshape(-1, 2, 3, 3), margins[fresh]
