from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from triaxis.bench.error import core_points
from triaxis.bench.error.core_points import COLLISION, MODES, NO_MISS, core_point, core_verdicts, on_grid
from triaxis.bench.error.errors import count_errors
from triaxis.bench.error.truth import Truth, exact_triangle, exact_truth
from triaxis.bench.error.workloads import workloads
from triaxis.golden.judge import judge
from triaxis.golden.pairs import VERDICT

WIDTH = 8


@pytest.fixture(scope="module")
def asked(tmp_path_factory):
    """Return a workload with errors of every kind at 8 bits, on its grid, and the truth."""
    workload = workloads(400, 3, None)[0]
    truth = exact_truth(workload.a, workload.b, folder=tmp_path_factory.mktemp("truth"))
    return workload, on_grid(workload, WIDTH), truth


@pytest.fixture
def no_rtl(monkeypatch):
    monkeypatch.setattr(core_points, "_through_rtl", lambda *_: (0, 1, 1.0))


def test_errors_are_counted_apart():
    truth = Truth((Fraction(0), Fraction(0), Fraction(0), Fraction(1, 2), Fraction(3)))
    errors = count_errors(np.array([True, False, True, True, False]), truth)
    assert (errors.pairs, errors.colliding, errors.missed, errors.false_alarms) == (5, 3, 1, 1)
    assert (errors.missed_share, errors.false_alarm_share) == (1 / 3, 1 / 2)
    with pytest.raises(ValueError, match="4 verdicts on 5 pairs"):
        count_errors(np.ones(4, np.bool_), truth)


def test_verdicts_are_those_of_the_golden_model_on_the_rounded_pairs(asked):
    _, rounded, _ = asked
    for mode, margin in ((COLLISION, 0), (NO_MISS, 1)):
        near = core_verdicts(rounded, mode)
        for (a, b), verdict in zip(rounded.pairs[:100].tolist(), near[:100], strict=True):
            assert judge(a, b, margin).near == verdict


def test_rounding_bounds_distances(asked):
    """The theorem behind both modes, on rationals: rounding changes a distance by at most r."""
    workload, rounded, truth = asked
    resolution = rounded.resolutions[0]
    for (a, b), exact, x in zip(rounded.pairs[:150].tolist(), truth.distances, workload.a, strict=False):
        assert abs(judge(a, b, 0).distance * resolution - exact) <= resolution
        assert exact_triangle(x)


def test_no_miss_mode_keeps_its_word(asked, no_rtl):
    _, rounded, truth = asked
    collision, safe = (core_point(rounded, truth, WIDTH, mode) for mode in MODES)
    assert collision.errors.missed > 0 and collision.errors.false_alarms > 0
    assert 0 < collision.farthest <= 1
    assert safe.errors.missed == 0 and safe.errors.false_alarms > collision.errors.false_alarms
    assert 1 < safe.farthest <= 2
    assert collision.problems == [] == safe.problems


def test_a_margin_too_small_is_noticed(asked, no_rtl):
    _, rounded, truth = asked
    careless = core_point(replace(rounded, margins=(0,)), truth, WIDTH, NO_MISS)
    assert any("missed" in problem for problem in careless.problems)


def test_alarms_beyond_the_band_are_noticed(asked, no_rtl, monkeypatch):
    _, rounded, truth = asked
    monkeypatch.setattr(
        core_points, "core_verdicts", lambda rounded, _: np.ones(len(rounded.pairs), np.bool_)
    )
    point = core_point(rounded, truth, WIDTH, NO_MISS)
    assert point.beyond_band > 0 and any("beyond 2 resolutions" in problem for problem in point.problems)


def test_errors_without_rounding_are_noticed(asked, no_rtl):
    _, rounded, truth = asked
    point = core_point(replace(rounded, unchanged=True), truth, WIDTH, COLLISION)
    assert "wrong verdicts although no coordinate was rounded" in point.problems


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

    monkeypatch.setattr(core_points, "RtlEngine", Wrong)
    _, rounded, truth = asked
    point = core_point(rounded, truth, WIDTH, COLLISION)
    assert any("the RTL differs" in problem for problem in point.problems)
    assert "3 cycles a pair" in point.problems
