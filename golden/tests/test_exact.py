"""Ranks are exact, axes those of the definition, and certificates prove what they say and no more."""

from fractions import Fraction
from itertools import permutations
from pathlib import Path

import numpy as np
import pytest

from triaxis.golden import axes, certificate
from triaxis.golden.axes import NUM_AXES, axis_name, axis_vector, separating
from triaxis.golden.certificate import axis_proves_clear, claims_prove_clear, witness_proves_near
from triaxis.golden.errors import InputError
from triaxis.golden.exact import coplanar, rank, triangle_rank
from triaxis.golden.native import native_function
from triaxis.golden.pairs import NO_AXIS, coordinate_range
from triaxis.golden.tests.bulk_pairs import awkward_margins, awkward_pairs

TRIANGLE = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
SEGMENT = [[0, 0, 0], [3, 6, 9], [1, 2, 3]]
POINT = [[5, -5, 5]] * 3


@pytest.mark.parametrize(("triangle", "expected"), [(TRIANGLE, 2), (SEGMENT, 1), (POINT, 0)])
def test_triangle_rank_in_every_order(triangle, expected):
    assert {triangle_rank(order) for order in permutations(triangle)} == {expected}


def test_rank_is_exact_where_floating_point_is_not():
    big = 10**30
    assert rank([[big, 1, 0], [big * 3, 3, 0]]) == 1
    assert rank([[big, 1, 0], [big * 3, 4, 0]]) == 2
    assert rank([[Fraction(1, 3), 0, 0], [0, Fraction(1, 10**20), 0], [0, 0, 1]]) == 3


def test_coplanar():
    assert coplanar(TRIANGLE, [[7, 7, 0], [9, 0, 0], [1, 1, 0]])
    assert not coplanar(TRIANGLE, [[7, 7, 0], [9, 0, 0], [1, 1, 1]])
    assert coplanar(SEGMENT, POINT)
    # Two skew segments are degenerate triangles in no common plane.
    assert not coplanar([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 1], [0, 0, 1], [0, 2, 1]])


@pytest.mark.parametrize("size", [3, 50, 2**18, 2**31 - 1])
def test_arrays_and_single_axes_agree(rng, size):
    pairs = rng.integers(-size, size + 1, (40, 2, 3, 3))
    margins = rng.integers(0, 3, 40)
    expected = [
        [axis_proves_clear(a, b, m, axis_vector(n, a, b)) for n in range(NUM_AXES)]
        for (a, b), m in zip(pairs.tolist(), margins.tolist(), strict=True)
    ]
    assert (separating(pairs, margins) == np.array(expected)).all()


def test_64_bits_suffice_up_to_their_limit(monkeypatch):
    low, high = -(1 << (axes._INT64_WIDTH - 1)), (1 << (axes._INT64_WIDTH - 1)) - 1
    rng = np.random.default_rng(3)
    pairs = np.where(rng.integers(0, 2, (3000, 2, 3, 3)) == 0, low, high)
    margins = np.where(rng.integers(0, 2, 3000) == 0, 0, high - low)
    fast = separating(pairs, margins)
    monkeypatch.setattr(axes, "_INT64_WIDTH", 1)
    assert (separating(pairs, margins) == fast).all()


