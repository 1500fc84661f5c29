"""Run time against error: the truth is exact, the workloads are what they say, the core keeps its band."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from triaxis.bench.error import points
from triaxis.bench.error.points import COLLISION, MODES, NO_MISS, core_point, core_verdicts, on_grid
from triaxis.bench.error.truth import check_triangles, exact_triangle, exact_truth
from triaxis.bench.error.workloads import LATTICE_BITS, part_grid, proper, workloads
from triaxis.golden.bulk import bulk_verdicts
from triaxis.golden.errors import InputError
from triaxis.golden.exact import triangle_rank
from triaxis.golden.judge import judge
from triaxis.golden.pairs import VERDICT
from triaxis.host.quantise import box_of, fits, grid_around

COUNT, WIDTH = 240, 8


@pytest.fixture(scope="module")
def made():
    return {workload.name: workload for workload in workloads(COUNT, 5, None)}


@pytest.fixture(scope="module")
def asked(tmp_path_factory):
    """Return a workload with errors of every kind at 8 bits, on its grid, and the truth."""
    workload = workloads(400, 3, None)[0]
    truth = exact_truth(workload.a, workload.b, folder=tmp_path_factory.mktemp("truth"))
    return workload, on_grid(workload, WIDTH), truth


@pytest.fixture
def no_rtl(monkeypatch):
    monkeypatch.setattr(points, "_through_rtl", lambda *_: (0, 1, 1.0))


def test_distances_are_those_of_the_integers(rng, tmp_path):
    """On small integers, which float32 holds, the bulk checker has the same near pairs at every margin."""
    pairs = rng.integers(-6, 7, (1200, 2, 3, 3))
    a, b = (pairs[:, k].astype(np.float32) for k in (0, 1))
    told = []
    truth = exact_truth(a, b, told.append, tmp_path)
    assert sum(told) == len(truth) == 1200
    for margin in range(4):
        assert np.array_equal(truth.near(margin), bulk_verdicts(pairs, margin)["near"])
    assert 0 < truth.near().sum() < 1200


def test_no_bit_of_a_float_is_lost(tmp_path):
    """Two points one unit in the last place apart, and the same at denormal size."""
    a = np.ones((2, 3, 3), np.float32)
    b = a.copy()
    b[0, :, 1] = np.nextafter(np.float32(1), np.float32(2))
    a[1] = b[1] = 0
    b[1, :, 2] = np.float32(1e-45)
    assert exact_truth(a, b, folder=tmp_path).distances == (Fraction(1, 2**23), Fraction(1, 2**149))


def test_answers_are_kept_and_a_damaged_file_is_not_believed(rng, tmp_path, monkeypatch):
    a, b = rng.uniform(-1, 1, (2, 5, 3, 3)).astype(np.float32)
    first = exact_truth(a, b, folder=tmp_path)
    (path,) = tmp_path.glob("*.json")
    with monkeypatch.context() as patch:
        patch.setattr("triaxis.bench.error.truth._solve", lambda _: pytest.fail("solved again"))
        assert exact_truth(a, b, folder=tmp_path) == first
    for damage in ("", "[]", '["1/0", "1", "1", "1", "1"]', "3"):
        path.write_text(damage)
        assert exact_truth(a, b, folder=tmp_path) == first


def test_bad_triangles_are_refused(tmp_path):
    good = np.zeros((2, 3, 3), np.float32)
    bad = good.copy()
    bad[1, 2, 0] = np.inf
    with pytest.raises(InputError, match="triangles B: pair 1, vertex 2, coordinate x: not finite"):
        exact_truth(good, bad, folder=tmp_path)
    with pytest.raises(InputError, match="float64"):
        check_triangles(good.astype(np.float64), good)
    with pytest.raises(InputError, match="shape"):
        exact_truth(good, good[:1], folder=tmp_path)


def test_workloads_follow_from_the_seed_and_no_triangle_is_degenerate(made):
    assert list(made) == ["random", "made solids", "near-contact made solids", "lattice near-misses"]
    for again, other in zip(workloads(COUNT, 5, None), workloads(COUNT, 6, None), strict=True):
        first = made[again.name]
        assert len(first) == COUNT == len(first.a)
        assert np.array_equal(first.a, again.a) and np.array_equal(first.b, again.b)
        assert not np.array_equal(first.b, other.b)
        assert first.a.dtype == first.b.dtype == np.float32
        assert all(triangle_rank(exact_triangle(t)) == 2 for t in np.concatenate([first.a, first.b]))


def test_degenerate_triangles_are_found_exactly(rng):
    """Segments of any direction, in float32 where that holds them, and triangles off them by one bit."""
    start, step = rng.integers(-(2**10), 2**10, (2, 300, 1, 3))
    assert not proper((start + step * rng.integers(-50, 51, (300, 3, 1))).astype(np.float32)).any()
    # Thin, far from the origin, and hardly wider than the last place of its coordinates.
    edge = np.nextafter(np.float32(4098), 0)
    assert proper(np.array([[[4096, 4096, 0], [4097, 4097, 0], [4098, edge, 0]]], np.float32)).all()


def test_contacts_are_close_and_on_both_sides(made, tmp_path):
    contacts = made["near-contact made solids"]
    truth = exact_truth(contacts.a, contacts.b, folder=tmp_path)
    assert max(truth.distances) < Fraction(2, 100)
    assert 0.3 < truth.near().mean() < 0.9
    assert sum(0 < distance < Fraction(1, 10**4) for distance in truth.distances) > COUNT / 20


def test_lattice_is_held_exactly(made):
    lattice = made["lattice near-misses"]
    assert on_grid(lattice, LATTICE_BITS).unchanged
    assert not on_grid(lattice, LATTICE_BITS - 4).unchanged


@pytest.mark.parametrize("width", [8, 16, 32])
def test_the_finest_grid_holds_its_boxes_and_none_finer_does(made, width):
    for part in made["random"].parts:
        boxes = [box_of(part.a), box_of(part.b)]
        grid = part_grid(part.a, part.b, width)
        assert fits(boxes, grid) and grid.resolution.numerator & (grid.resolution.numerator - 1) == 0
        assert not fits(boxes, grid_around(boxes, grid.resolution / 2, width))


def test_verdicts_are_those_of_the_golden_model_and_rounding_bounds_distances(asked):
    """The theorem behind both modes, on rationals: rounding changes a distance by at most r."""
    _, rounded, truth = asked
    resolution = rounded.resolutions[0]
    for mode, margin in ((COLLISION, 0), (NO_MISS, 1)):
        near = core_verdicts(rounded, mode)[:100]
        for (a, b), exact, verdict in zip(rounded.pairs[:100].tolist(), truth.distances, near, strict=False):
            judged = judge(a, b, margin)
            assert judged.near == verdict and abs(judged.distance * resolution - exact) <= resolution


def test_no_miss_mode_keeps_its_word(asked, no_rtl):
    _, rounded, truth = asked
    collision, safe = (core_point(rounded, truth, WIDTH, mode) for mode in MODES)
    assert collision.errors.missed > 0 and collision.errors.false_alarms > 0
    assert 0 < collision.farthest <= 1
    assert safe.errors.missed == 0 and safe.errors.false_alarms > collision.errors.false_alarms
    assert 1 < safe.farthest <= 2
    assert collision.problems == [] == safe.problems


def test_what_must_not_be_is_noticed(asked, no_rtl, monkeypatch):
    _, rounded, truth = asked
    careless = core_point(replace(rounded, margins=(0,)), truth, WIDTH, NO_MISS)
    assert any("missed" in problem for problem in careless.problems)
    unchanged = core_point(replace(rounded, unchanged=True), truth, WIDTH, COLLISION)
    assert "wrong verdicts although no coordinate was rounded" in unchanged.problems
    monkeypatch.setattr(points, "core_verdicts", lambda rounded, _: np.ones(len(rounded.pairs), np.bool_))
    point = core_point(rounded, truth, WIDTH, NO_MISS)
    assert point.beyond_band > 0 and any("beyond 2 resolutions" in problem for problem in point.problems)


@pytest.mark.simulator
def test_a_sample_runs_through_the_rtl(asked):
    _, rounded, truth = asked
    point = core_point(rounded, truth, WIDTH, COLLISION)
    assert (point.sampled, point.rtl_differs, point.cycles_per_pair) == (400, 0, 1)


def test_another_verdict_of_the_rtl_is_noticed(asked, monkeypatch):
    class Wrong:
        def __init__(self, *_):
            pass

        def verdicts(self, pairs, _):
            return np.zeros(len(pairs), VERDICT)

        def words(self, pairs, _):
            return None, 3 * len(pairs) + 20

    monkeypatch.setattr(points, "RtlEngine", Wrong)
    _, rounded, truth = asked
    problems = core_point(rounded, truth, WIDTH, COLLISION).problems
    assert any("the RTL differs" in problem for problem in problems) and "3 cycles a pair" in problems
