"""The project's own testplan is complete, and what is taken out of it, or put beside it, is named."""

import re
from dataclasses import replace
from functools import cache
from typing import Any

import pytest

from triaxis.coverage.core_coverage import core_model
from triaxis.coverage.counts import Counts
from triaxis.coverage.report import report
from triaxis.coverage.testplan import KINDS, TESTPLAN, read_testplan
from triaxis.coverage.testplan_progress import PlanResults, Tally, progress
from triaxis.fpga.board_build import SIGNED_OFF, TOP
from triaxis.golden.errors import InputError
from triaxis.host.cli import main
from triaxis.sim.configuration import Configuration
from triaxis.sim.models import BOARD_SVA, CORE_SVA, MESH_SVA
from triaxis.sim.paths import DUT
from triaxis.verif.regress.coverage_models import model_of
from triaxis.verif.signoff import testplan
from triaxis.verif.signoff.parts import Part
from triaxis.verif.signoff.plan import plan
from triaxis.verif.signoff.testplan import check_plan, inventory
from triaxis.verif.signoff.tests.signoff_evidence import good_parts
from triaxis.verif.testbench.assertions import assertion_names
from triaxis.verif.testbench.settings import Block

TEXT = TESTPLAN.read_text()


def test_the_board_that_ships_is_simulated_also_at_its_own_times():
    ran = [(run.test, run.board_parameters) for run in plan(1) if run.block is Block.BOARD]
    of_its_sizes = {test for test, parameters in ran if parameters.sizes == SIGNED_OFF.sizes}
    assert of_its_sizes >= {"BoardSmokeTest", "BoardGoTest", "BoardMixedTest", "BoardDepthTest"}
    assert any(replace(parameters, build_id=0) == SIGNED_OFF for _, parameters in ran)
    # A bitstream takes them from the top itself.
    text = (DUT / "board" / f"{TOP}.sv").read_text()
    named = re.findall(r"parameter (?:int unsigned|bit) (\w+) = (?:1'b)?(\w+)", text)
    package = (DUT / "board" / "triaxis_board_pkg.sv").read_text()
    constants = dict(re.findall(r"localparam int unsigned (\w+) = ([\d_]+);", package))
    sizes = {name: int(constants.get(value, value)) for name, value in named}
    assert {**sizes, "BuildId": 0} == SIGNED_OFF.rtl


def test_the_testplan_is_clean_and_the_inventory_whole(capsys):
    assert check_plan()[1] == []
    assert main(["coverage", "plan"]) == 0
    assert "lattice_near_misses" in capsys.readouterr().out
    known = inventory()
    assert all(known.names(kind) for kind in KINDS)
    assert len(known.bins) == 10 + 5 + 1 and core_model(Configuration()).name in known.bins
    assert "mesh_w16_m16_d4096_g8_l8_certified" in known.bins
    assert "answer.clear, wrongly" in known.illegal["core_w16_m0"]
    modules = {path.stem for path in (TESTPLAN.parents[1] / "dut").rglob("*.sv*")}
    assert known.heads("mutants") <= modules


KINDS_NAMED = ("tests", "proofs", "faults", "checks", "assertions")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        *((kind, "{}_gone", (" {}: no testpoint owns it", " {}_gone: unknown")) for kind in KINDS_NAMED),
        ('"triaxis_delay/*"', '"triaxis_fifo/*"', ("of triaxis_delay: no testpoint owns them",)),
        ('"succession", ', "", ("of succession: no testpoint owns them",)),
        ('["blind"]', '["blind.by its axes*"]', ("near, though a missing axis separates / coplanar",)),
        ("stage: V1", "stage: V2", ("test RandomTest: first asked for in V2, its class says V1",)),
    ],
)
def test_whatever_is_taken_out_is_missed(tmp_path, capsys, old, new, said):
    if old in KINDS_NAMED:
        name = min(inventory().names(old))
        old, new = f'"{name}"', f'"{new.format(name)}"'
        said = [text.format(name) for text in said]
    assert old in TEXT, "the testplan has changed: adapt the test"
    path = tmp_path / "testplan.hjson"
    path.write_text(TEXT.replace(old, new))
    assert main(["coverage", "plan", str(path)]) == 1
    found = capsys.readouterr().out
    assert all(text in found for text in said), found


@cache
def covered(model="", item="", bin_=0, hits=0):
    """Return reports of all models, in which all goals are met but that of one bin."""
    reports = []
    for one in dict.fromkeys(model_of(run.config) for run in plan(1)):
        counts = Counts.empty(one)
        counts.hits.update({item.name: item.goals.copy() for item in one.items})
        if one.name == model:
            counts.hits[item][bin_] = hits
        reports.append(report(one, counts))
    return reports


