"""``triaxis bench``: run time a pair against error, of the core, its reference and other packages."""

import argparse
import time

from rich.console import Console
from rich.table import Table

from triaxis.bench.error.core_points import CLOCK_NS, COLLISION, NO_MISS, WIDTHS
from triaxis.bench.error.errors import Errors
from triaxis.bench.error.peer_points import PeerPoint
from triaxis.bench.error.plot import draw
from triaxis.bench.error.report import Demand, demands, passed, write_report
from triaxis.bench.error.running import Benchmark, Measured
from triaxis.host.cli.progress import progress_bar
from triaxis.sim.provenance import provenance

REACHED, MISSED = 0, 1
# Of the bulk checker's widths: those of the two arithmetics, and the widest.
_SHOWN = (16, 24, WIDTHS[-1])
_WIDTH = 170
_SHARES = "missed: of those that collide; alarms: of the others"


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the command."""
    parser = commands.add_parser(
        "bench",
        help="measure run time against error, also of other packages",
        description="Ask whether pairs of float32 triangles collide: the core at eight widths, in collision "
        "mode and in no-miss mode, the bulk checker, the golden model, and those of python-fcl, coal, CGAL, "
        "libigl, VTK, Open3D and trimesh that are installed (`make peers`; CGAL also by its C++ headers, "
        "Debian: libcgal-dev). Compare with exact rational verdicts. Writes build/bench/error.json, "
        "error.png and error.svg. A run that was interrupted goes on with the same command.",
        epilog="Exit codes: 0 everything demanded is reached, 1 something is not, 2 error.",
    )
    parser.add_argument("--seed", type=int, default=1, help="what the pairs follow from (1)")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Measure, print, write."""
    started, before = time.monotonic(), provenance()
    benchmark = Benchmark(options.seed, before)
    if not benchmark.real_meshes:
        print("real meshes: no folder $TRIAXIS_DATA or ../shared/data: our own solids take their place")
    with progress_bar("bench", benchmark.steps) as progress:
        measured = benchmark.run(progress)
    found = demands(measured)
    path = write_report(measured, found, before, time.monotonic() - started)
    pictures = draw(measured)
    console = Console(width=_WIDTH)
    console.print(_core_table(measured))
    console.print(_software_table(measured))
    console.print(_demand_table(found))
    if measured.taken_up:
        print(f"{measured.taken_up} steps were those of a run that was interrupted")
    print(f"written to {path}, {', '.join(picture.name for picture in pictures)}")
    return REACHED if passed(found) else MISSED


def _errors(errors: Errors) -> str:
    return f"{_percent(errors.missed_share)}  {_percent(errors.false_alarm_share)}"


def _kernel(point: PeerPoint) -> str:
    most = point.most_kernel_ns
    return f"{point.kernel_ns:,.0f}" if most is None else f"<{most:,.0f}"


def _percent(share: float) -> str:
    return "0" if share == 0 else f"{100 * share:.2f} %"


def _table(title: str, headings: tuple[str, ...], measured: Measured, each: str) -> Table:
    table = Table(title=title)
    for number, heading in enumerate(headings):
        table.add_column(heading, justify="left" if number == 0 else "right")
    for result in measured.results:
        table.add_column(f"{result.workload.name}: {each}", justify="right")
    return table


def _core_table(measured: Measured) -> Table:
    title = f"core: one pair a clock, {CLOCK_NS:g} ns at 100 MHz; {_SHARES}"
    table = _table(title, ("W", "mode", "DSP48E1"), measured, "missed, alarms")
    for mode in (COLLISION, NO_MISS):
        for width in WIDTHS:
            points = [p for r in measured.results for p in r.core if (p.width, p.mode) == (width, mode)]
            shares = (_errors(point.errors) for point in points)
            table.add_row(str(width), mode, str(measured.dsps[width, mode]), *shares)
        table.add_section()
    return table


def _software_table(measured: Measured) -> Table:
    title = f"software, one thread, kernel's time without calls; {_SHARES}"
    table = _table(title, ("what", "call, ns"), measured, "ns, missed, alarms")
    for mode in (COLLISION, NO_MISS):
        for width in _SHOWN:
            cells: list[str] = []
            for result in measured.results:
                time_ns = next(p.claims_ns for p in result.bulk if (p.width, p.mode) == (width, mode))
                errors = next(p.errors for p in result.core if (p.width, p.mode) == (width, mode))
                cells.append(f"{time_ns:,.0f}  {_errors(errors)}")
            table.add_row(f"bulk, {mode}, W = {width}", "", *cells)
    table.add_row("golden model: the truth", "", *(f"{r.golden_ns:,.0f}  0  0" for r in measured.results))
    table.add_section()
    for points in zip(*(result.peers for result in measured.results), strict=True):
        calls = [point.overhead_ns for point in points]
        table.add_row(
            f"{points[0].name} {points[0].version}",
            f"{min(calls):,.0f}..{max(calls):,.0f}",
            *(f"{_kernel(point)}  {_errors(point.errors)}" for point in points),
        )
    for name, reason in measured.absent.items():
        table.add_row(name, "-", *["absent" for _ in measured.results])
        table.caption = f"{table.caption or ''}{reason}\n"
    return table


def _demand_table(found: list[Demand]) -> Table:
    table = Table(title="demanded")
    for heading in ("what", "found", ""):
        table.add_column(heading)
    for demand in found:
        table.add_row(demand.what, demand.found, demand.verdict)
    return table
