"""Tracefiles of lcov say what the counters say, and UCIS XML read back by pyucis what the database says."""

from dataclasses import replace
from datetime import UTC, datetime
from typing import Any
from xml.etree import ElementTree

import pytest

from triaxis.coverage.counts import Counts, CoverageDatabase
from triaxis.coverage.cover_model import CoverItem, CoverModel, Coverpoint, Exclusion, Kind, MaskPoint
from triaxis.coverage.interchange.lcov import read_code, write_lcov
from triaxis.coverage.interchange.ucis_xml import TestRecord, write_ucis
from triaxis.coverage.tests.counter_files import BINS, FIRST, SECOND, SOURCE, write_counters
from triaxis.golden.errors import InputError


@pytest.fixture
def source(tmp_path):
    path = tmp_path / "dut" / "leaf.sv"
    path.parent.mkdir()
    path.write_text(SOURCE)
    return path


@pytest.fixture
def models(tmp_path, source):
    """Counters of two models: the arm in line 10, and the way of line 14, are hit in no instance of any."""
    one = {FIRST: [10, 4, 6, 9, 0, 2, 7, 0, 5, 1, 2, 8, 3], SECOND: [10, 0, 10, 9, 0, 9, 0, 0, 5, 1, 2, 8, 3]}
    two = {FIRST: [100, 0, 100, 50, 0, 0, 50, 0, 1, 1, 0, 60, 5]}
    counts = {"one": one, "two": two}
    return [write_counters(tmp_path / f"{name}.dat", source, each) for name, each in counts.items()]


def tracefile(path):
    """Return the values in a tracefile by their keys."""
    found = {}
    for line in path.read_text().splitlines():
        key, _, value = line.partition(":")
        found.setdefault(key, []).append(value)
    return found


def test_counts_are_added_over_instances_and_models(models, tmp_path):
    lines = {2: 120, 3: 120, 4: 4, 5: 4, 6: 116, 7: 120, 9: 68, 10: 0, 11: 68, 12: 57, 14: 11, 15: 76}
    # By line, block and way.
    ways = ["3,0,0,4", "3,0,1,116", "10,0,0,0", "11,0,0,11", "11,0,1,57"]
    ways += ["14,0,0,0", "14,0,1,11", "14,1,0,3", "14,1,1,4"]
    assert tracefile(write_lcov(tmp_path / "t.info", models, tmp_path)) == {
        "TN": ["triaxis"], "SF": ["dut/leaf.sv"], "end_of_record": [""],
        "DA": [f"{line},{count}" for line, count in lines.items()], "BRDA": ways,
        "LF": ["12"], "LH": ["11"], "BRF": ["9"], "BRH": ["7"],
    }  # fmt: skip
    # A way without statements has no line.
    models[0].write_text(models[0].read_text().replace("\x01S\x026\x01", "\x01"))
    found = tracefile(write_lcov(tmp_path / "t.info", models[:1], tmp_path))
    assert "6,16" not in found["DA"] and "3,0,1,16" in found["BRDA"]


def test_counters_of_another_checkout_or_of_nothing_are_refused(models, tmp_path):
    with pytest.raises(InputError, match="which is not below"):
        write_lcov(tmp_path / "t.info", models, tmp_path / "golden")
    lines = models[0].read_text().splitlines(keepends=True)
    models[0].write_text("".join(line for line in lines if not ("_line/" in line or "_branch/" in line)))
    with pytest.raises(InputError, match="no line or branch counters"):
        write_lcov(tmp_path / "t.info", models, tmp_path)
    assert not list(tmp_path.glob("*.info*")) and not list(tmp_path.glob(".*"))


def test_each_model_is_of_the_module_that_its_runs_drive(tmp_path):
    modules = {
        "core_w8_m8": "triaxis_core", "core_w8_m8_certified": "triaxis_certified_core",
        "mesh_w16_m16_d64_g8_l8": "triaxis_mesh", "board": "nexys4ddr_top",
    }  # fmt: skip
    database = CoverageDatabase(replace(SMALL, name=name) for name in modules)
    root = ElementTree.parse(write_ucis(tmp_path / "a.xml", database, {}, [])).getroot()
    assert {one.get("name"): one.get("moduleName") for one in root.iter("instanceCoverages")} == modules
    assert {one.get("moduleName") for one in root.iter("cgId")} == set(modules.values())


