"""The core's result word, TDATA of the output stream (see dut/core/triaxis_core.sv)."""

import numpy as np
import numpy.typing as npt

from triaxis.golden.pairs import VERDICT, Verdicts

NEAR = 1 << 0
COPLANAR = 1 << 1
DEGENERATE_A = 1 << 2
DEGENERATE_B = 1 << 3
# Of the certified core: what was said could not be shown.
FAULT = 1 << 4
AXIS_SHIFT = 8
AXIS_MASK = 0x1F


def claimed_axes(words: npt.NDArray[np.uint16]) -> npt.NDArray[np.int8]:
    """Return the axis that each result word (N,) claims, NO_AXIS where it says near."""
    axes = (words >> AXIS_SHIFT & AXIS_MASK).astype(np.int8)
    # All bits set is -1.
    return axes | -(words & NEAR).astype(np.int8)


def decode(words: npt.NDArray[np.uint16]) -> Verdicts:
    """Return the verdicts in result words of shape (N,)."""
    verdicts = np.zeros(len(words), VERDICT)
    verdicts["near"] = words & NEAR != 0
    verdicts["axis"] = claimed_axes(words)
    verdicts["coplanar"] = words & COPLANAR != 0
    verdicts["degenerate_a"] = words & DEGENERATE_A != 0
    verdicts["degenerate_b"] = words & DEGENERATE_B != 0
    return verdicts


def encode(verdicts: Verdicts) -> npt.NDArray[np.uint16]:
    """Return the result words that the core must give for these verdicts: (N,) of uint16."""
    words = np.where(verdicts["near"], NEAR, verdicts["axis"].astype(np.uint16) << AXIS_SHIFT)
    words = words | np.where(verdicts["coplanar"], COPLANAR, 0)
    words |= np.where(verdicts["degenerate_a"], DEGENERATE_A, 0)
    words |= np.where(verdicts["degenerate_b"], DEGENERATE_B, 0)
    return words.astype(np.uint16)
