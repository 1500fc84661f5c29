"""``triaxis coverage``: the testplan, code coverage of dut/, stored coverage for other tools."""

import argparse
import json
from collections import Counter
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from triaxis.coverage.code_counters import Point
from triaxis.coverage.counts import CoverageDatabase
from triaxis.coverage.html import write_page
from triaxis.coverage.interchange.lcov import read_code, write_lcov
from triaxis.coverage.interchange.reqif import write_reqif
from triaxis.coverage.interchange.ucis_xml import TestRecord, write_ucis
from triaxis.coverage.report import report
from triaxis.coverage.testplan import RUNS, TESTPLAN, Testplan, Testpoint, read_testplan
from triaxis.coverage.testplan_lint import Inventory
from triaxis.coverage.waivers import WAIVERS, confirm_waivers
from triaxis.golden.errors import InputError
from triaxis.golden.input_file import read_input
from triaxis.host.cli import DONE, NO
from triaxis.host.cli.arguments import add_seed, positive
from triaxis.host.cli.terminal import print_list, progress_bar, table
from triaxis.sim.build import rtl_hash
from triaxis.sim.evidence import read_evidence
from triaxis.sim.paths import BUILD, ROOT
from triaxis.verif.code_coverage.run import COUNTERS, PAIRS, RESULT, STEPS, CodeCoverage, measure, write_json
from triaxis.verif.regress.coverage_models import model_named
from triaxis.verif.regress.definition import in_checkout
from triaxis.verif.signoff.plan import FOLDER
from triaxis.verif.signoff.testplan import check_plan, inventory

LCOV = BUILD / "coverage" / "triaxis.info"
UCIS = BUILD / "coverage" / "triaxis.ucis.xml"
PAGE = BUILD / "coverage" / "functional.html"
REQIF = BUILD / "coverage" / "triaxis.reqif"
COVERAGE = FOLDER / "coverage.json"
# Beside counts of functional coverage: what they were counted on.
_SIGNOFF = "signoff.json"
_MEASURE = "run `triaxis coverage code`"
_SIGN_OFF = "run `make signoff`"
# Bins that are printed; the JSON file has all.
_SHOWN = 40


def add_plan(parser: argparse.ArgumentParser) -> None:
    """Print each testpoint with its stage, what runs for it, and how many coverage bins, assertions and
    mutants it owns; then everything that the linter refuses.
    """
    parser.add_argument("plan", nargs="?", type=Path, default=TESTPLAN, help="the testplan (the project's)")
    parser.set_defaults(run=_plan)


def _plan(options: argparse.Namespace) -> int:
    plan, problems = check_plan(options.plan)
    known = inventory()
    Console(width=140).print(_testpoints(plan, known))
    sizes = (
        f"{len(known.tests)} tests, {len(known.proofs)} proofs, {len(known.faults)} faults, "
        f"{len(known.checks)} checks, {sum(map(len, known.bins.values()))} bins in {len(known.bins)} "
        f"configurations, {len(known.assertions)} assertions, {len(known.mutants)} mutants"
    )
    print(f"{len(plan.requirements)} requirements, {len(plan.testpoints)} testpoints; {sizes}")
    print_list("PROBLEM", problems)
    print("REFUSED" if problems else "clean: nothing unknown, nothing without a testpoint")
    return NO if problems else DONE


def _testpoints(plan: Testplan, known: Inventory) -> Table:
    headings = ("stage", "testpoint", "what runs", "bins", "assertions", "mutants")
    testpoints = table(f"testplan {plan.name}", headings, text=3)
    for testpoint in sorted(plan.testpoints, key=lambda testpoint: testpoint.stage):
        testpoints.add_row(
            testpoint.stage,
            testpoint.name,
            _runs(testpoint),
            str(_bin_count(testpoint, known)),
            *(str(len(known.owned(testpoint, kind))) for kind in ("assertions", "mutants")),
        )
    return testpoints


def _runs(testpoint: Testpoint) -> str:
    lines = [f"{kind}: {', '.join(testpoint.entries(kind))}" for kind in RUNS if testpoint.entries(kind)]
    return "\n".join(lines)


def _bin_count(testpoint: Testpoint, known: Inventory) -> int:
    """Return how many bins with goals it owns, over all configurations."""
    owned = known.owned(testpoint, "bins")
    return sum(len(owned & bins) for bins in known.bins.values())


