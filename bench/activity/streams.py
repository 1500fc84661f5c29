"""Pairs of which their boxes leave about one in a hundred undecided: what operand gating is measured on."""

from dataclasses import dataclass
from fractions import Fraction
from math import ceil

import numpy as np
import numpy.typing as npt

from triaxis.golden.pairs import Pairs, coordinate_range
from triaxis.host.quantise import centred_grid, quantise
from triaxis.host.scenes import Scene, scenes
from triaxis.verif.core.stimulus.margins import box_gaps

WIDTH = 16
UNDECIDED = Fraction(1, 100)
RANDOM_PAIRS = 10_000

# All of a scene of `scenes` in the range of WIDTH bits, in millimetres.
_SPAN = 300


@dataclass(frozen=True)
class Stream:
    """Pairs (N, 2, 3, 3) in the order in which they are sent, and the margin for all of them."""

    name: str
    pairs: Pairs
    margin: int

    @property
    def undecided(self) -> npt.NDArray[np.bool_]:
        """Return which pairs (N,) no box axis separates by more than the margin."""
        return box_gaps(self.pairs) <= self.margin

    @property
    def share(self) -> float:
        """Return the share of undecided pairs."""
        return float(self.undecided.mean())


def scene_meshes(scene: Scene) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Return both meshes of a scene, (N, 3, 3) and (M, 3, 3), on a grid that holds every scene."""
    grid = centred_grid([scene.a, scene.b], Fraction(_SPAN, 1 << WIDTH), WIDTH)
    return quantise(scene.a, grid, scene.name), quantise(scene.b, grid, scene.name)


def scene_stream(scene: Scene) -> Stream:
    """Return all facet pairs of a scene, facet by facet of A, each with all of B as they stand in the mesh.

    The margin is the smallest with which at least `UNDECIDED` of them are undecided.
    """
    a, b = scene_meshes(scene)
    pairs = np.stack([np.repeat(a, len(b), 0), np.tile(b, (len(a), 1, 1))], 1)
    return Stream(scene.name, pairs, _margin(box_gaps(pairs)))


def _margin(gaps: npt.NDArray[np.int64]) -> int:
    # Where boxes overlap, gaps are negative.
    return max(0, int(np.sort(gaps)[ceil(UNDECIDED * len(gaps)) - 1]))


def random_stream(
    rng: np.random.Generator, count: int = RANDOM_PAIRS, width: int = WIDTH, margin: int = 0
) -> Stream:
    """Return random pairs over the whole range, exactly `UNDECIDED` of them undecided, in random places."""
    low, high = coordinate_range(width)
    wanted = ceil(UNDECIDED * count)
    undecided, decided = np.empty((0, 2, 3, 3), np.int64), np.empty((0, 2, 3, 3), np.int64)
    while len(undecided) < wanted or len(decided) < count - wanted:
        drawn = rng.integers(low, high, (count, 2, 3, 3), endpoint=True)
        meet = box_gaps(drawn) <= margin
        undecided, decided = np.concatenate([undecided, drawn[meet]]), np.concatenate([decided, drawn[~meet]])
    pairs = np.concatenate([undecided[:wanted], decided[: count - wanted]])
    return Stream("random pairs", rng.permutation(pairs), margin)


def streams(seed: int) -> list[Stream]:
    """Return what is measured: random pairs, and all scenes."""
    return [random_stream(np.random.default_rng(seed)), *map(scene_stream, scenes())]
