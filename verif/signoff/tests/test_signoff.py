"""The simulations of a sign-off can fail: whatever misses its bound is among their problems."""

import re
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from triaxis.coverage.core_coverage import core_model
from triaxis.coverage.counts import Counts
from triaxis.coverage.report import IllegalHit, ItemReport, ModelReport
from triaxis.fpga.board_build import SIGNED_OFF, generics
from triaxis.golden.bulk import bulk_facts
from triaxis.golden.errors import InputError
from triaxis.host.scenes import box, write_stl
from triaxis.sim.configuration import Configuration
from triaxis.sim.mesh_engine import MeshEngine
from triaxis.sim.paths import ROOT
from triaxis.sim.validity import validity
from triaxis.verif.core.detector_check import DetectorResult
from triaxis.verif.core.solver_check import SolverResult
from triaxis.verif.core.stimulus.families import FAMILIES
from triaxis.verif.core.uvm_tests import BUILDS
from triaxis.verif.regress.coverage_models import merge_coverage
from triaxis.verif.signoff import scene_checks, simulation
from triaxis.verif.signoff.plan import VOLUME, plan
from triaxis.verif.signoff.scene_checks import SceneResult, check_sizes
from triaxis.verif.signoff.simulation import SOURCES, SimulationResult
from triaxis.verif.signoff.tests import signoff_evidence
from triaxis.verif.testbench.settings import BURST, PIN, Block, coverage_file
from triaxis.verif.testbench.simulation import RunResult, run_settings
from triaxis.verif.testbench.table import table

HERE = validity(SOURCES)
ALL_AXES = list(range(-1, 32))
COUNTS = {
    "accepted": 200_000, "checked": 200_000, "judged_by_golden_model": 100, "judged_axes": ALL_AXES,
    "failed": 0,
}  # fmt: skip
MESH_COUNTS = {
    "runs": 40, "complete_runs": 30, "accepted": 5_000, "checked": 5_000, "skipped_with_proof": 4_000,
    "tested": 1_000, "judged_by_golden_model": 100, "failed": 0,
}  # fmt: skip
CORE = RunResult(run_settings("RandomTest", Configuration(), 1, 10), True, 1.0, COUNTS, (), Path("log"))
ENGINE = replace(
    CORE, settings=run_settings("MeshRandomTest", "mesh_w16_m16_d64_g8_l8", 1, 10), counts=MESH_COUNTS
)
BOARD = replace(
    CORE,
    settings=run_settings("BoardGoTest", SIGNED_OFF.name, 1, 10),
    counts={"accepted": 100, "checked": 100, "clocks": 9000, "runs": 9, "gos": 5, "resets": 1, "failed": 0},
)
# Of its sizes, with other times.
OTHER_BOARD = replace(BOARD.settings, config=SIGNED_OFF.name.removesuffix("_real"))
SCENE = SceneResult("scene", "near", "near", True, 10, 5, 5, 1)
OTHER_SCENE = replace(SCENE, found="clear")
ILLEGAL = IllegalHit("flags", 1, "never")


def runs(core=CORE, engine=ENGINE, board=BOARD):
    return {"runs": [core, engine, board]}


def counted(**changes):
    return runs(core=replace(CORE, counts={**COUNTS, **changes}))


def covered(**changes):
    item = replace(ItemReport("claim", "the claim", 33, 33, (), (), ()), **changes)
    return {"coverage": [ModelReport("core_w16_m0", (item,))]}


GOOD = SimulationResult(
    [CORE, ENGINE, BOARD],
    [SCENE],
    None,
    DetectorResult(15, 3000, 0),
    SolverResult(4000, 0),
    covered()["coverage"],
    200_000,
    HERE,
    1.0,
)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({}, None),
        (runs(core=replace(CORE, passed=False)), "RandomTest in w16_m0 failed"),
        (runs(core=replace(CORE, counts=None)), "0 pairs checked"),
        (runs(board=replace(BOARD, counts={**(BOARD.counts or {}), "gos": 0})), "never said go"),
        (runs(board=replace(BOARD, settings=OTHER_BOARD)), f"no run was of {SIGNED_OFF.name}"),
        (runs(engine=replace(ENGINE, passed=False)), "MeshRandomTest in mesh_"),
        (runs(engine=replace(ENGINE, counts={**MESH_COUNTS, "checked": 0})), "no pair of a scene"),
        (counted(checked=199_999), "199999 pairs"),
        (counted(accepted=8), "8 of 10 pairs sent"),
        (counted(judged_axes=ALL_AXES[:-1]), "judged no pair that axis 31 separates in w16_m0"),
        (counted(judged_axes=ALL_AXES[1:]), "judged no near pair in w16_m0"),
        ({"scenes": []}, "no scene"),
        ({"scenes": [OTHER_SCENE]}, "clear, expected near"),
        ({"scenes": [replace(SCENE, agrees=False)]}, "golden model disagrees"),
        ({"real_meshes": [OTHER_SCENE]}, "expected near"),
        ({"detector": DetectorResult(14, 3000, 0)}, "14 of 15 seed vectors"),
        ({"detector": DetectorResult(15, 3000, 1)}, "1 of 3000 pairs wrong"),
        ({"solvers": SolverResult(4000, 1)}, "PPL differs on 1 of 4000 pairs"),
        ({"solvers": SolverResult(0, 0)}, "PPL differs on 0 of 0 pairs"),
        (covered(hit=32, missing=("near",)), "32 of 33 bins"),
        (covered(illegal_hits=(ILLEGAL,)), "illegal bin flags hit"),
        ({"coverage": []}, "no coverage"),
        ({"valid_for": replace(HERE, rtl_hash="other")}, "changed during"),
        ({"valid_for": replace(HERE, environment_hash="x")}, "changed during"),
    ],
)
def test_each_shortfall_is_a_problem(change, message):
    problems = replace(GOOD, **change).problems
    assert any(message in problem for problem in problems) if message else not problems, problems


