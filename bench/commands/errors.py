"""``triaxis bench error`` and ``stress``: wrong answers, of the core, its reference and other packages."""

import argparse
import time

from rich.console import Console
from rich.table import Table

from triaxis.bench.error import plot as error_plot
from triaxis.bench.error.points import CLOCK_NS, COLLISION, NO_MISS, WIDTHS, Errors
from triaxis.bench.error.report import Demand, demands, passed, write_report
from triaxis.bench.error.running import Benchmark, Measured
from triaxis.bench.error.software_points import PeerPoint
from triaxis.bench.harness import SOURCES
from triaxis.bench.stress import plot as stress_plot
from triaxis.bench.stress.measuring import ROUNDING_WIDTH
from triaxis.bench.stress.orders import METHODS
from triaxis.bench.stress.run import (
    PAIRS,
    RESULT,
    STEPS,
    FamilyResult,
    StressResult,
    check_options,
    run_stress,
    summary,
    write_numbers,
)
from triaxis.host.cli import DONE, NO
from triaxis.host.cli.arguments import add_seed
from triaxis.host.cli.terminal import print_list, progress_bar, table
from triaxis.sim.validity import provenance

# Of the bulk checker's widths: those of the two arithmetics, and the widest.
_SHOWN = (16, 24, WIDTHS[-1])
_WIDTH = 170
_SHARES = "missed: of those that collide; alarms: of the others"
# From this share of wrong answers on, a method is said to fail.
_FAILS = 0.001


