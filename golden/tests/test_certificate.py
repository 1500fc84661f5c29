from fractions import Fraction

from triaxis.golden.certificate import axis_proves_clear, witness_proves_near

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
