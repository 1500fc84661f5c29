"""The database of results: schema.sql filled from the evidence that runs leave, and read as rows.

Evidence is added as it is, from this machine or from another: the same file twice counts once. A row is never
changed afterwards, but older mutants go.
"""

import hashlib
import io
import json
import math
import re
import sqlite3
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import closing, contextmanager
from datetime import datetime
from itertools import takewhile
from pathlib import Path
from typing import Any

from triaxis.golden.errors import InputError
from triaxis.golden.input_file import read_input
from triaxis.golden.outputs import make_folder, write_whole
from triaxis.sim.evidence import read_evidence
from triaxis.sim.paths import BUILD
from triaxis.verif.regress.definition import in_checkout
from triaxis.verif.regress.failing import general
from triaxis.verif.regress.one_job import left_nothing

DATABASE = BUILD / "history" / "results.sqlite"
SIGNOFF, MUTATION, POWER = "sign-off", "mutation", "power"
# Of schema.sql.
VERSION = 2
_CREATED = re.compile(r"^CREATE \w+ (\w+)", re.MULTILINE)
_SCHEMA = Path(__file__).with_name("schema.sql")
# Others may be adding theirs.
_PATIENCE_SECONDS = 60
_STAMP = (
    "command",
    "seed",
    "passed",
    "summary",
    "seconds",
    "git_commit",
    "rtl_hash",
    "environment_hash",
    "verilator",
    "python",
)
_FLAGS = ("passed", "flaky", "silent")
_NUMBERS = ("seconds", "pairs", "failures", "coverage_percent", "hit", "total", "tried", "noticed")
_OLDER = """
DELETE FROM {} WHERE result IN (
  SELECT id FROM result WHERE (kind, rtl_hash, environment_hash) = (?, ?, ?)
  EXCEPT SELECT * FROM (
    SELECT id FROM result WHERE (kind, rtl_hash, environment_hash) = (?, ?, ?)
    ORDER BY finished DESC, id DESC LIMIT 1
  )
)
"""

Row = sqlite3.Row
Content = Mapping[str, Any]


@contextmanager
def opened(path: Path = DATABASE) -> Iterator[sqlite3.Connection]:
    """Give the database, made where there is none; commit at the end, unless that is an error.

    Raises InputError where the file is no such database, or cannot be read or written.
    """
    make_folder(path.parent)
    try:
        with closing(sqlite3.connect(path, timeout=_PATIENCE_SECONDS)) as connection:
            connection.row_factory = sqlite3.Row
            connection.execute("PRAGMA foreign_keys = ON")
            _make(connection, path)
            with connection:
                yield connection
    except sqlite3.OperationalError as error:
        raise InputError(f"{path}: {error}: try again, or see that it can be written") from error
    except sqlite3.DatabaseError as error:
        raise InputError(f"{path}: {error}: move it away, and add what it held with --add") from error


def _make(connection: sqlite3.Connection, path: Path) -> None:
    """Make what schema.sql describes, once: others may be about to. An older one gets the rest."""
    if _version(connection) == VERSION:
        return
    with connection:
        connection.execute("BEGIN IMMEDIATE")
        if (version := _version(connection)) == VERSION:
            return
        there = {name for (name,) in connection.execute("SELECT name FROM sqlite_master")}
        if there and not 0 < version < VERSION:
            raise InputError(f"{path}: is of another version: move it away, and add what it held with --add")
        for statement in _SCHEMA.read_text().split(";\n"):
            if (created := _CREATED.search(statement)) and created[1] not in there:
                connection.execute(statement)
        connection.execute(f"PRAGMA user_version = {VERSION}")


def _version(connection: sqlite3.Connection) -> int:
    return connection.execute("PRAGMA user_version").fetchone()[0]


