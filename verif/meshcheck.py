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
from triaxis.golden.stl import Facets

# Widths that are tried where none is asked for.
AUTOMATIC_WIDTHS = (16, 24, 32)

Decide = Callable[[Pairs, npt.NDArray[np.int64]], Verdicts]


@dataclass(frozen=True)
class MeshPair:
    """Two meshes on one grid, with the margin that covers clearance and rounding."""

    facets_a: Facets
    facets_b: Facets
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
    facets_a: Facets,
    facets_b: Facets,
    names: tuple[str, str],
    resolution: Fraction,
    clearance: Fraction,
    width: int | None,
) -> MeshPair:
    """Quantise both meshes on one centred grid; raise InputError where they do not fit."""
    meshes = [facets_a, facets_b]
    chosen = width or smallest_width(meshes, resolution, AUTOMATIC_WIDTHS)
    grid = centred_grid(meshes, resolution, chosen)
    a, b = quantise(facets_a, grid, names[0]), quantise(facets_b, grid, names[1])
    margin = margin_for(clearance, grid)
    return MeshPair(facets_a, facets_b, a, b, grid, clearance, margin)


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

    def exact(facet: npt.NDArray[np.float32]) -> list[list[Fraction]]:
        return [[Fraction(float(x)) for x in vertex] for vertex in facet]

    return judge(exact(meshes.facets_a[i]), exact(meshes.facets_b[j]), meshes.clearance).distance
