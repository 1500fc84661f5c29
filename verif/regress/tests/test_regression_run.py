"""Small regressions on dvsim from end to end: reports, failing seeds, kills, interrupts.

Those that must do on a cluster what they do here run on a real Slurm too, where there is one.
"""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from xml.etree import ElementTree

import pytest

from triaxis.coverage.core_coverage import core_model
from triaxis.coverage.counts import load
from triaxis.sim.configuration import Configuration
from triaxis.sim.evidence import read_evidence
from triaxis.sim.paths import BUILD
from triaxis.verif.regress.definition import as_test, read_definition
from triaxis.verif.regress.one_job import identity
from triaxis.verif.regress.records import PlannedRun, read_records

pytest.importorskip("dvsim", reason="dvsim is not installed: run `make regress`, which installs it")

# Whole regressions, with simulations.
pytestmark = [pytest.mark.regress, pytest.mark.simulator]

TRIAXIS = Path(sys.executable).with_name("triaxis")
CONFIG = "w16_m0"
# Runs of the regression `long`.
LONG = 5


def planned(test, seed=0):
    """Return a small run."""
    return PlannedRun(f"{test}_{CONFIG}", test, CONFIG, seed, 2000, "burst", 100)


def write_definition(folder, **changes):
    """Write small.hjson: regressions `good`, `short`, `long`, and `bad`, whose monitors lie."""
    regressions = {
        "good": {"MixedTest": 2, "FarTest": 1},
        "short": {"FarTest": 1},
        "long": {"TouchingTest": LONG},
        "bad": {"FarTest": 1, "DroppedResultTest": 2, "CorruptClaimTest": 1},
    }
    seeds = {test: count for used in regressions.values() for test, count in used.items()}
    tests = {test: as_test(planned(test).item, planned(test), count) for test, count in seeds.items()}
    content = {
        **read_definition().content,
        "tests": list(tests.values()),
        "regressions": [
            {"name": name, "tests": [tests[test]["name"] for test in used]}
            for name, used in regressions.items()
        ],
        "goals": [],
        **changes,
    }
    (folder / "small.hjson").write_text(json.dumps(content))


def start(folder, name, *options):
    """Start a small regression whose files are all in ``folder``."""
    words = [TRIAXIS, "regress", "run", name, "--definition", folder / "small.hjson", "--folder", folder]
    command = [str(word) for word in (*words, *options)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)


def regress(folder, name, *options, status=0):
    """Run a small regression; return what it printed."""
    process = start(folder, name, *options)
    said = process.communicate()[0]
    assert process.returncode == status, said
    return said


def results_of(folder, name):
    """Return the content of results.json."""
    return json.loads((folder / name / "results.json").read_text())


def await_results(folder, name, count, process):
    """Wait until so many runs have left their results."""
    limit = time.monotonic() + 3600
    while len(list((folder / name / "results").glob("*.json"))) < count:
        assert process.poll() is None, process.communicate()[0]
        assert time.monotonic() < limit
        time.sleep(0.02)


def _processes_in(folder):
    """Return the processes that have to do with a folder: what a regression started, but not ourselves."""
    found = []
    for entry in Path("/proc").iterdir():
        if not entry.name.isdigit() or int(entry.name) == os.getpid():
            continue
        try:
            about = (entry / "cmdline").read_bytes() + (entry / "environ").read_bytes()
            dead = (entry / "stat").read_text().rpartition(")")[2].split()[0] == "Z"
        except OSError:
            continue
        if str(folder).encode() in about and not dead:
            found.append(int(entry.name))
    return found


def await_silence(folder, seconds=60.0):
    """Return whether nothing that has to do with a folder runs any more, after some patience."""
    limit = time.monotonic() + seconds
    while (left := _processes_in(folder)) and time.monotonic() < limit:
        time.sleep(0.1)
    return not left


HOW = "verif/regress/slurm_node.sh start (as root, with Debian's slurm-wlm and munge) brings one up"


@pytest.fixture
def folder(tmp_path):
    write_definition(tmp_path)
    return tmp_path


