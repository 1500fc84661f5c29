"""Euclidean distances: exact, never a miss, fewer false alarms."""

from fractions import Fraction
from math import sqrt

import numpy as np
import pytest

from triaxis.golden.judge import judge
from triaxis.host import least, scenes
from triaxis.host.cli import ERROR, main
from triaxis.host.engines import scene_engine
from triaxis.host.euclidean import EuclideanEngine, euclidean_distance, squared_distance
from triaxis.host.least import least_distance
from triaxis.host.quantise import NOWHERE
from triaxis.host.scene import distance_of, prepare
from triaxis.host.stl import StlMesh


def nearest_by_descent(a, b):
    """Return the distance of two triangles by alternating projections: another way, in floating point."""
    points, rng = [np.array(t, float) for t in (a, b)], np.random.default_rng(1)
    best = np.inf
    for _ in range(2):
        x, y = (rng.dirichlet(np.ones(3)) for _ in "ab")
        for step in range(4000):
            gap = x @ points[0] - y @ points[1]
            # Frank-Wolfe: towards the vertices that decrease the square most.
            i, j = np.argmin(points[0] @ gap), np.argmax(points[1] @ gap)
            way = (points[0][i] - x @ points[0]) - (points[1][j] - y @ points[1])
            size = min(1.0, max(0.0, -(gap @ way) / max(way @ way, 1e-30)))
            x, y = x + size * (np.eye(3)[i] - x), y + size * (np.eye(3)[j] - y)
            if step % 500 == 499:
                best = min(best, float(np.linalg.norm(x @ points[0] - y @ points[1])))
    return best


@pytest.mark.long
def test_distances_are_those_of_other_methods(rng):
    for trial in range(25):
        a, b = (rng.integers(-20, 21, (3, 3)) for _ in "ab")
        if trial % 5 == 0:
            a[2] = a[1]
        if trial % 7 == 0:
            b[1] = b[2] = b[0]
        found = sqrt(squared_distance(a.tolist(), b.tolist()))
        chebyshev = float(judge(a.tolist(), b.tolist(), 0).distance)
        assert chebyshev - 1e-9 <= found <= sqrt(3) * chebyshev + 1e-9
        # From above, and slowly where they meet.
        assert found - 1e-9 <= nearest_by_descent(a, b) <= found + 0.3
        assert squared_distance(b.tolist(), a.tolist()) == squared_distance(a.tolist(), b.tolist())


@pytest.mark.parametrize(
    ("b", "square"),
    [
        ([[0, 0, 7], [9, 9, 7], [0, 9, 7]], 49),
        ([[1, 1, -3], [1, 1, 3], [2, 1, 3]], 0),
        ([[1, 1, 5]] * 3, 25),
        ([[12, -1, 2], [12, -1, 2], [20, -9, 3]], 4 + 1 + 4),
        ([[10, 10, 0], [11, 11, 0], [12, 10, 0]], 50),
        ([[2, 2, 0], [3, 2, 0], [2, 3, 0]], 0),
    ],
)
def test_known_distances(b, square):
    assert squared_distance([[0, 0, 0], [10, 0, 0], [0, 10, 0]], b) == square


@pytest.mark.long
def test_the_least_distance_is_that_of_all_pairs(rng):
    for _ in range(12):
        a, b = (rng.uniform(-20, 20, (9, 1, 3)) + rng.uniform(-3, 3, (9, 3, 3)) for _ in "ab")
        one, two = (StlMesh(mesh.astype(np.float32).astype(np.float64), Fraction(0)) for mesh in (a, b))
        meshes = prepare(one, two, ("a", "b"), Fraction(1, 100), Fraction(0), None)
        for euclidean, of in ((False, distance_of), (True, euclidean_distance)):
            found = least_distance(meshes, euclidean)
            distances = [float(of(one, i, two, j, NOWHERE)) for i in range(9) for j in range(9)]
            assert (found.distance, found.exact) == (min(distances), True)
            assert distances[9 * found.a + found.b] == min(distances)


