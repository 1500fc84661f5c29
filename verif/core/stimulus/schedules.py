"""How a core is sent to: what happens in each clock of a schedule, which is repeated to its end."""

import numpy as np

from triaxis.sim.core_engine import OFFER, RESET, TAKE, Steps


def flowing() -> Steps:
    """Return a schedule without gaps, back-pressure or resets."""
    return np.array([OFFER | TAKE], np.uint8)


def disturbed(rng: np.random.Generator) -> Steps:
    """Return a schedule with everything: streaming, gaps, full queues, resets in each of these."""
    phases: list[Steps] = []
    for _ in range(8):
        gaps = rng.integers(0, 2, 200) * OFFER | TAKE
        stalls = rng.integers(0, 2, 200) * TAKE | OFFER
        both = rng.integers(0, 4, 200)
        streaming, full, empty = np.full(600, OFFER | TAKE), np.full(100, OFFER), np.full(100, TAKE)
        for phase in (streaming, full, gaps, empty, stalls, both):
            clocks = phase.astype(np.uint8)
            if rng.integers(0, 2):
                clocks[rng.integers(0, len(clocks))] |= RESET
            phases.append(clocks)
    return np.concatenate(phases)


def stalls(rng: np.random.Generator) -> Steps:
    """Return a schedule of gaps, back-pressure and full queues, without resets."""
    return disturbed(rng) & ~np.uint8(RESET)


def resets(rng: np.random.Generator) -> Steps:
    """Return a schedule with everything, and resets with pairs in flight, often."""
    steps = disturbed(rng)
    again = np.flatnonzero(rng.integers(0, 400, len(steps)) == 0)
    steps[again] |= RESET
    return steps


def filling(rng: np.random.Generator) -> Steps:
    """Return a schedule that fills the queue to the last place and empties it, over and over."""
    full = np.full(100, OFFER, np.uint8)
    empty = np.full(100, TAKE, np.uint8)
    one = np.tile(np.array([OFFER | TAKE, OFFER], np.uint8), 50)
    parts = [full, one, empty, full, np.full(100, OFFER | TAKE, np.uint8)]
    return np.concatenate([parts[number] for number in rng.permutation(len(parts))])