SIZE = Coverpoint[Any]("size", ("<small> & 'low'", "medium", "large", "huge"), lambda s: s)
SIDE = Coverpoint[Any]("side", ("left", "right"), lambda s: s)
AXES = MaskPoint[Any]("axes", ("x", "y", "z"), lambda s: s)
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


def database_of(hits):
    database = CoverageDatabase([SMALL])
    database.add(Counts("small", SMALL.hash, {item.name: hits(item) for item in SMALL.items}))
    return database


def expected(item: CoverItem[Any], hits: list[int]) -> dict[tuple[str, str], tuple[int, str]]:
    """Return count and kind of each bin by point or cross."""
    names = [point.name for point in item.points]
    whole, found = " x ".join(names), dict[tuple[str, str], tuple[int, str]]()
    kinds = [one.exclusion.kind.value if one.exclusion else "bins" for one in item.bins]
    for one, kind, count in zip(item.bins, kinds, hits, strict=True):
        apart = kind != "bins" and len(names) > 1
        found[f"{whole} excluded" if apart else whole, one.name] = count, kind
    for place, point in enumerate(item.points if len(names) > 1 else ()):
        for name in point.bins:
            here = [n for n, one in enumerate(item.bins) if one.name.split(" / ")[place] == name]
            kind = min(kinds[n] for n in here)
            found[point.name, name] = sum(hits[n] for n in here), kind
    return found


def test_pyucis_reads_every_bin_run_and_count(models, rng, tmp_path):
    pytest.importorskip("ucis", reason="no pyucis here: it is of the dependency group regress")
    # By name, not by import: what is optional is not known to the type checker either.
    names = "cover_type_t", "history_node_kind", "scope_type_t", "xml.xml_factory"
    cover, history, scope, xml = (pytest.importorskip(f"ucis.{name}") for name in names)
    covers, scopes = cover.CoverTypeT, scope.ScopeTypeT
    kinds = {"bins": covers.CVGBIN, "ignore": covers.IGNOREBIN, "illegal": covers.ILLEGALBIN}
    database = database_of(lambda item: rng.integers(0, 40, item.size) * rng.integers(0, 2, item.size))
    runs = [TestRecord("signoff", True, "make signoff", 1), TestRecord("code", False)]
    path = write_ucis(tmp_path / "t.xml", database, {}, runs, written=datetime(2026, 1, 2, tzinfo=UTC))
    read = xml.XmlFactory.read(str(path))
    nodes = read.historyNodes(history.HistoryNodeKind.TEST)
    assert [(node.getLogicalName(), node.getTestStatus()) for node in nodes] == [
        ("signoff", True),
        ("code", False),
    ]
    [instance], [(_, counts)], goals = list(read.scopes(scopes.INSTANCE)), database, {}
    for item, group in zip(SMALL.items, instance.scopes(scopes.COVERGROUP), strict=True):
        [only] = list(group.scopes(scopes.COVERINSTANCE))
        points = [*only.scopes(scopes.COVERPOINT), *only.scopes(scopes.CROSS)]
        found = {
            (point.getScopeName(), bin_.getName()): (bin_.getCoverData().data, kind)
            for point in points
            for kind, number in kinds.items()
            for bin_ in point.coverItems(number)
        }
        assert found == expected(item, counts.hits[item.name].tolist())
        goals |= {f"{item.name} {p.getScopeName()}": p.getAtLeast() for p in points[: len(item.points)]}
    assert goals == {"sizes size": 5, "crossed axes": 1, "crossed side": 1, "mixed size": 3}
    # Of code, every count of every instance.
    code = read_code(models[0], tmp_path)
    read = xml.XmlFactory.read(str(write_ucis(path, CoverageDatabase([]), {"one": code}, runs)))
    [build] = list(read.scopes(scopes.INSTANCE))
    kinds = (scopes.BLOCK, covers.STMTBIN), (scopes.BRANCH, covers.BRANCHBIN)
    for part in build.scopes(scopes.INSTANCE):
        bins = [b for kind, n in kinds for each in part.scopes(kind) for b in each.coverItems(n)]
        own = [count for point, count in code.items() if point.instance.endswith(part.getScopeName())]
        assert sorted(b.getCoverData().data for b in bins) == sorted(own) and len(own) == len(BINS)
