"""The problems of a regression, and how its reports say so."""

from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from triaxis.coverage.report import IllegalHit, ItemReport, ModelReport
from triaxis.sim.evidence import read_evidence
from triaxis.verif.regress.definition import Regression
from triaxis.verif.regress.failing import FailingSeed
from triaxis.verif.regress.outcome import Outcome
from triaxis.verif.regress.records import State
from triaxis.verif.regress.reports import history_record, write_junit, write_report, write_results
from triaxis.verif.regress.run import Request
from triaxis.verif.regress.tests.test_regression_parts import PASSED, RUN

FAILED = replace(PASSED, passed=False, errors=("ERROR <tag> 3 & \x1b[31mred", "ERROR more"), counts=None)
FEWER = replace(PASSED, counts={"checked": 1999, "judged_by_golden_model": 0})
FLAKY = FailingSeed(RUN, "sources", "it failed", flaky=True)
SMOKE = Regression("smoke", ("MixedTest_w16_m0",), 1, 0, False)
ITEM = ItemReport("claim", "the claim", 33, 33, (), (), ())


def covered(model: str = "core_w16_m0", **changes: Any):
    return (ModelReport(model, (replace(ITEM, **changes),)),)


MISSING: dict[str, Any] = {"hit": 32, "missing": ("near",)}
HIT: dict[str, Any] = {"illegal_hits": (IllegalHit("flags", 1, "never"),)}


def outcome(folder: Path = Path(), **changes) -> Outcome:
    goals = Regression("nightly", ("MixedTest_w16_m0",), None, 2000, True)
    state = State(7, 1.0, "sources", (10.0,))
    good = Outcome(
        goals, state, folder, "triaxis regress run nightly", "local", (RUN,), (PASSED,), (), (), 0,
        covered(), 4.0,
    )  # fmt: skip
    return replace(good, **changes)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"records": (FAILED,)}, "MixedTest in w16_m0, seed 7 failed: ERROR <tag> N & "),
        ({"records": ()}, "MixedTest in w16_m0, seed 7: no result"),
        ({"records": (FEWER,)}, "1999 pairs"),
        ({"coverage": covered(**MISSING)}, "32 of 33 bins hit, missing first: near"),
        ({"coverage": covered(**HIT)}, "illegal bin flags hit 1 times: never"),
        ({"coverage": covered(**HIT), "regression": SMOKE}, "illegal coverage bin flags hit 1 times: never"),
        ({"flaky": (FLAKY,)}, "MixedTest in w16_m0, seed 7 is flaky"),
    ],
)
def test_each_shortfall_is_a_problem_and_a_failed_case(tmp_path, change, message):
    found = outcome(tmp_path, **change)
    assert any(message in problem for problem in found.problems), found.problems
    root = ElementTree.parse(write_junit(found)).getroot()
    cases = list(root.iter("testcase"))
    failures = [case for case in cases if case.find("failure") is not None]
    assert len(failures) >= 1
    assert (root.get("tests"), root.get("failures")) == (str(len(cases)), str(len(failures)))
    assert "FAILED" in write_report(found).read_text()


def test_all_well_and_smoke_has_no_goals():
    assert outcome().problems == []
    assert outcome(regression=SMOKE, coverage=covered(**MISSING)).problems == []


def test_page_shows_buckets_first_and_coverage_of_a_configuration_with_other_tags(tmp_path):
    record = replace(FAILED, run=replace(RUN, config="w13_m4_t1"))
    models = covered("core_w13_m4", **MISSING)
    page = write_report(outcome(tmp_path, records=(record,), coverage=models)).read_text()
    assert page.count("96.96") == 2
    assert page.index("Failure buckets") < page.index("Other problems")


def test_only_a_whole_nightly_goes_into_the_history(tmp_path):
    whole = Request("nightly")
    assert whole.is_whole_nightly
    other = {"regression": "smoke", "multiplier": 0.5, "folder": tmp_path, "definition": tmp_path}
    assert not any(replace(whole, **{name: value}).is_whole_nightly for name, value in other.items())


def test_results_and_history_tell_nothing_from_zero(tmp_path):
    found = outcome(tmp_path, records=(FAILED,), coverage=())
    result = read_evidence(write_results(found))
    assert result is not None
    assert (result["passed"], result["runs"][0]["pairs_checked"]) == (False, None)
    assert result["coverage"]["percent"] is None
    line = history_record(found)
    assert (line.coverage_percent, line.pairs, line.failures, line.passed) == (None, 0, 1, False)
    assert (line.kind, line.seed, line.seconds, line.pairs_per_second) == ("nightly", 7, 4.0, 0.0)


def test_a_seed_that_was_replayed_and_passes_is_fixed():
    seed = FailingSeed(RUN, "other sources", "it failed")
    assert outcome(replayed=(seed,)).fixed == [seed]
    assert outcome(replayed=(seed,), records=(FAILED,)).fixed == []
    assert outcome(replayed=(FLAKY,), flaky=(FLAKY,)).fixed == []
