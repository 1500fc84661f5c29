"""What dvsim starts for each job, here or elsewhere: ``build`` a configuration, or ``run`` a test once.

Exit codes: 0 built or passed, 1 failed. A run writes its result at once; the reason of a failed build is left
in a file too, for the report.
"""

import argparse
import re
import sys
import time
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from filelock import FileLock

from triaxis.golden.errors import InputError
from triaxis.golden.outputs import make_folder, write_whole
from triaxis.sim.validity import Sources, standing, validity
from triaxis.verif.counterexample.explaining import run_and_explain
from triaxis.verif.regress.failing import FailingSeeds
from triaxis.verif.regress.records import (
    PlannedRun,
    RunRecord,
    read_record,
    record_file,
    record_of,
    write_record,
)
from triaxis.verif.testbench.settings import BURST, PIN, TEST_DATA, TEST_MODULES
from triaxis.verif.testbench.simulation import RunResult, build_for, run_settings
from triaxis.verif.testbench.waves import WAVES, check_waves

SOURCES = Sources(("triaxis.verif.regress.one_job", *TEST_MODULES), TEST_DATA)
# Stands for whatever the checkout holds: dvsim called by hand, without `triaxis regress run`.
ANY = "any"
# Tests send whole groups: some pairs less than they were asked for.
_LEAST_SENT = 0.9
# An error of the RTL or of the environment; a simulator that was killed logs none.
_BLAME = re.compile("ERROR|CRITICAL|%Error|Error:")


def identity() -> str:
    """Return what results of runs are valid for, in short."""
    return validity(SOURCES).key


def error_file(folder: Path, config: str) -> Path:
    """Return where the reason of a failed build is left."""
    return folder / "builds" / f"{config}.error"


def unsent(result: RunResult) -> str:
    """Return that a run sent too few of the pairs that it was asked for; "" where it did not."""
    sent, wanted = result.counts["accepted"] if result.counts else 0, result.settings.pairs
    return f"{sent} of {wanted} pairs sent" if sent < _LEAST_SENT * wanted else ""


def left_nothing(counts: Mapping[str, Any] | None, errors: Iterable[str]) -> bool:
    """Return whether a run that failed left no result of its own, which says nothing of its seed."""
    return counts is None and not any(map(_BLAME.search, errors))


def _build(options: argparse.Namespace) -> int:
    """Build the simulators of a configuration, for the agents that need them."""
    failed = error_file(options.folder, options.config)
    failed.unlink(missing_ok=True)
    try:
        for agent in options.agent:
            build_for(run_settings("build", options.config, 1, 1, agent=agent))
    except InputError as error:
        write_whole(failed, f"{error}\n")
        print(f"FAILED: {error}")
        return 1
    print("BUILD DONE")
    return 0


def _perform(run: PlannedRun, folder: Path, sources: str, waves: str) -> RunRecord:
    """Run the simulation; whatever hinders it makes a failed run."""
    started = time.time()
    try:
        settings = replace(run.settings(folder), waves=waves)
        if waves:
            check_waves(waves, run.agent, settings.simulator)
        result = run_and_explain(settings)
    except InputError as error:
        return record_of(run, folder, sources, started, (f"ERROR {error}",), silent=True)
    errors, counts = result.errors, result.counts
    if result.passed and (told := unsent(result)):
        errors = (f"ERROR {told}",)
    passed = result.passed and not errors
    silent = not passed and left_nothing(counts, errors)
    found = result.counterexamples
    shown = "" if passed else result.waves_command
    return record_of(run, folder, sources, started, errors, passed, counts, found, silent, waves=shown)


def _run(options: argparse.Namespace) -> int:
    """Run once, unless the same run has passed meanwhile."""
    named = ("item", "test", "config", "seed", "pairs", "agent", "judged")
    run = PlannedRun(*(getattr(options, name) for name in named))
    path, before = record_file(options.folder, run), standing(SOURCES)
    sources = before.valid_for.key
    if options.identity not in (ANY, sources):
        # No result: it would be of neither the one nor the other.
        print("FAILED: the RTL or its environment changed during the regression")
        return 1
    make_folder(path.parent)
    # A run that outlived the regression that started it may still be at work in the same folder.
    with FileLock(path.with_name(f"{run.key}.lock")):
        record = read_record(path)
        if record is None or not record.passed or record.identity != sources:
            waves = "" if options.waves == "none" or run.agent != PIN else options.waves
            if options.waves != "none" and not waves:
                print("no waves: they are of runs on the pins, and this one is in bursts")
            record = _perform(run, options.folder, sources, waves)
            if not before.stands:
                print("FAILED: ERROR the RTL or its environment was written to during the run")
                return 1
            # First, so that no kill comes between a result and its being kept.
            FailingSeeds(options.failing).note(record)
            write_record(options.folder, record)
    for line in record.errors[:1]:
        print(f"FAILED: {line}")
    for line in (*record.errors[1:], *record.counterexamples):
        print(f"  {line}")
    print(f"log: {record.log}")
    if record.waves:
        print(f"waves: {record.waves}")
    print(f"replay: {record.replay}")
    if record.passed:
        print(f"TEST PASSED: {record.checked} pairs checked")
    return 0 if record.passed else 1


def main() -> int:
    """Do the job."""
    parser = argparse.ArgumentParser(description=__doc__)
    jobs = parser.add_subparsers(required=True)
    build = jobs.add_parser("build")
    build.add_argument("--config", required=True)
    build.add_argument("--number", help="tells dvsim that builds of other names are others")
    build.add_argument("--folder", type=Path, required=True, help="where the reason of a failure goes")
    build.add_argument("--agent", choices=(PIN, BURST), action="append", required=True)
    build.set_defaults(do=_build)
    run = jobs.add_parser("run")
    run.add_argument("--item", required=True, help="name of the test in the Hjson file")
    run.add_argument("--test", required=True, help="name of the UVM test")
    run.add_argument("--config", required=True)
    run.add_argument("--seed", type=int, required=True)
    run.add_argument("--folder", type=Path, required=True, help="where results and runs go")
    run.add_argument("--failing", type=Path, required=True, help="where failing seeds are kept")
    run.add_argument("--identity", default=ANY, help="the sources that the result is to be of")
    run.add_argument("--pairs", type=int, required=True)
    run.add_argument("--agent", choices=(PIN, BURST), default=BURST)
    run.add_argument("--judged", type=int, default=1)
    run.add_argument("--waves", choices=("none", *WAVES), default="none", help="of a run on the pins")
    run.set_defaults(do=_run)
    options = parser.parse_args()
    return options.do(options)


if __name__ == "__main__":
    sys.exit(main())
