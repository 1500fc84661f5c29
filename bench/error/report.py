"""``triaxis bench error``: what is demanded, and what is told."""

import argparse
import os
import platform
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

from rich.table import Table

from triaxis.bench import harness
from triaxis.bench.error.plot import figure_of
from triaxis.bench.error.points import CLOCK_NS, MODES, NO_MISS, WIDTHS, CorePoint, Errors, PeerPoint
from triaxis.bench.error.running import Benchmark, Measured, WorkloadResult
from triaxis.bench.harness import Findings, report, told
from triaxis.host.cli.arguments import add_seed
from triaxis.host.cli.terminal import progress_bar, table

# How many times the bulk checker's time a pair CGAL's exact kernel must take at least, over all workloads.
LEAST_TIMES_BULK = 2.0
# What it installs from; in this order, since calls from Python blur the first steps of its kernel.
CGAL = ("libcgal-dev", "cgal")

# Of the bulk checker's widths: those of the two arithmetics, and the widest.
_SHOWN = (16, 24, WIDTHS[-1])
_RATES = ("missed_share", "false_alarm_share")
_SHARES = "missed: of those that collide; alarms: of the others"


@dataclass(frozen=True)
class Demand:
    """Something that must be so, what was found, and whether it is so; None: not measured."""

    what: str
    found: str
    reached: bool | None

    @property
    def verdict(self) -> str:
        """Return it for a table."""
        return "NOT MEASURED" if self.reached is None else "reached" if self.reached else "MISSED"


def demands(measured: Measured) -> list[Demand]:
    """Return what must be so."""
    points = [point for result in measured.results for point in result.core]
    safe = [point for point in points if point.mode == NO_MISS]
    missed, pairs = sum(p.errors.missed for p in safe), sum(p.errors.colliding for p in safe)
    beyond = sum(point.beyond_band for point in points)
    alarms = sum(point.errors.false_alarms for point in points)
    differs, sampled = sum(p.rtl_differs for p in points), sum(p.sampled for p in points)
    exact = [point for point in points if point.unchanged and point.mode != NO_MISS]
    wrong = sum(point.errors.missed + point.errors.false_alarms for point in exact)
    bulk = [point for result in measured.results for point in result.bulk]
    unproven = sum(point.unproven + point.differs for point in bulk)
    return [
        Demand("no-miss mode misses nothing", f"{missed} of {pairs:,}", missed == 0 and pairs > 0),
        Demand(
            "false alarms within m + 1 resolutions",
            f"{beyond} of {alarms:,} beyond; farthest {_farthest(points)}",
            beyond == 0 and alarms > 0,
        ),
        Demand(
            "no error where nothing is rounded",
            f"{wrong} of {sum(point.errors.pairs for point in exact):,}",
            wrong == 0 if exact else None,
        ),
        Demand(
            "RTL as the bulk checker, on samples",
            f"{differs} of {sampled:,} differ",
            differs == 0 and sampled > 0,
        ),
        Demand("one pair a clock", _cycles(points), all(p.cycles_per_pair == 1 for p in points)),
        Demand(
            "bulk checker's axes prove what they claim",
            f"{unproven} of {sum(point.clear for point in bulk):,} do not",
            unproven == 0,
        ),
        _against_cgal(measured.results),
    ]


def _farthest(points: Iterable[CorePoint]) -> str:
    by_margin: dict[int, float] = {}
    for point in points:
        by_margin[point.margin] = max(point.farthest, by_margin.get(point.margin, 0.0))
    return ", ".join(f"{far:.3f} at m = {margin}" for margin, far in sorted(by_margin.items()))


def _cycles(points: Iterable[CorePoint]) -> str:
    cycles = {point.cycles_per_pair for point in points}
    return f"{', '.join(f'{count:g}' for count in sorted(cycles))} clock a pair"


def _against_cgal(results: list[WorkloadResult]) -> Demand:
    """Return the demand on CGAL, over all workloads alike: in C++ where that is there, else by its wheel."""
    what = f"CGAL's exact kernel takes {LEAST_TIMES_BULK:g} times the bulk checker's time or more"
    for name in CGAL:
        points = [point for result in results for point in result.peers if point.distribution == name]
        if not points:
            continue
        kernel, bulk = sum(p.kernel_ns for p in points), sum(p.bulk_ns for p in points)
        each = ", ".join(f"{point.times_bulk:.1f}" for point in points)
        mean = f"{kernel / len(points):.0f} to {bulk / len(points):.0f} ns"
        found = f"{points[0].name}: {kernel / bulk:.1f} times, {mean}; by workload {each}"
        return Demand(what, found, kernel >= LEAST_TIMES_BULK * bulk)
    return Demand(what, "CGAL is not installed", None)


