"""What the benchmark demands, and what it leaves: build/bench/error.json."""

import os
import platform
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from triaxis.bench import harness
from triaxis.bench.error.points import CLOCK_NS, NO_MISS, WIDTHS, CorePoint, Errors
from triaxis.bench.error.running import Measured, WorkloadResult
from triaxis.sim.validity import Provenance

RESULT = harness.FOLDER / "error.json"
# How many times the bulk checker's time a pair CGAL's exact kernel must take at least, over all workloads.
LEAST_TIMES_BULK = 2.0
# What it installs from; in this order, since calls from Python blur the first steps of its kernel.
CGAL = ("libcgal-dev", "cgal")


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


def passed(found: Iterable[Demand]) -> bool:
    """Return whether nothing was missed; what was not measured is not."""
    return all(demand.reached is not False for demand in found)


def write_report(measured: Measured, found: list[Demand], before: Provenance, seconds: float) -> Path:
    """Write build/bench/error.json, whole or not at all. ``before``: the checkout's state before the run."""
    missed = [demand for demand in found if demand.reached is False]
    not_measured = [demand.what for demand in found if demand.reached is None]
    content = {
        "not_measured": not_measured,
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
    return harness.write_result(
        RESULT,
        f"triaxis bench error --seed {measured.seed}",
        [f"{demand.what}: {demand.found}" for demand in missed],
        "; ".join(f"{demand.what}: {demand.found}" for demand in found[:2]),
        seconds,
        content,
        before,
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
        "core": [{**asdict(p), "errors": _errors(p.errors)} for p in result.core],
        "bulk": [asdict(point) for point in result.bulk],
        "golden_ns": result.golden_ns,
        "peers": [
            {**asdict(p), "errors": _errors(p.errors), "kernel_ns": p.kernel_ns, "times_bulk": p.times_bulk}
            for p in result.peers
        ],
    }


def _errors(errors: Errors) -> Mapping[str, Any]:
    shares = {"missed_share": errors.missed_share, "false_alarm_share": errors.false_alarm_share}
    return {**asdict(errors), **shares}
