"""Where a mesh stands: turned about the axes of its frame, then moved.

A move is exact: the grid takes it (`Grid.moved`). A turn is exact by multiples of 90 degrees; by other
angles it is computed in float64, and what that may be off goes into the mesh's ``rounding``, which the
margin covers.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import gmpy2
import numpy as np

from triaxis.golden.errors import InputError
from triaxis.host.quantise import Vector
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
    move: Vector = (Fraction(0), Fraction(0), Fraction(0))

    @property
    def exact(self) -> bool:
        """Return whether no turn rounds anything."""
        return all(turn.exact for turn in self.turns)


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
