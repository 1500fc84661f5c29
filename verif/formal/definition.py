"""What the core is to compute, as polynomials: the 32 axes, and the vertices projected on them.

Straight from the contract: no product or sum of the core is taken over.
"""

from dataclasses import dataclass
from functools import cache
from itertools import combinations

from triaxis.verif.formal.polynomial import ONE, ZERO, Polynomial, variable

AXES = 32
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


def _unit(k: int) -> Vector:
    x, y, z = (ONE if k == place else ZERO for place in range(3))
    return x, y, z


def _normal(triangle: int) -> Vector:
    first, second, third = (vertex(triangle, number) for number in range(3))
    return outer(minus(second, first), minus(third, first))


def _vectors() -> list[Vector]:
    """Return the 32 axes by number."""
    box = [_unit(k) for k in range(3)]
    edges = [[edge(triangle, i) for i in range(3)] for triangle in (0, 1)]
    edge_edge = [outer(e, f) for e in edges[0] for f in edges[1]]
    edge_box = [outer(e, _unit(k)) for triangle in (0, 1) for e in edges[triangle] for k in range(3)]
    return [*box, _normal(0), _normal(1), *edge_edge, *edge_box]


@cache
def axes() -> tuple[Axis, ...]:
    """Return the 32 axes by number."""

    def on(vector: Vector, triangle: int) -> tuple[Polynomial, ...]:
        return tuple(inner(vector, vertex(triangle, v)) for v in range(3))

    return tuple(Axis(vector, on(vector, 0), on(vector, 1)) for vector in _vectors())


@cache
def normals() -> tuple[Vector, Vector]:
    """Return the normals of A and B: zero exactly where the triangle is degenerate."""
    return _normal(0), _normal(1)


@cache
def orientations() -> dict[tuple[int, ...], Polynomial]:
    """Return the orientation of each four of the six vertices: all zero where one plane holds all six."""
    six = [vertex(triangle, number) for triangle in (0, 1) for number in range(3)]

    def orientation(numbers: tuple[int, ...]) -> Polynomial:
        u, v, w = (minus(six[number], six[numbers[0]]) for number in numbers[1:])
        return inner(outer(u, v), w)

    return {numbers: orientation(numbers) for numbers in combinations(range(6), 4)}