def test_numbering():
    a = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    b = [[0, 0, 9], [0, 2, 9], [3, 0, 9]]
    assert [axis_vector(n, a, b) for n in range(3)] == [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
    assert axis_vector(3, a, b) == [0, 0, 1]
    assert axis_vector(4, a, b) == [0, 0, -6]
    # Edge 0 of A is (1, 0, 0), edge 1 of B is (3, -2, 0).
    assert axis_vector(5 + 1, a, b) == [0, 0, -2]
    # Edge 0 of A x coordinate y; edge 2 of B, (-3, 0, 0), x coordinate z.
    assert axis_vector(14 + 1, a, b) == [0, 0, 1]
    assert axis_vector(23 + 3 * 2 + 2, a, b) == [0, 3, 0]
    assert len({axis_name(n) for n in range(NUM_AXES)}) == NUM_AXES


A = [[0, 0, 0], [4, 0, 0], [0, 4, 0]]
B = [[0, 0, 3], [4, 0, 3], [0, 4, 5]]
HALF = Fraction(1, 2)


def test_witness():
    assert witness_proves_near(A, B, 3, [1, 0, 0], [1, 0, 0])
    assert witness_proves_near(A, B, 3, [HALF, HALF, 0], [HALF, HALF, 0])
    assert not witness_proves_near(A, B, 2, [1, 0, 0], [1, 0, 0])
    # Weights that are no point of the triangle prove nothing.
    assert not witness_proves_near(A, B, 3, [1, 1, -1], [1, 1, -1])
    assert not witness_proves_near(A, B, 3, [0, 0, 0], [0, 0, 0])
    assert not witness_proves_near(A, B, 3, [HALF, 0, 0], [1, 0, 0])


def test_axis():
    assert axis_proves_clear(A, B, 2, [0, 0, 1])
    assert axis_proves_clear(A, B, 2, [0, 0, -7])
    assert not axis_proves_clear(A, B, 3, [0, 0, 1])
    assert not axis_proves_clear(A, B, 0, [1, 0, 0])
    assert not axis_proves_clear(A, B, 0, [0, 0, 0])


@pytest.mark.parametrize("width", [8, 20, 32])
def test_a_claim_is_proven_exactly_where_its_axis_separates(rng, width):
    pairs = awkward_pairs(rng, 300, width)
    margins = awkward_margins(rng, pairs, width)
    separates = separating(pairs.astype(np.int64), margins.astype(np.int64))
    for axis in range(32):
        proven = claims_prove_clear(pairs, margins, np.full(len(pairs), axis))
        assert (proven == separates[:, axis]).all()
    assert 0 < separates.sum() < separates.size


@pytest.mark.parametrize("width", [8, 20, 21, 32])
def test_claims_at_the_ends_of_the_range(rng, width):
    low, high = coordinate_range(width)
    pairs = rng.choice(np.array([low, high]), (2000, 2, 3, 3))
    margins = rng.choice(np.array([0, high - low - 1, high - low, 2 * high + 1]), len(pairs))
    claims = rng.integers(NO_AXIS, NUM_AXES, len(pairs))
    due = separating(pairs, margins)[np.arange(len(pairs)), claims] & (claims != NO_AXIS)
    assert (claims_prove_clear(pairs, margins, claims) == due).all()
    assert due.any()
    for wrong in (claims + NUM_AXES, claims[1:], np.full(len(pairs), NO_AXIS - 1)):
        with pytest.raises(InputError, match=r"claims: must be axes, -1\.\.31, of shape \(2000,\)"):
            claims_prove_clear(pairs, margins, wrong)


@pytest.mark.regress
@pytest.mark.parametrize(
    "fault",
    [
        ("int64_t{1} << 19", "int64_t{1} << 31"),
        ("std::max(low_b - high_a, low_a - high_b)", "(low_b - high_a)"),
        ("> margin * norm", ">= margin * norm"),
        ("from(t, 1), from(t, 2)}", "from(t, 2), from(t, 2)}"),
        ("i < std::min(start + kBlock, n)", "i < std::min(start + kBlock, n) - 1"),
    ],
    ids=lambda fault: fault[0],
)
def test_a_broken_check_of_claims_is_noticed(rng, tmp_path, monkeypatch, fault):
    source = (Path(certificate.__file__).parent / "certificate.cpp").read_text()
    assert fault[0] in source
    (tmp_path / "certificate.cpp").write_text(source.replace(*fault))
    broken = native_function("certificate", "triaxis_proven", "pppip", tmp_path)
    monkeypatch.setattr(certificate, "_proven", lambda: broken)
    pairs = np.concatenate([awkward_pairs(rng, 3000, width) for width in (8, 20, 32)])
    margins = awkward_margins(rng, pairs, 32)
    due = separating(pairs.astype(np.int64), margins.astype(np.int64))
    found = [claims_prove_clear(pairs, margins, np.full(len(pairs), axis)) for axis in range(NUM_AXES)]
    assert (np.stack(found, 1) != due).any()
