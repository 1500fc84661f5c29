"""Which facet pairs really come within a clearance: on the coordinates as they were read, rounded to no grid.

The bulk checker brackets the answer on the finest grid: within c - r there, certainly near; beyond c + r,
certainly not. What is between goes to the golden model, exactly.
"""

from dataclasses import dataclass
from fractions import Fraction
from math import ceil, floor

import numpy as np
import numpy.typing as npt

from triaxis.golden.bulk import bulk_verdicts
from triaxis.host.broadphase import candidates
from triaxis.host.grid_choice import finest_resolution, grown
from triaxis.host.meshcheck import distance_of, near_facets
from triaxis.host.quantise import Grid, Vector, box_of, grid_around, quantise
from triaxis.host.stl import StlMesh

_WIDTH = 32

Numbers = npt.NDArray[np.int64]


class TooManyError(Exception):
    """More pairs than are worth the time."""


@dataclass(frozen=True)
class ExactNear:
    """Pairs as numbers i * facets of B + j, ascending: those that are near, and those left undecided."""

    near: Numbers
    undecided: Numbers


def count_candidates(a: Numbers, b: Numbers, margin: int, most: int) -> int:
    """Return how many pairs of facets (N, 3, 3) no box decides; raise TooManyError beyond ``most``."""
    count = 0
    for i, _ in candidates(a, b, margin):
        count += len(i)
        if count > most:
            raise TooManyError
    return count


def exact_near(
    mesh_a: StlMesh, mesh_b: StlMesh, move: Vector, clearance: Fraction, most_pairs: int, most_judged: int
) -> ExactNear:
    """Return the pairs within the clearance, A being moved exactly.

    At most ``most_judged`` go to the golden model; the rest of what is between is undecided. Raises
    TooManyError where more than ``most_pairs`` have boxes that come so near.
    """
    grid = _grid(mesh_a, mesh_b, move, clearance)
    a = quantise(mesh_a.facets, grid.moved(move), "A")
    b = quantise(mesh_b.facets, grid, "B")
    # Two coordinates, each off by half a step.
    surely, at_most = floor(clearance / grid.resolution) - 1, ceil(clearance / grid.resolution) + 1
    count_candidates(a, b, at_most, most_pairs)
    found = [pairs for _, pairs in near_facets(a, b, at_most, bulk_verdicts)]
    possible = np.concatenate([np.empty((0, 2), np.int64), *found])
    sure = np.zeros(len(possible), np.bool_)
    if surely >= 0 and len(possible):
        pairs = np.stack([a[possible[:, 0]], b[possible[:, 1]]], 1)
        sure = bulk_verdicts(pairs, surely)["near"].astype(np.bool_)
    doubtful = np.flatnonzero(~sure)
    for index in doubtful[:most_judged].tolist():
        i, j = possible[index].tolist()
        sure[index] = distance_of(mesh_a, i, mesh_b, j, move) <= clearance
    numbers = possible[:, 0] * len(b) + possible[:, 1]
    return ExactNear(np.sort(numbers[sure]), np.sort(numbers[doubtful[most_judged:]]))


def _grid(mesh_a: StlMesh, mesh_b: StlMesh, move: Vector, clearance: Fraction) -> Grid:
    """Return the finest grid that holds both, and the clearance as a margin."""
    boxes = [box_of(mesh_a.facets, move), box_of(mesh_b.facets)]
    low, high = boxes[0]
    for box in boxes[1:]:
        x, y, z = (min(p, q) for p, q in zip(low, box[0], strict=True))
        low = (x, y, z)
        x, y, z = (max(p, q) for p, q in zip(high, box[1], strict=True))
        high = (x, y, z)
    resolution = finest_resolution(grown((low, high), clearance), _WIDTH)
    return grid_around(boxes, resolution, _WIDTH)
