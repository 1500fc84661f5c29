"""Run time against error: the truth is exact, the core keeps its band, what is wrong is seen."""

import json
from dataclasses import replace
from fractions import Fraction
from types import SimpleNamespace

import numpy as np
import pytest

from triaxis.bench import harness
from triaxis.bench.error import points, report
from triaxis.bench.error.points import (
    COLLISION,
    MODES,
    NO_MISS,
    WIDTHS,
    BulkPoint,
    CorePoint,
    Errors,
    PeerPoint,
    core_point,
    on_grid,
)
from triaxis.bench.error.report import demands, findings
from triaxis.bench.error.running import Measured, WorkloadResult
from triaxis.bench.error.truth import exact_truth
from triaxis.bench.error.workloads import workloads
from triaxis.golden.bulk import bulk_verdicts
from triaxis.host.cli import main

WIDTH = 8


@pytest.fixture(scope="module")
def asked():
    """Return a workload with errors of every kind at 8 bits on its grid, and the truth."""
    workload = workloads(400, 3, None)[0]
    truth = exact_truth(workload.a, workload.b)
    return on_grid(workload, WIDTH), truth


def test_distances_are_exact(rng):
    """On small integers, which float32 holds, the bulk checker has the same near pairs at every margin."""
    pairs = rng.integers(-6, 7, (300, 2, 3, 3))
    a, b = (pairs[:, k].astype(np.float32) for k in (0, 1))
    truth = exact_truth(a, b)
    assert 0 < truth.near().sum() < 300
    for margin in range(4):
        assert np.array_equal(truth.near(margin), bulk_verdicts(pairs, margin)["near"])
    # No bit of a float is lost: one unit in the last place, and the same at denormal size.
    a, b = np.ones((2, 2, 3, 3), np.float32)
    b[0, :, 1] = np.nextafter(np.float32(1), np.float32(2))
    a[1] = b[1] = 0
    b[1, :, 2] = np.float32(1e-45)
    assert exact_truth(a, b).distances == (Fraction(1, 2**23), Fraction(1, 2**149))


def test_no_miss_mode_keeps_its_word_and_a_broken_one_is_noticed(asked, monkeypatch):
    monkeypatch.setattr(points, "_through_rtl", lambda *_: (0, 1, 1.0))
    rounded, truth = asked
    collision, safe = (core_point(rounded, truth, WIDTH, mode) for mode in MODES)
    assert collision.errors.missed > 0 and collision.errors.false_alarms > 0
    assert 0 < collision.farthest <= 1 < safe.farthest <= 2
    assert safe.errors.missed == 0 and safe.errors.false_alarms > collision.errors.false_alarms
    assert collision.beyond_band == 0 == safe.beyond_band
    assert core_point(replace(rounded, margins=(0,)), truth, WIDTH, NO_MISS).errors.missed > 0
    monkeypatch.setattr(points, "bulk_verdicts", lambda pairs, _: {"near": np.ones(len(pairs), np.bool_)})
    assert core_point(rounded, truth, WIDTH, NO_MISS).beyond_band > 0


@pytest.mark.regress
@pytest.mark.simulator
def test_a_sample_runs_through_the_rtl(asked):
    rounded, truth = asked
    point = core_point(rounded, truth, WIDTH, COLLISION)
    assert (point.sampled, point.rtl_differs, point.cycles_per_pair) == (400, 0, 1)


def core(width, mode, errors, **changes):
    point = CorePoint(width, mode, errors, int(mode == NO_MISS), 0, 0.5, 100, 0, 1.0, False)
    return replace(point, **changes)


def peer(name="CGAL, C++", distribution="libcgal-dev", run=130.0, call=10.0, bulk=40.0):
    return PeerPoint(name, distribution, "1", "call", Errors(100, 40, 4, 0), run, call, bulk, 2.0)


@pytest.fixture(scope="module")
def measured():
    """Return what a run could have found, everything in order."""
    workload = workloads(12, 1, None)[0]
    shares = {COLLISION: Errors(100, 40, 3, 2), NO_MISS: Errors(100, 40, 0, 9)}
    core_points = [core(width, mode, shares[mode]) for width in WIDTHS for mode in MODES]
    core_points[-2] = core(WIDTHS[-1], COLLISION, Errors(100, 40, 0, 0), unchanged=True)
    bulk = [BulkPoint(width, mode, 40.0, 60, 0, 0) for width in WIDTHS for mode in MODES]
    result = WorkloadResult(workload, 40, core_points, bulk, 2e5, [peer(), peer("VTK", "vtk")])
    dsps = {(width, mode): 100 for width in WIDTHS for mode in MODES}
    return Measured(1, False, dsps, [result], {"coal": "coal: not installed"}, 0)


def changed(measured, **changes):
    return replace(measured, results=[replace(measured.results[0], **changes)])


def test_demands(measured):
    found = demands(measured)
    assert [demand.verdict for demand in found] == ["reached"] * len(found) and "3.0 times" in found[-1].found
    # What is absent is not called reached.
    absent = changed(measured, peers=[peer("VTK", "vtk")])
    assert demands(absent)[-1].verdict == "NOT MEASURED" and findings(absent).problems == []
    result = measured.results[0]
    # The last points of the core: one that rounds nothing, and one in no-miss mode.
    for field, place, values, what in (
        ("core", -1, {"errors": Errors(100, 40, 1, 9)}, "no-miss mode misses nothing"),
        ("core", -1, {"beyond_band": 1}, "false alarms within"),
        ("core", -2, {"errors": Errors(100, 40, 1, 0)}, "no error where"),
        ("core", -1, {"rtl_differs": 1}, "RTL as the bulk checker"),
        ("core", -1, {"cycles_per_pair": 1.5}, "one pair a clock"),
        ("bulk", 0, {"unproven": 1}, "bulk checker's axes"),
        ("peers", 0, {"bulk_ns": 61.0}, "CGAL's exact kernel"),
    ):
        worse = list(getattr(result, field))
        worse[place] = replace(worse[place], **values)
        (problem,) = findings(changed(measured, **{field: worse})).problems
        assert problem.startswith(what)


@pytest.mark.parametrize(("kernel", "code"), [(130.0, 0), (50.0, 1)])
def test_the_command_writes_numbers_and_pictures(measured, tmp_path, monkeypatch, capsys, kernel, code):
    found = changed(measured, peers=[peer(run=kernel), peer("VTK", "vtk")])
    done = SimpleNamespace(real_meshes=False, steps=1, run=lambda _: found)
    monkeypatch.setattr(report, "Benchmark", lambda _: done)
    monkeypatch.setattr(harness, "FOLDER", tmp_path)
    assert main(["bench", "error"]) == code
    assert ("MISSED" in capsys.readouterr().out) == bool(code)
    content = json.loads((tmp_path / "error.json").read_text())
    assert content["passed"] != bool(code) and content["rtl_hash"] and content["seed"] == 1
    random = content["workloads"]["random"]
    assert random["core"][0]["errors"]["missed_share"] == 3 / 40
    assert random["peers"][0]["kernel_ns"] == kernel - 10
    assert all((tmp_path / f"error.{suffix}").stat().st_size > 20_000 for suffix in ("svg", "png"))
