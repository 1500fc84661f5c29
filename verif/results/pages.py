"""Pages of the database: all results with their trends, each result down to its runs and mutants, each file.

A page is made from its name alone, so they are the same where they are served, made anew each time, and as
files, which need no network.
"""

import os
import re
import sqlite3
from collections import defaultdict
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

from markupsafe import Markup

from triaxis.coverage.html import rendered
from triaxis.coverage.testplan import read_testplan
from triaxis.golden.errors import InputError
from triaxis.golden.outputs import write_whole
from triaxis.sim.build import rtl_files, rtl_hash
from triaxis.sim.evidence import read_evidence
from triaxis.sim.paths import BUILD, DUT, ROOT
from triaxis.verif.code_coverage.run import RESULT as CODE_COVERAGE
from triaxis.verif.regress.records import read_records, read_state
from triaxis.verif.regress.run import FOLDER as REGRESSIONS
from triaxis.verif.results.database import DATABASE, MUTATION, Row, opened
from triaxis.verif.signoff.plots import trend

FOLDER = BUILD / "results"
INDEX = "index.html"
# Results that a trend shows, and that have a page of their own among the files.
_NEWEST = 60
_RESULT = re.compile(r"result-(\d{1,18})\.html")
_COMPARED = re.compile(r"compare-(\d{1,18})-(\d{1,18})\.html")
_SOURCE = "source-"
_TRENDS = (
    ("Pairs checked", "millions", "pairs", 1e-6),
    ("Time", "minutes", "seconds", 1 / 60),
    ("Functional coverage", "percent", "coverage_percent", 1.0),
    ("Failing runs", "runs", "failures", 1.0),
)


def page(name: str, database: Path = DATABASE) -> str | None:
    """Return the page of a name, None where there is none."""
    with opened(database) as connection:
        if name == INDEX:
            return _index(connection)
        if found := _RESULT.fullmatch(name):
            return _result(connection, int(found[1]))
        if found := _COMPARED.fullmatch(name):
            return _compared(connection, int(found[1]), int(found[2]))
        if name.startswith(_SOURCE):
            return _source(connection, name)
    return None


def names(database: Path = DATABASE) -> list[str]:
    """Return the names of all pages that files are made of."""
    with opened(database) as connection:
        linked = _linked(connection)
        found = (_rows(connection, "SELECT * FROM result WHERE id = ?", number)[0] for number in linked)
        before = {row["id"]: _before(connection, row, linked) for row in found}
        sources = [source_page(file) for file in _mutated_files(connection, _mutation(connection))]
    compared = [f"compare-{one}-{number}.html" for number, one in before.items() if one is not None]
    return [*(f"result-{number}.html" for number in before), *compared, *sources, INDEX]


def _linked(connection: sqlite3.Connection) -> set[int]:
    """Return the results that have a page among the files."""
    newest = _rows(connection, "SELECT id FROM result ORDER BY finished DESC, id DESC LIMIT ?", _NEWEST)
    return {row["id"] for row in newest}


def write_pages(folder: Path = FOLDER, database: Path = DATABASE, also: Sequence[str] = ()) -> Path:
    """Write all pages, and those named besides; return the first to read."""
    for name in (*names(database), *also):
        made = page(name, database)
        if made is None:
            raise InputError(f"{name}: there are no such results: see {folder / INDEX}")
        write_whole(folder / name, made)
    return folder / INDEX


def source_page(file: str) -> str:
    """Return the name of the page of a file of RTL."""
    return f"{_SOURCE}{file.replace('/', '-')}.html"


def _show(template: str, title: str, **values: object) -> str:
    return rendered(Path(__file__).with_name(template), title=f"Triaxis: {title}", log=_log, **values)


def _log(path: str, finished: str | None = None) -> Markup:
    """Return a link to a log, or its name where it is not there, or was written again since then."""
    whole = ROOT / path
    if not whole.is_file() or not whole.is_relative_to(BUILD):
        return Markup("<code>{}</code>").format(path)
    if finished and whole.stat().st_mtime > datetime.fromisoformat(finished).timestamp() + 1:
        return Markup("<code>{}</code>, of a later run now").format(path)
    return Markup("<a href='{}'>log</a>").format(os.path.relpath(whole, FOLDER))


def _rows(connection: sqlite3.Connection, query: str, *values: object) -> list[Row]:
    return connection.execute(query, values).fetchall()


def _index(connection: sqlite3.Connection) -> str:
    results = _rows(connection, "SELECT * FROM result ORDER BY finished DESC, id DESC")
    return _show(
        "index.html", "results", results=results, linked=_linked(connection), running=list(_running()),
        trends=list(_trends(results)),
        tests=_rows(connection, "SELECT * FROM test ORDER BY mean_seconds DESC"),
        flaky=_rows(connection, "SELECT * FROM flaky ORDER BY last DESC"),
    )  # fmt: skip


