"""``triaxis gate``: whether the stored sign-off allows a bitstream of the RTL as it stands."""

import argparse
import sys
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.sim.build import rtl_hash
from triaxis.sim.paths import DUT
from triaxis.verif.signoff.folder import RESULT
from triaxis.verif.signoff.gate import refusals, remarks

OPEN, REFUSED = 0, 1


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the command."""
    parser = commands.add_parser(
        "gate",
        help="say whether the stored sign-off allows a bitstream of this RTL",
        description="Refuse, with the reason, where the sign-off is missing, failed, or is of another "
        "RTL, or where a waiver that it rests on has expired or changed.",
        epilog="Exit codes: 0 allowed, 1 refused, 2 error.",
    )
    parser.add_argument(
        "--result",
        type=Path,
        default=RESULT,
        metavar="FILE",
        help="build/signoff/signoff.json",
    )
    parser.add_argument(
        "--rtl", type=Path, default=DUT, metavar="FOLDER", help="the RTL that is to be built (dut/)"
    )
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Print the answer."""
    if not options.rtl.is_dir():
        raise InputError(f"{options.rtl}: no such folder: --rtl names the folder of the RTL")
    found = refusals(options.result, rtl_hash(options.rtl))
    for line in found:
        print(f"gate: refused: {line}", file=sys.stderr)
    if not found:
        print(f"gate: open: {options.result} covers this RTL")
        for line in remarks(options.result):
            print(f"gate: note: {line}")
    return REFUSED if found else OPEN
