"""What a core in some configuration must answer, from exact facts, and what where a check of it is tried."""

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from triaxis.golden.axes import BOX_AXES
from triaxis.golden.facts import Facts, lowest_axis
from triaxis.sim.configuration import Configuration
from triaxis.sim.packing import PARITIES, WHICH_BITS, Try
from triaxis.sim.result import AXIS_SHIFT, COPLANAR, DEGENERATE_A, DEGENERATE_B, FAULT, NEAR

# Axes of a core without the edge x box axes: they come last.
AXES_WITHOUT_EDGE_BOX = 14

_BOXES = np.uint32((1 << BOX_AXES) - 1)
_SPACE = np.uint32((1 << AXES_WITHOUT_EDGE_BOX) - 1)


def facts_of_core(facts: Facts, configuration: Configuration) -> Facts:
    """Return the facts as far as the core's axes decide.

    Without the edge x box axes a pair that only they separate is near; it is coplanar (docs/theory.md,
    section 2).
    """
    if configuration.edge_box:
        return facts
    return replace(facts, above=facts.above & _SPACE, below=facts.below & _SPACE)


def expected_words(facts: Facts, configuration: Configuration) -> npt.NDArray[np.uint16]:
    """Return the result words (N,) that the core must give for pairs with these facts.

    With operand gating the flags of a pair that a box axis decides read 0.
    """
    separating = facts_of_core(facts, configuration).separating
    flags = np.where(facts.coplanar, np.uint16(COPLANAR), np.uint16(0))
    flags |= np.where(facts.rank_a < 2, np.uint16(DEGENERATE_A), np.uint16(0))
    flags |= np.where(facts.rank_b < 2, np.uint16(DEGENERATE_B), np.uint16(0))
    if configuration.gating:
        flags *= (separating & _BOXES == 0).astype(np.uint16)
    near = separating == 0
    claim = lowest_axis(separating).astype(np.uint16) << np.uint16(AXIS_SHIFT)
    return (flags | np.where(near, np.uint16(NEAR), claim)).astype(np.uint16, copy=False)


def tried_words(
    words: npt.NDArray[np.uint16],
    facts: Facts,
    attempts: npt.NDArray[np.integer],
    configuration: Configuration,
) -> npt.NDArray[np.uint16]:
    """Return the result words that a certified core must give where it must give ``words`` without attempts.

    A claim is answered by its own truth, over all axes; what is not as it was kept is near, with a fault.
    """
    kinds = attempts >> WHICH_BITS
    which = (attempts & ((1 << WHICH_BITS) - 1)).astype(np.uint16)
    claims = kinds == Try.CLAIM
    holds = facts.separating >> which.astype(np.uint32) & np.uint32(1) == 1
    # A number has one bit more than places; the three lowest bits of ``which`` choose one.
    numbered = which & 7 < configuration.queue_depth.bit_length()
    faults = claims & ~holds
    faults |= (kinds == Try.PARITY) & np.isin(which, PARITIES)
    faults |= (kinds == Try.NUMBER) & numbered
    flags = words & np.uint16(COPLANAR | DEGENERATE_A | DEGENERATE_B)
    words = np.where(claims, flags | which << np.uint16(AXIS_SHIFT), words)
    return np.where(faults, flags | np.uint16(NEAR | FAULT), words).astype(np.uint16, copy=False)