def test_the_nearest_by_euclid_is_found_among_many_that_are_as_near_by_chebyshev(monkeypatch):
    corner, size = np.array([[0, 0, 0], [-1, 0, 0], [0, -1, 0]]), 1 + np.arange(300)[:, None, None] / 300
    many = corner * size, 1 - corner * size
    one = np.add(corner, [50, 0, 0]), np.subtract([51.001, 0, 0], corner * [1, -1, -1])
    files = [np.concatenate([some, last[None]]) for some, last in zip(many, one, strict=True)]
    a, b = (StlMesh(mesh.astype(np.float32).astype(np.float64), Fraction(0)) for mesh in files)
    meshes = prepare(a, b, ("a", "b"), Fraction(1, 1000), Fraction(0), None)
    found = least_distance(meshes, True)
    assert (found.a, found.b) == (300, 300) and found.distance == pytest.approx(1.001, abs=1e-5)
    assert least_distance(meshes, False).distance == 1
    assert found.exact
    # Where more are listed than are looked at, what was found may not be the least.
    monkeypatch.setattr(least, "_LISTED", 100)
    assert not least_distance(meshes, True).exact


def test_check_decides_by_the_coordinates_of_the_files(tmp_path, capsys):
    files = [tmp_path / "a.stl", tmp_path / "b.stl"]
    for file, low in zip(files, (-1, 0), strict=True):
        scenes.write_stl(file, scenes.box((low, low, low), (low + 1, low + 1, low + 1)))

    def check(gap, *options):
        words = ["check", *map(str, files), "--move", f"-{gap}", "0", "0", "--clearance", "0.5", *options]
        status = main([*words, "--engine", "bulk", "--distance", "euclidean"])
        return status, capsys.readouterr().out

    for gap, status, said in (("0.5", 1, "NEAR: "), ("0.50001", 0, "CLEAR"), ("0.501", 0, "CLEAR")):
        found, out = check(gap)
        assert found == status and said in out, out
    # What is turned is rounded, and what is rounded is near within the band.
    assert check("0.501", "--rotate", "z", "45", "--rotate", "z", "-45")[0] == 1


@pytest.mark.parametrize(
    ("high", "wall", "more", "expected", "said"),
    [
        # Inside, and on a grid of 0.001 in touch: a finer one tells.
        (9.9996, 10, (), 1, "inside"),
        (9.9996, 10, ("--move", "0.0008", "9", "0"), 0, "CLEAR"),
        (9.9996, 10, ("--surfaces-only",), 0, "surfaces only"),
        (10.1, 10.4, ("--resolution", "1", "--clearance", "0.2"), 1, "inside"),
        # No grid holds what is that large, and tells so close from touching.
        (9.99999905, 10, (), ERROR, "on no grid of 32 bits"),
    ],
)
def test_insides_are_asked_where_facets_do_not_touch(tmp_path, capsys, high, wall, more, expected, said):
    files = [tmp_path / "a.stl", tmp_path / "b.stl"]
    corners = high - 0.4 + 0.4 * np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) - [0, 5, 5]
    # The vertex that touches comes first.
    scenes.write_stl(files[0], corners[[[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]])
    outer = scenes.box((0, 0, 0), (wall, wall, wall))
    scenes.write_stl(files[1], np.concatenate([outer, *([outer + 3e6] if expected == ERROR else [])]))
    words = [
        "check",
        *map(str, files),
        "--distance",
        "euclidean",
        "--engine",
        "bulk",
        *(() if "--clearance" in more else ("--clearance", "0")),
        *more,
    ]
    status, told = main(words), capsys.readouterr()
    assert status == expected and said in told.out + told.err, told


def test_what_only_corners_bring_near_is_cleared_and_nothing_else(rng):
    a, b = (rng.integers(-300, 300, (60, 1, 3)) + rng.integers(-9, 10, (60, 3, 3)) for _ in "ab")
    engine = scene_engine("bulk", a, b, 16)
    cleared = 0
    for margin in (20, 40, 60):
        clearance = Fraction(margin - 2)
        both = EuclideanEngine(engine, a, b, clearance)
        near = {tuple(pair) for pair in both.run((3, -4, 5), margin).near.tolist()}
        moved = a + np.array([3, -4, 5])
        for i, j in engine.run((3, -4, 5), margin).near.tolist():
            distance = sqrt(squared_distance(moved[i].tolist(), b[j].tolist()))
            if distance <= clearance:
                assert (i, j) in near
            if (i, j) not in near:
                cleared += 1
                assert distance > clearance + sqrt(3) * 2
        first = both.run((3, -4, 5), margin, stop_at_first=True)
        assert (first.near_count > 0) == (len(near) > 0)
    assert cleared > 5
