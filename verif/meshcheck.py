"""Two meshes against each other: quantise, skip what boxes decide, ask an engine about the rest."""

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import numpy.typing as npt

from triaxis.golden.broadphase import candidates
from triaxis.golden.judge import judge
from triaxis.golden.pairs import Pairs, Verdicts
from triaxis.golden.quantise import Grid, centred_grid, margin_for, quantise, smallest_width
from triaxis.golden.stl import StlMesh

# Widths that are tried where none is asked for.
AUTOMATIC_WIDTHS = (16, 24, 32)

Decide = Callable[[Pairs, npt.NDArray[np.int64]], Verdicts]


@dataclass(frozen=True)
class MeshPair:
    """Two meshes on one grid, with the margin that covers clearance and rounding."""

    mesh_a: StlMesh
    mesh_b: StlMesh
    a: npt.NDArray[np.int64]
    b: npt.NDArray[np.int64]
    grid: Grid
    clearance: Fraction
    margin: int


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
) -> MeshPair:
    """Quantise both meshes on one centred grid; raise InputError where they do not fit."""
    meshes = [mesh_a.facets, mesh_b.facets]
    chosen = width or smallest_width(meshes, resolution, clearance, AUTOMATIC_WIDTHS)
    grid = centred_grid(meshes, resolution, chosen)
    a, b = quantise(mesh_a.facets, grid, names[0]), quantise(mesh_b.facets, grid, names[1])
    margin = margin_for(clearance, grid, mesh_a.rounding + mesh_b.rounding)
    return MeshPair(mesh_a, mesh_b, a, b, grid, clearance, margin)


def check_meshes(
    meshes: MeshPair, decide: Decide, listed: int, progress: Callable[[int], None] | None = None
) -> MeshResult:
    """Decide all facet pairs; ``progress`` is told of facets of A that are done with."""
    tested, near_count = 0, 0
    near: list[tuple[int, int]] = []
    done = 0
    for i, j in candidates(meshes.a, meshes.b, meshes.margin):
        pairs = np.stack([meshes.a[i], meshes.b[j]], 1)
        verdicts = decide(pairs, np.full(len(pairs), meshes.margin, np.int64))
        tested += len(pairs)
        hits = np.flatnonzero(verdicts["near"])
        near_count += len(hits)
        order = hits[np.lexsort((j[hits], i[hits]))][: max(listed - len(near), 0)]
        near += [(int(i[k]), int(j[k])) for k in order]
        if progress:
            progress(int(i[-1]) + 1 - done)
            done = int(i[-1]) + 1
    total = len(meshes.a) * len(meshes.b)
    return MeshResult(total, total - tested, tested, near_count, tuple(near))


def exact_distance(meshes: MeshPair, i: int, j: int) -> Fraction:
    """Return the exact Chebyshev distance of two facets as they stand in the files, unrounded."""

    def exact(facet: npt.NDArray[np.floating]) -> list[list[Fraction]]:
        return [[Fraction(float(x)) for x in vertex] for vertex in facet]

    return judge(exact(meshes.mesh_a.facets[i]), exact(meshes.mesh_b.facets[j]), meshes.clearance).distance


def one_box_holds_the_other(meshes: MeshPair) -> bool:
    """Return whether the box of one mesh lies inside the box of the other."""
    low_a, high_a = meshes.a.min((0, 1)), meshes.a.max((0, 1))
    low_b, high_b = meshes.b.min((0, 1)), meshes.b.max((0, 1))
    a_holds_b = (low_a <= low_b).all() and (high_b <= high_a).all()
    b_holds_a = (low_b <= low_a).all() and (high_a <= high_b).all()
    return bool(a_holds_b or b_holds_a)