def add_error(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``bench error``."""
    parser.description = (
        "Ask whether pairs of float32 triangles collide: the core at eight widths, in collision mode and in "
        "no-miss mode, the bulk checker, the golden model, and those of python-fcl, coal, CGAL, libigl, VTK, "
        "Open3D and trimesh that are installed (`make peers`; CGAL also by its C++ headers, Debian: "
        "libcgal-dev). Compare with exact rational verdicts. Writes build/bench/error.json, error.png and "
        "error.svg. A run that was interrupted goes on with the same command."
    )
    add_seed(parser, "what the pairs follow from")
    parser.set_defaults(run=_error)


def _error(options: argparse.Namespace) -> int:
    started, before = time.monotonic(), provenance(SOURCES)
    benchmark = Benchmark(options.seed, before)
    if not benchmark.real_meshes:
        print("real meshes: no folder $TRIAXIS_DATA or ../shared/data: our own solids take their place")
    with progress_bar("bench", benchmark.steps) as progress:
        measured = benchmark.run(progress)
    found = demands(measured)
    path = write_report(measured, found, before, time.monotonic() - started)
    pictures = error_plot.draw(measured)
    console = Console(width=_WIDTH)
    console.print(_core_table(measured))
    console.print(_software_table(measured))
    console.print(_demand_table(found))
    if measured.taken_up:
        print(f"{measured.taken_up} steps were taken over from an interrupted run")
    print(f"written to {path}, {', '.join(picture.name for picture in pictures)}")
    return DONE if passed(found) else NO


def _errors(errors: Errors) -> str:
    return f"{_percent(errors.missed_share)}  {_percent(errors.false_alarm_share)}"


def _kernel(point: PeerPoint) -> str:
    most = point.most_kernel_ns
    return f"{point.kernel_ns:,.0f}" if most is None else f"<{most:,.0f}"


def _percent(share: float) -> str:
    return "0" if share == 0 else f"{100 * share:.2f} %"


def _core_table(measured: Measured) -> Table:
    title = f"core: one pair a clock, {CLOCK_NS:g} ns at 100 MHz; {_SHARES}"
    workloads = (f"{result.workload.name}: missed, alarms" for result in measured.results)
    rows = table(title, ("W", "mode", "DSP48E1", *workloads))
    for mode in (COLLISION, NO_MISS):
        for width in WIDTHS:
            points = [p for r in measured.results for p in r.core if (p.width, p.mode) == (width, mode)]
            shares = (_errors(point.errors) for point in points)
            rows.add_row(str(width), mode, str(measured.dsps[width, mode]), *shares)
        rows.add_section()
    return rows


def _software_table(measured: Measured) -> Table:
    title = f"software, one thread, kernel's time without calls; {_SHARES}"
    workloads = (f"{result.workload.name}: ns, missed, alarms" for result in measured.results)
    rows = table(title, ("what", "call, ns", *workloads))
    for mode in (COLLISION, NO_MISS):
        for width in _SHOWN:
            cells: list[str] = []
            for result in measured.results:
                time_ns = next(p.claims_ns for p in result.bulk if (p.width, p.mode) == (width, mode))
                errors = next(p.errors for p in result.core if (p.width, p.mode) == (width, mode))
                cells.append(f"{time_ns:,.0f}  {_errors(errors)}")
            rows.add_row(f"bulk, {mode}, W = {width}", "", *cells)
    rows.add_row("golden model: the truth", "", *(f"{r.golden_ns:,.0f}  0  0" for r in measured.results))
    rows.add_section()
    for points in zip(*(result.peers for result in measured.results), strict=True):
        calls = [point.overhead_ns for point in points]
        rows.add_row(
            f"{points[0].name} {points[0].version}",
            f"{min(calls):,.0f}..{max(calls):,.0f}",
            *(f"{_kernel(point)}  {_errors(point.errors)}" for point in points),
        )
    for name, reason in measured.absent.items():
        rows.add_row(name, "-", *["absent" for _ in measured.results])
        rows.caption = f"{rows.caption or ''}{reason}\n"
    return rows


def _demand_table(found: list[Demand]) -> Table:
    rows = table("demanded", ("what", "found", ""), text=3)
    for demand in found:
        rows.add_row(demand.what, demand.found, demand.verdict)
    return rows


def add_stress(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``bench stress``."""
    parser.description = (
        "Families of pairs with one knob each, turned from easy to impossible: the core as simulated, its "
        "no-miss mode, and three published tests in float32 and float64, in all 72 orders of each pair, "
        f"against exact verdicts. Rounded pairs are for {ROUNDING_WIDTH} bits. Writes "
        "build/bench/stress.json, and pictures of errors, of order-dependence and of rounding."
    )
    add_seed(parser)
    parser.add_argument(
        "--pairs", type=int, default=PAIRS, metavar="N", help=f"pairs at each setting ({PAIRS})"
    )
    parser.set_defaults(run=_stress)


def _stress(options: argparse.Namespace) -> int:
    check_options(options.seed, options.pairs)
    with progress_bar("cores and settings", STEPS) as progress:
        result = run_stress(options.seed, options.pairs, progress)
    console = Console(width=150)
    console.print(_wrong_answers(result))
    console.print(_core_answers(result))
    print_list("PROBLEM", result.problems)
    verdict = "FAILED" if result.problems else "PASSED"
    print(f"{verdict}: {summary(result)}, {result.seconds:.0f} s")
    for path in (write_numbers(result), *stress_plot.draw(result, RESULT.parent)):
        print(f"written to {path}")
    return NO if result.problems else DONE


def _wrong_answers(result: StressResult) -> Table:
    title = f"wrong answers: the most at any setting, and from which setting on ({_FAILS:.1%})"
    rows = table(title, ("family", *(method.name for method in METHODS)))
    for family in result.families:
        rows.add_row(family.family.name, *(_method_cell(family, method.name) for method in METHODS))
    return rows


def _method_cell(result: FamilyResult, name: str) -> str:
    rates = [measured.methods[name].rate for measured in result.measured]
    first = next((k for k, rate in enumerate(rates) if rate >= _FAILS), None)
    if first is None:
        return f"{max(rates):.2%}"
    return f"{max(rates):.0%} from {result.family.settings[first].label}"


def _core_answers(result: StressResult) -> Table:
    headings = ("family", "answers", "wrong", "no-miss: answers", "missed", "false alarms", "farthest (LSB)")
    rows = table(f"the core: as simulated, and its no-miss mode at {ROUNDING_WIDTH} bits", headings)
    for family in result.families:
        core, no_miss = family.core, family.no_miss
        rows.add_row(
            family.family.name,
            f"{core.answers:,}",
            f"{core.wrong}",
            f"{no_miss.answers:,}",
            f"{no_miss.misses}",
            f"{no_miss.false_alarms / no_miss.answers:.1%}",
            f"{max(measured.farthest for measured in family.measured):.2f} of 2",
        )
    return rows
