"""The small interface behind which an exact solver of the distance program sits.

The Chebyshev distance of two triangles is the optimum of a linear program over the rationals:

    min t   where  |sum_i l_i A_i - sum_j u_j B_j| <= t in each coordinate,
                   l, u >= 0,  sum l = sum u = 1.

A solution is a pair of nearest points. Its dual is

    max d   where  c.A_i - c.B_j >= d for all vertices A_i, B_j,  |c|1 <= 1,

whose solution is a separating axis. Both optima are the distance (docs/theory.md, section 8).
"""

from dataclasses import dataclass
from typing import Protocol

from triaxis.golden.exact import Rational, Triangle


@dataclass(frozen=True)
class NearestPoints:
    """Barycentric weights of two nearest points, and their Chebyshev distance."""

    distance: Rational
    weights_a: tuple[Rational, Rational, Rational]
    weights_b: tuple[Rational, Rational, Rational]


@dataclass(frozen=True)
class BestAxis:
    """An axis with |axis|1 <= 1 on which A lies above B by the distance."""

    distance: Rational
    axis: tuple[Rational, Rational, Rational]


class DistanceSolver(Protocol):
    """Solves the distance program exactly. Nothing it says is trusted: see the certificates."""

    def nearest_points(self, a: Triangle, b: Triangle) -> NearestPoints:
        """Solve the program."""
        ...

    def best_axis(self, a: Triangle, b: Triangle) -> BestAxis:
        """Solve its dual."""
        ...