def add_code(parser: argparse.ArgumentParser) -> None:
    """Run the environment's tests on builds with coverage counters, and set what was not hit against
    coverage/waivers.toml. Writes build/coverage/code.json.
    """
    add_seed(parser)
    told = f"of the test of all families, on each core ({PAIRS}); of others in proportion"
    parser.add_argument("--pairs", type=positive, default=PAIRS, help=told)
    parser.add_argument(
        "--confirm-waivers", action="store_true",
        help="measure nothing: write into coverage/waivers.toml that all reasons were read again and hold",
    )  # fmt: skip
    parser.set_defaults(run=_code)


def _code(options: argparse.Namespace) -> int:
    if options.confirm_waivers:
        print(f"{confirm_waivers()} waivers confirmed for the RTL as it is: commit {WAIVERS}")
        return DONE
    with progress_bar("code coverage", STEPS) as progress:
        result = measure(options.seed, options.pairs, progress=progress)
    path = write_json(result, options.seed, pairs=options.pairs)
    _print_code(result)
    print(f"written to {path}")
    return DONE if result.passed else NO


def _print_code(result: CodeCoverage) -> None:
    console = Console(width=110)
    console.print(_totals(result))
    categories = Counter(waiver.category for waiver in result.waivers)
    named = ", ".join(f"{count} {category}" for category, count in categories.items())
    print(f"{len(result.waivers)} waivers: {named}")
    for run in result.runs:
        print(f"{run.model}: {run.test}: {run.checked} checked, {run.wrong} wrong, {run.seconds:.0f} s")
    all_of_them = "all in the JSON file"
    print_list("NOT COVERED", [str(bin_) for bin_ in result.assessment.uncovered], _SHOWN, all_of_them)
    print_list("PROBLEM", result.problems, _SHOWN, all_of_them)
    print(f"{'PASSED' if result.passed else 'FAILED'}: code coverage, {result.seconds:.0f} s")


def _totals(result: CodeCoverage) -> Table:
    headings = ("bins", "hit", "waived", "total", "covered")
    totals = table("code coverage of dut/, each instance by itself", headings)
    for kind, total in result.assessment.totals.items():
        percent = "none" if total.percent is None else f"{total.percent:.2f} %"
        totals.add_row(kind, str(total.hit), str(total.waived), str(total.total), percent)
    return totals


def add_page(parser: argparse.ArgumentParser) -> None:
    """Add up the functional coverage of runs, and write every bin with its count, goal and exclusion as a
    page; print how many of each model are hit.
    """
    parser.add_argument(
        "runs", nargs="+", type=Path, metavar="RUN",
        help="folders of runs, as in build/runs/, or their coverage.json",
    )  # fmt: skip
    parser.add_argument("--out", type=Path, metavar="FILE.html", default=PAGE, help=f"({in_checkout(PAGE)})")
    parser.set_defaults(run=_page)


def _page(options: argparse.Namespace) -> int:
    files = [run / COVERAGE.name if run.is_dir() else run for run in options.runs]
    for file in files:
        if not file.exists():
            raise InputError(f"{file}: no such file: a run that passed leaves it, `triaxis sim` for one")
    database = _added_up(files)
    write_page(options.out, database)
    for model, counts in database:
        found = report(model, counts)
        print(f"{model.name}: {found.hit} of {found.total} bins")
    print(f"written to {options.out}")
    return DONE


def add_export(parser: argparse.ArgumentParser) -> None:
    """Write line and branch coverage of the last `triaxis coverage code` as an lcov tracefile (for
    genhtml, in the checkout), and functional coverage of the last sign-off together with it as UCIS XML
    (for pyucis); requirements and testpoints as ReqIF. Without options all of them, in build/coverage/;
    with --lcov, --ucis, --reqif those alone.
    """
    parser.add_argument("--lcov", type=Path, metavar="FILE", help="the tracefile to write")
    parser.add_argument("--ucis", type=Path, metavar="FILE", help="the UCIS XML file to write")
    parser.add_argument("--reqif", type=Path, metavar="FILE", help="the ReqIF file to write")
    parser.add_argument(
        "--from",
        dest="sources",
        type=Path,
        nargs="+",
        default=[COVERAGE],
        metavar="FILE",
        help="counts of functional coverage, each with its signoff.json beside it; several are added up "
        "(build/signoff/coverage.json)",
    )
    parser.set_defaults(run=_export)


