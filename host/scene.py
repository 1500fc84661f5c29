"""Meshes on a grid: where A stands, what goes to an engine, and exact distances of what comes back.

A move is exact: the grid takes it (`Grid.moved`). A turn is exact by multiples of 90 degrees; by other
angles it is computed in float64, and what that may be off goes into the mesh's ``rounding``, which the
margin covers.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import gmpy2
import numpy as np
import numpy.typing as npt

from triaxis.golden.bulk import bulk_claims
from triaxis.golden.errors import InputError
from triaxis.golden.judge import judge
from triaxis.golden.pairs import NO_AXIS, Pairs
from triaxis.host.broadphase import candidates
from triaxis.host.quantise import (
    NOWHERE,
    Grid,
    Vector,
    box_of,
    grid_around,
    margin_for,
    quantise,
    smallest_width,
)
from triaxis.host.stl import StlMesh

# It says nothing of its types.
_MPFR: Any = gmpy2

AXES = "xyz"
_BITS = 200
_QUARTERS = {0: (1.0, 0.0), 90: (0.0, 1.0), 180: (-1.0, 0.0), 270: (0.0, -1.0)}


@dataclass(frozen=True)
class Turn:
    """A rotation about a coordinate axis (0, 1, 2) through the origin, right-handed, in degrees."""

    axis: int
    degrees: Fraction

    @property
    def exact(self) -> bool:
        """Return whether it only exchanges and negates coordinates."""
        return self.degrees % 90 == 0

    @property
    def cosine_and_sine(self) -> tuple[float, float]:
        """Return both, each at most 2^-53 from its real value; exactly for multiples of 90 degrees."""
        degrees = self.degrees % 360
        if degrees in _QUARTERS:
            return _QUARTERS[int(degrees)]
        with _MPFR.context(_MPFR.get_context(), precision=_BITS):
            angle = _MPFR.mpfr(_MPFR.mpq(degrees)) * _MPFR.const_pi() / 180
            return float(_MPFR.cos(angle)), float(_MPFR.sin(angle))


@dataclass(frozen=True)
class Pose:
    """Turns in the order given, then a move, in the unit of the files."""

    turns: tuple[Turn, ...] = ()
    move: Vector = NOWHERE

    @property
    def exact(self) -> bool:
        """Return whether no turn rounds anything."""
        return all(turn.exact for turn in self.turns)


UNMOVED = Pose()


def turned(mesh: StlMesh, turns: Sequence[Turn]) -> StlMesh:
    """Return the mesh after the turns, its ``rounding`` increased by what they may be off.

    Raises InputError where a coordinate becomes too large for float64.
    """
    for turn in turns:
        with np.errstate(over="ignore", invalid="ignore"):
            mesh = _turned(mesh, turn)
        if not np.isfinite(mesh.facets).all():
            raise InputError(
                "rotation: coordinates beyond 1e308: too large to be turned, scale the mesh down"
            )
    return mesh


def _turned(mesh: StlMesh, turn: Turn) -> StlMesh:
    """Return the mesh after one turn.

    With u = 2^-53, e the error of the coordinates before and M the largest of them: an error of e in both
    coordinates becomes at most (|c| + |s|) e <= 3/2 e. The errors of c and s add at most 2 M u, the
    rounding of both products 2 M u, that of the sum 2 M u, each but for terms of M u^2: less than 8 M u = M
    2^-50 together. Numbers below the normal range add at most 2^-1070.
    """
    cosine, sine = turn.cosine_and_sine
    first, second = (turn.axis + 1) % 3, (turn.axis + 2) % 3
    facets = mesh.facets.astype(np.float64)
    x, y = facets[..., first].copy(), facets[..., second].copy()
    facets[..., first] = cosine * x - sine * y
    facets[..., second] = sine * x + cosine * y
    if turn.exact:
        return StlMesh(facets, mesh.rounding)
    largest = Fraction(float(max(np.abs(x).max(), np.abs(y).max())))
    rounding = mesh.rounding * Fraction(3, 2) + largest / 2**50 + Fraction(1, 2**1070)
    return StlMesh(facets, rounding)


# Widths that are tried where none is asked for.
AUTOMATIC_WIDTHS = (16, 24, 32)

NOT_MOVED = np.zeros(3, np.int64)
# Which of pairs (N, 2, 3, 3) at margins (N,) are near, (N,).
Decide = Callable[[Pairs, npt.NDArray[np.int64]], npt.NDArray[np.bool_]]
FacetPairs = npt.NDArray[np.int64]


def bulk_near(pairs: Pairs, margins: npt.NDArray[np.int64]) -> npt.NDArray[np.bool_]:
    """Return which pairs are near, as the bulk checker has it."""
    return bulk_claims(pairs, margins) == NO_AXIS


@dataclass(frozen=True)
class MeshPair:
    """Two meshes on one grid, with the margin that covers clearance and rounding.

    ``mesh_a`` is A as it was turned; the pose's move is exact. ``a`` is on the grid where A stands.
    """

    mesh_a: StlMesh
    mesh_b: StlMesh
    a: npt.NDArray[np.int64]
    b: npt.NDArray[np.int64]
    grid: Grid
    margin: int
    pose: Pose


def prepare(
    mesh_a: StlMesh,
    mesh_b: StlMesh,
    names: tuple[str, str],
    resolution: Fraction,
    clearance: Fraction,
    width: int | None,
    pose: Pose = UNMOVED,
) -> MeshPair:
    """Quantise both meshes on one grid, A in its pose; raise InputError where they do not fit."""
    mesh_a = turned(mesh_a, pose.turns)
    boxes = [box_of(mesh_a.facets, pose.move), box_of(mesh_b.facets)]
    chosen = width or smallest_width(boxes, resolution, clearance, AUTOMATIC_WIDTHS)
    grid = grid_around(boxes, resolution, chosen)
    a = quantise(mesh_a.facets, grid.moved(pose.move), names[0])
    b = quantise(mesh_b.facets, grid, names[1])
    margin = margin_for(clearance, grid, mesh_a.rounding + mesh_b.rounding)
    return MeshPair(mesh_a, mesh_b, a, b, grid, margin, pose)


def near_facets(
    a: npt.NDArray[np.int64], b: npt.NDArray[np.int64], margin: int, decide: Decide
) -> Iterator[tuple[int, FacetPairs]]:
    """Yield, block by block, how many pairs were decided, and which (i of A, j of B) are near: (K, 2).

    ``a`` and ``b`` have shape (N, 3, 3).
    """
    return near_of(candidates(a, b, margin), a, b, NOT_MOVED, margin, decide)


def near_of(
    blocks: Iterator[tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]], a: npt.NDArray[np.int64],
    b: npt.NDArray[np.int64], move: npt.NDArray[np.int64], margin: int, decide: Decide,
) -> Iterator[tuple[int, FacetPairs]]:  # fmt: skip
    """Yield what `near_facets` does of blocks of pairs (i of A, j of B), of A translated by ``move`` (3,)."""
    for i, j in blocks:
        near = decide(np.stack([a[i] + move, b[j]], 1), np.full(len(i), margin, np.int64))
        yield len(i), np.stack([i[near], j[near]], 1)


def distance_of(mesh_a: StlMesh, i: int, mesh_b: StlMesh, j: int, move: Vector) -> Fraction:
    """Return the exact Chebyshev distance of facet i of A, after an exact move, and facet j of B."""
    a = [[Fraction(float(x)) + m for x, m in zip(vertex, move, strict=True)] for vertex in mesh_a.facets[i]]
    b = [[Fraction(float(x)) for x in vertex] for vertex in mesh_b.facets[j]]
    return judge(a, b, 0).distance
