"""A small regression on a real Slurm, where there is one: see verif/regress/slurm_node.sh."""

import json
import os
import re
import shutil
import signal
import subprocess
import time
from pathlib import Path

import pytest

pytest.importorskip("dvsim", reason="dvsim is not installed: run `make regress`, which installs it")

from triaxis.sim.paths import BUILD
from triaxis.verif.regress.records import read_records
from triaxis.verif.regress.tests.small_regressions import (
    LONG,
    await_results,
    await_silence,
    regress,
    results_of,
    start,
    write_definition,
)

pytestmark = [pytest.mark.regress, pytest.mark.simulator]

_HOW = "verif/regress/slurm_node.sh start (as root, with Debian's slurm-wlm and munge) brings one up"


@pytest.fixture
def folder(request, monkeypatch):
    """Return a folder with small regressions, where a cluster's nodes see it; skip where no Slurm answers."""
    if shutil.which("sinfo") is None:
        pytest.skip(f"Slurm is not installed: {_HOW}")
    own = Path(os.environ.get("TRIAXIS_SLURM", BUILD / "slurm")) / "slurm.conf"
    if "SLURM_CONF" not in os.environ and own.exists():
        monkeypatch.setenv("SLURM_CONF", str(own))
    answer = subprocess.run(["sinfo", "--noheader"], capture_output=True, text=True, check=False)
    if answer.returncode or not answer.stdout.strip():
        pytest.skip(f"Slurm does not answer: {_HOW}")
    path = BUILD / "slurm-tests" / re.sub(r"\W+", "_", request.node.name)
    shutil.rmtree(path, ignore_errors=True)
    path.mkdir(parents=True)
    write_definition(path)
    return path


def queue():
    """Return the names of the jobs that Slurm runs or keeps waiting."""
    answer = subprocess.run(
        ["squeue", "--noheader", "--format=%j"], capture_output=True, text=True, check=True
    )
    return answer.stdout.split()


def test_runs_are_jobs_of_slurm(folder, seed):
    said = regress(folder, "good", "--launcher", "slurm", "--seed", seed)
    assert "3 of 3 runs passed" in said
    result = results_of(folder, "good")
    assert result["launcher"] == "slurm"
    jobs = [run["job"] for run in result["runs"]]
    assert len(set(jobs)) == 3
    for job in jobs:
        shown = subprocess.run(["scontrol", "show", "job", job], capture_output=True, text=True, check=True)
        assert "JobState=COMPLETED" in shown.stdout
        assert "JobName=triaxis-good-" in shown.stdout


def test_a_failure_there_is_a_failure_here(folder, seed):
    regress(folder, "bad", "--launcher", "slurm", "--seed", seed, status=1)
    result = results_of(folder, "bad")
    assert [bucket["runs"] for bucket in result["buckets"]] == [2, 1]
    assert len(json.loads((folder / "failing.json").read_text())) == 3
    assert all(run["job"] for run in result["runs"])


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_stopped_jobs_end_and_the_rest_is_run_later(folder, seed, number):
    process = start(folder, "long", "--launcher", "slurm", "--seed", seed, "--jobs", "1")
    await_results(folder, "long", 2, process)
    process.send_signal(number)
    process.communicate()
    assert process.returncode == (130 if number == signal.SIGINT else -signal.SIGKILL)
    assert await_silence(folder)
    limit = time.monotonic() + 600
    while any(name.startswith("triaxis-long-") for name in queue()) and time.monotonic() < limit:
        time.sleep(0.2)
    assert not any(name.startswith("triaxis-long-") for name in queue())
    before = read_records(folder / "long")
    said = regress(folder, "long", "--launcher", "slurm")
    assert f"continuing: {len(before)} of {LONG} runs passed before" in said
    assert results_of(folder, "long")["passed"]
