"""The parts of a regression on their own: buckets, failing seeds, history, state, jobs."""

import subprocess
import sys
from dataclasses import replace
from datetime import UTC, datetime

import pytest

from triaxis.golden.errors import InputError
from triaxis.verif.regress import dispatch
from triaxis.verif.regress.failing import FailingSeed, FailingSeeds, buckets, few_of_each_bucket, general
from triaxis.verif.regress.history import NightlyRecord, append_record, now, read_history
from triaxis.verif.regress.launchers import LSF, SLURM, launcher
from triaxis.verif.regress.one_job import error_file
from triaxis.verif.regress.records import (
    PlannedRun,
    RunRecord,
    State,
    begin,
    previous,
    read_record,
    read_state,
    record_file,
    write_record,
    write_state,
)

RUN = PlannedRun("MixedTest_w16_m0", "MixedTest", "w16_m0", 7, 2000, "burst", 1)
PASSED = RunRecord(
    RUN, "sources", True, (), (), {"checked": 2000, "judged_by_golden_model": 2000}, 10.0, 12.0,
    "host", None, "log", "folder", "replay",
)  # fmt: skip
FAILED = replace(PASSED, passed=False, errors=("12.00ns ERROR 3 pairs accepted and never answered",))
LINE = NightlyRecord("2026-01-31T01:17:00+00:00", "nightly", None, "f" * 64, 1, True, 9, 0, None, 1.5, None)


@pytest.mark.parametrize(
    ("first", "second"),
    [
        (
            "40695.00ns ERROR    ..me/ci/verif/scoreboard.py(125) [top.env]: tag 78 where 77 was due",
            "  1.00us ERROR    ..ild/other/verif/scoreboard.py(125) [top.env]: tag 8 where 7 was due",
        ),
        ("margin 3, [[[1, -2, 3], [4, 5, 6]]]: wrong", "margin 0, [[[10, 20, 30]]]: wrong"),
        ("core says 0x0400", "core says 0xbeef"),
        ("cannot read /tmp/a/b/c.npz", "cannot read /var/c.npz"),
        ("build abcdef0123456789 gone", "build 0123456789abcdef gone"),
        ("took 3.5e-07 s", "took 12 s"),
        ("123456789 pairs sent, 123456788 seen", "7 pairs sent, 6 seen"),
        (
            "core says (False, 3, True) (0x0006), exact answer (True, None, False): margin 7, [[[1, 2",
            "core says (True, 12, False) (0xbeef), exact answer (False, 1, True): margin 0, [[[-1]]]",
        ),
    ],
)
def test_messages_that_say_the_same(first, second):
    assert general(first) == general(second)


def test_messages_that_say_something_else():
    texts = (
        "ERROR tag 78 where 77 was due",
        "ERROR 1 pairs accepted and never answered",
        "%Error: a.sv:1: x",
    )
    assert len({general(text) for text in texts}) == len(texts)


def test_a_long_message_is_cut_before_an_open_bracket():
    assert general("x" * 150 + " (one of many words)") == "x" * 150
    assert general("core says (True, 1) (0x1): margin 0, [[1]]") == "core says (..) (HEX)"


def test_a_run_without_a_result_says_nothing_of_its_seed(tmp_path):
    silent = replace(FAILED, errors=("ERROR no space left",), silent=True)
    assert buckets([silent])[0].message == "ended without a result: no space left"
    write_record(tmp_path, silent)
    assert read_record(record_file(tmp_path, RUN)) == silent
    store = FailingSeeds(tmp_path / "failing.json")
    store.note([silent])
    assert store.read() == []
    store.note([FAILED])
    (entry,) = store.read()
    store.note([silent])
    assert store.read() == [entry]
    assert store.forget() == [entry]
    assert store.read() == store.forget() == []


def test_a_few_short_seeds_stand_for_a_bucket():
    seeds = [
        FailingSeed(replace(RUN, seed=i, pairs=9000 - i), "sources", "other" if i == 4 else "many")
        for i in range(9)
    ]
    assert [seed.run.seed for seed in few_of_each_bucket(seeds)] == [4, 6, 7, 8]


def test_fullest_bucket_first():
    other = replace(FAILED, errors=("ERROR something else",))
    more = replace(FAILED, errors=("99.00ns ERROR 1 pairs accepted and never answered",))
    found = buckets([other, FAILED, PASSED, more, replace(FAILED, errors=())])
    assert [len(bucket.records) for bucket in found] == [2, 1, 1]
    assert found[0].message == "ERROR N pairs accepted and never answered"
    assert {bucket.message for bucket in found[1:]} == {"ERROR something else", "no error line"}


def test_failing_seeds_are_kept_until_they_pass_on_other_sources(tmp_path):
    store = FailingSeeds(tmp_path / "failing.json")
    store.note([PASSED])
    assert store.read() == []
    store.note([FAILED])
    store.note([FAILED])
    (entry,) = store.read()
    assert (entry.run, entry.flaky) == (RUN, False)
    # Another run leaves it alone.
    store.note([replace(PASSED, run=replace(RUN, seed=8))])
    assert store.read() == [entry]
    store.note([PASSED])
    assert store.read() == [replace(entry, flaky=True)]
    # It stays flaky where it fails once more, but not on other sources.
    store.note([FAILED])
    assert store.read()[0].flaky
    store.note([replace(FAILED, identity="other")])
    assert not store.read()[0].flaky
    store.note([PASSED])
    assert store.read() == []


