"""The mixture of all families at the rate of a simulation.

Base pairs, which may cost microseconds each, are used several times, under the exact symmetries of
`symmetry`: in another vertex order, with A and B swapped or not, under another symmetry of the cube and,
every second time, in another place. To the core these are new inputs: other numbers in other places of
its arithmetic. Margins go with their pairs, and no verdict changes.
"""

from collections.abc import Sequence

import numpy as np

from triaxis.verif.core.stimulus.stimulus import Family, Pairs32, Rng, Stimulus, bounds, divided, joined
from triaxis.verif.core.stimulus.symmetry import random_cube_symmetries, random_orders, random_translations

# How often a base pair is used, on average.
TIMES = 16

# Base pairs made at a time: enough that a family's cost is that of its arithmetic, not of its calls.
_BLOCK = 4096


def centred(pairs: Pairs32) -> Pairs32:
    """Return the pairs moved so that zero is in their middle: small pairs get small numbers."""
    vertices = pairs.reshape(-1, 6, 3)
    low, high = bounds(vertices)
    # (low + high + 1) / 2 without overflow. Rounded up, what spans all of the range stays in it.
    middle = (low >> 1) + (high >> 1) + ((low | high) & 1)
    return (vertices - middle[:, None]).reshape(-1, 2, 3, 3)


def varied(rng: Rng, stimulus: Stimulus, width: int) -> Stimulus:
    """Return each pair under a random symmetry; a quarter of the array is also moved, and one centred."""
    pairs = random_cube_symmetries(rng, random_orders(rng, stimulus.pairs))
    half, rest = len(pairs) // 2, len(pairs) * 3 // 4
    pairs[half:rest] = random_translations(rng, pairs[half:rest], width)
    pairs[rest:] = centred(pairs[rest:])
    return Stimulus(pairs, stimulus.margins)


def mixed_once(rng: Rng, families: Sequence[Family], count: int, width: int, largest_margin: int) -> Stimulus:
    """Return the families in equal shares and random order, each base pair used up to TIMES times."""
    base_count = max(len(families), -(-count // TIMES))
    counts = divided(base_count, [1] * len(families))
    base = joined([f(rng, n, width, largest_margin) for f, n in zip(families, counts, strict=True)])
    chosen = rng.permutation(TIMES * base_count)[:count] % base_count
    return varied(rng, base[chosen], width)


class Mixture:
    """An endless supply of bursts of all families.

    It keeps a pool of one block of base pairs for each family given, draws bursts from all of it, and
    renews blocks in turn, so that a base pair is drawn TIMES times on average before it goes. The same
    generator and the same calls give the same bursts.
    """

    def __init__(self, rng: Rng, families: Sequence[Family], width: int, largest_margin: int) -> None:
        """Make the first pool; a family that is given twice has twice the share."""
        self._rng, self._families = rng, tuple(families)
        self._width, self._largest = width, largest_margin
        self._pool = joined([self._block(number) for number in range(len(self._families))])
        self._next, self._drawn = 0, 0

    def burst(self, count: int) -> Stimulus:
        """Return the next pairs with their margins."""
        chosen = self._rng.integers(0, len(self._pool), count, np.uint32)
        stimulus = varied(self._rng, self._pool[chosen], self._width)
        self._drawn += count
        while self._drawn >= TIMES * _BLOCK:
            self._drawn -= TIMES * _BLOCK
            self._renew()
        return stimulus

    def _block(self, number: int) -> Stimulus:
        return self._families[number](self._rng, _BLOCK, self._width, self._largest)

    def _renew(self) -> None:
        place = slice(self._next * _BLOCK, (self._next + 1) * _BLOCK)
        block = self._block(self._next)
        self._pool.pairs[place], self._pool.margins[place] = block.pairs, block.margins
        self._next = (self._next + 1) % len(self._families)
