"""What the core is to compute, as polynomials: the 32 axes, and the vertices projected on them.

Straight from the contract, by the golden package's list of axes, which the theorem in theorem/ is about too:
no product or sum of the core is taken over. The polynomials have integer coefficients in the coordinates of a
pair of triangles and its margin, and just what the algebra of the core needs: sums, products, and exact
bounds over all coordinates of W bits.
"""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import chain, combinations
from typing import cast

import numpy as np
import numpy.typing as npt

from triaxis.golden.axes import NUM_AXES, axis_vector
from triaxis.golden.exact import Triangle

# Variables: 9 t + 3 v + k is coordinate k of vertex v of triangle t (0: A, 1: B).
VARIABLES = 18
MARGIN = 18

_Monomial = tuple[int, ...]


@dataclass(frozen=True)
class Polynomial:
    """A polynomial: the coefficient of each monomial, none of them 0; a monomial is its variables, sorted."""

    terms: frozenset[tuple[_Monomial, int]]

    def __add__(self, other: "Polynomial") -> "Polynomial":
        """Return the sum."""
        return _collect(chain(self.terms, other.terms))

    def __neg__(self) -> "Polynomial":
        """Return the negative."""
        return self.scaled(-1)

    def __sub__(self, other: "Polynomial") -> "Polynomial":
        """Return the difference."""
        return self + -other

    def __mul__(self, other: "Polynomial | int") -> "Polynomial":
        """Return the product."""
        if isinstance(other, int):
            return self.scaled(other)
        return _collect(
            (tuple(sorted(left + right)), a * b) for left, a in self.terms for right, b in other.terms
        )

    def scaled(self, factor: int) -> "Polynomial":
        """Return the product with a number."""
        return Polynomial(frozenset((monomial, factor * own) for monomial, own in self.terms if factor))

    @cached_property
    def variables(self) -> tuple[int, ...]:
        """Return the variables that occur."""
        return tuple(sorted({variable for monomial, _ in self.terms for variable in monomial}))

    @cached_property
    def degree(self) -> int | None:
        """Return the degree, 0 for the zero polynomial; None where its monomials are of several degrees."""
        degrees = {len(monomial) for monomial, _ in self.terms} or {0}
        return degrees.pop() if len(degrees) == 1 else None

    @cached_property
    def corner_bound(self) -> int | None:
        """Return b such that the absolute is at most b L^degree, and that somewhere, for coordinates of any
        W bits, where L = 2^W - 1; None where the argument does not hold.

        It holds for a polynomial that is affine in each variable (so it is largest at a corner of the box),
        of one degree (so the corners of the box of side 1 tell), and the same wherever the origin lies.
        """
        affine = all(len(set(monomial)) == len(monomial) for monomial, _ in self.terms)
        if not affine or self.degree is None or MARGIN in self.variables or not self._is_translatable:
            return None
        return int(np.abs(at_corners([self], self.variables)).max(initial=0))

    @property
    def _is_translatable(self) -> bool:
        """Return whether moving all six vertices by the same vector changes nothing."""
        return not any(
            _collect(
                (tuple(other for other in monomial if other != variable), factor)
                for monomial, factor in self.terms
                for variable in monomial
                if variable % 3 == k
            ).terms
            for k in range(3)
        )

    def extent(self, width: int) -> tuple[int, int] | None:
        """Return bounds for coordinates of ``width`` bits, exact for sums; None where they are not known."""
        if self.degree == 1 and MARGIN not in self.variables:
            up = sum(factor for _, factor in self.terms if factor > 0)
            down = sum(-factor for _, factor in self.terms if factor < 0)
            lowest, highest = -1 << (width - 1), (1 << (width - 1)) - 1
            return up * lowest - down * highest, up * highest - down * lowest
        bound = self.corner_bound
        if bound is None or self.degree is None:
            return None
        largest = bound * ((1 << width) - 1) ** self.degree
        return -largest, largest


def _collect(terms: Iterable[tuple[_Monomial, int]]) -> Polynomial:
    total: dict[_Monomial, int] = {}
    for monomial, factor in terms:
        total[monomial] = total.get(monomial, 0) + factor
    return Polynomial(frozenset((monomial, factor) for monomial, factor in total.items() if factor))


ZERO = Polynomial(frozenset())
ONE = Polynomial(frozenset({((), 1)}))


def variable(number: int) -> Polynomial:
    """Return one variable."""
    return Polynomial(frozenset({((number,), 1)}))


def at_corners(polynomials: Sequence[Polynomial], variables: Sequence[int]) -> npt.NDArray[np.int32]:
    """Return the values (N, 2^K) of N polynomials at all corners {0, 1}^K of their K variables.

    A monomial is 1 where all of its variables are, so sums of the coefficients, small numbers, tell.
    """
    corners = np.arange(1 << len(variables))
    bits = {number: ((corners >> place) & 1).astype(np.bool_) for place, number in enumerate(variables)}
    values = np.zeros((len(polynomials), len(corners)), np.int32)
    for row, polynomial in zip(values, polynomials, strict=True):
        for monomial, factor in polynomial.terms:
            at = np.ones(len(corners), np.bool_)
            for number in monomial:
                at &= bits[number]
            row[at] += factor
    return values


