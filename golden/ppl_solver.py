"""The distance program, solved by the Parma Polyhedra Library in exact rational arithmetic.

PPL is GPL software. This file is the only one that touches it: another exact solver takes its place
by satisfying `triaxis.golden.solver.DistanceSolver`.
"""

from collections.abc import Sequence
from fractions import Fraction
from math import lcm

import ppl

from triaxis.golden.exact import Triangle
from triaxis.golden.solver import BestAxis, NearestPoints


def _integers(a: Triangle, b: Triangle) -> tuple[list[list[int]], list[list[int]], int]:
    """Return both triangles scaled to integers, and the scale: PPL takes integer coefficients."""
    scale = lcm(*(x.denominator for triangle in (a, b) for vertex in triangle for x in vertex))
    scaled = [
        [[x.numerator * (scale // x.denominator) for x in vertex] for vertex in triangle]
        for triangle in (a, b)
    ]
    return scaled[0], scaled[1], scale


def _solve(
    unknowns: int, rows: Sequence[tuple[list[int], int]], equalities: int, objective: list[int], mode: str
) -> list[Fraction]:
    """Optimise over ``unknowns`` numbers; the first ``equalities`` rows are equal to 0, the others
    at least 0. A row is its coefficients and its constant.
    """
    program = ppl.MIP_Problem(unknowns)
    for index, (coefficients, constant) in enumerate(rows):
        expression = ppl.Linear_Expression(coefficients, constant)
        program.add_constraint(expression == 0 if index < equalities else expression >= 0)
    program.set_objective_function(ppl.Linear_Expression(objective, 0))
    program.set_optimization_mode(mode)
    point = program.optimizing_point()
    divisor = int(point.divisor())
    return [Fraction(int(x), divisor) for x in point.coefficients()]


class PplSolver:
    """A DistanceSolver on PPL's simplex method."""

    def nearest_points(self, a: Triangle, b: Triangle) -> NearestPoints:
        """Solve for three weights of A, three of B and the distance."""
        a, b, scale = _integers(a, b)
        rows: list[tuple[list[int], int]] = [
            ([1, 1, 1, 0, 0, 0, 0], -1),
            ([0, 0, 0, 1, 1, 1, 0], -1),
        ]
        for k in range(3):
            gap = [a[0][k], a[1][k], a[2][k], -b[0][k], -b[1][k], -b[2][k]]
            rows.append(([*gap, 1], 0))
            rows.append(([*(-x for x in gap), 1], 0))
        for i in range(6):
            rows.append(([int(i == j) for j in range(7)], 0))
        x = _solve(7, rows, 2, [0, 0, 0, 0, 0, 0, 1], "minimization")
        return NearestPoints(x[6] / scale, (x[0], x[1], x[2]), (x[3], x[4], x[5]))

    def best_axis(self, a: Triangle, b: Triangle) -> BestAxis:
        """Solve for the positive and negative parts of the axis, the floor of A and that of -B."""
        a, b, scale = _integers(a, b)
        rows: list[tuple[list[int], int]] = []
        for vertex in a:
            rows.append(([*vertex, *(-x for x in vertex), -1, 0], 0))
        for vertex in b:
            rows.append(([*(-x for x in vertex), *vertex, 0, -1], 0))
        rows.append(([-1, -1, -1, -1, -1, -1, 0, 0], 1))
        for i in range(6):
            rows.append(([int(i == j) for j in range(8)], 0))
        x = _solve(8, rows, 0, [0, 0, 0, 0, 0, 0, 1, 1], "maximization")
        axis = (x[0] - x[3], x[1] - x[4], x[2] - x[5])
        return BestAxis((x[6] + x[7]) / scale, axis)
