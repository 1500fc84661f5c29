"""The parts of a regression on their own: buckets, failing seeds, state, problems, jobs."""

import shutil
import subprocess
import sys
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest.mock import ANY
from xml.etree import ElementTree

import pytest

from triaxis.coverage.counts import Counts
from triaxis.coverage.report import IllegalHit, ItemReport, ModelReport
from triaxis.golden.errors import InputError
from triaxis.sim.evidence import read_evidence
from triaxis.sim.paths import DUT
from triaxis.sim.validity import standing
from triaxis.verif.regress import dispatch, one_job, run
from triaxis.verif.regress.coverage_models import model_of
from triaxis.verif.regress.definition import Regression
from triaxis.verif.regress.failing import FailingSeed, FailingSeeds, buckets
from triaxis.verif.regress.launchers import LSF, SLURM, launcher
from triaxis.verif.regress.one_job import error_file
from triaxis.verif.regress.outcome import Outcome
from triaxis.verif.regress.records import (
    PlannedRun,
    RunRecord,
    State,
    begin,
    previous,
    read_record,
    read_state,
    record_file,
    record_of,
    write_record,
    write_state,
)
from triaxis.verif.regress.reports import write_junit, write_report, write_results
from triaxis.verif.testbench.settings import coverage_file
from triaxis.verif.testbench.simulation import RunResult

RUN = PlannedRun("MixedTest_w16_m0", "MixedTest", "w16_m0", 7, 2000, "burst", 1)
PASSED = RunRecord(
    RUN, "sources", True, (), (), {"checked": 2000, "judged_by_golden_model": 2000}, 10.0, 12.0,
    "host", None, "log", "folder", "replay",
)  # fmt: skip
FAILED = replace(PASSED, passed=False, errors=("12.00ns ERROR 3 pairs accepted and never answered",))


def test_fullest_bucket_first():
    other = replace(FAILED, errors=("ERROR tag 78 where 77 was due",))
    more = replace(FAILED, errors=("99.00ns ERROR 1 pairs accepted and never answered",))
    silent = replace(FAILED, errors=("ERROR no space left",), silent=True)
    found = buckets([other, FAILED, PASSED, more, replace(FAILED, errors=()), silent])
    assert {message: len(records) for message, records in found.items()} == {
        "ERROR N pairs accepted and never answered": 2,
        "ERROR tag N where N was due": 1,
        "no error line": 1,
        "ended without a result: no space left": 1,
    }
    assert next(iter(found.values())) == [FAILED, more]


def test_failing_seeds_are_kept_until_they_pass_on_other_sources(tmp_path):
    store = FailingSeeds(tmp_path / "failing.json")
    entry = FailingSeed(RUN, "sources", "ERROR N pairs accepted and never answered")
    flaky, silent = replace(entry, flaky=True), replace(FAILED, silent=True)
    moved = replace(FAILED, identity="other")
    for record, left in (
        (PASSED, []),
        # A run that left no result says nothing of its seed.
        (silent, []),
        (FAILED, [entry]),
        (FAILED, [entry]),
        (silent, [entry]),
        (replace(PASSED, run=replace(RUN, seed=8)), [entry]),
        (PASSED, [flaky]),
        # It stays flaky where it fails once more, but not on other sources.
        (FAILED, [flaky]),
        (moved, [replace(entry, identity="other")]),
        (PASSED, []),
        (FAILED, [entry]),
    ):
        store.note(record)
        assert store.read() == left
    assert store.forget() == [entry]
    assert store.read() == store.forget() == []
    store.path.write_text('[{"run": ')
    with pytest.raises(InputError, match=r"failing\.json: damaged"):
        store.note(FAILED)
    assert store.path.read_text() == '[{"run": '


