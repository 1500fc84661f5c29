"""What cannot happen in a core, and why: the exclusions of its coverage model.

Everything here is proved, so every exclusion is illegal: a hit means that the core answered wrongly,
that the golden model erred, or that a proof is wrong. Proofs speak of the Minkowski difference D of A, B
and the cube of the margin: an axis separates when a plane normal to it has D strictly on one side of the
origin, and D not holding the origin is separated by the normal of one of its facets. Facets are normal
to axes 3..13 where D is full-dimensional without the cube; axes made of edge x k (k = x, y, z) act in the
plane with normal N as N_k times the perpendicular of the edge.

Proofs do not expire: each run tries them again, and the test that an exclusion names does so on all
pairs of a tiny grid.
"""

from collections.abc import Callable

from triaxis.coverage.core_sample import Decision, Relation
from triaxis.coverage.cover_model import Exclusion, Kind
from triaxis.sim.configuration import Configuration

# Kinds of argument; every exclusion is of one of these.
GEOMETRY, BUILD, CONTRACT = "geometry", "build", "contract"
ARGUMENTS = {
    GEOMETRY: "no two triangles lie so",
    BUILD: "the parameters of the build leave it out",
    CONTRACT: "the core must not answer so",
}
OWNER = "verif"

POINT, SEGMENT, TRIANGLE = range(3)
FACE = 2
ALL_VERTICES = 6
_TEST = "coverage/tests/test_core_exclusions.py"
_GRID = f"{_TEST}::test_no_excluded_bin_is_hit"
_ANSWERS = "coverage/tests/test_core_coverage.py::test_wrong_answers_hit_illegal_bins"


def _never(reason: str, when: Callable[..., bool], test: str = _GRID, category: str = GEOMETRY) -> Exclusion:
    return Exclusion(Kind.ILLEGAL, reason, test, when, category, OWNER)


def _edge_of_a(axis: int) -> bool:
    return 5 <= axis < 23


def _edge_of_b(axis: int) -> bool:
    return 5 <= axis < 14 or axis >= 23


def sole_axis(build: Configuration) -> tuple[Exclusion, ...]:
    """Return the proofs for axis x side x rank A x rank B (x margin sign)."""
    proofs = [
        _never(
            "the normal of a segment or point is zero, and a zero axis separates nothing",
            lambda axis, side, a, b, m=0: (axis == 3 and a < TRIANGLE) or (axis == 4 and b < TRIANGLE),
        ),
        _never(
            "the edges of a point are zero, so the axis is",
            lambda axis, side, a, b, m=0: (
                (_edge_of_a(axis) and a == POINT) or (_edge_of_b(axis) and b == POINT)
            ),
        ),
        _never(
            "the edges of a segment sum to 0, so two or three are not zero, and parallel: their axes "
            "separate together, never one alone",
            lambda axis, side, a, b, m=0: (
                (_edge_of_a(axis) and a == SEGMENT) or (_edge_of_b(axis) and b == SEGMENT)
            ),
        ),
    ]
    if build.edge_box:
        proofs.append(
            _never(
                "with margin 0 and a triangle: D is full-dimensional and has facets normal to axes 3..13; or "
                "it lies in a plane beside the origin, whose normal is the triangle's; or in one through the "
                "origin, where edge x k is normal to its sides",
                lambda axis, side, a, b, m=0: axis < 3 and m == 0 and TRIANGLE in (a, b),
            )
        )
    return tuple(proofs)


# Of relation x rank A x rank B (x margin sign).
RELATION_PROOFS: tuple[Exclusion, ...] = (
    _never(
        "a part has no higher rank than the whole, and a point in a point is identical with it",
        lambda r, a, b, m=0: (
            (r == Relation.A_IN_B and (a > b or a == b == POINT))
            or (r == Relation.B_IN_A and (b > a or a == b == POINT))
            or (r == Relation.IDENTICAL and a != b)
        ),
    ),
    _never(
        "a point and a segment have three vertices at most that differ: always coplanar",
        lambda r, a, b, m=0: r == Relation.PENETRATING and a + b <= SEGMENT,
    ),
    _never(
        "with margin 0 two segments, or a point and a triangle, that meet lie in one plane",
        lambda r, a, b, m=0: r == Relation.PENETRATING and m == 0 and a + b == 2,
    ),
    _never(
        "with margin 0 a point that is near is a part of the other",
        lambda r, a, b, m=0: r == Relation.COPLANAR and m == 0 and POINT in (a, b),
    ),
    _never(
        "with margin 0 two points that are near are the same, so flat on every axis",
        lambda r, a, b, m=0: r == Relation.TOUCHING and m == 0 and a == b == POINT,
    ),
)