FIRST_PLANE_AXIS = 14

Vector = tuple[Polynomial, Polynomial, Polynomial]


@dataclass(frozen=True)
class Axis:
    """An axis, and the projections of the vertices of A and of B on it."""

    vector: Vector
    on_a: tuple[Polynomial, ...]
    on_b: tuple[Polynomial, ...]


def vertex(triangle: int, number: int) -> Vector:
    """Return a vertex of A (0) or B (1)."""
    first = 9 * triangle + 3 * number
    return variable(first), variable(first + 1), variable(first + 2)


def vertices() -> list[Vector]:
    """Return the three vertices of A, then those of B."""
    return [vertex(triangle, number) for triangle in (0, 1) for number in range(3)]


def minus(u: Vector, v: Vector) -> Vector:
    """Return u - v."""
    return u[0] - v[0], u[1] - v[1], u[2] - v[2]


def outer(u: Vector, v: Vector) -> Vector:
    """Return the cross product."""
    return u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]


def inner(u: Vector, v: Vector) -> Polynomial:
    """Return the inner product."""
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


def edge(triangle: int, number: int) -> Vector:
    """Return an edge, from that vertex to the next."""
    return minus(vertex(triangle, (number + 1) % 3), vertex(triangle, number))


def _axis_vector(number: int) -> Vector:
    """Return an axis, as the golden package defines it for numbers: its rule holds for polynomials too."""
    a, b = (cast(Triangle, [vertex(triangle, place) for place in range(3)]) for triangle in (0, 1))
    found = cast(list[Polynomial | int], axis_vector(number, a, b))
    x, y, z = (ONE.scaled(part) if isinstance(part, int) else part for part in found)
    return x, y, z


@cache
def axes() -> tuple[Axis, ...]:
    """Return the 32 axes by number."""

    def on(vector: Vector, triangle: int) -> tuple[Polynomial, ...]:
        return tuple(inner(vector, vertex(triangle, v)) for v in range(3))

    vectors = [_axis_vector(number) for number in range(NUM_AXES)]
    return tuple(Axis(vector, on(vector, 0), on(vector, 1)) for vector in vectors)


@cache
def normals() -> tuple[Vector, Vector]:
    """Return the normals of A and B: zero exactly where the triangle is degenerate."""
    return axes()[3].vector, axes()[4].vector


@cache
def orientations() -> dict[tuple[int, ...], Polynomial]:
    """Return the orientation of each four of the six vertices: all zero where one plane holds all six."""
    six = vertices()

    def orientation(numbers: tuple[int, ...]) -> Polynomial:
        u, v, w = (minus(six[number], six[numbers[0]]) for number in numbers[1:])
        return inner(outer(u, v), w)

    return {numbers: orientation(numbers) for numbers in combinations(range(6), 4)}


def is_test_of(axis: Axis, own: Polynomial, points: Sequence[Polynomial]) -> bool:
    """Return whether {0, own} and the points are the projections of one triangle and of the other.

    The axis may serve with either sign, and any vertex of the first triangle may be the origin.
    """
    for first, second in ((axis.on_a, axis.on_b), (axis.on_b, axis.on_a)):
        for start in first:
            interval, others = ({value - start for value in values} for values in (first, second))
            if interval == {ZERO, own} and others == set(points):
                return True
            if interval == {ZERO, -own} and others == {-point for point in points}:
                return True
    return False


def same_up_to_signs(found: Sequence[Polynomial], wanted: Sequence[Polynomial]) -> bool:
    """Return whether the nonzero polynomials of both are the same, each up to its sign."""
    both = (Counter(frozenset({one, -one}) for one in every if one != ZERO) for every in (found, wanted))
    return next(both) == next(both)


def missing_of_plane(flat: Sequence[Polynomial]) -> str | None:
    """Return why zeros of these orientations do not put all six vertices in a plane; None: they do."""
    known = {one for polynomial in flat for one in (polynomial, -polynomial)}
    for numbers, orientation in orientations().items():
        if numbers[0] == 0:
            if orientation not in known:
                return f"the orientation of vertices {numbers} is missing"
            continue
        total = ZERO
        for place in range(4):
            face = orientations()[(0, *(number for at, number in enumerate(numbers) if at != place))]
            total += -face if place % 2 else face
        if total != orientation:
            return f"the orientation of vertices {numbers} does not follow from the others"
    return None


@cache
def extremes(axis: Axis, tested: tuple[Polynomial, ...]) -> tuple[int, int, int]:
    """Return the largest |axis|1 and the largest reach of an interval test, in powers of L, and the degree.

    ``tested``: the triangle's own end, then the points. The reach is that of 0 and the own end moved by a
    margin of L, and of the points. Absolutes of what is affine in each variable are convex in it, so their
    sums are largest at corners too.
    """
    every = (*axis.vector, *tested)
    variables = sorted({number for polynomial in every for number in polynomial.variables})
    values = abs(at_corners(every, variables))
    norms = values[:3].sum(0)
    reach = max(int((values[3] + norms).max()), int(values[4:].max()))
    degree = next(polynomial.degree for polynomial in tested[1:] if polynomial != ZERO)
    return int(norms.max()), reach, degree or 0