def test_damaged_failing_seeds_are_not_overwritten(tmp_path):
    path = tmp_path / "failing.json"
    path.write_text('[{"run": ')
    with pytest.raises(InputError, match=r"failing\.json: damaged"):
        FailingSeeds(path).note([FAILED])
    assert path.read_text() == '[{"run": '


def test_a_cut_result_counts_as_missing(tmp_path):
    write_record(tmp_path, PASSED)
    path = record_file(tmp_path, RUN)
    assert read_record(path) == PASSED
    text = path.read_text()
    for end in (0, 1, len(text) // 2, len(text) - 3):
        path.write_text(text[:end])
        assert read_record(path) is None


def test_history_survives_a_kill_in_the_middle_of_a_line(tmp_path):
    path = tmp_path / "history" / "nightly.jsonl"
    assert read_history(path) == []
    begun = datetime(2026, 1, 31, 1, 0, tzinfo=UTC).timestamp()
    append_record(LINE, begun, path)
    # Killed after it was written, and continued: there it stands already.
    append_record(replace(LINE, date="2026-01-31T02:00:00+00:00"), begun, path)
    with path.open("a") as file:
        file.write('{"date": "2026-02-01T0')
    assert read_history(path) == [LINE]
    second = replace(LINE, date=now(), kind="signoff", coverage_percent=99.5)
    append_record(second, begun, path)
    assert read_history(path) == [LINE, second]
    # The same seed once more, another day.
    third = replace(LINE, date="2026-02-01T01:17:00+00:00")
    append_record(third, datetime(2026, 2, 1, tzinfo=UTC).timestamp(), path)
    assert read_history(path) == [LINE, second, third]


def test_only_the_same_unfinished_regression_is_continued(tmp_path):
    folder = tmp_path / "nightly"
    wanted = State("nightly", 1, 1.0, "sources", ())
    first = begin(folder, wanted, fresh=False)
    (folder / "result").write_text("kept")
    second = begin(folder, wanted, fresh=False)
    assert len(second.started) == 2 and second.started[0] == first.started[0]
    assert (folder / "result").exists()
    for changed, difference in (
        (replace(wanted, seed=2), "of seed 1"),
        (replace(wanted, identity="other"), "of other sources"),
        (replace(wanted, multiplier=2.0), "of 1 times the seeds"),
    ):
        assert not changed.continues(second)
        assert changed.differences(second) == [difference]
    # Finished, or not wanted: moved aside, where it stays readable.
    write_state(folder, replace(second, finished=True))
    third = begin(folder, wanted, fresh=False)
    assert len(third.started) == 1
    assert (previous(folder) / "result").read_text() == "kept"
    assert not (folder / "result").exists()
    assert len(begin(folder, wanted, fresh=True).started) == 1
    assert read_state(previous(folder)) == third


def test_time_between_a_kill_and_its_continuation_does_not_count():
    state = State("nightly", 1, 1.0, "sources", (100.0, 500.0))
    records = [replace(PASSED, finished=finished) for finished in (110.0, 130.0, 510.0)]
    assert state.seconds(records, now=520.0) == 30.0 + 20.0


def job(*words, folder):
    command = [sys.executable, "-m", "triaxis.verif.regress.one_job", *words, "--folder", str(folder)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_a_failed_build_leaves_its_reason(tmp_path):
    answer = job("build", "--config", "w16_m17", "--agent", "burst", folder=tmp_path)
    assert answer.returncode == 1
    assert "FAILED: margin bits 17: must be 0..16" in answer.stdout
    assert "margin bits 17" in error_file(tmp_path, "w16_m17").read_text()


def test_a_run_of_other_sources_leaves_no_result(tmp_path):
    words = ["--item", RUN.item, "--test", RUN.test, "--config", RUN.config, "--seed", "7", "--pairs", "1"]
    words += ["--failing", str(tmp_path / "failing.json"), "--identity", "other"]
    answer = job("run", *words, folder=tmp_path)
    assert answer.returncode == 1
    assert answer.stdout == "FAILED: the RTL or its environment changed during the regression\n"
    assert not list(tmp_path.rglob("*.json"))


def test_missing_tools_are_named(monkeypatch, tmp_path):
    monkeypatch.setattr(dispatch, "_DVSIM", tmp_path / "dvsim")
    with pytest.raises(InputError, match="run `make regress`, which installs it"):
        dispatch.check_dvsim()
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(InputError, match="srun: not found: install Slurm's commands"):
        launcher(SLURM, "name", None)
    with pytest.raises(InputError, match="bsub: not found"):
        launcher(LSF, "name", None)


def test_lsf_goes_through_bsub(monkeypatch, tmp_path):
    bsub = tmp_path / "bsub"
    bsub.write_text("#!/bin/sh\n")
    bsub.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
    found = launcher(LSF, "triaxis-x", 3)
    assert found.prefix == "bsub -I -J triaxis-x"
    assert found.jobs == 3
    assert found.environment()["DVSIM_BACKEND"] == "local"