@pytest.fixture(params=["local", "slurm"])
def place(request, tmp_path, monkeypatch):
    """Return a folder with small regressions, where a cluster's nodes see it, and the launcher."""
    path = tmp_path
    if request.param == "slurm":
        if shutil.which("sinfo") is None:
            pytest.skip(f"Slurm is not installed: {HOW}")
        own = Path(os.environ.get("TRIAXIS_SLURM", BUILD / "slurm")) / "slurm.conf"
        if "SLURM_CONF" not in os.environ and own.exists():
            monkeypatch.setenv("SLURM_CONF", str(own))
        if not output_of("sinfo", "--noheader"):
            pytest.skip(f"Slurm does not answer: {HOW}")
        path = BUILD / "slurm-tests" / re.sub(r"\W+", "_", request.node.name)
        shutil.rmtree(path, ignore_errors=True)
        path.mkdir(parents=True)
    write_definition(path)
    return path, ("--launcher", request.param)


def output_of(*command):
    return subprocess.run(command, capture_output=True, text=True, check=False).stdout.strip()


def failed_cases(folder, name, count):
    """Return the failures of a JUnit file of so many cases, each with its replay."""
    root = ElementTree.parse(folder / name / "junit.xml").getroot()
    found = {
        case: next(entry.get("value") for entry in case.iter("property") if entry.get("name") == "replay")
        for case in root.iter("testcase")
    }
    failures = [(failure, replay) for case, replay in found.items() for failure in case.iter("failure")]
    assert (root.get("tests"), root.get("failures")) == (str(count), str(len(failures)))
    return failures


def test_a_good_regression_leaves_its_reports(place, seed):
    folder, launcher = place
    said = regress(folder, "good", "--seed", seed, *launcher)
    assert f"PASSED: good, seed {seed}: 3 of 3 runs passed" in said
    folder = folder / "good"

    result = read_evidence(folder / "results.json")
    assert result is not None
    assert (result["passed"], result["problems"], result["launcher"]) == (True, [], launcher[1])
    assert result["pairs_checked"] == sum(run["pairs_checked"] for run in result["runs"]) >= 5900
    for run in result["runs"]:
        assert run["replay"] == (
            f".venv/bin/triaxis sim {run['test']} --seed {run['seed']} --config {CONFIG} --pairs 2000 "
            "--agent burst --judged 100"
        )
        if launcher[1] == "slurm":
            shown = output_of("scontrol", "show", "job", run["job"])
            assert "JobState=COMPLETED" in shown and "JobName=triaxis-good-" in shown

    # The merged coverage is the sum of that of the runs.
    model = core_model(Configuration())
    parts = [load(path, model) for path in (folder / "runs").glob("*/coverage.json")]
    assert len(parts) == 3
    for name, hits in load(folder / "coverage.json", model).hits.items():
        assert (hits == sum(part.hits[name] for part in parts)).all()
    assert failed_cases(folder.parent, "good", 3) == []

    # Opens where there is no network.
    page = (folder / "report.html").read_text()
    assert "PASSED" in page and "http" not in page and "src=" not in page
    links = re.findall(r"href='([^']+)'", page)
    assert links and all((folder / link).exists() for link in links)

    # dvsim ran each seed under its own number.
    logs = {path.parent.parent.name for path in (folder / "dvsim").glob("**/latest/run.log")}
    assert logs == {f"{run['item']}.{run['seed']}" for run in result["runs"]}


def test_failures_go_into_buckets_and_are_kept_and_replayed_first(place, seed):
    folder, launcher = place
    said = regress(folder, "bad", "--seed", seed, *launcher, status=1)
    result = results_of(folder, "bad")
    assert not result["passed"]
    assert [bucket["runs"] for bucket in result["buckets"]] == [2, 1]
    dropped, corrupt = (bucket["message"] for bucket in result["buckets"])
    assert dropped.endswith("N pairs accepted and never answered, from pair N on")
    assert "core says (..) (HEX), exact answer (..)" in corrupt
    assert f"2 x {dropped}" in said
    assert "replay: .venv/bin/triaxis sim DroppedResultTest" in said
    failures = failed_cases(folder, "bad", len(result["runs"]))
    assert len(failures) == 3
    for failure, replay in failures:
        assert failure.get("message") in (dropped, corrupt)
        assert f"replay: {replay}" in (failure.text or "")

    # Kept, and first in a regression that would not run them itself.
    kept = json.loads((folder / "failing.json").read_text())
    assert {entry["run"]["seed"] for entry in kept} == {r["seed"] for r in result["runs"] if not r["passed"]}
    said = regress(folder, "short", "--seed", seed, *launcher, status=1)
    assert "replaying 3 seeds that failed before" in said
    records = read_records(folder / "short").values()
    replayed = [record for record in records if not record.passed]
    assert (len(records), len(replayed)) == (4, 3)
    last = max(record.finished for record in replayed)
    assert all(record.started >= last for record in records if record.passed)
    assert json.loads((folder / "failing.json").read_text()) == kept


