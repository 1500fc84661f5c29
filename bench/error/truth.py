"""Exact distances of pairs of float32 triangles as they are, rounded to no grid: what verdicts are held to.

The golden model solves each pair over the rationals and checks its own certificate (docs/theory.md,
section 8); a float32 is a rational.
"""

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from triaxis.golden.exact import Rational, Triangle
from triaxis.golden.judge import judge
from triaxis.golden.processes import in_processes

# (N, 3, 3): triangle, vertex, coordinate.
Triangles = npt.NDArray[np.float32]

# Pairs that a process takes at a time.
_CHUNK = 500


@dataclass(frozen=True)
class Truth:
    """Exact Chebyshev distances of pairs (N,), in the unit of the coordinates."""

    distances: tuple[Fraction, ...]

    def __len__(self) -> int:
        """Return the number of pairs."""
        return len(self.distances)

    def near(self, clearance: Fraction | int = 0) -> npt.NDArray[np.bool_]:
        """Return whether each pair comes within the clearance: (N,). 0: collides, touching included."""
        return np.array([distance <= clearance for distance in self.distances], np.bool_)


def exact_triangle(triangle: npt.NDArray[np.floating[Any]]) -> Triangle:
    """Return a triangle (3, 3) of floats as the rationals that they are."""
    return [[Rational(x) for x in vertex] for vertex in triangle.tolist()]


def exact_truth(a: Triangles, b: Triangles) -> Truth:
    """Return the exact distances of A (N, 3, 3) and B (N, 3, 3)."""
    chunks = [(a[start : start + _CHUNK], b[start : start + _CHUNK]) for start in range(0, len(a), _CHUNK)]
    return Truth(tuple(distance for chunk in in_processes(_solve, chunks) for distance in chunk))


def _solve(chunk: tuple[Triangles, Triangles]) -> list[Fraction]:
    pairs = zip(*chunk, strict=True)
    return [judge(exact_triangle(a), exact_triangle(b), 0).distance for a, b in pairs]