def _faces(margin: int, a: int, b: int, face: int) -> bool:
    return margin == 0 and a == b == face


_TWO_FACES = (
    "a level axis is not flat; where all vertices of A and all of B are outermost, A and B each fall "
    "together on it, and with margin 0 in the same place, so it is flat"
)


# Of touching vertices of A x of B (x margin sign).
CONTACT_PROOFS: tuple[Exclusion, ...] = (_never(_TWO_FACES, lambda a, b, m=0: _faces(m, a, b, ALL_VERTICES)),)


# Of feature of A x feature of B x coplanar (x margin sign).
CONTACT_FEATURES_PROOFS: tuple[Exclusion, ...] = (
    _never(_TWO_FACES, lambda a, b, coplanar, m=0: _faces(m, a, b, FACE)),
    _never(
        "a face is outermost only along its normal, which is flat for a coplanar pair, and flat is not level",
        lambda a, b, coplanar, m=0: bool(coplanar) and FACE in (a, b),
    ),
)


_POINTS = "the edges and normals of two points are zero: only box axes separate them"
_COPLANAR_BLIND = (
    "axes 3..13 of a coplanar pair are zero or normal to the plane, where nothing is apart, and the core has "
    "no edge x box axes"
)


def decision(build: Configuration) -> tuple[Exclusion, ...]:
    """Return the proofs for decision x coplanar x rank A x rank B (x margin sign)."""
    proofs = [
        _never(
            "a point and a segment have three vertices at most that differ: always coplanar",
            lambda d, coplanar, a, b, m=0: not coplanar and a + b <= SEGMENT,
        ),
        _never(_POINTS, lambda d, coplanar, a, b, m=0: d == Decision.OTHER and a == b == POINT),
        _never(
            "with margin 0 two segments, or a point and a triangle, that meet lie in one plane",
            lambda d, coplanar, a, b, m=0: d == Decision.NEAR and not coplanar and m == 0 and a + b == 2,
        ),
    ]
    if not build.edge_box:
        proofs.append(
            _never(
                _COPLANAR_BLIND,
                lambda d, coplanar, a, b, m=0: d == Decision.OTHER and bool(coplanar),
                category=BUILD,
            )
        )
    return tuple(proofs)


def flags(build: Configuration) -> tuple[Exclusion, ...]:
    """Return the proofs for decision x flags answered."""
    proofs: list[Exclusion] = []
    if build.gating:
        proofs.append(
            _never(
                "operand gating: the flags of a pair that its boxes decide read 0",
                lambda d, flags: d == Decision.BOX and flags != 0,
                _ANSWERS,
                CONTRACT,
            )
        )
    if not build.margin_bits:
        proofs.append(
            _never(
                "two segments or points that meet lie in one plane",
                lambda d, flags: d == Decision.NEAR and flags == 0b110,
            )
        )
    if not build.edge_box:
        proofs.append(
            _never(
                _COPLANAR_BLIND,
                lambda d, flags: d == Decision.OTHER and bool(flags & 1),
                category=BUILD,
            ),
        )
    return tuple(proofs)


def largest_margin(build: Configuration) -> tuple[Exclusion, ...]:
    """Return the proofs for whether the margin is the largest x decision."""
    if build.margin_bits < build.width:
        return ()
    return (
        _never(
            "no two points in range are further apart than 2^W - 1, so at that margin every pair is near",
            lambda largest, decision: bool(largest) and decision != Decision.NEAR,
        ),
    )


# Of what the core must not answer.
ANSWER_PROOFS: tuple[Exclusion, ...] = (
    _never(
        "the core must answer as the golden model does: verdict, lowest axis, spare bits 0",
        lambda answer: answer not in (2, 3),
        _ANSWERS,
        CONTRACT,
    ),
)


# Of axes that the core lacks x coplanar.
BLIND_PROOFS: tuple[Exclusion, ...] = (
    _never(
        "with margin 0 a pair that is not coplanar and clear is separated by one of axes 0..13",
        lambda blind, coplanar: bool(blind) and not coplanar,
    ),
)