def test_a_seed_that_passes_is_fixed_or_flaky_and_can_be_forgotten(folder, seed):
    """Fixed where the sources are others than it failed on; flaky, and a failure, where they are not."""
    run = planned("FarTest", 4321)
    for sources, status, word in (("other sources", 0, "fixed"), (identity(), 1, "flaky")):
        entry = {"run": vars(run), "identity": sources, "bucket": "it failed", "flaky": False}
        (folder / "failing.json").write_text(json.dumps([entry]))
        said = regress(folder, "short", "--seed", seed, status=status)
        assert results_of(folder, "short")[word] == [run.key]
        assert word in said
        left = json.loads((folder / "failing.json").read_text())
        assert left == ([{**entry, "flaky": True}] if word == "flaky" else [])
    words = [TRIAXIS, "regress", "forget", "--folder", folder]
    said = subprocess.run(words, capture_output=True, text=True, check=True).stdout
    assert f"forgotten: FarTest in {CONFIG}, seed 4321: it failed" in said
    assert json.loads((folder / "failing.json").read_text()) == []


@pytest.mark.parametrize("victim", ["regression", "dvsim"])
def test_a_killed_regression_goes_on_with_what_is_missing(place, seed, victim):
    folder, launcher = place
    process = start(folder, "long", "--seed", seed, "--jobs", "1", *launcher)
    await_results(folder, "long", 2, process)
    (dvsim,) = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
    os.kill(process.pid if victim == "regression" else int(dvsim), signal.SIGKILL)
    said = process.communicate()[0]
    if victim == "dvsim":
        assert process.returncode == 2
        assert "dvsim was killed (signal 9): the same command goes on from here" in said
    # Nothing simulates on behind our back.
    assert await_silence(folder)
    limit = time.monotonic() + 600
    while launcher[1] == "slurm" and "triaxis-long-" in output_of("squeue", "--noheader", "--format=%j"):
        assert time.monotonic() < limit
        time.sleep(0.2)
    before = read_records(folder / "long")
    assert 2 <= len(before) < LONG
    assert all(record.passed for record in before.values())
    assert not (folder / "long" / "results.json").exists()

    # Without a seed: that of what was left.
    said = regress(folder, "long", *launcher)
    assert f"continuing: {len(before)} of {LONG} runs passed before" in said
    after = read_records(folder / "long")
    assert len(after) == LONG
    assert {key: after[key] for key in before} == before
    result = results_of(folder, "long")
    assert (result["passed"], result["seed"], result["runs_kept_from_before"]) == (True, seed, len(before))


def test_a_stop_leaves_no_process_and_is_no_failure_and_another_seed_is_another_regression(folder, seed):
    for number in (signal.SIGTERM, signal.SIGINT):
        process = start(folder, "long", "--seed", seed)
        await_results(folder, "long", len(read_records(folder / "long")) + 1, process)
        assert "a regression is running there" in regress(folder, "long", status=2)
        process.send_signal(number)
        said = process.communicate()[0]
        assert process.returncode == 130 and "interrupted" in said, said
        assert await_silence(folder, 1.0)
    assert not (folder / "failing.json").exists()
    left = read_records(folder / "long")
    assert all(record.passed for record in left.values())
    (folder / "long.previous").mkdir()
    said = regress(folder, "long", "--seed", seed + 1, "--seeds-times", "0.4")
    assert "not continued" in said
    assert len(results_of(folder, "long")["runs"]) == 2
    # The one before stays readable.
    assert read_records(folder / "long.previous") == left


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("nope", (), "regression nope: unknown"),
        ("../../zz", (), "regression ../../zz: unknown"),
        ("", (), "regression '': unknown"),
        ("good", ("--definition", "nonexistent"), "cannot read"),
        ("good", ("--folder", "small.hjson"), "small.hjson: is no folder"),
    ],
)
def test_what_cannot_be_run_leaves_nothing_behind(folder, monkeypatch, name, options, message):
    monkeypatch.chdir(folder)
    assert message in regress(folder, name, *options, status=2)
    assert [path.name for path in folder.iterdir()] == ["small.hjson"]


def test_a_build_that_dvsim_cannot_start_is_an_error(tmp_path):
    write_definition(tmp_path, build_cmd="false")
    assert "error: dvsim started no run" in regress(tmp_path, "good", status=2)
