"""UCIS XML read back by pyucis says what the database says: every bin's name, count, kind and goal."""

from collections.abc import Callable
from datetime import UTC, datetime
from itertools import product
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

from triaxis.coverage.counts import Counts, CoverageDatabase
from triaxis.coverage.cover_model import (
    CoverItem,
    CoverModel,
    Coverpoint,
    Exclusion,
    Kind,
    MaskPoint,
)
from triaxis.coverage.interchange.lcov import read_code
from triaxis.coverage.interchange.ucis_xml import TestRecord, write_ucis
from triaxis.coverage.tests.counter_files import BINS, FIRST, SECOND, SOURCE, write_counters

_ABSENT = "no pyucis here: it is of the dependency group regress"
# By name, not by import: what is optional is not known to the type checker either.
CoverTypeT: Any = pytest.importorskip("ucis.cover_type_t", reason=_ABSENT).CoverTypeT
HistoryNodeKind: Any = pytest.importorskip("ucis.history_node_kind").HistoryNodeKind
ScopeTypeT: Any = pytest.importorskip("ucis.scope_type_t").ScopeTypeT
CoverageReportBuilder: Any = pytest.importorskip("ucis.report.coverage_report_builder").CoverageReportBuilder
XmlFactory: Any = pytest.importorskip("ucis.xml.xml_factory").XmlFactory

WRITTEN = datetime(2026, 1, 2, 3, 4, 5, tzinfo=UTC)
CODE = (
    (ScopeTypeT.BLOCK, CoverTypeT.STMTBIN, "block"),
    (ScopeTypeT.BRANCH, CoverTypeT.BRANCHBIN, None),
)
COUNTED = {"bins": CoverTypeT.CVGBIN, "ignore": CoverTypeT.IGNOREBIN, "illegal": CoverTypeT.ILLEGALBIN}

SIZE = Coverpoint[Any]("size", ("<small> & 'low'", "medium", "large", "huge"), lambda s: s.astype(np.uint8))
SIDE = Coverpoint[Any]("side", ("left", "right"), lambda s: s.astype(np.uint8), partial=True)
AXES = MaskPoint[Any]("axes", ("x", "y", "z"), lambda s: s.astype(np.uint32))
DULL = Exclusion(Kind.IGNORE, "dull", "tests/a", lambda size: size == 2)
NEVER = Exclusion(Kind.ILLEGAL, "none is that large", "tests/b", lambda size: size == 3)
NO_Z = Exclusion(Kind.ILLEGAL, "there is no z", "tests/c", lambda axis, side: axis == 2)
NO_Y = Exclusion(Kind.IGNORE, "y is left", "tests/d", lambda axis, side: axis == 1 and side == 1)
SMALL = CoverModel(
    "small",
    (
        CoverItem("sizes", "how large", (SIZE,), (DULL, NEVER), at_least=5),
        CoverItem("crossed", "axes x side", (AXES, SIDE), (NO_Z, NO_Y), at_least=2),
        CoverItem("mixed", "goals that differ", (SIZE,), at_least=lambda size: 3 - size % 2),
    ),
)


def database_of(hits: Callable[[CoverItem[Any]], Any]) -> CoverageDatabase:
    database = CoverageDatabase([SMALL])
    database.add(Counts("small", SMALL.hash, {item.name: hits(item) for item in SMALL.items}))
    return database


def filled(rng: np.random.Generator) -> CoverageDatabase:
    """Return a database in which every bin's count is its own, some 0."""
    return database_of(lambda item: rng.integers(0, 40, item.size) * rng.integers(0, 2, item.size))


def expected(item: CoverItem[Any], hits: list[int]) -> dict[tuple[str, str], tuple[int, str]]:
    """Return count and kind of each bin by point or cross."""
    whole = " x ".join(point.name for point in item.points)
    kinds = [one.exclusion.kind.value if one.exclusion else "bins" for one in item.bins]
    found: dict[tuple[str, str], tuple[int, str]] = {}
    for one, kind, count in zip(item.bins, kinds, hits, strict=True):
        apart = kind != "bins" and len(item.points) > 1
        found[f"{whole} excluded" if apart else whole, one.name] = count, kind
    codes = list(product(*(range(len(point.bins)) for point in item.points)))
    for place, point in enumerate(item.points if len(item.points) > 1 else ()):
        for code, name in enumerate(point.bins):
            here = [n for n, every in enumerate(codes) if every[place] == code]
            why = {kinds[n] for n in here}
            kind = "bins" if "bins" in why else "illegal" if why == {"illegal"} else "ignore"
            found[point.name, name] = sum(hits[n] for n in here), kind
    return found


def read_back(path: Path) -> Any:
    """Return what pyucis makes of a file, after it has set it against the schema."""
    return XmlFactory.read(str(path))


