"""UCIS XML read back by pyucis says what the database says: every bin's name, count, kind and goal."""

from collections.abc import Iterator, Mapping, Sequence
from datetime import UTC, datetime
from itertools import product
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

from triaxis.coverage.code_counters import Point
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

Contents = dict[tuple[str, ...], tuple[int, str, int]]


def filled(models: Sequence[CoverModel[Any]], rng: np.random.Generator) -> CoverageDatabase:
    """Return a database in which every bin's count is its own, some 0."""
    database = CoverageDatabase(models)
    for model in models:
        hits = {
            item.name: rng.integers(0, 40, item.size) * rng.integers(0, 2, item.size) for item in model.items
        }
        database.add(Counts(model.name, model.hash, hits))
    return database


def expected(database: CoverageDatabase) -> Contents:
    """Return count, kind and goal of each bin by instance, covergroup, point or cross, and bin."""
    return {
        (model.name, item.name, *place): content
        for model, counts in database
        for item in model.items
        for place, content in expected_item(item, counts.hits[item.name].tolist())
    }


def expected_item(
    item: CoverItem[Any], hits: list[int]
) -> Iterator[tuple[tuple[str, str], tuple[int, str, int]]]:
    goal = max(b.goal for b in item.bins if not b.exclusion)
    whole = " x ".join(point.name for point in item.points)
    for one, count in zip(item.bins, hits, strict=True):
        kind = one.exclusion.kind.value if one.exclusion else "bins"
        apart = one.exclusion and len(item.points) > 1
        yield (f"{whole} excluded" if apart else whole, one.name), (count, kind, 1 if apart else goal)
    if len(item.points) == 1:
        return
    codes = list(product(*(range(len(point.bins)) for point in item.points)))
    for place, point in enumerate(item.points):
        for code, name in enumerate(point.bins):
            here = [n for n, every in enumerate(codes) if every[place] == code]
            why = {b.exclusion.kind.value if b.exclusion else "bins" for b in (item.bins[n] for n in here)}
            kind = "bins" if "bins" in why else "illegal" if why == {"illegal"} else "ignore"
            yield (point.name, name), (sum(hits[n] for n in here), kind, 1)


def read_back(path: Path) -> Any:
    """Return what pyucis makes of a file, after it has set it against the schema."""
    return XmlFactory.read(str(path))


def goals_of_crosses(path: Path) -> dict[tuple[str, ...], int]:
    """Return what crosses need by instance, covergroup and cross: pyucis reads those of points alone."""
    return {
        (instance.attrib["name"], group.attrib["name"], cross.attrib["name"]): int(options.attrib["at_least"])
        for instance in ElementTree.parse(path).getroot().iter("instanceCoverages")
        for group in instance.iter("cgInstance")
        for cross in group.iter("cross")
        for options in cross.iter("options")
    }


def found(path: Path) -> Contents:
    """Return what pyucis knows: of each instance of a covergroup, its coverpoints and crosses."""
    contents: Contents = {}
    ucis, of_crosses = read_back(path), goals_of_crosses(path)
    for instance in ucis.scopes(ScopeTypeT.INSTANCE):
        for group in instance.scopes(ScopeTypeT.COVERGROUP):
            [only] = list(group.scopes(ScopeTypeT.COVERINSTANCE))
            points = [*only.scopes(ScopeTypeT.COVERPOINT), *only.scopes(ScopeTypeT.CROSS)]
            for point in points:
                for kind, number in COUNTED.items():
                    for bin_ in point.coverItems(number):
                        place = (instance.getScopeName(), group.getScopeName(), point.getScopeName())
                        key = (*place, bin_.getName())
                        assert key not in contents
                        goal = of_crosses[place] if place in of_crosses else point.getAtLeast()
                        contents[key] = (bin_.getCoverData().data, kind, goal)
    return contents


def test_pyucis_reads_every_bin(rng: np.random.Generator, tmp_path: Path) -> None:
    database = filled([SMALL], rng)
    contents = found(write_ucis(tmp_path / "t.xml", database))
    assert contents == expected(database)
    assert {kind for _, kind, _ in contents.values()} == set(COUNTED)
    # Named as people would look for them.
    assert contents["small", "sizes", "size", "<small> & 'low'"][1:] == ("bins", 5)
    assert contents["small", "crossed", "axes x side excluded", "z / left"][1:] == ("illegal", 1)
    assert ("small", "crossed", "axes x side", "z / left") not in contents


