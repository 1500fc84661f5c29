"""The sign-off can fail: whatever falls short stands among its problems."""

from dataclasses import replace
from pathlib import Path

import pytest

from triaxis.coverage.covergroup import PointReport
from triaxis.verif import signoff
from triaxis.verif.configuration import Configuration
from triaxis.verif.signoff import DetectorResult, SceneResult, SignoffResult, plan, provenance
from triaxis.verif.simulation import RunResult, run_settings


def good():
    settings = run_settings("RandomTest", Configuration(), 1, 10)
    run = RunResult(settings, True, 1.0, {"checked": 200_000, "failed": 0}, (), Path("log"))
    scene = SceneResult("scene", "near", "near", True, 10, 5, 5, 1)
    point = PointReport("claim", 33, 33, ())
    return SignoffResult([run], [scene], None, DetectorResult(15, 3000, 0), [point], provenance(), 1.0)


def test_all_well():
    assert good().problems == []


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda r: replace(r, runs=[replace(r.runs[0], passed=False)]), "RandomTest in w16_m0 failed"),
        (lambda r: replace(r, runs=[replace(r.runs[0], counts=None)]), "0 pairs checked"),
        (lambda r: replace(r, runs=[replace(r.runs[0], counts={"checked": 199_999})]), "199999 pairs"),
        (lambda r: replace(r, scenes=[]), "no scene"),
        (lambda r: replace(r, scenes=[replace(r.scenes[0], found="clear")]), "clear, expected near"),
        (lambda r: replace(r, scenes=[replace(r.scenes[0], agrees=False)]), "golden model disagrees"),
        (lambda r: replace(r, real_meshes=[replace(r.scenes[0], found="clear")]), "expected near"),
        (lambda r: replace(r, detector=DetectorResult(14, 3000, 0)), "14 of 15 seed vectors"),
        (lambda r: replace(r, detector=DetectorResult(15, 3000, 1)), "1 of 3000 pairs wrong"),
        (lambda r: replace(r, coverage=[PointReport("claim", 32, 33, ("near",))]), "32 of 33 bins"),
        (lambda r: replace(r, coverage=[]), "no coverage"),
        (lambda r: replace(r, provenance=replace(r.provenance, rtl_hash="other")), "changed during"),
    ],
)
def test_each_shortfall_is_a_problem(change, message):
    problems = change(good()).problems
    assert any(message in problem for problem in problems), problems


def test_plan_covers_widths_margins_and_builds():
    runs = plan(1)
    configurations = {run.configuration for run in runs}
    assert {c.width for c in configurations} >= {8, 16, 24, 32}
    assert {c.margin_bits for c in configurations} >= {0, 8, 16, 24, 32}
    assert any(not c.edge_box for c in configurations)
    assert {c.gating for c in configurations} == {True, False}
    assert sum(run.pairs for run in runs) >= signoff.LEAST_PAIRS
    assert len({run.folder for run in runs}) == len(runs)