@dataclass(frozen=True)
class _Measured:
    """A measurement of code coverage: its counters by the name of the build, and the record of it."""

    counters: dict[str, Path]
    record: TestRecord


def _export(options: argparse.Namespace) -> int:
    every = options.lcov is None and options.ucis is None and options.reqif is None
    lcov: Path | None = LCOV if every else options.lcov
    ucis: Path | None = UCIS if every else options.ucis
    reqif: Path | None = REQIF if every else options.reqif
    here = rtl_hash()
    # All that can be wrong with what is stored comes before the first file.
    functional = _functional(options.sources, here) if ucis else None
    code = _measured(here) if lcov or (ucis and RESULT.exists()) else None
    if ucis and functional:
        database, records = functional
        points: dict[str, dict[Point, int]] = {}
        if code:
            points = {name: read_code(path, ROOT) for name, path in code.counters.items()}
            records.append(code.record)
        else:
            print(f"without code coverage: none is stored ({_MEASURE})")
        print(f"written to {write_ucis(ucis, database, points, records)}")
    if lcov and code:
        print(f"written to {write_lcov(lcov, code.counters.values(), ROOT)}")
    if reqif:
        changed = datetime.fromtimestamp(TESTPLAN.stat().st_mtime, UTC)
        print(f"written to {write_reqif(reqif, read_testplan(), changed)}")
    return DONE


def _evidence(path: Path, here: str, remedy: str) -> dict[str, Any]:
    """Return a stored result; raise InputError where there is none, or it is of another RTL."""
    content = read_evidence(path)
    if content is None:
        raise InputError(f"{path}: no such file: {remedy} first")
    if not all(isinstance(content[name], str) for name in ("rtl_hash", "command")):
        raise InputError(f"{path}: rtl_hash and command must be texts: {remedy} again")
    if content["rtl_hash"] != here:
        raise InputError(
            f"{path}: is of another RTL ({content['rtl_hash'][:12]}, here {here[:12]}): {remedy}"
        )
    return content


def _record(name: str, content: dict[str, Any]) -> TestRecord:
    return TestRecord(name, content["passed"] is True, content["command"], content.get("seed"))


def _measured(here: str) -> _Measured:
    content = _evidence(RESULT, here, _MEASURE)
    try:
        counters = {run["model"]: COUNTERS / f"{run['model']}.dat" for run in content["runs"]}
    except (KeyError, TypeError):
        counters = {}
    if not counters:
        raise InputError(f"{RESULT}: names no runs: {_MEASURE} again")
    for path in counters.values():
        if not path.exists():
            raise InputError(f"{path}: no such file: {_MEASURE} again")
        if path.stat().st_mtime > RESULT.stat().st_mtime:
            raise InputError(
                f"{path}: newer than {RESULT.name}, so of a run that did not end: {_MEASURE} again"
            )
    return _Measured(counters, _record("code coverage", content))


def _functional(sources: list[Path], here: str) -> tuple[CoverageDatabase, list[TestRecord]]:
    records: list[TestRecord] = []
    for path in sources:
        if not path.exists():
            raise InputError(f"{path}: no such file: {_SIGN_OFF} first")
        records.append(_record("sign-off", _evidence(path.with_name(_SIGNOFF), here, _SIGN_OFF)))
    return _added_up(sources), records


def _added_up(files: list[Path]) -> CoverageDatabase:
    """Return the counts in files together; InputError where one is named twice."""
    counts = Counter(path.resolve() for path in files)
    if again := [path for path, count in counts.items() if count > 1]:
        raise InputError(f"{again[0]}: named twice: each run counts once")
    names = dict.fromkeys(name for path in files for name in _model_names(path))
    database = CoverageDatabase(map(model_named, names))
    for path in files:
        database.add_file(path)
    return database


def _model_names(path: Path) -> list[str]:
    data = read_input(path)
    try:
        names = [model["model"] for model in json.loads(data)["models"]]
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise InputError(f"{path}: not a coverage file: what wrote it has to be run again") from error
    if not names or not all(isinstance(name, str) for name in names):
        raise InputError(f"{path}: counts of no model: what wrote it has to be run again")
    return names