def _trends(results: Sequence[Row]) -> Iterator[tuple[str, list[Markup]]]:
    """Yield the plots of each kind of which there are at least two results."""
    kinds: dict[str, list[Row]] = defaultdict(list)
    for row in reversed(results):
        kinds[row["kind"]].append(row)
    for kind, rows in kinds.items():
        rows = rows[-_NEWEST:]
        dates = [row["finished"][:16].replace("T", " ") for row in rows]
        plots: list[Markup] = []
        for title, label, key, scale in _TRENDS:
            values = [None if row[key] is None else row[key] * scale for row in rows]
            if len(rows) > 1 and any(value is not None for value in values):
                plots.append(Markup(trend(title, label, dates, values, from_zero=label != "percent")))
        if plots:
            yield kind, plots


@dataclass(frozen=True)
class _Running:
    """A regression that has not come to its end: the runs that are done, and its builds."""

    name: str
    command: str
    passed: int
    failed: int
    builds: Sequence[tuple[str, str]]
    logs: Sequence[str]


def _running() -> Iterator[_Running]:
    for folder in sorted(REGRESSIONS.glob("*/")):
        state = read_state(folder)
        if state is None or state.finished or folder.name.endswith(".previous"):
            continue
        records = read_records(folder).values()
        passed = sum(record.passed for record in records)
        failed = {path.stem for path in folder.glob("builds/*.error")}
        logs = sorted(folder.glob("dvsim/**/build.log"))
        times = f" --seeds-times {state.multiplier:g}" if state.multiplier != 1 else ""
        builds = [(log.parent.parent.name, _state_of(log, failed)) for log in logs]
        yield _Running(
            folder.name, f"triaxis regress run {folder.name} --seed {state.seed}{times}", passed,
            len(records) - passed, builds,
            [str(path.relative_to(ROOT)) for path in (*sorted(folder.glob("dvsim-*.log")), *logs)],
        )  # fmt: skip


def _state_of(log: Path, failed: set[str]) -> str:
    if "BUILD DONE" in log.read_text(errors="replace"):
        return "built"
    return "failed" if failed & set(log.parts) else "building"


# Of one result; and of two, the earlier one first.
_BEFORE = """
SELECT id FROM result WHERE kind = ? AND (finished, id) < (?, ?) ORDER BY finished DESC, id DESC LIMIT 1
"""
_KILLS = """
SELECT test, sum(mutants) AS mutants, count(*) AS files FROM kills WHERE result = ?
GROUP BY test ORDER BY mutants DESC
"""
_FILES = """
SELECT file, count(*) AS mutants, sum(fate = 'killed') AS killed, sum(fate = 'equivalent') AS equivalent
FROM mutant WHERE result = ? GROUP BY file
"""
_MET = """
SELECT model, mutant, count(test) AS tests, coalesce(group_concat(test, ', '), '') AS names
FROM noticed WHERE result = ? GROUP BY model, mutant ORDER BY tests, model, mutant
"""
_OTHER_OUTCOMES = """
SELECT b.test, b.config, b.agent, b.seed, b.passed AS after, b.said, b.replay
FROM run AS a JOIN run AS b USING (replay)
WHERE a.result = ? AND b.result = ? AND a.passed <> b.passed
"""
_FAILED = """
SELECT * FROM run WHERE result = ?2 AND NOT passed
AND replay NOT IN (SELECT replay FROM run WHERE result = ?1)
"""
_ONLY_THERE = """
SELECT test, config, agent FROM run WHERE result = ?
EXCEPT SELECT test, config, agent FROM run WHERE result = ?
"""
_TIMES = """
WITH time AS (SELECT result, test, config, agent, sum(seconds) AS seconds FROM run GROUP BY 1, 2, 3, 4)
SELECT test, config, agent, a.seconds AS before, b.seconds AS after, b.seconds / a.seconds AS ratio
FROM time AS a JOIN time AS b USING (test, config, agent)
WHERE a.result = ? AND b.result = ? AND a.seconds > 0 ORDER BY b.seconds - a.seconds DESC
"""
_OTHER_COVERAGE = """
SELECT place, item, a.hit AS hit_before, a.total AS total_before, b.hit, b.total
FROM (SELECT DISTINCT kind, place, item FROM covered WHERE result IN (?1, ?2))
LEFT JOIN (SELECT * FROM covered WHERE result = ?1) AS a USING (kind, place, item)
LEFT JOIN (SELECT * FROM covered WHERE result = ?2) AS b USING (kind, place, item)
WHERE a.hit IS NOT b.hit OR a.total IS NOT b.total
"""
_OTHER_FATES = """
SELECT id, coalesce(b.file, a.file) AS file, coalesce(b.line, a.line) AS line, a.fate AS before,
  a.test AS test_before, b.fate, b.test
FROM (SELECT DISTINCT id FROM mutant WHERE result IN (?1, ?2))
LEFT JOIN (SELECT * FROM mutant WHERE result = ?1) AS a USING (id)
LEFT JOIN (SELECT * FROM mutant WHERE result = ?2) AS b USING (id)
WHERE a.fate IS NOT b.fate OR a.test IS NOT b.test
"""


