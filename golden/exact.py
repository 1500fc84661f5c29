"""Exact scalars, vectors and the rank of a few of them.

Rationals are those of gmpy2, which compute as Fraction does in a fraction of its time. To the type checker
they are Fractions: gmpy2 says nothing of its types.
"""

from collections.abc import Sequence
from fractions import Fraction
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    Rational = Fraction
else:
    import gmpy2

    Rational = gmpy2.mpq


Scalar = int | Fraction | Rational
Vector = Sequence[Scalar]
Triangle = Sequence[Vector]


def dot(x: Vector, y: Vector) -> Scalar:
    """Return the exact inner product of two vectors of length 3."""
    return x[0] * y[0] + x[1] * y[1] + x[2] * y[2]


def difference(x: Vector, y: Vector) -> list[Scalar]:
    """Return x - y, exactly."""
    return [x[0] - y[0], x[1] - y[1], x[2] - y[2]]


def rank(vectors: Sequence[Vector]) -> int:
    """Return the exact rank of vectors of length 3, by elimination without division."""
    rows = [list(vector) for vector in vectors]
    found = 0
    for column in range(3):
        pivot = next((r for r in range(found, len(rows)) if rows[r][column] != 0), None)
        if pivot is None:
            continue
        rows[found], rows[pivot] = rows[pivot], rows[found]
        head = rows[found]
        for row in rows[found + 1 :]:
            factor = row[column]
            if factor != 0:
                for k in range(column, 3):
                    row[k] = row[k] * head[column] - head[k] * factor
        found += 1
    return found


def triangle_rank(triangle: Triangle) -> int:
    """Return 0 for a point, 1 for a segment, 2 for a proper triangle."""
    first = triangle[0]
    return rank([difference(vertex, first) for vertex in triangle[1:]])


def coplanar(a: Triangle, b: Triangle) -> bool:
    """Return whether all six vertices lie in one plane."""
    return rank([difference(vertex, a[0]) for vertex in (*a[1:], *b)]) < 3
