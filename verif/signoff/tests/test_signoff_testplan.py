"""The project's own testplan is complete, and what is taken out of it, or put beside it, is named."""

import re
from pathlib import Path

import pytest

from triaxis.coverage.core_coverage import core_model
from triaxis.coverage.counts import Counts
from triaxis.coverage.report import report
from triaxis.coverage.testplan import KINDS, TESTPLAN, read_testplan
from triaxis.coverage.testplan_progress import PlanResults, Tally, stage_progress
from triaxis.golden.errors import InputError
from triaxis.host.cli import main
from triaxis.verif.regress.coverage_models import model_of
from triaxis.verif.signoff.plan import plan
from triaxis.verif.signoff.testplan import check_plan, inventory
from triaxis.verif.testbench.assertions import CORE_SVA, MESH_SVA, assertion_names

TEXT = TESTPLAN.read_text()


def refused(tmp_path, old, new):
    """Return what the linter says of the plan with one change."""
    assert old in TEXT, "the testplan has changed: adapt the test"
    path = tmp_path / "testplan.hjson"
    path.write_text(TEXT.replace(old, new))
    return check_plan(path)[1]


def test_the_testplan_is_clean():
    plan, problems = check_plan()
    assert problems == []
    assert {testpoint.stage for testpoint in plan.testpoints} == {"V1", "V2", "V3"}


def test_every_kind_of_thing_is_in_the_inventory():
    known = inventory()
    assert all(known.names(kind) for kind in KINDS)
    assert len(known.bins) == 8 + 5 and core_model(16, 0).name in known.bins
    assert "mesh_w16_m16_d4096_g8_l8" in known.bins
    assert "answer.clear, wrongly" in known.illegal["core_w16_m0"]
    modules = {path.stem for path in (TESTPLAN.parents[1] / "dut").rglob("*.sv*")}
    assert known.heads("mutants") <= modules


@pytest.mark.parametrize("kind", ["tests", "proofs", "faults", "checks", "assertions"])
def test_whatever_is_taken_out_is_missed(tmp_path, kind):
    name = min(inventory().names(kind))
    found = refused(tmp_path, f'"{name}"', f'"{name}_gone"')
    assert any(f" {name}: no testpoint owns it" in line for line in found), found
    assert any(f" {name}_gone: unknown" in line for line in found), found


def test_a_module_without_testpoint_is_named(tmp_path):
    found = refused(tmp_path, '"triaxis_delay/*"', '"triaxis_fifo/*"')
    assert any("of triaxis_delay: no testpoint owns them" in line for line in found), found


def test_a_cover_item_without_testpoint_is_named(tmp_path):
    found = refused(tmp_path, '"succession", ', "")
    assert any("of succession: no testpoint owns them" in line for line in found), found


def test_a_bin_of_one_configuration_is_missed(tmp_path):
    found = refused(tmp_path, '["blind"]', '["blind.by its axes*"]')
    assert any("near, though a missing axis separates / coplanar" in line for line in found), found


def progress_with(change):
    """Return the status of each testpoint by name: each bin hit as often as its goal, but for a change."""
    reports = []
    for model in dict.fromkeys(model_of(one.config) for one in plan(1)):
        counts = Counts.empty(model)
        counts.hits.update({item.name: item.goals.copy() for item in model.items})
        change(model.name, counts.hits)
        reports.append(report(model, counts))
    stages = stage_progress(read_testplan(), inventory(), PlanResults(coverage=reports))
    return {status.name: status for stage in stages for status in stage.testpoints}


def test_coverage_comes_out_as_it_was_counted():
    found = progress_with(lambda model, hits: None)
    assert not any(status.failing for status in found.values())
    # 32 axes and near in seven configurations, 14 axes and near in the one without edge x box.
    assert found["claims"].bins == Tally(7 * 33 + 15, 0, 0)


def test_a_missing_bin_and_an_illegal_one_fail_their_owners():
    def change(model, hits):
        if model == "core_w8_m8":
            hits["succession"][3] = 0
        if model == "core_w16_m0":
            hits["answer"][0] = 1

    failing = {name: status.failing for name, status in progress_with(change).items() if status.failing}
    assert set(failing) == {"operand_gating", "general_pairs"}
    assert failing["operand_gating"][0].startswith("succession.")
    assert failing["general_pairs"] == ("answer.clear, wrongly",)


def test_assertions_are_all_of_those_in_the_files():
    for path in (*CORE_SVA.glob("*.sv"), *MESH_SVA.glob("*.sv")):
        text = re.sub(r"//.*", "", path.read_text())
        found = assertion_names(path)
        assert len(set(found)) == len(found) == len(re.findall(r"\bassert property\b", text))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("module m (input logic c); assert property (@(posedge c) 1'b1); endmodule", "without a label"),
        ("module m (input logic c); A : assert property (@(posedge c) 1'b1; endmodule", "no valid System"),
    ],
)
def test_what_cannot_be_named_is_refused(tmp_path: Path, text: str, said: str):
    path = tmp_path / "m.sv"
    path.write_text(text)
    with pytest.raises(InputError, match=said):
        assertion_names(path)


def test_command(tmp_path, capsys):
    assert main(["coverage", "plan"]) == 0
    assert "lattice_near_misses" in capsys.readouterr().out
    broken = tmp_path / "plan.hjson"
    broken.write_text(TEXT.replace('"RegressionsTest"', '"MixedTest"'))
    assert main(["coverage", "plan", str(broken)]) == 1
    assert "test RegressionsTest: no testpoint owns it" in capsys.readouterr().out