def test_a_cut_result_counts_as_missing(tmp_path):
    write_record(tmp_path, PASSED)
    path = record_file(tmp_path, RUN)
    assert read_record(path) == PASSED
    text = path.read_text()
    for end in (0, 1, len(text) // 2, len(text) - 3):
        path.write_text(text[:end])
        assert read_record(path) is None


def test_only_the_same_unfinished_regression_is_continued(tmp_path):
    folder, said = tmp_path / "nightly", []
    wanted = State(1, 1.0, "sources")
    first = begin(folder, wanted, said.append)
    (folder / "result").write_text("kept")
    second = begin(folder, replace(wanted, seed=5), said.append, any_seed=True)
    assert (second.seed, len(second.started), second.started[0]) == (1, 2, first.started[0])
    assert (folder / "result").exists() and said == []
    # Finished, another, or not wanted: moved aside, where it stays readable.
    write_state(folder, replace(second, finished=True))
    third = begin(folder, wanted, said.append)
    assert len(third.started) == 1 and said == []
    assert (previous(folder) / "result").read_text() == "kept"
    assert not (folder / "result").exists()
    assert len(begin(folder, wanted, said.append, fresh=True).started) == 1
    assert read_state(previous(folder)) == third
    for changed, difference in (
        (replace(wanted, seed=2), "of seed 1"),
        (replace(wanted, seed=2, identity="other"), "of other sources"),
        (replace(wanted, seed=2, identity="other", multiplier=2.0), "of 1 times the seeds"),
    ):
        assert begin(folder, changed, said.append) == replace(changed, started=ANY)
        assert said.pop() == f"not continued: the unfinished regression there is {difference}"
    # The time between a kill and its continuation does not count.
    state = State(1, 1.0, "sources", (100.0, 500.0))
    records = [replace(PASSED, finished=finished) for finished in (110.0, 130.0, 510.0)]
    assert state.seconds(records, now=520.0) == 30.0 + 20.0


# --- The outcome ----------------------------------------------------------------------------------------

TOLD = replace(PASSED, passed=False, errors=("ERROR <tag> 3 & \x1b[31mred", "ERROR more"), counts=None)
FEWER = replace(PASSED, counts={"checked": 1999, "judged_by_golden_model": 0})
FLAKY = FailingSeed(RUN, "sources", "it failed", flaky=True)
SMOKE = Regression("smoke", ("MixedTest_w16_m0",), 1, 0, False)
ITEM = ItemReport("claim", "the claim", 33, 33, (), (), ())


def covered(**changes: Any):
    return (ModelReport("core_w16_m0", (replace(ITEM, **changes),)),)


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
        ({"records": (TOLD,)}, "MixedTest in w16_m0, seed 7 failed: ERROR <tag> N & "),
        ({"records": ()}, "MixedTest in w16_m0, seed 7: no result"),
        ({"records": (FEWER,)}, "1999 pairs"),
        ({"coverage": covered(**MISSING)}, "32 of 33 bins hit, missing first: near"),
        ({"coverage": covered(**HIT)}, "illegal bin flags hit 1 times: never"),
        ({"coverage": covered(**HIT), "regression": SMOKE}, "claim: illegal bin flags hit 1 times: never"),
        ({"coverage": ()}, "no coverage was collected"),
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


def test_what_must_not_be_hit_fails_a_regression_whatever_coverage_is_asked_for(tmp_path, monkeypatch):
    model = model_of("w8_m0")
    item = next(item for item in model.items if item.illegal.any())
    counts = Counts.empty(model)
    counts.hits[item.name][item.illegal.argmax()] = 1
    counts.save(coverage_file(tmp_path / "run"))
    one = replace(RUN, config="w8_m0")
    write_record(tmp_path, replace(PASSED, run=one, folder=str(tmp_path / "run")))
    monkeypatch.setattr(run, "check_dvsim", lambda: None)
    work = run._Regression(run.Request("nightly", folder=tmp_path), print, lambda *_: nullcontext(print))
    work._folder, state = tmp_path, State(7, 1.0, "sources", (10.0,))
    for uncovered in (frozenset[str](), frozenset({"w8_m0"})):
        work._regression = replace(SMOKE, uncovered=uncovered)
        found = work._outcome(state, (one,), (one,), (), 0)
        assert [model.model for model in found.coverage] == ([] if uncovered else [model.name])
        (problem,) = found.problems
        assert problem.startswith(f"coverage {model.name}, {item.name}: illegal bin "), problem


def test_no_run_is_blamed_for_what_an_earlier_attempt_left(tmp_path, monkeypatch):
    """A failure would end the regression, and what had passed of it would be lost."""
    monkeypatch.setattr(dispatch, "_DVSIM", Path("/bin/false"))
    work = run._Regression(run.Request("smoke", folder=tmp_path), print, lambda *_: nullcontext(print))
    one, *_ = work._definition.plan("smoke", 1)
    log = work._dvsim._scratch("main") / f"{one.item}.{one.seed}" / "latest" / "run.log"
    for left in (log, error_file(work._folder, one.config)):
        left.parent.mkdir(parents=True, exist_ok=True)
        left.write_text("no space left")
    with pytest.raises(InputError, match="dvsim started no run"):
        work._pass("main", [one], print)


def test_results_tell_nothing_from_zero(tmp_path):
    found = outcome(tmp_path, records=(TOLD,), coverage=())
    result = read_evidence(write_results(found))
    assert result is not None
    assert (result["passed"], result["runs"][0]["pairs_checked"]) == (False, None)
    assert result["coverage"]["percent"] is None


def test_results_of_the_board_count_replies_and_none_that_the_golden_model_judged(tmp_path):
    result = read_evidence(
        write_results(outcome(tmp_path, records=(PASSED, replace(PASSED, counts={"checked": 9}))))
    )
    assert result is not None
    assert (result["pairs_checked"], result["pairs_judged_by_golden_model"]) == (2009, 2000)


def test_a_folder_that_is_no_regressions_is_left_as_it_is(tmp_path):
    folder, wanted = tmp_path / "smoke", State(1, 1.0, "sources")
    for other in (folder, previous(folder)):
        other.mkdir()
        (other / "thesis.txt").write_text("mine")
        with pytest.raises(
            InputError, match=r"holds no regression, and is not removed: use another --folder"
        ):
            begin(folder, wanted, print)
        assert (other / "thesis.txt").read_text() == "mine"
        shutil.rmtree(other)
    assert begin(folder, wanted, print).seed == 1


# --- Jobs -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("job", "said"),
    [
        ("build --config w16_m17 --agent burst", "FAILED: margin bits 17: must be 0..16"),
        (
            "run --item MixedTest_w16_m0 --test MixedTest --config w16_m0 --seed 7 --pairs 1 --identity other"
            " --failing failing.json",
            "FAILED: the RTL or its environment changed during the regression",
        ),
    ],
)
def test_a_job_that_cannot_be_done_leaves_its_reason_and_no_result(tmp_path, job, said):
    command = [sys.executable, "-m", "triaxis.verif.regress.one_job", *job.split(), "--folder", "."]
    answer = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert answer.returncode == 1 and said in answer.stdout
    assert not list(tmp_path.rglob("*.json"))
    if "build" in job:
        assert "margin bits 17" in error_file(tmp_path, "w16_m17").read_text()


