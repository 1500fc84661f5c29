"""The distance program, solved by the Parma Polyhedra Library in exact rational arithmetic.

PPL is GPL software. This file is the only one that touches it: another exact solver takes its place
by satisfying `triaxis.golden.solver.DistanceSolver`.
"""

from collections.abc import Sequence
from math import lcm

import ppl

from triaxis.golden.exact import Rational, Triangle
from triaxis.golden.solver import BestAxis, NearestPoints


def _integers(a: Triangle, b: Triangle) -> tuple[list[list[int]], list[list[int]], int]:
    """Return both triangles scaled to integers, and the scale: PPL takes integer coefficients."""
    scale = lcm(*(x.denominator for triangle in (a, b) for vertex in triangle for x in vertex))
    scaled = [
        [[x.numerator * (scale // x.denominator) for x in vertex] for vertex in triangle]
        for triangle in (a, b)
    ]
    return scaled[0], scaled[1], scale


def _at_least_zero(coefficients: list[int], constant: int) -> ppl.Constraint:
    return ppl.Linear_Expression(coefficients, constant) >= 0


def _not_negative(unknowns: int) -> list[ppl.Constraint]:
    return [ppl.Variable(i) >= 0 for i in range(unknowns)]


def _solve(
    fixed: Sequence[ppl.Constraint],
    rows: Sequence[tuple[list[int], int]],
    objective: int,
    mode: str,
) -> list[Rational]:
    """Optimise unknown number ``objective``, the last, over the fixed constraints and rows that are
    at least 0. A row is its coefficients and its constant.
    """
    program = ppl.MIP_Problem(objective + 1)
    for constraint in fixed:
        program.add_constraint(constraint)
    for coefficients, constant in rows:
        program.add_constraint(_at_least_zero(coefficients, constant))
    program.set_objective_function(ppl.Variable(objective))
    program.set_optimization_mode(mode)
    point = program.optimizing_point()
    divisor = point.divisor()
    return [Rational(x, divisor) for x in point.coefficients()]


# Unknowns of the program: weights of A2, A3, B2, B3, and the distance t. The weights of A1 and B1
# are what is left of 1.
_WEIGHTS = [
    *_not_negative(4),
    _at_least_zero([-1, -1, 0, 0], 1),
    _at_least_zero([0, 0, -1, -1], 1),
]

# Unknowns of the dual, with the origin at A1: positive and negative parts of the axis, how far A
# reaches below 0, and the distance d.
_AXIS = [
    *_not_negative(7),
    _at_least_zero([-1, -1, -1, -1, -1, -1], 1),
]


class PplSolver:
    """A DistanceSolver on PPL's simplex method."""

    def nearest_points(self, a: Triangle, b: Triangle) -> NearestPoints:
        """Solve the program."""
        a, b, scale = _integers(a, b)
        rows: list[tuple[list[int], int]] = []
        for k in range(3):
            start = a[0][k] - b[0][k]
            gap = [a[1][k] - a[0][k], a[2][k] - a[0][k], b[0][k] - b[1][k], b[0][k] - b[2][k]]
            rows.append(([*gap, 1], start))
            rows.append(([*(-x for x in gap), 1], -start))
        a2, a3, b2, b3, distance = _solve(_WEIGHTS, rows, 4, "minimization")
        return NearestPoints(distance / scale, (1 - a2 - a3, a2, a3), (1 - b2 - b3, b2, b3))

    def best_axis(self, a: Triangle, b: Triangle) -> BestAxis:
        """Solve its dual."""
        a, b, scale = _integers(a, b)
        rows: list[tuple[list[int], int]] = []
        for vertex in a[1:]:
            offset = [x - y for x, y in zip(vertex, a[0], strict=True)]
            rows.append(([*offset, *(-x for x in offset), 1, 0], 0))
        for vertex in b:
            offset = [x - y for x, y in zip(vertex, a[0], strict=True)]
            rows.append(([*(-x for x in offset), *offset, -1, -1], 0))
        x = _solve(_AXIS, rows, 7, "maximization")
        return BestAxis(x[7] / scale, (x[0] - x[3], x[1] - x[4], x[2] - x[5]))