def test_excluded_bins_have_their_reasons_and_goals_that_differ_are_said(
    rng: np.random.Generator, tmp_path: Path
) -> None:
    root = ElementTree.parse(write_ucis(tmp_path / "t.xml", filled([SMALL], rng))).getroot()
    attributes = {
        (point.get("name"), one.get("name"), attribute.get("key")): attribute.text
        for group in root.iter("cgInstance")
        for point in group.iter("coverpoint")
        for one in point.iter("coverpointBin")
        for attribute in one.iter("userAttr")
    }
    assert attributes["size", "large", "reason"] == "dull"
    assert attributes["size", "huge", "proof"] == "tests/b"
    assert attributes["axes x side excluded", "z / left", "reason"] == "there is no z"
    assert {key for key in attributes if key[2] == "at_least"} == {
        ("size", "medium", "at_least"),
        ("size", "huge", "at_least"),
    }
    [cross] = list(root.iter("cross"))
    indices = {b.get("name"): [int(i.text or "") for i in b.iter("index")] for b in cross.iter("crossBin")}
    assert indices == {"x / left": [0, 0], "x / right": [0, 1], "y / left": [1, 0]}


def full(model: CoverModel[Any]) -> CoverageDatabase:
    database = CoverageDatabase([model])
    database.add(Counts(model.name, model.hash, {i.name: i.goals.copy() for i in model.items}))
    return database


def records(path: Path) -> list[tuple[str, bool, str, str, str | None]]:
    return [
        (n.getLogicalName(), n.getTestStatus(), n.getDate(), n.getCmd(), n.getSeed())
        for n in read_back(path).historyNodes(HistoryNodeKind.TEST)
    ]


def test_the_runs_are_recorded(tmp_path: Path) -> None:
    runs = [TestRecord("signoff", True, "make signoff", 1), TestRecord("code", False)]
    path = write_ucis(tmp_path / "t.xml", full(SMALL), tests=runs, written=WRITTEN)
    [first, second] = records(path)
    assert first[:4] == ("signoff", True, "20260102030405", "make signoff") and str(first[4]) == "1"
    assert second[:2] == ("code", False)
    again = write_ucis(tmp_path / "u.xml", full(SMALL), tests=runs, written=WRITTEN)
    assert again.read_bytes() == path.read_bytes()
    # Without a record it passed where all is covered and nothing illegal hit.
    wrong = full(SMALL)
    wrong.add(Counts("small", SMALL.hash, {i.name: i.illegal.astype(np.int64) for i in SMALL.items}))
    for database, passed in ((full(SMALL), True), (CoverageDatabase([SMALL]), False), (wrong, False)):
        assert [one[1] for one in records(write_ucis(path, database))] == [passed]


def code_of(points: Mapping[str, Mapping[Point, int]]) -> dict[tuple[str, ...], int]:
    """Return counts by build, instance, file, line, column and way."""
    return {
        (build, p.instance, p.path, str(p.line), str(p.column), p.what): count
        for build, every in points.items()
        for p, count in every.items()
    }


def code_found(ucis: Any, outer: str) -> dict[tuple[str, ...], int]:
    """Return the same, as pyucis reads it."""
    counts: dict[tuple[str, ...], int] = {}
    for build in ucis.scopes(ScopeTypeT.INSTANCE):
        inner = [(f"{outer}.{one.getScopeName()}", one) for one in build.scopes(ScopeTypeT.INSTANCE)]
        for path, instance in ((outer, build), *inner):
            for kind, bins in (
                (ScopeTypeT.BLOCK, CoverTypeT.STMTBIN),
                (ScopeTypeT.BRANCH, CoverTypeT.BRANCHBIN),
            ):
                for scope in instance.scopes(kind):
                    for bin_ in scope.coverItems(bins):
                        at = bin_.getSourceInfo()
                        what = "block" if kind == ScopeTypeT.BLOCK else bin_.getName()
                        place = (at.file.getFileName(), str(at.line), str(at.token), what)
                        counts[build.getScopeName(), path, *place] = bin_.getCoverData().data
    return counts


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
    ucis = read_back(write_ucis(tmp_path / "t.xml", CoverageDatabase([]), code))
    assert code_found(ucis, "TOP.top") == code_of(code)
    assert sorted(code_of(code).values()) == [
        n for first, last in ((0, 2 * bins), (100, 100 + bins), (200, 200 + bins)) for n in range(first, last)
    ]
