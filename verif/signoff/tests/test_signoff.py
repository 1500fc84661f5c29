"""The sign-off can fail: whatever misses its bound is among its problems."""

from dataclasses import replace
from pathlib import Path

import pytest

from triaxis.coverage.core_coverage import core_model
from triaxis.coverage.counts import Counts
from triaxis.coverage.report import IllegalHit, ItemReport, ModelReport
from triaxis.golden.errors import InputError
from triaxis.sim.configuration import Configuration
from triaxis.sim.validity import validity
from triaxis.verif.core.detector_check import DetectorResult
from triaxis.verif.regress.coverage_models import merge_coverage
from triaxis.verif.signoff.plan import VOLUME, plan
from triaxis.verif.signoff.scene_checks import SceneResult
from triaxis.verif.signoff.simulation import SOURCES, SimulationResult
from triaxis.verif.testbench.settings import BURST, PIN, coverage_file
from triaxis.verif.testbench.simulation import RunResult, run_settings

HERE = validity(SOURCES)
ALL_AXES = list(range(-1, 32))
COUNTS = {
    "accepted": 200_000,
    "checked": 200_000,
    "judged_by_golden_model": 100,
    "judged_axes": ALL_AXES,
    "failed": 0,
}
ITEM = ItemReport("claim", "the claim", 33, 33, (), (), ())
ILLEGAL = IllegalHit("flags", 1, "never")


def coverage(**changes):
    return [ModelReport("core_w16_m0", (replace(ITEM, **changes),))]


MESH_COUNTS = {
    "runs": 40,
    "complete_runs": 30,
    "accepted": 5_000,
    "checked": 5_000,
    "skipped_with_proof": 4_000,
    "tested": 1_000,
    "judged_by_golden_model": 100,
    "failed": 0,
}


def good():
    settings = run_settings("RandomTest", Configuration(), 1, 10)
    run = RunResult(settings, True, 1.0, COUNTS, (), Path("log"))
    of_engine = run_settings("MeshRandomTest", "mesh_w16_m16_d64_g8_l8", 1, 10)
    engine_run = RunResult(of_engine, True, 1.0, MESH_COUNTS, (), Path("log"))
    scene = SceneResult("scene", "near", "near", True, 10, 5, 5, 1)
    detector = DetectorResult(15, 3000, 0)
    runs = [run, engine_run]
    return SimulationResult(runs, [scene], None, detector, coverage(), 200_000, HERE, 1.0)


def counted(result, **changes):
    core, engine = result.runs
    return replace(result, runs=[replace(core, counts={**COUNTS, **changes}), engine])


def without_scenes(result):
    core, engine = result.runs
    return replace(result, runs=[core, replace(engine, counts={**MESH_COUNTS, "checked": 0})])


def test_all_well():
    assert good().problems == []


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda r: replace(r, runs=[replace(r.runs[0], passed=False)]), "RandomTest in w16_m0 failed"),
        (lambda r: replace(r, runs=[replace(r.runs[0], counts=None)]), "0 pairs checked"),
        (lambda r: counted(r, checked=199_999), "199999 pairs"),
        (lambda r: counted(r, accepted=8), "8 of 10 pairs sent"),
        (lambda r: counted(r, judged_axes=ALL_AXES[:-1]), "decided by axis 31, in w16_m0"),
        (lambda r: counted(r, judged_axes=ALL_AXES[1:]), "decided by nothing, being near"),
        (lambda r: replace(r, valid_for=replace(HERE, environment_hash="x")), "changed during"),
        (without_scenes, "no pair of a scene"),
        (lambda r: replace(r, runs=[r.runs[0], replace(r.runs[1], passed=False)]), "MeshRandomTest in mesh_"),
        (lambda r: replace(r, scenes=[]), "no scene"),
        (lambda r: replace(r, scenes=[replace(r.scenes[0], found="clear")]), "clear, expected near"),
        (lambda r: replace(r, scenes=[replace(r.scenes[0], agrees=False)]), "golden model disagrees"),
        (lambda r: replace(r, real_meshes=[replace(r.scenes[0], found="clear")]), "expected near"),
        (lambda r: replace(r, detector=DetectorResult(14, 3000, 0)), "14 of 15 seed vectors"),
        (lambda r: replace(r, detector=DetectorResult(15, 3000, 1)), "1 of 3000 pairs wrong"),
        (lambda r: replace(r, coverage=coverage(hit=32, missing=("near",))), "32 of 33 bins"),
        (lambda r: replace(r, coverage=coverage(illegal_hits=(ILLEGAL,))), "illegal bin flags hit"),
        (lambda r: replace(r, coverage=[]), "no coverage"),
        (lambda r: replace(r, valid_for=replace(HERE, rtl_hash="other")), "changed during"),
    ],
)
def test_each_shortfall_is_a_problem(change, message):
    problems = change(good()).problems
    assert any(message in problem for problem in problems), problems


def test_plan_covers_widths_margins_and_builds():
    runs = plan(1)
    configurations = {run.configuration for run in runs if not run.of_mesh_engine}
    assert {c.width for c in configurations} >= {8, 16, 24, 32}
    assert {c.margin_bits for c in configurations} >= {0, 8, 16, 24, 32}
    assert any(not c.edge_box for c in configurations)
    assert {c.gating for c in configurations} == {True, False}
    assert sum(run.pairs for run in runs if run.test == "VolumeTest") >= VOLUME
    assert {run.agent for run in runs} == {PIN, BURST}
    assert len({run.folder for run in runs}) == len(runs)


def test_coverage_of_another_model_ends_the_signoff(tmp_path):
    """A run of one configuration that left the coverage of another."""
    Counts.empty(core_model(16, 16)).save(coverage_file(tmp_path))
    assert merge_coverage(tmp_path, ["w16_m16"], [("w16_m16", tmp_path)])[0].model == "core_w16_m16"
    wrong = {"counts of coverage model core_w16_m16": tmp_path, "cannot read": tmp_path / "none"}
    for message, folder in wrong.items():
        with pytest.raises(InputError, match=message):
            merge_coverage(tmp_path, ["w16_m0"], [("w16_m0", folder)])
