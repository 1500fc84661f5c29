"""``triaxis export``: stored coverage for other tools, an lcov tracefile and UCIS XML."""

import argparse
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from triaxis.coverage.database import CoverageDatabase
from triaxis.coverage.interchange.code_points import CodePoint, read_code_points
from triaxis.coverage.interchange.lcov import write_lcov
from triaxis.coverage.interchange.ucis_xml import TestRecord, write_ucis
from triaxis.golden.errors import InputError
from triaxis.golden.input_file import read_input
from triaxis.sim.build import rtl_hash
from triaxis.sim.paths import BUILD, ROOT
from triaxis.verif.code_coverage.run import COUNTERS, RESULT
from triaxis.verif.regress.coverage_models import model_named
from triaxis.verif.signoff.folder import FOLDER

LCOV = BUILD / "coverage" / "triaxis.info"
UCIS = BUILD / "coverage" / "triaxis.ucis.xml"
COVERAGE = FOLDER / "coverage.json"
# Beside counts of functional coverage: what they were counted on.
_SIGNOFF = "signoff.json"
_MEASURE = "run `triaxis code-coverage`"
_SIGN_OFF = "run `make signoff`"
_NEEDED = ("rtl_hash", "passed", "command")
_MODEL = "core_"


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the command."""
    parser = commands.add_parser(
        "export",
        help="write stored coverage as an lcov tracefile and as UCIS XML",
        description="Write line and branch coverage of the last `triaxis code-coverage` as an lcov tracefile "
        "(for genhtml, in the checkout), and functional coverage of the last sign-off together with it as "
        "UCIS XML (for pyucis). Without --lcov and --ucis, both, in build/coverage/; with one of them, "
        "that one alone.",
        epilog="Exit codes: 0 written, 2 error.",
    )
    parser.add_argument("--lcov", type=Path, metavar="FILE", help="the tracefile to write")
    parser.add_argument("--ucis", type=Path, metavar="FILE", help="the UCIS XML file to write")
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
    parser.set_defaults(run=run)


@dataclass(frozen=True)
class _Code:
    """A measurement of code coverage: its counters by the name of the build, and the record of it."""

    counters: dict[str, Path]
    record: TestRecord


def run(options: argparse.Namespace) -> int:
    """Write what is asked for and say where it is."""
    both = options.lcov is None and options.ucis is None
    lcov: Path | None = LCOV if both else options.lcov
    ucis: Path | None = UCIS if both else options.ucis
    here = rtl_hash()
    # All that can be wrong with what is stored comes before the first file.
    functional = _functional(options.sources, here) if ucis else None
    code = _measured(here) if lcov or RESULT.exists() else None
    if ucis and functional:
        database, records = functional
        points: dict[str, list[CodePoint]] = {}
        if code:
            points = {name: read_code_points(path, ROOT) for name, path in code.counters.items()}
            records.append(code.record)
        else:
            print(f"without code coverage: none is stored ({_MEASURE})")
        print(f"written to {write_ucis(ucis, database, points, records)}")
    if lcov and code:
        print(f"written to {write_lcov(lcov, code.counters.values(), ROOT)}")
    return 0


def _evidence(path: Path, here: str, remedy: str) -> dict[str, Any]:
    """Return a stored result; raise InputError where there is none, or it is of another RTL."""
    if not path.exists():
        raise InputError(f"{path}: no such file: {remedy} first")
    data = read_input(path)
    try:
        content = json.loads(data)
    except ValueError as error:
        raise InputError(f"{path}: not readable: {remedy} again") from error
    if not isinstance(content, dict) or any(key not in content for key in _NEEDED):
        raise InputError(f"{path}: does not say {', '.join(_NEEDED)}: {remedy} again")
    if content["rtl_hash"] != here:
        raise InputError(
            f"{path}: is of another RTL ({content['rtl_hash'][:12]}, here {here[:12]}): {remedy}"
        )
    return content


def _record(name: str, content: dict[str, Any]) -> TestRecord:
    return TestRecord(name, content["passed"] is True, content["command"], content.get("seed"))


def _measured(here: str) -> _Code:
    content = _evidence(RESULT, here, _MEASURE)
    counters = {run["model"]: COUNTERS / f"{run['model']}.dat" for run in content.get("runs", [])}
    if not counters:
        raise InputError(f"{RESULT}: names no runs: {_MEASURE} again")
    for path in counters.values():
        if not path.exists():
            raise InputError(f"{path}: no such file: {_MEASURE} again")
        if path.stat().st_mtime > RESULT.stat().st_mtime:
            raise InputError(
                f"{path}: newer than {RESULT.name}, so of a run that did not end: {_MEASURE} again"
            )
    return _Code(counters, _record("code coverage", content))


def _functional(sources: list[Path], here: str) -> tuple[CoverageDatabase, list[TestRecord]]:
    records: list[TestRecord] = []
    for path in sources:
        if not path.exists():
            raise InputError(f"{path}: no such file: {_SIGN_OFF} first")
        records.append(_record("sign-off", _evidence(path.with_name(_SIGNOFF), here, _SIGN_OFF)))
    names = dict.fromkeys(name for path in sources for name in _model_names(path))
    database = CoverageDatabase(map(model_named, names))
    for path in sources:
        database.add_file(path)
    return database, records


def _model_names(path: Path) -> list[str]:
    data = read_input(path)
    try:
        names = [model["model"] for model in json.loads(data)["models"]]
    except (ValueError, KeyError, TypeError) as error:
        raise InputError(f"{path}: not a coverage file: {_SIGN_OFF} again") from error
    if not names or not all(isinstance(name, str) for name in names):
        raise InputError(f"{path}: counts of no model: {_SIGN_OFF} again")
    return names
