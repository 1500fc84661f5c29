"""``triaxis shrink``: failing pairs made small, drawn, and kept as regression cases."""

import argparse
import sys
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.sim.configuration import parse_configuration
from triaxis.sim.paths import DUT, rtl_sources
from triaxis.verif.core.kept_cases import REGRESSIONS
from triaxis.verif.counterexample.bare_core import BareCore
from triaxis.verif.counterexample.explaining import PICTURES, explain
from triaxis.verif.counterexample.failing import read_failing

SHRUNK, NONE_FAILS = 0, 1


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the command."""
    parser = commands.add_parser(
        "shrink",
        help="make failing pairs small, draw them, keep them as regression cases",
        description="Look for the smallest pair that still fails in the same way, for each pair of the "
        "file that the scoreboard left, on the bare core; where a pair fails only after others, for the "
        "shortest sequence. Each is drawn, and kept so that later runs send it first.",
        epilog="Exit codes: 0 shrunk, 1 no pair fails on the bare core, 2 error.",
    )
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
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Shrink every pair of the file and print before and after."""
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
        return SHRUNK
    print(f"none of {len(failing)} pairs fails on the bare core {configuration.name}", file=sys.stderr)
    return NONE_FAILS


def _check_rtl(dut: Path) -> None:
    """Raise InputError unless the folder has the files that make a core."""
    missing = [source.name for source in rtl_sources(dut) if not source.is_file()]
    if missing:
        raise InputError(f"{dut}: no {missing[0]}: must hold the files that dut/core/triaxis.f lists")
