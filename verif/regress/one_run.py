"""What dvsim starts for each run, here or on another machine: simulates, and writes the result at once.

Exit codes: 0 passed, 1 failed.
"""

import argparse
import os
import re
import socket
import sys
import time
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.sim.file_lock import locked
from triaxis.verif.counterexample.explaining import run_and_explain
from triaxis.verif.regress.failing import FailingSeeds
from triaxis.verif.regress.identity import identity
from triaxis.verif.regress.planned_run import PlannedRun, add_options
from triaxis.verif.regress.run_record import RunRecord, read_record, record_file, write_record
from triaxis.verif.testbench.simulation import RunResult

# Stands for whatever the checkout holds: dvsim called by hand, without `triaxis regress run`.
ANY = "any"
# Tests send whole groups: some pairs less than they were asked for.
_MOST_OF = 0.9
# An error of the RTL or of the environment; a simulator that was killed logs none.
_BLAME = re.compile("ERROR|CRITICAL|%Error|Error:")


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--item", required=True, help="name of the test in the Hjson file")
    parser.add_argument("--test", required=True, help="name of the UVM test")
    parser.add_argument("--config", required=True)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--folder", type=Path, required=True, help="where results and runs go")
    parser.add_argument("--failing", type=Path, required=True, help="where failing seeds are kept")
    parser.add_argument("--identity", default=ANY, help="the sources that the result is to be of")
    add_options(parser)
    return parser.parse_args()


def _too_few(run: PlannedRun, result: RunResult) -> tuple[str, ...]:
    """Return what is wrong with a run that passed on less than it was asked for."""
    accepted = int(result.counts["accepted"]) if result.counts else 0
    if result.passed and accepted < _MOST_OF * run.pairs:
        return (f"ERROR {accepted} of {run.pairs} pairs sent",)
    return ()


def _perform(run: PlannedRun, folder: Path, sources: str) -> RunRecord:
    """Run the simulation; whatever hinders it makes a failed run."""
    settings = run.settings(folder / "runs" / run.key)
    log = Path(settings.folder) / "simulation.log"
    started = time.time()
    counts, found, errors, silent = None, (), (), False
    try:
        result = run_and_explain(settings)
        errors = result.errors + _too_few(run, result)
        counts, found = result.counts, result.counterexamples
        passed = result.passed and not errors
        silent = not passed and counts is None and not any(map(_BLAME.search, errors))
    except InputError as error:
        passed, errors, silent = False, (f"ERROR {error}",), True
    return RunRecord(
        run,
        sources,
        passed,
        errors,
        found,
        counts,
        started,
        time.time(),
        socket.gethostname(),
        os.environ.get("SLURM_JOB_ID") or os.environ.get("LSB_JOBID"),
        str(log),
        settings.folder,
        settings.replay_command,
        silent,
    )


def main() -> int:
    """Run once, unless the same run has passed meanwhile."""
    options = _options()
    run = PlannedRun(
        options.item,
        options.test,
        options.config,
        options.seed,
        options.pairs,
        options.agent,
        options.judged,
    )
    results, sources = options.folder / "results", identity()
    if options.identity not in (ANY, sources):
        # No result: it would be of neither the one nor the other.
        print("FAILED: the RTL or its environment changed during the regression")
        return 1
    # A run that outlived the regression that started it may still be at work in the same folder.
    with locked(results / f"{run.key}.lock"):
        record = read_record(record_file(results, run))
        if record is None or not record.passed or record.identity != sources:
            record = _perform(run, options.folder, sources)
            # First, so that no kill comes between a result and its being kept.
            FailingSeeds(options.failing).note([record])
            write_record(results, record)
    for line in record.errors[:1]:
        print(f"FAILED: {line}")
    for line in (*record.errors[1:], *record.counterexamples):
        print(f"  {line}")
    print(f"log: {record.log}\nreplay: {record.replay}")
    if record.passed:
        print(f"TEST PASSED: {record.checked} pairs checked")
    return 0 if record.passed else 1


if __name__ == "__main__":
    sys.exit(main())
