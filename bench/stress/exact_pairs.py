"""Exact facts of pairs of whole numbers below 2^53: by the bulk checker on 32 bits, by the judge beyond."""

from abc import ABC, abstractmethod
from fractions import Fraction

import numpy as np
import numpy.typing as npt

from triaxis.golden.bulk import bulk_facts
from triaxis.golden.judge import judge
from triaxis.verif.core.stimulus.stimulus import Ints, chosen_rows

Mask = npt.NDArray[np.bool_]

# One in so many of the bulk checker's verdicts is judged again by the linear program.
JUDGED_ONE_IN = 100


class ExactPairs(ABC):
    """Pairs (N, 2, 3, 3) whose exact Chebyshev distances can be compared with whole limits."""

    # Pairs judged by the linear program, and how many answers on them it contradicts.
    judged: int = 0
    contradicted: int = 0

    @abstractmethod
    def within(self, limit: int) -> Mask:
        """Return which pairs are at most ``limit`` units from each other: (N,)."""

    def reach(self, chosen: Mask, most: int) -> int | None:
        """Return the least whole limit, up to ``most``, that all chosen pairs are within; None if none is."""
        if not (self.within(most) | ~chosen).all():
            return None
        low, high = -1, most
        while high - low > 1:
            middle = (low + high) // 2
            if (self.within(middle) | ~chosen).all():
                high = middle
            else:
                low = middle
        return high


class BulkPairs(ExactPairs):
    """Pairs of 32 bits."""

    def __init__(self, pairs: Ints) -> None:
        """Take pairs of 32 bits; a sample of what `within` says is judged by the linear program."""
        self._pairs = pairs.astype(np.int32)
        self._sample = np.arange(0, len(pairs), JUDGED_ONE_IN)
        judgements = [judge(a, b, 0) for a, b in chosen_rows(pairs, self._sample).tolist()]
        self._distances = [judgement.distance for judgement in judgements]
        self.judged = len(judgements)

    def within(self, limit: int) -> Mask:
        """Return which pairs are within the limit; count in ``contradicted`` where the judge disagrees."""
        near = bulk_facts(self._pairs, limit).near
        judged = np.array([distance <= limit for distance in self._distances], np.bool_)
        self.contradicted += int((near[self._sample] != judged).sum())
        return near


class JudgedPairs(ExactPairs):
    """Pairs of any size: each is judged, with a certificate that is checked."""

    def __init__(self, pairs: Ints) -> None:
        """Judge all pairs."""
        self._distances: list[Fraction] = [judge(a, b, 0).distance for a, b in pairs.tolist()]
        self.judged = len(pairs)

    def within(self, limit: int) -> Mask:
        """Return which pairs are within the limit."""
        return np.array([distance <= limit for distance in self._distances], np.bool_)
