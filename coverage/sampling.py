"""Counting of whole samples: codes are made once a sample, joint codes of crosses share their prefixes."""

from functools import reduce
from math import prod
from operator import mul
from typing import Generic

import numpy as np
import numpy.typing as npt

from triaxis.coverage.cover_model import (
    MASK_BITS,
    Codes,
    CoverItem,
    Coverpoint,
    Mask,
    MaskPoint,
    Sample,
)

Hits = npt.NDArray[np.int64]

# Bit k of byte b: (256, 8).
_BITS = np.unpackbits(np.arange(256, dtype=np.uint8)[:, None], axis=1, bitorder="little").astype(np.int64)


class Sampler(Generic[Sample]):
    """Counts the items of a model for one sample, keeping the codes that several items need."""

    def __init__(self, sample: Sample) -> None:
        """Start with no codes computed."""
        self._sample = sample
        self._joint: dict[tuple[Coverpoint[Sample], ...], Codes] = {}

    def hits(self, item: CoverItem[Sample]) -> Hits:
        """Return how often each bin of the item is hit: (item.size,)."""
        first, *others = item.points
        classes = tuple(point for point in others if isinstance(point, Coverpoint))
        if isinstance(first, MaskPoint):
            return self._mask_hits(first, classes)
        return self._point_hits((first, *classes))

    def _point_hits(self, points: tuple[Coverpoint[Sample], ...]) -> Hits:
        radices = [point.radix for point in points]
        table = np.bincount(self._codes(points), minlength=prod(radices)).reshape(radices)
        # The last code of a partial point stands for none of its bins.
        return table[tuple(slice(len(point.bins)) for point in points)].reshape(-1)

    def _mask_hits(self, point: MaskPoint[Sample], classes: tuple[Coverpoint[Sample], ...]) -> Hits:
        masks = point.masks(self._sample)
        radices = [other.radix for other in classes]
        codes = self._codes(classes) if classes else np.zeros(len(masks), np.uint8)
        table = _mask_table(masks, codes, prod(radices)).reshape(*radices, MASK_BITS)
        if table[..., len(point.bins) :].any():
            raise ValueError(f"{point.name}: a mask has bits beyond its {len(point.bins)} bins")
        kept = (*(slice(len(other.bins)) for other in classes), slice(len(point.bins)))
        return np.moveaxis(table[kept], -1, 0).reshape(-1)

    def _codes(self, points: tuple[Coverpoint[Sample], ...]) -> Codes:
        """Return the joint codes of points: the last point's varying fastest."""
        codes = self._joint.get(points)
        if codes is None:
            codes = self._checked(points[0]) if len(points) == 1 else self._join(points)
            self._joint[points] = codes
        return codes

    def _checked(self, point: Coverpoint[Sample]) -> Codes:
        """Return the codes of a point: one too large would count for another bin of a cross."""
        codes = point.codes(self._sample)
        if len(codes) and codes.max() >= point.radix:
            raise ValueError(f"{point.name}: code {codes.max()} where there are {point.radix}")
        return codes

    def _join(self, points: tuple[Coverpoint[Sample], ...]) -> Codes:
        radix = points[-1].radix
        size = reduce(mul, (point.radix for point in points))
        dtype = np.min_scalar_type(size - 1)
        joint = np.multiply(self._codes(points[:-1]), dtype.type(radix), dtype=dtype)
        joint += self._codes(points[-1:])
        return joint


def _mask_table(masks: Mask, codes: Codes, size: int) -> Hits:
    """Return how often each bit is set together with each code: (size, 32).

    Bytes are counted, 256 counters for each code, and bits added up from those counters.
    """
    rows = np.flatnonzero(masks != 0)
    octets = masks[rows].astype("<u4", copy=False).view(np.uint8).reshape(-1, 4)
    offsets = codes[rows].astype(np.intp) << 8
    tables = [np.bincount(offsets + octets[:, k], minlength=size << 8) for k in range(4)]
    return np.concatenate([table.reshape(size, 256) @ _BITS for table in tables], 1)
