"""The distance program as a game of two players, solved by the simplex method on integers.

One player picks one of the three coordinates and a sign, the other a vertex of A and one of B; the first is
paid the signed coordinate of their difference. Mixed, the second player's choice is a point of A and one of
B, the first one's an axis with |c|1 <= 1, and the value of the game is the Chebyshev distance: the two
programs of `triaxis.golden.solver` are its two sides (von Neumann, 1928). With every payment made positive
by the same amount, the origin is a vertex of the second player's program, so no first phase is needed
(Dantzig, 1951), and where it ends both players' best choices stand in one tableau.

Pivots are Edmonds' (Systems of distinct representatives and linear algebra, 1967): every entry is a minor of
the integer matrix, so each division has no remainder. The steepest column is taken first, and by Bland's rule
(1977), which ends always, where that should not come to an end.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from math import lcm

from triaxis.golden.exact import Rational, Scalar, Triangle
from triaxis.golden.solver import BestAxis, NearestPoints

_ROWS, _COLUMNS = 6, 9
# Pivots until Bland's rule: six are usual.
_STEEPEST = 30


@dataclass(frozen=True)
class _Game:
    """The value in the unit of the triangles, and how often each side is chosen, of ``total`` times.

    ``axis``: the first player's six choices, + and then - of each coordinate; ``points``: the second one's
    nine, those with A's first vertex first.
    """

    value: Rational
    axis: Sequence[int]
    points: Sequence[int]
    total: int


def _pivot(tableau: list[list[int]], row: int, column: int, divisor: int) -> int:
    """Exchange a row's unknown and a column's; return what all entries are to be divided by from now on."""
    chosen = tableau[row]
    pivot = chosen[column]
    for number, other in enumerate(tableau):
        if number == row:
            continue
        factor = other[column]
        if factor:
            other[:] = [(x * pivot - factor * y) // divisor for x, y in zip(other, chosen, strict=True)]
            other[column] = -factor
        elif pivot != divisor:
            other[:] = [x * pivot // divisor for x in other]
    chosen[column] = divisor
    return pivot


def _solve(differences: Sequence[Sequence[int]], scale: int) -> _Game:
    """Solve the game of nine differences of vertices, which are multiplied by ``scale``."""
    raised = 1 + max(abs(x) for difference in differences for x in difference)
    tableau = [
        [*(raised + sign * difference[k] for difference in differences), 1]
        for k in range(3)
        for sign in (1, -1)
    ]
    # The objective, to be made as large as can be; its last entry is minus its value.
    tableau.append([*([1] * _COLUMNS), 0])
    objective = tableau[_ROWS]
    # Unknowns 0..8 are the second player's, 9..14 what is left of each row's bound.
    inside, outside = list(range(_COLUMNS, _COLUMNS + _ROWS)), list(range(_COLUMNS))
    divisor, steps = 1, 0
    while True:
        better = [column for column in range(_COLUMNS) if objective[column] > 0]
        if not better:
            break
        if steps < _STEEPEST:
            column = max(better, key=objective.__getitem__)
        else:
            column = min(better, key=outside.__getitem__)
        steps += 1
        row = _leaving(tableau, inside, column)
        divisor = _pivot(tableau, row, column, divisor)
        inside[row], outside[column] = outside[column], inside[row]
    total = -objective[_COLUMNS]
    points, axis = [0] * _COLUMNS, [0] * _ROWS
    for row, unknown in enumerate(inside):
        if unknown < _COLUMNS:
            points[unknown] = tableau[row][_COLUMNS]
    for column, unknown in enumerate(outside):
        if unknown >= _COLUMNS:
            axis[unknown - _COLUMNS] = -objective[column]
    return _Game(Rational(divisor - raised * total, total * scale), axis, points, total)


def _leaving(tableau: Sequence[Sequence[int]], inside: Sequence[int], column: int) -> int:
    """Return the row whose bound is met first as a column's unknown grows."""
    best = -1
    for row in range(_ROWS):
        step = tableau[row][column]
        if step <= 0:
            continue
        if best >= 0:
            here, there = tableau[row][_COLUMNS] * tableau[best][column], tableau[best][_COLUMNS] * step
            if here > there or (here == there and inside[row] > inside[best]):
                continue
        best = row
    return best


def _times(x: Scalar, scale: int) -> int:
    """Return x * scale, which is whole, whatever fixed number of bits x may be in."""
    return int(x.numerator) * (scale // int(x.denominator))


class GameSolver:
    """A DistanceSolver of our own. Of the last two triangles both programs are solved at once."""

    def __init__(self) -> None:
        """Know no game yet."""
        self._last: tuple[object, _Game] | None = None

    def nearest_points(self, a: Triangle, b: Triangle) -> NearestPoints:
        """Solve the program."""
        game = self._game(a, b)
        a1, a2, a3 = (Rational(sum(game.points[i : i + 3]), game.total) for i in (0, 3, 6))
        b1, b2, b3 = (Rational(sum(game.points[j::3]), game.total) for j in range(3))
        return NearestPoints(game.value, (a1, a2, a3), (b1, b2, b3))

    def best_axis(self, a: Triangle, b: Triangle) -> BestAxis:
        """Solve its dual."""
        game = self._game(a, b)
        x, y, z = (Rational(game.axis[k] - game.axis[k + 1], game.total) for k in (0, 2, 4))
        return BestAxis(game.value, (x, y, z))

    def _game(self, a: Triangle, b: Triangle) -> _Game:
        asked = [[tuple(vertex) for vertex in triangle] for triangle in (a, b)]
        # Read once: other threads may ask meanwhile.
        last = self._last
        if last is None or last[0] != asked:
            scale = lcm(*(int(x.denominator) for triangle in asked for vertex in triangle for x in vertex))
            whole = [[[_times(x, scale) for x in v] for v in triangle] for triangle in asked]
            differences = [[p - q for p, q in zip(v, w, strict=True)] for v, w in product(*whole)]
            self._last = last = asked, _solve(differences, scale)
        return last[1]
