"""``triaxis regress``: regressions on dvsim, here or on a cluster; failing pairs made small and kept."""

import argparse
import sys
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.host.cli import DONE, NO
from triaxis.host.cli.arguments import add_seed, named_folder, natural, positive
from triaxis.host.cli.terminal import print_list, progress_bar
from triaxis.sim.configuration import parse_configuration
from triaxis.sim.paths import DUT, rtl_sources
from triaxis.verif.core.failing_pairs import read_failing
from triaxis.verif.core.kept_cases import REGRESSIONS
from triaxis.verif.counterexample.explaining import PICTURES, explain
from triaxis.verif.counterexample.finding import BareCore
from triaxis.verif.regress.definition import DEFINITION, in_checkout
from triaxis.verif.regress.failing import NAME as FAILING
from triaxis.verif.regress.failing import FailingSeeds
from triaxis.verif.regress.four_state import RESULT as FOUR_STATE
from triaxis.verif.regress.four_state import plan, run_four_state, write_result
from triaxis.verif.regress.launchers import LAUNCHERS, LOCAL
from triaxis.verif.regress.outcome import Outcome
from triaxis.verif.regress.reports import JUNIT, REPORT, RESULTS
from triaxis.verif.regress.run import FOLDER, Request, regress
from triaxis.verif.results.database import keep

_SHOWN = 20
# Seeds multiplied by more than this are a mistake: a regression of months.
_MOST_SEEDS_MULTIPLIED = 1000