def test_pyucis_reads_every_bin(rng: np.random.Generator, tmp_path: Path) -> None:
    database = filled(rng)
    [instance] = read_back(write_ucis(tmp_path / "t.xml", database)).scopes(ScopeTypeT.INSTANCE)
    assert instance.getScopeName() == "small"
    [(_, counts)] = database
    goals: dict[str, int] = {}
    for item, group in zip(SMALL.items, instance.scopes(ScopeTypeT.COVERGROUP), strict=True):
        assert group.getScopeName() == item.name
        [only] = list(group.scopes(ScopeTypeT.COVERINSTANCE))
        points = [*only.scopes(ScopeTypeT.COVERPOINT), *only.scopes(ScopeTypeT.CROSS)]
        read = {
            (point.getScopeName(), bin_.getName()): (bin_.getCoverData().data, kind)
            for point in points
            for kind, number in COUNTED.items()
            for bin_ in point.coverItems(number)
        }
        assert read == expected(item, counts.hits[item.name].tolist())
        # Named as people would look for them.
        assert ("size", "<small> & 'low'") in read or ("axes x side excluded", "z / left") in read
        goals |= {f"{item.name} {p.getScopeName()}": p.getAtLeast() for p in points[: len(item.points)]}
    assert goals == {"sizes size": 5, "crossed axes": 1, "crossed side": 1, "mixed size": 3}


def test_excluded_bins_have_their_reasons_and_goals_that_differ_are_said(
    rng: np.random.Generator, tmp_path: Path
) -> None:
    root = ElementTree.parse(write_ucis(tmp_path / "t.xml", filled(rng))).getroot()
    attributes = {
        (point.get("name"), one.get("name"), attribute.get("key")): attribute.text
        for point in root.iter("coverpoint")
        for one in point.iter("coverpointBin")
        for attribute in one.iter("userAttr")
    }
    assert attributes["size", "large", "reason"] == "dull"
    assert attributes["size", "huge", "proof"] == "tests/b"
    assert attributes["axes x side excluded", "z / left", "reason"] == "there is no z"
    assert {key[1] for key in attributes if key[2] == "at_least"} == {"medium", "huge"}
    [cross] = list(root.iter("cross"))
    assert [options.get("at_least") for options in cross.iter("options")] == ["2"]
    indices = {b.get("name"): [int(i.text or "") for i in b.iter("index")] for b in cross.iter("crossBin")}
    assert indices == {"x / left": [0, 0], "x / right": [0, 1], "y / left": [1, 0]}


def records(path: Path) -> list[tuple[str, bool, str, str, str | None]]:
    return [
        (n.getLogicalName(), n.getTestStatus(), n.getDate(), n.getCmd(), n.getSeed())
        for n in read_back(path).historyNodes(HistoryNodeKind.TEST)
    ]


def test_the_runs_are_recorded(tmp_path: Path) -> None:
    full = database_of(lambda item: item.goals.copy())
    runs = [TestRecord("signoff", True, "make signoff", 1), TestRecord("code", False)]
    path = write_ucis(tmp_path / "t.xml", full, tests=runs, written=WRITTEN)
    [first, second] = records(path)
    assert first[:4] == ("signoff", True, "20260102030405", "make signoff") and str(first[4]) == "1"
    assert second[:2] == ("code", False)
    again = write_ucis(tmp_path / "u.xml", full, tests=runs, written=WRITTEN)
    assert again.read_bytes() == path.read_bytes()
    # Without a record it passed where all is covered and nothing illegal hit.
    wrong = database_of(lambda item: item.goals + item.illegal)
    for database, passed in ((full, True), (CoverageDatabase([SMALL]), False), (wrong, False)):
        assert [one[1] for one in records(write_ucis(path, database))] == [passed]


def test_pyucis_reads_line_and_branch_counts_of_each_instance(tmp_path: Path) -> None:
    source = tmp_path / "dut" / "leaf.sv"
    source.parent.mkdir()
    source.write_text(SOURCE)
    bins = len(BINS)
    models = {
        "one": {FIRST: range(bins), SECOND: range(bins, 2 * bins)},
        "two": {"TOP.top": range(100, 100 + bins), FIRST: range(200, 200 + bins)},
    }
    code = {
        name: read_code(write_counters(tmp_path / f"{name}.dat", source, dict(counts)), tmp_path)
        for name, counts in models.items()
    }
    expected = {
        (build, p.instance, p.path, str(p.line), str(p.column), p.what): count
        for build, points in code.items()
        for p, count in points.items()
    }
    assert sorted(expected.values()) == [*range(2 * bins), *range(100, 100 + bins), *range(200, 200 + bins)]
    found: dict[tuple[str, ...], int] = {}
    ucis = read_back(write_ucis(tmp_path / "t.xml", CoverageDatabase([]), code))
    for build in ucis.scopes(ScopeTypeT.INSTANCE):
        inner = {f"TOP.top.{one.getScopeName()}": one for one in build.scopes(ScopeTypeT.INSTANCE)}
        for path, instance in {"TOP.top": build, **inner}.items():
            for kind, number, what in CODE:
                for bin_ in (one for scope in instance.scopes(kind) for one in scope.coverItems(number)):
                    at = bin_.getSourceInfo()
                    place = (at.file.getFileName(), str(at.line), str(at.token), what or bin_.getName())
                    found[build.getScopeName(), path, *place] = bin_.getCoverData().data
    assert found == expected
