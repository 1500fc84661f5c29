"""The solver of our own: against PPL where that is installed, and where games degenerate."""

from fractions import Fraction
from itertools import product

import numpy as np
import pytest

from triaxis.golden import game_solver
from triaxis.golden.bulk import bulk_facts
from triaxis.golden.game_solver import GameSolver
from triaxis.golden.judge import judge

SIZES = (1, 2, 5, 1000, 2**15, 2**31, 2**53, 2**200)


def random_pairs(rng, size, count):
    """Return pairs of random triangles, a third of them flattened on one coordinate or drawn to a segment."""
    whole = [[int(x) * size // 1000 for x in row] for row in rng.integers(-1000, 1001, (count, 18))]
    pairs = [(_triangle(row[:9]), _triangle(row[9:])) for row in whole]
    for number, (a, b) in enumerate(pairs):
        if number % 6 == 0:
            pairs[number] = [[x, y, 0] for x, y, _ in a], [[x, y, 0] for x, y, _ in b]
        elif number % 6 == 1:
            pairs[number] = [a[0], a[0], a[2]], b
    return pairs


def _triangle(numbers):
    return [numbers[0:3], numbers[3:6], numbers[6:9]]


@pytest.mark.parametrize("size", SIZES)
def test_it_finds_what_ppl_finds(rng, size):
    ppl = pytest.importorskip(
        "triaxis.golden.ppl_solver", reason="pplpy is not installed: nothing to compare"
    )
    ours, theirs = GameSolver(), ppl.PplSolver()
    for a, b in random_pairs(rng, size, 200):
        # Each proves itself, whichever of many best points and axes it is.
        distance = judge(a, b, 0, theirs).distance
        for margin in (0, distance, distance + 1):
            verdict = judge(a, b, margin, ours)
            assert verdict.distance == distance and verdict.near == (distance <= margin)


def test_every_pair_of_a_tiny_grid_agrees_with_the_axes():
    # All corners of a square and the cube's first edge: most of these are degenerate, and meet.
    points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 1)]
    triangles = list(product(points, repeat=3))
    pairs = np.array([(a, b) for a in triangles[::3] for b in triangles], np.int64)
    for margin in (0, 1):
        near = bulk_facts(pairs, np.full(len(pairs), margin)).separating == 0
        solver = GameSolver()
        assert [judge(a, b, margin, solver).near for a, b in pairs.tolist()] == near.tolist()


def test_fractions_are_taken_as_they_are():
    a = [[0, 0, 0], [Fraction(1, 3), 0, 0], [0, Fraction(1, 7), 0]]
    b = [[0, 0, Fraction(5, 11)], [1, 0, Fraction(5, 11)], [0, 1, Fraction(5, 11)]]
    assert judge(a, b, 0).distance == Fraction(5, 11)


def test_it_ends_by_blands_rule_alone(rng, monkeypatch):
    quick = GameSolver()
    pairs = random_pairs(rng, 1, 60) + random_pairs(rng, 1000, 60)
    found = [quick.best_axis(a, b).distance for a, b in pairs]
    monkeypatch.setattr(game_solver, "_STEEPEST", 0)
    slow = GameSolver()
    assert [judge(a, b, 0, slow).distance for a, b in pairs] == found


def test_a_triangle_that_is_changed_in_place_is_another():
    a, b = [[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 0, 5], [1, 0, 5], [0, 1, 5]]
    solver = GameSolver()
    assert solver.best_axis(a, b).distance == 5
    for vertex in b:
        vertex[2] = 9
    assert solver.nearest_points(a, b).distance == 9