@pytest.mark.parametrize(
    ("passed", "counts", "errors", "silent"),
    [
        (True, {"accepted": 1800}, (), False),
        (False, {"accepted": 1799}, ("ERROR 1799 of 2000 pairs sent",), False),
        (False, None, ("ERROR 0 of 2000 pairs sent",), False),
        # What was killed says nothing of the RTL; what an assertion ended does.
        (False, None, ("killed",), True),
        (False, None, ("%Error: a.sv: Assertion failed",), False),
    ],
)
def test_a_run_passes_where_it_sent_its_pairs(tmp_path, monkeypatch, passed, counts, errors, silent):
    unsent = passed or "sent" in errors[0]
    came = RunResult(RUN.settings(tmp_path), unsent, 1.0, counts, () if unsent else errors, tmp_path)
    monkeypatch.setattr(one_job, "run_and_explain", lambda _: came)
    found = one_job._perform(RUN, tmp_path, "sources", "")
    assert (found.passed, found.errors, found.silent) == (passed, errors, silent)


def test_a_run_whose_sources_were_written_to_leaves_no_result(tmp_path, monkeypatch, capsys):
    """Though they are again what they were: the simulation may have been of what was there in between."""
    dut, key = tmp_path / "dut", standing(one_job.SOURCES).valid_for.key
    shutil.copytree(DUT, dut)
    monkeypatch.setattr(one_job, "standing", lambda sources: standing(sources, dut))
    runs = []

    def perform(run, folder, sources, _):
        runs.append(run)
        if len(runs) == 1:
            file = dut / "core" / "triaxis_core.sv"
            file.write_text(file.read_text())
        return record_of(run, folder, sources, 0.0, (), True, {"checked": 1, "judged": 1})

    monkeypatch.setattr(one_job, "_perform", perform)
    words = "run --item MixedTest_w16_m0 --test MixedTest --config w16_m0 --seed 7 --pairs 1"
    folders = ["--folder", str(tmp_path / "smoke"), "--failing", str(tmp_path / "failing.json")]
    monkeypatch.setattr(sys, "argv", ["one_job", *words.split(), "--identity", key, *folders])
    assert one_job.main() == 1 and "was written to during the run" in capsys.readouterr().out
    assert not list(tmp_path.rglob("*.json"))
    assert one_job.main() == 0 and len(list((tmp_path / "smoke").rglob("*.json"))) == 1


def test_missing_tools_are_named_and_lsf_goes_through_bsub(monkeypatch, tmp_path):
    monkeypatch.setattr(dispatch, "_DVSIM", tmp_path / "dvsim")
    with pytest.raises(InputError, match="run `make regress`, which installs it"):
        dispatch.check_dvsim()
    monkeypatch.setenv("PATH", str(tmp_path))
    for kind, said in ((SLURM, "srun: not found: install Slurm's commands"), (LSF, "bsub: not found")):
        with pytest.raises(InputError, match=said):
            launcher(kind, "name", None)
    (tmp_path / "srun").symlink_to("/bin/true")
    for answer, said in (("echo all; echo down >&2; exit 1", "down; see"), ("", "no partition; see")):
        (tmp_path / "sinfo").write_text(f"#!/bin/sh\n{answer}\n")
        (tmp_path / "sinfo").chmod(0o755)
        with pytest.raises(InputError, match=f"Slurm does not answer: {said}"):
            launcher(SLURM, "name", None)
    bsub = tmp_path / "bsub"
    bsub.write_text("#!/bin/sh\n")
    bsub.chmod(0o755)
    found = launcher(LSF, "triaxis-x", 3)
    assert (found.prefix, found.jobs) == ("bsub -I -J triaxis-x", 3)
