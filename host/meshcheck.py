"""Two meshes against each other: quantise, skip what boxes decide, ask an engine about the rest."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import numpy.typing as npt

from triaxis.golden.judge import judge
from triaxis.golden.pairs import Pairs, Verdicts
from triaxis.host.broadphase import candidates
from triaxis.host.pose import Pose, turned
from triaxis.host.quantise import Grid, Vector, box_of, grid_around, margin_for, quantise, smallest_width
from triaxis.host.stl import StlMesh

# Widths that are tried where none is asked for.
AUTOMATIC_WIDTHS = (16, 24, 32)

Decide = Callable[[Pairs, npt.NDArray[np.int64]], Verdicts]
FacetPairs = npt.NDArray[np.int64]


@dataclass(frozen=True)
class MeshPair:
    """Two meshes on one grid, with the margin that covers clearance and rounding.

    ``mesh_a`` is A as it was turned; ``move`` is what then moved it. ``a`` is on the grid where A stands.
    """

    mesh_a: StlMesh
    mesh_b: StlMesh
    a: npt.NDArray[np.int64]
    b: npt.NDArray[np.int64]
    grid: Grid
    clearance: Fraction
    margin: int
    move: Vector


@dataclass(frozen=True)
class MeshResult:
    """What came of it. Facet numbers count from 0 in each file; ``near`` holds (i of A, j of B)."""

    pairs: int
    skipped: int
    tested: int
    near_count: int
    near: tuple[tuple[int, int], ...]


def prepare(
    mesh_a: StlMesh,
    mesh_b: StlMesh,
    names: tuple[str, str],
    resolution: Fraction,
    clearance: Fraction,
    width: int | None,
    pose: Pose | None = None,
) -> MeshPair:
    """Quantise both meshes on one grid, A in its pose; raise InputError where they do not fit."""
    pose = pose or Pose()
    mesh_a = turned(mesh_a, pose.turns)
    boxes = [box_of(mesh_a.facets, pose.move), box_of(mesh_b.facets)]
    chosen = width or smallest_width(boxes, resolution, clearance, AUTOMATIC_WIDTHS)
    grid = grid_around(boxes, resolution, chosen)
    a = quantise(mesh_a.facets, grid.moved(pose.move), names[0])
    b = quantise(mesh_b.facets, grid, names[1])
    margin = margin_for(clearance, grid, mesh_a.rounding + mesh_b.rounding)
    return MeshPair(mesh_a, mesh_b, a, b, grid, clearance, margin, pose.move)


def near_facets(
    a: npt.NDArray[np.int64],
    b: npt.NDArray[np.int64],
    margin: int,
    decide: Decide,
    progress: Callable[[int], None] | None = None,
    at_once: int = 1 << 20,
) -> Iterator[tuple[int, FacetPairs]]:
    """Yield, piece by piece, how many pairs were decided, and which (i of A, j of B) are near: (K, 2).

    ``a`` and ``b`` have shape (N, 3, 3). ``progress`` is told of facets of A that are done with. A piece has
    at most ``at_once`` pairs.
    """
    done = 0
    for i, j in candidates(a, b, margin):
        for start in range(0, len(i), at_once):
            k, m = i[start : start + at_once], j[start : start + at_once]
            near = decide(np.stack([a[k], b[m]], 1), np.full(len(k), margin, np.int64))["near"]
            yield len(k), np.stack([k[near], m[near]], 1)
        if progress:
            progress(int(i[-1]) + 1 - done)
            done = int(i[-1]) + 1


def in_order(pairs: FacetPairs) -> FacetPairs:
    """Return facet pairs (K, 2) by their number in A, then in B."""
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]


def check_meshes(
    meshes: MeshPair, decide: Decide, listed: int, progress: Callable[[int], None] | None = None
) -> MeshResult:
    """Decide all facet pairs; ``progress`` is told of facets of A that are done with."""
    tested, near_count = 0, 0
    near: list[tuple[int, int]] = []
    for count, found in near_facets(meshes.a, meshes.b, meshes.margin, decide, progress):
        tested += count
        near_count += len(found)
        near += [(int(i), int(j)) for i, j in in_order(found)[: max(listed - len(near), 0)]]
    total = len(meshes.a) * len(meshes.b)
    return MeshResult(total, total - tested, tested, near_count, tuple(near))


def distance_of(mesh_a: StlMesh, i: int, mesh_b: StlMesh, j: int, move: Vector) -> Fraction:
    """Return the exact Chebyshev distance of facet i of A, after an exact move, and facet j of B."""
    a = [[Fraction(float(x)) + m for x, m in zip(vertex, move, strict=True)] for vertex in mesh_a.facets[i]]
    b = [[Fraction(float(x)) for x in vertex] for vertex in mesh_b.facets[j]]
    return judge(a, b, 0).distance


def exact_distance(meshes: MeshPair, i: int, j: int) -> Fraction:
    """Return the exact Chebyshev distance of two facets as they stand, unrounded."""
    return distance_of(meshes.mesh_a, i, meshes.mesh_b, j, meshes.move)
