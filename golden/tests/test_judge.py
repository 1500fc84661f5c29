from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from triaxis.golden.axes import first_separating
from triaxis.golden.game_solver import GameSolver
from triaxis.golden.judge import CertificateError, judge, judge_in_parallel, judge_pairs
from triaxis.golden.pairs import NO_AXIS

FLAT = [[0, 0, 0], [10, 0, 0], [0, 10, 0]]


def lifted(triangle, height):
    return [[x, y, z + height] for x, y, z in triangle]


@pytest.mark.parametrize("height", [0, 1, 7, Fraction(1, 3), Fraction(-22, 7), 2**70])
def test_distance_of_parallel_triangles(height):
    for margin in (abs(height), abs(height) + 1):
        verdict = judge(FLAT, lifted(FLAT, height), margin)
        assert verdict.near and verdict.distance == abs(height)
    if height:
        assert not judge(FLAT, lifted(FLAT, height), abs(height) - Fraction(1, 10**9)).near


def test_distance_inside_a_face_is_chebyshev():
    # The plane x + y + z = 12 and the origin: a cube of half side 4 just reaches it.
    plane = [[12, 0, 0], [0, 12, 0], [0, 0, 12]]
    assert judge(plane, [[0, 0, 0]] * 3, 0).distance == 4


def test_float32_coordinates_are_judged_exactly():
    third = [[Fraction(float(np.float32(x))) for x in v] for v in [[0.1, 0, 0], [0.1, 1, 0], [0.1, 0, 1]]]
    point = [[Fraction(1, 10), Fraction(1, 4), Fraction(1, 4)]] * 3
    distance = judge(third, point, 0).distance
    assert distance == abs(Fraction(float(np.float32(0.1))) - Fraction(1, 10)) > 0


def test_any_axis_and_program_agree(rng):
    for size in (1, 2, 5, 1000, 2**31):
        pairs = rng.integers(-size, size + 1, (150, 2, 3, 3))
        margins = rng.integers(0, max(2, size // 2), 150)
        verdicts = judge_pairs(pairs, margins)
        assert ((verdicts["axis"] == NO_AXIS) == verdicts["near"]).all()
        assert (verdicts["axis"] == first_separating(pairs, margins)).all()


def test_parallel_gives_the_same(rng, monkeypatch):
    monkeypatch.setattr("triaxis.golden.judge._CHUNK", 20)
    pairs, margins = rng.integers(-9, 10, (50, 2, 3, 3)), rng.integers(0, 4, 50)
    assert (judge_in_parallel(pairs, margins) == judge_pairs(pairs, margins)).all()
    assert len(judge_in_parallel(pairs[:0], margins[:0])) == 0


LIES = {
    "distance": lambda best: {"distance": best.distance + 1},
    "axis": lambda best: {"axis": (best.axis[1], best.axis[2], best.axis[0])},
    # Of clear pairs a nearer distance, and an axis that shows as much: of both, half.
    "half": lambda best: {"distance": best.distance / 2, "axis": tuple(x / 2 for x in best.axis)},
    "weights": lambda nearest: {"weights_a": (Fraction(2), Fraction(-1), Fraction(0))},
    "optimum": lambda nearest: {"distance": nearest.distance + Fraction(1, 7)},
}


class LyingSolver(GameSolver):
    """Wrong in one respect."""

    def __init__(self, lie):
        super().__init__()
        self.lie = lie

    def best_axis(self, a, b):
        best = super().best_axis(a, b)
        return replace(best, **LIES[self.lie](best)) if self.lie in ("distance", "axis", "half") else best

    def nearest_points(self, a, b):
        nearest = super().nearest_points(a, b)
        return replace(nearest, **LIES[self.lie](nearest)) if self.lie in ("weights", "optimum") else nearest


@pytest.mark.parametrize(
    ("lie", "height", "margin"),
    [
        ("distance", 3, 3),
        ("axis", 5, 1),
        ("half", 5, 1),
        ("weights", 3, 3),
        ("weights", 3, 1),
        ("optimum", 3, 5),
    ],
)
def test_a_lying_solver_is_caught(lie, height, margin):
    judge(FLAT, lifted(FLAT, height), margin, LyingSolver("none"))
    with pytest.raises(CertificateError):
        judge(FLAT, lifted(FLAT, height), margin, LyingSolver(lie))


def test_what_a_second_check_does_not_confirm_is_no_answer(monkeypatch):
    monkeypatch.setattr("triaxis.golden.judge.axis_proves_clear", lambda *_: False)
    with pytest.raises(CertificateError, match=r"does not separate .* by 1$"):
        judge(FLAT, lifted(FLAT, 5), 1)
    monkeypatch.setattr("triaxis.golden.judge.first_separating", lambda pairs, _: np.zeros(len(pairs)))
    with pytest.raises(CertificateError, match="the 32 axes and the linear program disagree on"):
        judge_pairs(np.array([[FLAT, FLAT]]), np.zeros(1, np.int64))


def test_fixed_numbers_of_bits_do_not_run_over():
    a = [[Fraction(1, 8) if k == n else Fraction(0) for k in range(3)] for n in range(3)]
    b = [list(np.array([1 << 30, k, n], np.int32)) for k, n in ((0, 0), (1, 0), (0, 1))]
    assert judge(a, b, 0).distance == (1 << 30) - Fraction(1, 8)
