"""A stream: the pairs that a fresh core is sent, the last of which it gets wrong.

Most faults need one pair. Those that leave something behind (operands that are not replaced, a margin
that belongs to the pair before) need the pairs before it too: its context.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from triaxis.golden.pairs import Pairs, coordinate_range
from triaxis.sim.configuration import Configuration


@dataclass(frozen=True, eq=False)
class Stream:
    """Pairs (K, 2, 3, 3) and margins (K,), K at least 1, sent one per clock; the last one fails."""

    pairs: Pairs
    margins: npt.NDArray[np.int64]

    def __post_init__(self) -> None:
        """Check the shapes."""
        if self.pairs.shape[1:] != (2, 3, 3) or self.margins.shape != (len(self.pairs),):
            raise ValueError(f"stream: pairs {self.pairs.shape}, margins {self.margins.shape}")
        if not len(self.pairs):
            raise ValueError("stream: no pair")

    def __len__(self) -> int:
        """Return the number of pairs."""
        return len(self.pairs)

    @property
    def pair(self) -> Pairs:
        """Return the pair that fails, (2, 3, 3)."""
        return self.pairs[-1]

    @property
    def margin(self) -> int:
        """Return the margin of the pair that fails."""
        return int(self.margins[-1])

    def fits(self, configuration: Configuration) -> bool:
        """Return whether a core in that configuration can be sent all of it."""
        low, high = coordinate_range(configuration.width)
        return bool(
            self.pairs.min() >= low
            and self.pairs.max() <= high
            and self.margins.max() <= configuration.max_margin
        )

    def preceded_by(self, context: "Stream") -> "Stream":
        """Return this stream with another one before it."""
        return Stream(
            np.concatenate([context.pairs, self.pairs]), np.concatenate([context.margins, self.margins])
        )

    def describe(self) -> str:
        """Return the pairs and margins in one line."""
        each = [f"margin {m}, {p.tolist()}" for p, m in zip(self.pairs, self.margins.tolist(), strict=True)]
        return "; then ".join(each)
