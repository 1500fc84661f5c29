"""``triaxis bitstream``: a bitstream of the Nexys 4 DDR, for RTL that is signed off and for no other."""

import argparse
import sys
from collections.abc import Mapping
from pathlib import Path

from triaxis.bench.activity.measuring import RESULT as ACTIVITY
from triaxis.bench.activity.measuring import SAIF
from triaxis.fpga.bitstream import (
    Provenance,
    board_hash,
    build_id,
    file_hash,
    manifest_path,
    remove_bitstream,
    write_bitstream,
)
from triaxis.fpga.board_build import BoardParameters, Inputs, board_sources
from triaxis.fpga.vivado_run import STAGES, RefusedError, find_vivado, run_vivado
from triaxis.host.cli.progress import progress_bar
from triaxis.sim.build import rtl_hash
from triaxis.sim.evidence import read_evidence
from triaxis.sim.paths import BUILD, DUT
from triaxis.verif.signoff.folder import RESULT
from triaxis.verif.signoff.gate import refusals

WRITTEN, REFUSED = 0, 1
BITSTREAM = BUILD / "fpga" / "nexys4ddr.bit"
REPORTS = BUILD / "fpga" / "vivado"


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the command."""
    parser = commands.add_parser(
        "bitstream",
        help="build the board's bitstream with Vivado, if the sign-off allows it",
        description="Ask the gate, then build with Vivado, which must be on PATH. Writes "
        "build/fpga/nexys4ddr.bit with a manifest; reports stay in build/fpga/vivado/. The power report "
        "uses the simulated activity of `triaxis activity` where there is one of the same RTL. Whatever "
        "happens, an older bitstream is removed first.",
        epilog="Exit codes: 0 written, 1 refused: by the gate, or for timing, routing or critical warnings; "
        "2 error.",
    )
    parser.add_argument(
        "--result", type=Path, default=RESULT, metavar="FILE", help="build/signoff/signoff.json"
    )
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Ask the gate, build, write."""
    remove_bitstream(BITSTREAM)
    before = _provenance(options.result)
    if isinstance(before, list):
        return _refused(before)
    vivado = find_vivado()
    inputs = Inputs(
        tuple(board_sources(DUT)),
        (DUT / "core", DUT / "mesh", DUT / "board"),
        BoardParameters().generics(build_id(before.rtl_hash, before.board_hash)),
        _activity(before.rtl_hash),
    )
    try:
        with progress_bar("Vivado", len(STAGES)) as progress:
            built = run_vivado(vivado, inputs, REPORTS, progress)
    except RefusedError as error:
        print(f"bitstream: refused: {error}", file=sys.stderr)
        return REFUSED
    # Hours may have passed: what was built must be what the gate saw, and still be allowed.
    after = _provenance(options.result)
    if isinstance(after, list):
        return _refused(after)
    if after != before:
        print(
            "bitstream: refused: RTL, scripts or sign-off changed during the build: build again",
            file=sys.stderr,
        )
        return REFUSED
    write_bitstream(BITSTREAM, built, inputs, before)
    _print(built.figures, inputs)
    return WRITTEN


def _provenance(result: Path) -> Provenance | list[str]:
    """Return what a bitstream may be built on, or why none may."""
    rtl = rtl_hash()
    found = refusals(result, rtl)
    return found or Provenance(rtl, board_hash(), result, file_hash(result))


def _activity(rtl: str) -> Path | None:
    """Return the simulated activity, where there is one of this RTL."""
    evidence = read_evidence(ACTIVITY)
    return SAIF if SAIF.is_file() and evidence and evidence["rtl_hash"] == rtl else None


def _refused(lines: list[str]) -> int:
    for line in lines:
        print(f"gate: refused: {line}", file=sys.stderr)
    return REFUSED


def _print(figures: Mapping[str, float], inputs: Inputs) -> None:
    for name, value in figures.items():
        print(f"{name}: {value:g}")
    if inputs.activity is None:
        print("power: estimated without simulated activity of this RTL: run `make activity` first")
    print(f"written to {BITSTREAM}, {manifest_path(BITSTREAM).name}; reports in {REPORTS}")
