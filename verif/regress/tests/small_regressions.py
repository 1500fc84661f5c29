"""A definition of small regressions, and the command line on it, for the tests of regressions."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

from triaxis.verif.regress.definition import read_definition

TRIAXIS = Path(sys.executable).with_name("triaxis")
CONFIG = "w16_m0"
# Runs of the regression `long`.
LONG = 5


def _test(test, seeds):
    return {
        "name": f"{test}_{CONFIG}",
        "uvm_test": test,
        "build_mode": CONFIG,
        "run_opts": ["--pairs 2000", "--judged 100"],
        "reseed": seeds,
    }


def write_definition(folder, **changes):
    """Write small.hjson: regressions `good`, `short`, `long`, and `bad`, whose monitors lie."""
    good = [_test("MixedTest", 2), _test("FarTest", 1)]
    long = [_test("TouchingTest", LONG)]
    bad = [_test("DroppedResultTest", 2), _test("CorruptClaimTest", 1)]
    regressions = {"good": good, "short": good[1:], "long": long, "bad": [*good[1:], *bad]}
    content = read_definition().part(
        {
            "tests": [*good, *long, *bad],
            "regressions": [
                {"name": name, "tests": [test["name"] for test in tests]}
                for name, tests in regressions.items()
            ],
            "goals": [],
            **changes,
        }
    )
    path = folder / "small.hjson"
    path.write_text(json.dumps(content))
    return path


def command(folder, name, *options, definition="small.hjson"):
    """Return the command line of a small regression whose files are all in ``folder``."""
    words = [
        TRIAXIS,
        "regress",
        "run",
        name,
        "--definition",
        folder / definition,
        "--folder",
        folder,
        *options,
    ]
    return [str(word) for word in words]


def regress(folder, name, *options, status=0):
    """Run a small regression; return what it printed."""
    answer = subprocess.run(command(folder, name, *options), capture_output=True, text=True, check=False)
    assert answer.returncode == status, answer.stdout + answer.stderr
    return answer.stdout + answer.stderr


def start(folder, name, *options):
    """Start a small regression in the background."""
    return subprocess.Popen(
        command(folder, name, *options), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )


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


def processes_in(folder):
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
    while (left := processes_in(folder)) and time.monotonic() < limit:
        time.sleep(0.1)
    return not left


def dvsim_of(process):
    """Return the dvsim that a regression started."""
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
    assert len(children) == 1
    return int(children[0])


def kill(pid):
    """End a process as nothing can hinder."""
    os.kill(pid, signal.SIGKILL)