def add_error(parser: argparse.ArgumentParser) -> None:
    """Ask whether pairs of float32 triangles collide: the core at eight widths, in collision mode and in
    no-miss mode, the bulk checker, the golden model, and those of python-fcl, coal, CGAL, libigl, VTK,
    Open3D and trimesh that are installed (`make peers`; CGAL also by its C++ headers, Debian:
    libcgal-dev). Compare with exact rational verdicts. Writes build/bench/error.json, error.png and
    error.svg. A run that was interrupted goes on with the same command.
    """
    add_seed(parser, "what the pairs follow from")
    parser.set_defaults(
        run=lambda options: report(harness.FOLDER / "error.json", partial(_measured, options.seed))
    )


def _measured(seed: int) -> Findings:
    benchmark = Benchmark(seed)
    if not benchmark.real_meshes:
        print("real meshes: no folder $TRIAXIS_DATA or ../shared/data: our own solids take their place")
    with progress_bar("runs of the benchmark", benchmark.steps) as progress:
        return findings(benchmark.run(progress))


def findings(measured: Measured) -> Findings:
    """Return what is told; what was not measured is no problem."""
    found = demands(measured)
    content = {
        "not_measured": [demand.what for demand in found if demand.reached is None],
        "seed": measured.seed,
        "real_meshes": measured.real_meshes,
        # Times are those of this machine.
        "processor": _processor(),
        "load_average": round(os.getloadavg()[1], 2),
        "steps_of_an_interrupted_run": measured.taken_up,
        "demands": [asdict(demand) for demand in found],
        "units": "times: nanoseconds of processor time a pair; shares: of colliding pairs missed, of clear "
        "pairs called near",
        "core": {"clock_ns": CLOCK_NS, "cycles_per_pair": 1, "dsp48e1": _dsps(measured)},
        "peers_absent": measured.absent,
        "workloads": {result.workload.name: _workload(result) for result in measured.results},
    }
    taken_up = f"{measured.taken_up} steps were taken over from an interrupted run"
    return Findings(
        f"triaxis bench error --seed {measured.seed}",
        "; ".join(f"{demand.what}: {demand.found}" for demand in found[:2]),
        [f"{demand.what}: {demand.found}" for demand in found if demand.reached is False],
        content,
        [_core_table(measured), _software_table(measured), _demand_table(found)],
        {"error": lambda: figure_of(measured)},
        [taken_up] if measured.taken_up else [],
    )


def _processor() -> str:
    """Return what Linux calls the processor, or else its kind."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    names = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return f"{next(names, platform.machine())}, {os.cpu_count()} cores"


def _dsps(measured: Measured) -> dict[str, dict[str, int]]:
    modes = sorted({mode for _, mode in measured.dsps})
    return {mode: {str(width): measured.dsps[width, mode] for width in WIDTHS} for mode in modes}


def _workload(result: WorkloadResult) -> dict[str, Any]:
    return {
        "pairs": len(result.workload),
        "colliding": result.colliding,
        "parts": {part.source: len(part) for part in result.workload.parts},
        "core": [{**asdict(p), "errors": told(p.errors, *_RATES)} for p in result.core],
        "bulk": [asdict(point) for point in result.bulk],
        "golden_ns": result.golden_ns,
        "peers": [
            {**told(p, "kernel_ns", "times_bulk"), "errors": told(p.errors, *_RATES)} for p in result.peers
        ],
    }


def _shares(errors: Errors) -> str:
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
    for mode in MODES:
        for width in WIDTHS:
            points = [p for r in measured.results for p in r.core if (p.width, p.mode) == (width, mode)]
            shares = (_shares(point.errors) for point in points)
            rows.add_row(str(width), mode, str(measured.dsps[width, mode]), *shares)
        rows.add_section()
    return rows


def _software_table(measured: Measured) -> Table:
    title = f"software, one thread, kernel's time without calls; {_SHARES}"
    workloads = (f"{result.workload.name}: ns, missed, alarms" for result in measured.results)
    rows = table(title, ("what", "call, ns", *workloads))
    for mode in MODES:
        for width in _SHOWN:
            cells: list[str] = []
            for result in measured.results:
                time_ns = next(p.claims_ns for p in result.bulk if (p.width, p.mode) == (width, mode))
                errors = next(p.errors for p in result.core if (p.width, p.mode) == (width, mode))
                cells.append(f"{time_ns:,.0f}  {_shares(errors)}")
            rows.add_row(f"bulk, {mode}, W = {width}", "", *cells)
    rows.add_row("golden model: the truth", "", *(f"{r.golden_ns:,.0f}  0  0" for r in measured.results))
    rows.add_section()
    for points in zip(*(result.peers for result in measured.results), strict=True):
        calls = [point.overhead_ns for point in points]
        rows.add_row(
            f"{points[0].name} {points[0].version}",
            f"{min(calls):,.0f}..{max(calls):,.0f}",
            *(f"{_kernel(point)}  {_shares(point.errors)}" for point in points),
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
