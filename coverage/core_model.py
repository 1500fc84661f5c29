"""What the core must have been seen doing."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from triaxis.coverage.covergroup import NO_BIN, BinNumbers, CoverModel, Coverpoint, cross
from triaxis.golden.axes import NUM_AXES, axis_name
from triaxis.golden.pairs import Pairs, coordinate_range


@dataclass(frozen=True)
class CoreSample:
    """N checked pairs: inputs, the exact verdict, all separating axes (N, 32), clocks waited."""

    pairs: Pairs
    margins: npt.NDArray[np.int64]
    near: npt.NDArray[np.bool_]
    separating: npt.NDArray[np.bool_]
    waits_in: npt.NDArray[np.int64]
    waits_out: npt.NDArray[np.int64]
    width: int
    max_margin: int


AXES = tuple(f"{n:02d} {axis_name(n)}" for n in range(NUM_AXES))
RANKS = ("point", "segment", "triangle")
SCALES = ("tiny, below 2^3", "small, below 2^(W/2)", "large", "reaching both limits")
WAITS = ("none", "1", "2 to 7", "8 or more")


def _first_axis(sample: CoreSample) -> BinNumbers:
    return np.where(sample.separating.any(1), sample.separating.argmax(1) + 1, 0)


def _sole_axis(sample: CoreSample) -> BinNumbers:
    return np.where(sample.separating.sum(1) == 1, sample.separating.argmax(1), NO_BIN)


def _rank(triangles: npt.NDArray[np.int64]) -> BinNumbers:
    """Return 0 point, 1 segment, 2 triangle, exactly.

    A component of the area is less than 2^67, so its 64-bit value may have wrapped: it is zero where
    the wrapped value is, and the float64 value, off by far less than 2^62, says that it is small.
    """
    p, q = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    point = ((p == 0) & (q == 0)).all(1)
    wrapped = np.cross(p, q)
    about = np.cross(p.astype(np.float64), q.astype(np.float64))
    segment = ((wrapped == 0) & (np.abs(about) < 2.0**62)).all(1)
    return np.where(point, 0, np.where(segment, 1, 2))


def _scale(sample: CoreSample) -> BinNumbers:
    low, high = coordinate_range(sample.width)
    flat = sample.pairs.reshape(len(sample.pairs), 18)
    largest = np.abs(flat).max(1)
    both = (flat.min(1) == low) & (flat.max(1) == high)
    small = 1 << (sample.width // 2)
    return np.where(both, 3, np.where(largest < 8, 0, np.where(largest < small, 1, 2)))


def _margin(sample: CoreSample) -> BinNumbers:
    m = sample.margins
    below_max = np.where(m == 0, 0, np.where(m == 1, 1, np.where(m < 8, 2, 3)))
    return np.where((m == sample.max_margin) & (m > 0), 4, below_max)


def _waits(waits: npt.NDArray[np.int64]) -> BinNumbers:
    return np.where(waits == 0, 0, np.where(waits == 1, 1, np.where(waits < 8, 2, 3)))


_RANK_A = Coverpoint[CoreSample]("rank_a", "what A is", RANKS, lambda s: _rank(s.pairs[:, 0]))
_RANK_B = Coverpoint[CoreSample]("rank_b", "what B is", RANKS, lambda s: _rank(s.pairs[:, 1]))
_NEAR = Coverpoint[CoreSample]("near", "the verdict", ("clear", "near"), lambda s: s.near.astype(np.int64))
_SCALE = Coverpoint[CoreSample]("scale", "size of the coordinates", SCALES, _scale)
_MARGIN = Coverpoint[CoreSample](
    "margin", "the margin", ("0", "1", "2 to 7", "8 or more", "the largest"), _margin
)
_RANKS = cross("ranks", "what A is / what B is", _RANK_A, _RANK_B)

CORE_MODEL = CoverModel[CoreSample](
    "triaxis_core",
    (
        Coverpoint("claim", "the lowest-numbered separating axis", ("near", *AXES), _first_axis),
        Coverpoint("sole_axis", "the only axis that separates", AXES, _sole_axis),
        cross("ranks_near", "what A is / what B is / the verdict", _RANKS, _NEAR),
        cross("scale_near", "size of the coordinates / the verdict", _SCALE, _NEAR),
        cross("margin_near", "the margin / the verdict", _MARGIN, _NEAR),
        Coverpoint("wait_in", "clocks a pair waited", WAITS, lambda s: _waits(s.waits_in)),
        Coverpoint("wait_out", "clocks a result waited", WAITS, lambda s: _waits(s.waits_out)),
    ),
)
