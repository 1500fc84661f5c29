"""The widths of the package, proved by enumerating the corners of the coordinate box.

Every quantity is a polynomial, affine in each coordinate, so over a box it is largest at a corner; it is
homogeneous and does not change where all six vertices are moved, so the corners {0, 1}^18 tell its largest
value for every width: a number times a power of L = 2^W - 1. `Polynomial.corner_bound` checks all three.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import combinations, product
from pathlib import Path

from triaxis.golden.axes import BOX_AXES
from triaxis.golden.errors import InputError
from triaxis.golden.pairs import MAX_WIDTH, MIN_WIDTH
from triaxis.verif.formal.definition import (
    FIRST_PLANE_AXIS,
    Polynomial,
    Vector,
    at_corners,
    axes,
    edge,
    inner,
    minus,
    normals,
    orientations,
    outer,
    vertices,
)  # fmt: skip
from triaxis.verif.formal.proof import Finding, Proof
from triaxis.verif.testbench.rtl_package import Package


@dataclass(frozen=True)
class Bound:
    """The largest absolute of a kind of quantity, factor * L^degree, and the width that is to hold it."""

    quantity: str
    factor: int
    degree: int
    width: str

    def largest(self, width: int) -> int:
        """Return the largest absolute for coordinates of ``width`` bits."""
        return self.factor * ((1 << width) - 1) ** self.degree


def _largest(quantity: str, polynomials: Iterable[Polynomial], degree: int) -> int:
    """Return the factor of the bound; raise InputError where the argument does not hold."""
    factors = []
    for polynomial in set(polynomials):
        if polynomial.terms and (polynomial.corner_bound is None or polynomial.degree != degree):
            raise InputError(f"{quantity}: not affine, homogeneous and translatable: corners do not tell")
        factors.append(polynomial.corner_bound or 0)
    return max(factors)


def _common_vertex_products() -> list[Polynomial]:
    """Return the components of the cross products of two differences from one vertex."""
    return [
        component
        for start in vertices()
        for u, v in combinations([minus(end, start) for end in vertices() if end != start], 2)
        for component in outer(u, v)
    ]


def _edge_edge() -> list[Vector]:
    return [outer(edge(0, i), edge(1, j)) for i, j in product(range(3), range(3))]


def _projection_differences() -> list[Polynomial]:
    """Return the differences of any two vertices' projections on the eleven axes in space."""
    return [
        inner(axis.vector, minus(u, v))
        for axis in axes()[BOX_AXES:FIRST_PLANE_AXIS]
        for u, v in combinations(vertices(), 2)
    ]


def _differences() -> list[Polynomial]:
    return [component for u, v in combinations(vertices(), 2) for component in minus(u, v)]


def _largest_norm(vectors: Iterable[Vector]) -> int:
    """Return the largest sum of absolutes: convex in each coordinate, so at a corner as well."""
    largest = 0
    for vector in vectors:
        variables = sorted({number for component in vector for number in component.variables})
        largest = max(largest, int(abs(at_corners(vector, variables)).sum(0).max()))
    return largest


def bounds() -> list[Bound]:
    """Return the bounds of all kinds of quantities, enumerated."""
    edge_edge = _edge_edge()
    signed = (
        ("difference of two vertices", _differences(), 1, "diff_width"),
        ("cross product from a common vertex", _common_vertex_products(), 2, "cross_width"),
        ("edge x edge, one component", [c for v in edge_edge for c in v], 2, "axis_width"),
        ("orientation of four vertices", list(orientations().values()), 3, "span_width"),
        ("difference of projections on an axis", _projection_differences(), 3, "span_width"),
    )
    return [
        Bound(quantity, _largest(quantity, polynomials, degree), degree, width)
        for quantity, polynomials, degree, width in signed
    ]


class WidthsProof(Proof):
    """The widths of the package against the corners, at every W."""

    def attempt(self, dut: Path, folder: Path) -> Finding:
        """Compare; see `Proof`."""
        folder.mkdir(parents=True, exist_ok=True)
        found = bounds()
        norm = _largest_norm([*_edge_edge(), *normals()])
        edge_norm = _largest_norm(axis.vector for axis in axes()[FIRST_PLANE_AXIS:])
        problems = [
            problem
            for width in range(MIN_WIDTH, MAX_WIDTH + 1)
            for problem in _problems(Package(dut), found, norm, edge_norm, width)
        ]
        log = folder / "bounds.txt"
        lines = [
            f"{bound.quantity}: at most {bound.factor} L^{bound.degree}, {bound.width}" for bound in found
        ]
        lines += [f"sum of absolutes: at most {norm} L^2, edge x coordinate {edge_norm} L", *problems]
        log.write_text("\n".join(lines) + "\n", encoding="utf-8")
        return Finding(tuple(problems), log, {"widths": MAX_WIDTH - MIN_WIDTH + 1, "bounds": len(found) + 2})


def widths() -> Proof:
    """Return the proof."""
    return WidthsProof(
        "widths",
        "The package's widths hold every difference, cross product, axis component, orientation, projection "
        "and sum of absolutes, at every W; no bit is wasted on an operand of a multiplier; thresholds are in "
        "time, at every W and M.",
        "enumeration of all corners of the coordinates",
        {"W": f"{MIN_WIDTH}..{MAX_WIDTH}"},
        (),
    )


# Widths of the operands of multipliers: a bit more may cost another DSP block.
_TIGHT = ("diff_width", "cross_width")


def _late(package: Package, width: int) -> list[str]:
    """Return the margins at which a threshold would come after the points that it is for."""
    axis, difference = package.call("axis_width", width), package.call("diff_width", width)
    areas = package.call("area_latency", width)
    space = package.call("prism_latency", width) + package.call("ProjectionLatency")
    return [
        f"widths: thresholds come late at W = {width}, M = {bits}"
        for bits in range(1, width + 1)
        if package.call("threshold_latency", 3, axis, bits) > space
        or 1 + package.call("threshold_latency", 2, difference, bits) > areas
    ]


def _problems(package: Package, found: list[Bound], norm: int, edge_norm: int, width: int) -> list[str]:
    problems = _late(package, width)
    for bound in found:
        bits = package.call(bound.width, width)
        if bound.largest(width) >= 1 << (bits - 1):
            problems.append(f"widths: {bound.quantity}: {bits} bits are too few at W = {width}")
        elif bound.width in _TIGHT and bound.largest(width) < 1 << (bits - 2):
            problems.append(f"widths: {bound.quantity}: {bits} bits are more than needed at W = {width}")
    # The sum of three coordinates does not stay the same where all vertices move: by its range.
    lowest, bits = 3 << (width - 1), package.call("height_width", width)
    if not 1 << (bits - 2) < lowest <= 1 << (bits - 1):
        problems.append(
            f"widths: sum of three coordinates: {bits} bits are too few, or too many, at W = {width}"
        )
    side = (1 << width) - 1
    for what, largest, name in (
        ("sum of absolutes of an axis", norm * side**2, "axis_width"),
        ("sum of absolutes of edge x coordinate", edge_norm * side, "diff_width"),
    ):
        bits = package.call(name, width)
        if largest >= 1 << bits:
            problems.append(f"widths: {what}: {bits} bits are too few at W = {width}")
    return problems