@pytest.mark.parametrize(
    ("model", "item", "bin_", "hits", "owner", "said"),
    [
        ("core_w8_m8", "succession", 3, 0, "operand_gating", "succession."),
        ("core_w16_m0", "answer", 0, 1, "general_pairs", "answer.clear, wrongly"),
        ("", "", 0, 0, "", ""),
    ],
)
def test_a_missing_and_an_illegal_bin_fail_their_owner_alone(model, item, bin_, hits, owner, said):
    reports = covered(model, item, bin_, hits)
    statuses = progress(read_testplan(), inventory(), PlanResults(coverage=reports))
    found = {status.name: status for status in statuses}
    failing = {name: status.failing for name, status in found.items() if status.failing}
    assert set(failing) == ({owner} if owner else set())
    assert all(text.startswith(said) for texts in failing.values() for text in texts)
    # 32 axes and near in nine configurations, 14 axes and near in the one without edge x box.
    assert found["claims"].tallies["bins"] == Tally(9 * 33 + 15, 0, 0)


def run_parts():
    """Return parts that ran all that the testplan asks for, and found nothing."""
    parts = good_parts()
    found: Any = {name: part.evidence for name, part in parts.items()}
    for part, key, kind, what in (
        ("simulation", "runs", "tests", {"passed": True}), ("faults", "faults", "faults", {"caught": True}),
        ("proofs", "proofs", "proofs", {"passed": True, "result": "proved"}),
    ):  # fmt: skip
        found[part][key] = [{"name": one, "test": one, **what} for one in inventory().names(kind)]
    first, *others = sorted(inventory().mutants)
    found["mutation"].update(killed=others, equivalents=[{"id": first}])
    return parts


THEOREM_ABSENT = {"name": "theorem", "passed": False, "result": "not measured"}


@pytest.mark.parametrize(
    ("part", "change", "kind", "name"),
    [
        ("proofs", lambda e: e["proofs"].append(THEOREM_ABSENT), "", ""),
        ("simulation", lambda e: e["runs"].append({"test": "FarTest", "passed": False}), "tests", "FarTest"),
        ("proofs", lambda e: e["proofs"].append({**THEOREM_ABSENT, "name": "reach"}), "proofs", "reach"),
        ("proofs", lambda e: e["proofs"].append({**THEOREM_ABSENT, "result": "x"}), "proofs", "theorem"),
        ("proofs", lambda e: e["proofs"].clear(), "proofs", None),
        ("faults", lambda e: e["faults"].append({"name": "F5", "caught": False}), "faults", "F5"),
        ("mutation", lambda e: e["survivors"].append({"id": e["killed"][9]}), "mutants", 10),
        ("mutation", lambda e: e.update(equivalents=[]), "mutants", 0),
        ("simulation", lambda e: e["detector"].update(seed_vectors_clear=14), "checks", "detector"),
        ("simulation", lambda e: e["detector"].update(wrong=1), "checks", "detector"),
        ("simulation", lambda e: e["detector"].update(pairs=0), "checks", "detector"),
        ("simulation", lambda e: e["solvers"].update(pairs=0), "checks", "solvers"),
        ("simulation", lambda e: e["solvers"].update(different=1), "checks", "solvers"),
        ("simulation", lambda e: e.update(scenes=[]), "checks", "scenes"),
        ("simulation", lambda e: e["scenes"][0].update(agrees=False), "checks", "scenes"),
        ("simulation", lambda e: e.update(real_meshes=[{**e["scenes"][0], "found": ""}]), "checks", "scenes"),
        ("exhaustive", lambda e: e.update(passed=False), "checks", "exhaustive"),
        ("code_coverage", lambda e: e.update(passed=False), "checks", "code_coverage"),
    ],
)  # fmt: skip
def test_what_fails_or_is_not_there_leaves_its_testpoints_open_and_what_they_serve(part, change, kind, name):
    parts = run_parts()
    change(parts[part].evidence)
    found = testplan.testplan_part(parts, covered())
    name = sorted(inventory().mutants)[name] if kind == "mutants" else name
    every = read_testplan().testpoints
    owned = {one.name: inventory().owned(one, kind) if kind else () for one in every}
    owners = {one for one, names in owned.items() if name in names or (name is None and names)}
    assert {one["name"] for one in found["testpoints"] if one["passed"] is not True} == owners
    served = {one for point in every if point.name in owners for one in point.requirements}
    assert {one["id"] for one in found["requirements"] if not one["passed"]} == served
    assert found["passed"] is (not owners) and bool(owners) is bool(kind) and not found["problems"]
    # Nothing of what did not run is met.
    absent = testplan.testplan_part({**parts, part: Part(None, "no tool")}, covered())
    assert not absent["passed"] and owners <= {p["name"] for p in absent["testpoints"] if not p["passed"]}


def test_assertions_are_all_of_those_in_the_files(tmp_path):
    for path in (*CORE_SVA.glob("*.sv"), *MESH_SVA.glob("*.sv"), *BOARD_SVA.glob("*.sv")):
        text = re.sub(r"//.*", "", path.read_text())
        found = assertion_names(path)
        assert len(set(found)) == len(found) == len(re.findall(r"\bassert property\b", text))
    nameless = tmp_path / "nameless.sv"
    nameless.write_text("module m (input logic c); assert property (@(posedge c) 1'b1); endmodule")
    with pytest.raises(InputError, match="without a label"):
        assertion_names(nameless)