def add_evidence(file: Path, path: Path = DATABASE) -> bool:
    """Add a regression's results.json, a sign-off's signoff.json, mutation.json or power.json; return whether
    it is new.

    Raises InputError where it is none of these, or not whole.
    """
    content = None
    if file.exists():
        # No pipe, which may have nothing to say for ever.
        read_input(file)
        content = read_evidence(file)
    if content is None:
        raise InputError(
            f"{file}: no such file: name results.json, signoff.json, mutation.json or power.json of a run"
        )
    wanted = "must be the whole result of a regression, a sign-off or a run over mutants"
    try:
        rows = list(_rows(content))
        for _, row in rows:
            _check(row)
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise InputError(f"{file}: {wanted}: {error!r}") from error
    (_, result), *rest = rows
    with opened(path) as connection:
        try:
            number = _insert(connection, "result", result, "ON CONFLICT (key) DO NOTHING")
            if number is None:
                return False
            for table, row in rest:
                _insert(connection, table, {"result": number, **row})
        # Of a value that is missing, of another type, or too large.
        except (sqlite3.IntegrityError, sqlite3.InterfaceError, sqlite3.ProgrammingError, ValueError,
                OverflowError) as error:  # fmt: skip
            connection.rollback()
            raise InputError(f"{file}: {wanted}: {error}") from error
        # Eight thousand rows a time: of one state of the sources the newest result alone keeps its mutants.
        same = [result[name] for name in ("kind", "rtl_hash", "environment_hash")]
        for table in ("mutant", "noticed"):
            connection.execute(_OLDER.format(table), (*same, *same))
    return True


def keep(file: Path, path: Path = DATABASE) -> None:
    """Add what a run left; where that cannot be, say so: the run's verdict stands."""
    try:
        add_evidence(file, path)
    except InputError as error:
        print(f"not among `triaxis results`: {error}", file=sys.stderr)


def _insert(connection: sqlite3.Connection, table: str, row: Content, how: str = "") -> int | None:
    """Insert a row; return its number, None where it was there before."""
    names = ", ".join(row)
    marks = ", ".join("?" * len(row))
    found = connection.execute(f"INSERT INTO {table} ({names}) VALUES ({marks}) {how}", tuple(row.values()))
    return found.lastrowid if found.rowcount else None


def _check(row: Content) -> None:
    """Raise ValueError for what no page could show: SQLite keeps values of any type."""
    for name, value in row.items():
        if value is None:
            continue
        if name in _FLAGS and not isinstance(value, bool):
            raise ValueError(f"{name}: {value!r}: must be true or false")
        if name in _NUMBERS and (type(value) not in (int, float) or not 0 <= value < math.inf):
            raise ValueError(f"{name}: {value!r}: must be a number that is not negative")


def _rows(content: Content) -> Iterator[tuple[str, Content]]:
    """Yield the rows of a file with the names of their tables, that of the result first."""
    if "regression" in content:
        yield from _regression(content)
    elif "parts" in content:
        yield from _signoff(content)
    elif "mutants" in content:
        yield "result", _of_mutants(content, MUTATION)
        yield from (("mutant", _mutant(one)) for one in content["mutants"])
    elif "power" in content:
        yield "result", _of_mutants(content, POWER)
        for of in content["power"]:
            yield from _power(of)
    else:
        raise ValueError("it has neither `regression`, `parts`, `mutants` nor `power`")
    if not isinstance(content["problems"], list):
        raise TypeError("problems: must be a list")
    yield from (("problem", {"said": problem}) for problem in content["problems"])
    yield from (("exception", {"said": line}) for line in content.get("exceptions", ()))


def _result(content: Content, kind: str, finished: str, same: Iterable[Any], **more: Any) -> dict[str, Any]:
    """Return the row of a file. ``same``: what a repetition of its writing does not change."""
    datetime.fromisoformat(finished)
    identity = [kind, content["command"], content["rtl_hash"], content["environment_hash"], *same]
    return {
        "key": hashlib.sha256(json.dumps(identity).encode()).hexdigest(),
        "kind": kind,
        "finished": finished,
        **{name: content[name] for name in _STAMP},
        **more,
    }


def _regression(content: Content) -> Iterator[tuple[str, Content]]:
    times = content["seeds_multiplied_by"]
    kind = content["regression"] + (f" x {times:g}" if times != 1 else "")
    runs = content["runs"]
    yield (
        "result",
        _result(
            content, kind, content["finished"], [content["begun"]],
            pairs=content["pairs_checked"], failures=sum(not run["passed"] for run in runs),
            coverage_percent=content["coverage"]["percent"],
        ),
    )  # fmt: skip
    flaky = set(content["flaky"])
    for run in runs:
        row = _run(run, run["pairs_checked"], run["bucket"])
        yield "run", row | {"flaky": run["key"] in flaky, "silent": run["silent"]}
    yield from _functional(content["coverage"]["models"])


