"""A definition of small regressions, and the command line on it, for the tests of regressions."""

import json
import os
import subprocess
import sys
import time
from pathlib import Path

from triaxis.verif.regress.definition import as_test, read_definition
from triaxis.verif.regress.records import PlannedRun

TRIAXIS = Path(sys.executable).with_name("triaxis")
CONFIG = "w16_m0"
# Runs of the regression `long`.
LONG = 5


def planned(test, seed=0):
    """Return a small run."""
    return PlannedRun(f"{test}_{CONFIG}", test, CONFIG, seed, 2000, "burst", 100)


def write_definition(folder, **changes):
    """Write small.hjson: regressions `good`, `short`, `long`, and `bad`, whose monitors lie."""
    seeds = {
        "MixedTest": 2,
        "FarTest": 1,
        "TouchingTest": LONG,
        "DroppedResultTest": 2,
        "CorruptClaimTest": 1,
    }
    tests = {test: as_test(planned(test).item, planned(test), count) for test, count in seeds.items()}
    regressions = {
        "good": ("MixedTest", "FarTest"),
        "short": ("FarTest",),
        "long": ("TouchingTest",),
        "bad": ("FarTest", "DroppedResultTest", "CorruptClaimTest"),
    }
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