def _before(connection: sqlite3.Connection, row: Row, linked: Collection[int]) -> int | None:
    """Return the result of the same kind before one, None where none of those that have a page is."""
    found = _rows(connection, _BEFORE, row["kind"], row["finished"], row["id"])
    return found[0]["id"] if found and found[0]["id"] in linked else None


def _result(connection: sqlite3.Connection, number: int) -> str | None:
    found = _rows(connection, "SELECT * FROM result WHERE id = ?", number)
    if not found:
        return None
    row = found[0]

    def of_it(table: str, order: str = "rowid") -> list[Row]:
        return _rows(connection, f"SELECT * FROM {table} WHERE result = ? ORDER BY {order}", number)

    runs = of_it("run", "passed, test, config, seed")
    tests = {point.name: point.tests for point in read_testplan().testpoints}
    return _show(
        "result.html", f"{row['kind']} {number}", row=row, runs=runs,
        before=_before(connection, row, _linked(connection)), problems=of_it("problem"),
        exceptions=of_it("exception"), parts=of_it("part"),
        points=[
            (point, [run for run in runs if run["test"] in tests.get(point["name"], ())])
            for point in of_it("testpoint")
        ],
        covered=of_it("covered", "hit = total, kind DESC, place"), kills=_rows(connection, _KILLS, number),
        files=_rows(connection, _FILES, number), power=of_it("power"), met=_rows(connection, _MET, number),
        source_page=source_page,
        sources=_mutated_files(connection, number) if number == _mutation(connection) else [],
    )  # fmt: skip


def _compared(connection: sqlite3.Connection, one: int, other: int) -> str | None:
    """Return what differs from one result to the other."""
    rows = [row for n in (one, other) for row in _rows(connection, "SELECT * FROM result WHERE id = ?", n)]
    if len(rows) < 2:
        return None
    kept = all(_mutated_files(connection, number) for number in (one, other))
    queries = {
        "runs": _OTHER_OUTCOMES, "failed": _FAILED, "times": _TIMES, "covered": _OTHER_COVERAGE,
        "mutants": _OTHER_FATES,
    }  # fmt: skip
    return _show(
        "compare.html", f"{one} and {other}", rows=rows, mutants_kept=kept,
        only=[
            (row, _rows(connection, _ONLY_THERE, row["id"], another["id"]))
            for row, another in (rows, rows[::-1])
        ],
        **{
            name: _rows(connection, query, one, other) if kept or name != "mutants" else []
            for name, query in queries.items()
        },
    )  # fmt: skip


def _mutation(connection: sqlite3.Connection) -> int | None:
    """Return the newest result of mutants of today's RTL, None where there is none: its lines are others."""
    found = _rows(
        connection,
        "SELECT id FROM result WHERE (kind, rtl_hash) = (?, ?) ORDER BY finished DESC, id DESC LIMIT 1",
        MUTATION, rtl_hash(),
    )  # fmt: skip
    return found[0]["id"] if found else None


def _mutated_files(connection: sqlite3.Connection, number: int | None) -> list[str]:
    """Return the files of today's RTL of which a result has mutants."""
    query = "SELECT DISTINCT file FROM mutant WHERE result = ? ORDER BY file"
    today = {str(path.relative_to(DUT.parent)) for path in rtl_files(DUT)}
    return [row["file"] for row in _rows(connection, query, number) if row["file"] in today]


def _source(connection: sqlite3.Connection, name: str) -> str | None:
    """Return a file of today's RTL, line by line: what is not covered there, and its mutants."""
    files = _mutated_files(connection, _mutation(connection))
    file = {source_page(one): one for one in files}.get(name)
    if file is None:
        return None
    number = _mutation(connection)
    mutants: dict[int, list[Row]] = defaultdict(list)
    for row in _rows(connection, "SELECT * FROM mutant WHERE result = ? AND file = ?", number, file):
        mutants[row["line"]].append(row)
    open_bins, measured = _uncovered(file)
    lines = [
        (line, text, open_bins.get(line, []), mutants.get(line, []))
        for line, text in enumerate((DUT.parent / file).read_text().splitlines(), 1)
    ]
    return _show("source.html", file, file=file, lines=lines, measured=measured, mutation=number)


def _uncovered(file: str) -> tuple[dict[int, list[str]], bool]:
    """Return what code coverage found open by line, and whether it was measured on today's RTL."""
    content: dict[str, Any] | None = read_evidence(CODE_COVERAGE)
    if content is None or content["rtl_hash"] != rtl_hash(DUT):
        return {}, False
    found: dict[int, list[str]] = defaultdict(list)
    for one in content["uncovered"]:
        if one["file"] in (file, Path(file).name):
            found[one["line"]].append(f"{one['kind']} {one['what']}, {one['instance']}, {one['model']}")
    return found, True