def add_four_state(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``regress four-state``."""
    parser.description = (
        "Run the tests on the pins in Icarus Verilog, which knows of unknown values: registers before a "
        "reset, memories before they are written, inputs that offer nothing. No output that counts may be "
        f"unknown, and every answer must be right. Some twenty minutes. Writes {in_checkout(FOUR_STATE)}."
    )
    add_seed(parser)
    parser.set_defaults(run=_four_state)


def _four_state(options: argparse.Namespace) -> int:
    with progress_bar("runs", len(plan(options.seed))) as progress:
        result = run_four_state(options.seed, progress)
    path = write_result(result, f"triaxis regress four-state --seed {options.seed}")
    print_list("FAILED:", result.problems, _SHOWN, f"all in {path}")
    print(f"{'FAILED' if result.problems else 'PASSED'}: {result.summary}, {result.seconds:.0f} s")
    print(f"written to {path}")
    return NO if result.problems else DONE


def add_run(parser: argparse.ArgumentParser) -> None:
    """Run a regression of the table of tests on dvsim: seeds that failed before first, then the rest. One
    that was interrupted or killed is continued by the same command: what passed on the same sources and
    with the same seed is not run again. Writes results.json, report.html, junit.xml and the merged
    coverage into build/regress/NAME/. Seeds that failed are kept in build/regress/failing.json until they
    pass on other sources; smoke replays at most three of each kind of failure, nightly all of them.
    """
    parser.add_argument(
        "regression", metavar="NAME", nargs="?", default="smoke", help="smoke or nightly (smoke)"
    )
    parser.add_argument("--launcher", choices=LAUNCHERS, default=LOCAL, help="where runs go (local)")
    parser.add_argument(
        "--seed", type=natural,
        help="what all seeds follow from (1; nightly: the date; continued: that of what is continued)",
    )  # fmt: skip
    parser.add_argument("--jobs", type=positive, metavar="N", help="runs at a time (local: one a core)")
    parser.add_argument("--fresh", action="store_true", help="start anew, continue nothing")
    parser.add_argument(
        "--seeds-times", type=float, default=1.0, metavar="X",
        help="run X times as many seeds of each test, at least one: 5 for a weekend (1)",
    )  # fmt: skip
    parser.add_argument(
        "--definition", type=Path, default=DEFINITION, metavar="FILE.hjson", help="another file"
    )
    _add_folder(parser)
    parser.set_defaults(run=_run)


def _add_folder(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--folder", type=named_folder, default=FOLDER, metavar="DIR",
        help="where all is written; a cluster's nodes must share it (build/regress)",
    )  # fmt: skip


def _request(options: argparse.Namespace) -> Request:
    if not 0 < options.seeds_times <= _MOST_SEEDS_MULTIPLIED:
        limits = f"must be above 0, and at most {_MOST_SEEDS_MULTIPLIED}"
        raise InputError(f"seeds-times {options.seeds_times}: {limits}")
    return Request(
        regression=options.regression,
        seed=options.seed,
        multiplier=options.seeds_times,
        launcher=options.launcher,
        jobs=options.jobs,
        fresh=options.fresh,
        definition=options.definition.resolve(),
        folder=options.folder.resolve(),
    )


def _run(options: argparse.Namespace) -> int:
    request = _request(options)
    outcome = regress(request, lambda line: print(line, flush=True), progress_bar)
    if request.is_usual:
        keep(outcome.folder / RESULTS)
    _print(outcome)
    return NO if outcome.problems else DONE


def add_forget(parser: argparse.ArgumentParser) -> None:
    """Forget all seeds that failed before, those found flaky too, and say which."""
    _add_folder(parser)
    parser.set_defaults(run=_forget)


def _forget(options: argparse.Namespace) -> int:
    failing = options.folder.resolve() / FAILING
    forgotten = FailingSeeds(failing).forget() if failing.exists() else []
    for seed in forgotten:
        print(f"forgotten: {seed.run}: {seed.bucket}")
    print(f"{len(forgotten)} failing seeds forgotten, none is left in {in_checkout(failing)}")
    return DONE


def _print(outcome: Outcome) -> None:
    for message, records in outcome.buckets.items():
        first = records[0]
        print(f"{len(records)} x {message}")
        for line in (*first.errors[:1], *first.counterexamples[:1]):
            print(f"  {line}")
        print(f"  log:    {first.log}\n  replay: {first.replay}")
    for seed in outcome.fixed:
        print(f"fixed: {seed.run} failed before and passes")
    print_list("PROBLEM", outcome.shortfalls, _SHOWN, f"all in {RESULTS}")
    print(f"{'FAILED' if outcome.problems else 'PASSED'}: {outcome.summary}")
    files = ", ".join((RESULTS, REPORT, JUNIT, "coverage.html"))
    print(f"written to {in_checkout(outcome.folder)}: {files}")


def add_shrink(parser: argparse.ArgumentParser) -> None:
    """Look for the smallest pair that still fails in the same way, for each pair of the file that the
    scoreboard left, on the bare core; where a pair fails only after others, for the shortest sequence.
    Each is drawn, and kept so that later runs send it first.
    """
    parser.add_argument("failing", type=Path, metavar="FAILING.npz", help="failing_pairs.npz of a run")
    parser.add_argument(
        "--config", default="w16_m0", metavar="NAME",
        help="w<width>_m<margin bits>[_t<tag bits>][_no_edge_box][_ungated] (w16_m0)",
    )  # fmt: skip
    parser.add_argument("--dut", type=Path, default=DUT, metavar="FOLDER", help="folder of the RTL (dut)")
    parser.add_argument(
        "--keep", action=argparse.BooleanOptionalAction, default=True,
        help="keep what is found as regression cases",
    )  # fmt: skip
    parser.add_argument(
        "--store",
        type=Path,
        default=REGRESSIONS,
        metavar="FOLDER",
        help="where to keep them (verif/core/kept)",
    )
    parser.add_argument("--fault", default="", metavar="TEXT", help="what the fault was, for the cases kept")
    parser.add_argument(
        "--pictures",
        type=Path,
        default=PICTURES,
        metavar="FOLDER",
        help="where to draw (build/counterexamples)",
    )
    parser.add_argument("--svg", action="store_true", help="draw as SVG instead of PNG")
    parser.set_defaults(run=_shrink)


def _shrink(options: argparse.Namespace) -> int:
    configuration = parse_configuration(options.config)
    failing = read_failing(options.failing, configuration)
    _check_rtl(options.dut)
    core = BareCore(configuration, options.dut.resolve())
    store, ending = options.store if options.keep else None, ".svg" if options.svg else ".png"
    shrunk = 0
    for number, found in enumerate(explain(core, failing, options.pictures, store, options.fault, ending)):
        print("\n  ".join([f"pair {number}", *found.lines()]), flush=True)
        shrunk += found.counterexample is not None
    if shrunk:
        return DONE
    print(f"none of {len(failing)} pairs fails on the bare core {configuration.name}", file=sys.stderr)
    return NO


def _check_rtl(dut: Path) -> None:
    """Raise InputError unless the folder has the files that make a core."""
    missing = [source.name for source in rtl_sources() if not (dut / source.relative_to(DUT)).is_file()]
    if missing:
        raise InputError(f"{dut}: no {missing[0]}: must hold the files that dut/core/triaxis.f lists")
