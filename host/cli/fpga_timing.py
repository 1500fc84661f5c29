"""``triaxis fpga-timing``: the core routed on an ECP5, as a proxy for its timing on the board's part."""

import argparse

from rich.console import Console
from rich.table import Table

from triaxis.fpga.ecp5_flow import PART, STAGES, TARGET_MHZ, nextpnr_version, route
from triaxis.fpga.ecp5_registers import Absorbed
from triaxis.fpga.timing import Timing, read_timing, write_timing
from triaxis.host.cli.progress import progress_bar
from triaxis.sim.build import rtl_hash
from triaxis.sim.paths import BUILD, rtl_sources
from triaxis.sim.programs import yosys_version

REACHED, MISSED = 0, 1
_WIDTH = 16
_FOLDER = BUILD / "fpga" / "timing"


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the command."""
    parser = commands.add_parser(
        "fpga-timing",
        help="route the core on an ECP5: frequency and critical path",
        description=f"Place and route the core at W = {_WIDTH}, M = 0 on an {PART} with open tools, as a "
        "proxy for its timing; takes many minutes. Writes build/fpga/timing.json.",
        epilog=f"Exit codes: 0 at least {TARGET_MHZ:g} MHz, 1 less, 2 error.",
    )
    parser.add_argument("--seed", type=int, default=1, help="of the placement (default: 1)")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Route, print, write."""
    tool = f"{yosys_version().split('(')[0].strip()}, {nextpnr_version()}"
    parameters = {"W": _WIDTH, "M": 0}
    sources = [source for source in rtl_sources() if source.name != "CollisionDetector.sv"]
    with progress_bar("timing", len(STAGES)) as progress:
        routed = route(sources, parameters, _FOLDER, progress, seed=options.seed)
    timing = read_timing(routed.report)
    path = BUILD / "fpga" / "timing.json"
    write_timing(path, timing, routed.absorbed, parameters, rtl_hash(), tool)
    _print(timing, routed.absorbed)
    print(f"written to {path}")
    return REACHED if timing.reached else MISSED


def _print(timing: Timing, absorbed: Absorbed) -> None:
    console = Console(width=110)
    table = Table(title=f"critical path, {PART}, routed")
    for heading in ("wire", "ns on it", "cells behind it", "ns in them", "ns so far"):
        table.add_column(heading, justify="left" if heading == "wire" else "right", overflow="fold")
    total = 0.0
    for hop in timing.path.hops:
        total += hop.routing_ns + hop.logic_ns
        table.add_row(
            hop.net or f"(register {timing.path.start})",
            f"{hop.routing_ns:.2f}",
            str(hop.cells),
            f"{hop.logic_ns:.2f}",
            f"{total:.2f}",
        )
    table.add_row(f"(register {timing.path.end})", "", "", "", f"{total:.2f}")
    console.print(table)
    print(f"logic {timing.path.logic_ns:.2f} ns, routing {timing.path.routing_ns:.2f} ns")
    for kind, used in timing.used.items():
        print(f"{kind}: {used} of {timing.available[kind]}")
    print(
        f"blocks with registers before / behind: {absorbed.before} / {absorbed.behind} of {absorbed.blocks}"
    )
    verdict = "reached" if timing.reached else "MISSED"
    print(f"{timing.mhz:.1f} MHz, at least {TARGET_MHZ:g}: {verdict}")