def test_a_bitstream_is_given_each_parameter_as_it_was_simulated():
    given = {
        name: int(value.rpartition("'")[2].lstrip("bh"), 16 if "'h" in value else 10)
        for name, value in generics(SIGNED_OFF, 0xC0DE).items()
    }
    assert given == replace(SIGNED_OFF, build_id=0xC0DE).rtl


def test_plan_covers_widths_margins_and_builds():
    planned = plan(1)
    configurations = {run.configuration for run in planned if run.block is Block.CORE}
    assert {c.width for c in configurations} >= {8, 16, 24, 32}
    assert {c.margin_bits for c in configurations} >= {0, 8, 16, 24, 32}
    assert any(not c.edge_box for c in configurations)
    assert {c.gating for c in configurations} == {True, False}
    assert sum(run.pairs for run in planned if run.test == "VolumeTest") >= VOLUME
    assert {run.agent for run in planned} == {PIN, BURST}


def test_a_configuration_is_signed_off_with_its_share_of_the_volume_and_is_named():
    volume = table()["VolumeTest"].volume
    assert volume.keys() == set(BUILDS) and sum(volume.values()) == 100
    said = (ROOT / "docs" / "signoff.md").read_text().partition("## The verdict")[0]
    assert set(re.findall(r"`((?:mesh_|board_)?w\d+_m\w+)`", said)) == {run.config for run in plan(1)}


def test_the_documents_tell_of_all_tests_and_families():
    said = (ROOT / "docs" / "verification.md").read_text()
    assert table().keys() <= set(re.findall(r"`(\w+Test)`", said))
    assert f"all {len(FAMILIES)} families" in (ROOT / "docs" / "benchmarks.md").read_text()


def test_coverage_of_another_model_ends_the_signoff(tmp_path):
    """A run of one configuration that left the coverage of another."""
    Counts.empty(core_model(Configuration(16, 16))).save(coverage_file(tmp_path))
    assert merge_coverage(tmp_path, ["w16_m16"], [("w16_m16", tmp_path)])[0].model == "core_w16_m16"
    wrong = {"counts of coverage model core_w16_m16": tmp_path, "cannot read": tmp_path / "none"}
    for message, folder in wrong.items():
        with pytest.raises(InputError, match=message):
            merge_coverage(tmp_path, ["w16_m0"], [("w16_m0", folder)])


def test_a_run_that_fails_covers_nothing_and_is_told_in_the_file(monkeypatch):
    ran = {run.settings: run for run in (replace(CORE, passed=False, counts={**COUNTS, "failed": 3}), BOARD)}
    covering, steps = [], []
    for name, answer in {
        "plan": lambda *_: list(ran), "_builds": lambda _: [lambda: None],
        "run_and_explain": ran.__getitem__, "check_scenes": lambda _: [SCENE],
        "check_real_meshes": lambda _: [OTHER_SCENE], "check_detector": lambda _: GOOD.detector,
        "check_solvers": lambda _: GOOD.solvers,
        "merge_coverage": lambda _, configs, passed: covering.extend(passed) or GOOD.coverage,
    }.items():  # fmt: skip
        monkeypatch.setattr(simulation, name, answer)
    found = simulation.simulate(1, steps.append, 5)
    assert covering == [(BOARD.settings.config, Path(BOARD.settings.folder))]
    assert sum(steps) == simulation.step_count(1, 5) == 1 + 2 + 4
    written = simulation.as_evidence(found, 1, 5)
    assert written["passed"] is False and written["problems"] == found.problems
    assert (written["mismatches"], written["pairs_checked"]) == (3, 200_000)
    assert [run["passed"] for run in written["runs"]] == [False, True]
    # All that figures, gate and archive ask for.
    assert signoff_evidence.good_parts()["simulation"].as_json.keys() - {"absent"} <= written.keys()


@pytest.mark.parametrize(
    ("expected", "wrong", "said", "agrees"),
    [(True, False, "near", True), (False, False, "near", True), (False, True, "clear", False)],
)
def test_a_scene_of_another_end_or_verdict_fails(tmp_path, monkeypatch, expected, wrong, said, agrees):
    """A box in a box; and beside one, nearer than the clearance, of which the core says clear."""

    def verdicts(pairs, margins):
        answers = bulk_facts(pairs, margins).verdicts
        answers["near"] &= not wrong
        return answers

    monkeypatch.setattr(scene_checks, "RtlEngine", lambda _: SimpleNamespace(verdicts=verdicts))
    inner, outer = (tmp_path / f"{name}.stl" for name in ("inner", "outer"))
    write_stl(inner, box((0, 0, 0), (4, 4, 4)))
    write_stl(outer, box((-9, -9, -9), (9, 9, 9)) + np.array([99 * wrong, 0, 0], np.float32))
    found = scene_checks._check_files("box", inner, outer, expected, Fraction(200 * wrong or 1))
    assert (found.found, found.agrees, found.passed) == (said, agrees, expected)


@pytest.mark.long
@pytest.mark.simulator
def test_sizes_between_are_decided_and_a_wrong_count_is_seen(monkeypatch):
    assert all(scene.passed for scene in check_sizes())
    run = MeshEngine.run
    monkeypatch.setattr(MeshEngine, "run", lambda *words: replace(run(*words), near_count=0))
    assert [scene.passed for scene in check_sizes()] == [*[False] * 9, True]