def _signoff(content: Content) -> Iterator[tuple[str, Content]]:
    parts, figures = content["parts"], content["figures"]
    simulated = parts["simulation"]["absent"] is None
    runs = parts["simulation"]["runs"] if simulated else ()
    covered = figures["functional_coverage"]
    yield (
        "result",
        _result(
            content, SIGNOFF, content["date"], [content["date"]], pairs=figures["pairs_checked"],
            failures=sum(not run["passed"] for run in runs) if simulated else None, coverage_percent=covered,
        ),
    )  # fmt: skip
    for name, part in parts.items():
        measured = part["absent"] is None
        row = {key: part[key] if measured else None for key in ("passed", "seconds")}
        yield "part", {"name": name, **row, "summary": part["summary"] if measured else part["absent"]}
    for point in parts["testplan"].get("testpoints", ()):
        yield "testpoint", {key: point[key] for key in ("name", "stage", "passed")}
    for run in runs:
        # Of what was told of it, between its name and its log.
        errors = [*takewhile(lambda line: not line.startswith("  log:"), (run["explanation"] or ())[1:])]
        pairs = run["counts"]["checked"] if run["counts"] else None
        silent = not run["passed"] and left_nothing(run["counts"], errors)
        said = general(errors[0]) if errors else None
        yield "run", _run(run, pairs, said) | {"flaky": False, "silent": silent}
    yield from _functional(parts["simulation"].get("coverage", {}))
    for file, kinds in parts["code_coverage"].get("files", {}).items():
        for kind, total in kinds.items():
            yield "covered", _covered("code", file, kind, total["hit"] + total["waived"], total["total"])


def _run(run: Content, pairs: int | None, said: str | None) -> dict[str, Any]:
    kept = ("test", "config", "agent", "seed", "passed", "seconds", "replay")
    log = in_checkout(Path(run["log"]))
    return {**{name: run[name] for name in kept}, "pairs": pairs, "said": said, "log": log}


def _functional(models: Content) -> Iterator[tuple[str, Content]]:
    for model, items in models.items():
        for name, item in items.items():
            yield "covered", _covered("functional", model, name, item["hit"], item["total"])


def _covered(kind: str, place: str, item: str, hit: int, total: int) -> Content:
    return {"kind": kind, "place": place, "item": item, "hit": hit, "total": total}


def _of_mutants(content: Content, kind: str) -> Content:
    finished = content["finished"]
    return _result(content, kind, finished, [finished, content["seconds"], content["summary"]])


def _mutant(one: Content) -> Content:
    file, _, line = one["place"].rpartition(":")
    kept = ("id", "original", "changed", "fate", "by", "test", "target")
    return {**{name: one[name] for name in kept}, "file": file, "line": int(line)}


def _power(of: Content) -> Iterator[tuple[str, Content]]:
    model, mutants = of["model"], of["mutants"]
    for test, row in of["tests"].items():
        noticed = sum(test in tests for tests in mutants.values())
        yield "power", {"model": model, "test": test, "tried": len(mutants), "noticed": noticed, **row}
    for mutant, tests in mutants.items():
        for test in tests or (None,):
            yield "noticed", {"model": model, "mutant": mutant, "test": test}


def export_parquet(folder: Path, path: Path = DATABASE) -> list[Path]:
    """Write every table as FOLDER/NAME.parquet; return these. InputError where pyarrow is not installed."""
    try:
        import pyarrow as arrow
        import pyarrow.parquet as parquet
    except ImportError as error:
        raise InputError("--parquet: pyarrow is not installed: pip install pyarrow") from error
    make_folder(folder)
    written: list[Path] = []
    with opened(path) as connection:
        names = connection.execute("SELECT name FROM sqlite_master WHERE type = 'table' ORDER BY name")
        for (name,) in names.fetchall():
            found = connection.execute(f"SELECT * FROM {name}")
            columns = [column for column, *_ in found.description]
            rows = found.fetchall()
            table = arrow.table({name: [row[name] for row in rows] for name in columns})
            whole = io.BytesIO()
            parquet.write_table(table, whole)
            written.append(write_whole(folder / f"{name}.parquet", whole.getvalue()))
    return written
