"""Errors of verdicts: missed collisions and false alarms, counted apart, against the exact answers."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from triaxis.bench.error.truth import Truth

Mask = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class Errors:
    """How many of ``pairs`` collide in truth, how many of those were missed, how many others were alarms."""

    pairs: int
    colliding: int
    missed: int
    false_alarms: int

    @property
    def missed_share(self) -> float:
        """Return the share of the colliding pairs that was missed; 0 where none collides."""
        return self.missed / self.colliding if self.colliding else 0.0

    @property
    def false_alarm_share(self) -> float:
        """Return the share of the clear pairs that was called near; 0 where none is clear."""
        clear = self.pairs - self.colliding
        return self.false_alarms / clear if clear else 0.0


def count_errors(verdicts: Mask, truth: Truth) -> Errors:
    """Return the errors of verdicts (N,), true: near, on whether pairs collide, touching included."""
    colliding = truth.near()
    if verdicts.shape != colliding.shape:
        raise ValueError(f"{len(verdicts)} verdicts on {len(truth)} pairs")
    return Errors(
        len(truth),
        int(colliding.sum()),
        int((colliding & ~verdicts).sum()),
        int((verdicts & ~colliding).sum()),
    )
