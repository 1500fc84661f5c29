"""UCIS XML, the interchange format of IEEE/Accellera UCIS 1.0, of functional coverage and of code.

What is what:

    instance      one for each coverage model, that is, for each configuration, of the board for all; for
                  code, one for each build measured, and below it one for each instance that has counters
    covergroup    an item of the model, by its name; its meaning is the comment
    coverpoint    the point of an item that has one; its bins are of type bins, ignore or illegal
    cross         the bins that count of an item that has several
    coverpoint    each point of a cross, of weight 0: a bin's count is the sum of its part of the cross
    coverpoint    ``.. excluded``, of weight 0: the bins of a cross that do not count, as ignore or illegal
    at_least      hits that a bin needs, of a point or cross; a bin that needs fewer has it as an attribute
    block         a statement block, at its line; branch: a statement that branches, with its ways

Excluded bins of a cross stand in a point of their own because readers take every bin of a cross for one
that counts: pyucis drops their type. Each excluded bin has its reason, and the test that supports it.

Our own writer: that of pyucis drops the types of bins of a cross and every reason, and a sign-off does
not need pyucis.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from itertools import groupby
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import numpy as np
import numpy.typing as npt

from triaxis.coverage.code_counters import Point
from triaxis.coverage.counts import Counts, CoverageDatabase
from triaxis.coverage.cover_model import Bin, CoverItem, CoverModel, Hits, Kind
from triaxis.coverage.interchange.lcov import branch_statements
from triaxis.golden.outputs import write_whole
from triaxis.sim.configuration import parse_configuration

_VERSION = "1.0"
_TOOL = "triaxis"
# What runs drive, by how the name of a model begins; of the core its configuration tells.
_TOPS = {"mesh": "triaxis_mesh", "board": "nexys4ddr_top"}
_CATEGORY = "UCIS:Simulator"


@dataclass(frozen=True)
class TestRecord:
    """A run that brought in coverage: its name, whether it passed, and the command that repeats it."""

    # Not a test of ours, whatever its name.
    __test__ = False

    name: str
    passed: bool
    command: str = ""
    seed: int | None = None


def write_ucis(
    path: Path,
    database: CoverageDatabase,
    code: Mapping[str, Mapping[Point, int]],
    tests: Sequence[TestRecord],
    written: datetime | None = None,
) -> Path:
    """Write functional coverage, and code coverage by the name of its build, whole or not at all.

    ``written``: when, now unless given. Raise InputError where the file cannot be written.
    """
    root = _Document(database, code, tests, written or datetime.now(UTC)).root
    indent(root, " ")
    return write_whole(path, tostring(root, encoding="utf-8", xml_declaration=True) + b"\n")


class _Document:
    def __init__(
        self,
        database: CoverageDatabase,
        code: Mapping[str, Mapping[Point, int]],
        tests: Sequence[TestRecord],
        written: datetime,
    ) -> None:
        when = written.astimezone(UTC).strftime("%Y-%m-%dT%H:%M:%S")
        self.root = Element("UCIS", ucisVersion=_VERSION, writtenBy=_TOOL, writtenTime=when)
        self._instances = 0
        modelled = [_source(model) for model, _ in database]
        counted = sorted({point.path for points in code.values() for point in points})
        self._files = {name: number for number, name in enumerate(dict.fromkeys([*modelled, *counted]), 1)}
        for name, number in self._files.items():
            SubElement(self.root, "sourceFiles", fileName=name, id=str(number))
        self._history(tests, when)
        for model, counts in database:
            self._model(model, counts)
        for name, points in code.items():
            self._build(name, points)

    def _history(self, tests: Iterable[TestRecord], when: str) -> None:
        for number, test in enumerate(tests):
            node = SubElement(
                self.root, "historyNodes", historyNodeId=str(number), logicalName=test.name,
                testStatus=_flag(test.passed), date=when, toolCategory=_CATEGORY, ucisVersion=_VERSION,
                vendorId=_TOOL, vendorTool=_TOOL, vendorToolVersion=_VERSION,
            )  # fmt: skip
            if test.command:
                node.set("cmd", test.command)
            if test.seed is not None:
                node.set("seed", str(test.seed))

    def _id(self, parent: Element, tag: str, file: str, line: int = 1, count: int = 1) -> None:
        SubElement(parent, tag, file=str(self._files[file]), line=str(line), inlineCount=str(count))

    def _instance(self, name: str, module: str, file: str, parent: Element | None = None) -> Element:
        key = str(self._instances)
        self._instances += 1
        found = SubElement(
            self.root, "instanceCoverages", name=name, key=key, instanceId=key, moduleName=module
        )
        if parent is not None:
            found.set("parentInstanceId", parent.attrib["instanceId"])
        self._id(found, "id", file)
        return found

    def _model(self, model: CoverModel[Any], counts: Counts) -> None:
        source = _source(model)
        module = _module(model.name)
        instance = self._instance(model.name, module, source)
        for item in model.items:
            coverage = SubElement(instance, "covergroupCoverage")
            group = SubElement(coverage, "cgInstance", name=item.name, key="0")
            SubElement(group, "options", comment=item.meaning, per_instance="true")
            identity = SubElement(group, "cgId", cgName=item.name, moduleName=module)
            self._id(identity, "cginstSourceId", source)
            self._id(identity, "cgSourceId", source)
            for key, point in enumerate(_points(item, counts.hits[item.name])):
                point.set("key", str(key))
                group.append(point)

    def _build(self, name: str, counts: Mapping[Point, int]) -> None:
        by_instance = sorted(counts, key=lambda p: p.instance)
        # Verilator names its own root, then the module that is built.
        top = by_instance[0].instance.split(".")[:2]
        outer = ".".join(top)
        first = next((p.path for p in by_instance if p.instance == outer), by_instance[0].path)
        parent = self._instance(name, top[-1], first)
        for path, group in groupby(by_instance, key=lambda p: p.instance):
            here = {point: counts[point] for point in group}
            one, inner = next(iter(here)), path[len(outer) + 1 :]
            place = self._instance(inner, one.module, one.path, parent) if inner else parent
            self._blocks(place, here)
            self._branches(place, here)

    def _blocks(self, instance: Element, counts: Mapping[Point, int]) -> None:
        blocks = [point for point in counts if point.kind == "line"]
        if not blocks:
            return
        coverage = SubElement(instance, "blockCoverage")
        for block in sorted(blocks, key=lambda p: (p.line, p.column)):
            statement = SubElement(coverage, "statement", alias=f"line {block.line}")
            self._id(statement, "id", block.path, block.line, block.column)
            _contents(SubElement(statement, "bin"), counts[block])

    def _branches(self, instance: Element, counts: Mapping[Point, int]) -> None:
        statements = branch_statements(counts)
        if not statements:
            return
        coverage = SubElement(instance, "branchCoverage")
        for ways in statements:
            first = ways[0]
            statement = SubElement(
                coverage, "statement", statementType="if", branchExpr=f"line {first.line}:{first.column}"
            )
            self._id(statement, "id", first.path, first.line, first.column)
            for way in ways:
                branch = SubElement(statement, "branch")
                self._id(branch, "id", way.path, way.line, way.column)
                _contents(SubElement(branch, "branchBin", alias=way.what), counts[way])


def _source(model: CoverModel[Any]) -> str:
    """Return the file that defines a model, as far as it says."""
    modules = model.sources.modules
    return f"{modules[0].removeprefix('triaxis.').replace('.', '/')}.py" if modules else model.name


def _module(model: str) -> str:
    """Return the module that the runs of a model drive; of a model of no block its own name."""
    block, _, config = model.partition("_")
    return parse_configuration(config).top if block == "core" else _TOPS.get(block, model)


def _flag(value: bool) -> str:
    return "true" if value else "false"


def _contents(parent: Element, count: int) -> None:
    SubElement(parent, "contents", coverageCount=str(count))


def _attribute(parent: Element, key: str, kind: str, text: str) -> None:
    SubElement(parent, "userAttr", key=key, type=kind).text = text


def _points(item: CoverItem[Any], hits: Hits) -> Iterator[Element]:
    """Give the coverpoints of an item, then its cross."""
    counts: list[int] = hits.tolist()
    goal = max((b.goal for b in item.bins if b.exclusion is None), default=1)
    if len(item.points) == 1:
        point = _coverpoint(item.points[0].name, 1, goal)
        for number, (one, count) in enumerate(zip(item.bins, counts, strict=True)):
            _coverpoint_bin(point, number, one, count, goal)
        yield point
        return
    yield from _parts(item, hits)
    name = " x ".join(point.name for point in item.points)
    excluded = [(n, b) for n, b in enumerate(item.bins) if b.exclusion is not None]
    if excluded:
        point = _coverpoint(f"{name} excluded", 0, 1)
        for number, one in excluded:
            _coverpoint_bin(point, number, one, counts[number], one.goal)
        yield point
    yield _cross(item, name, counts, goal)


def _coverpoint(name: str, weight: int, goal: int) -> Element:
    point = Element("coverpoint", name=name)
    SubElement(point, "options", weight=str(weight), at_least=str(goal))
    return point


def _coverpoint_bin(point: Element, number: int, one: Bin, count: int, goal: int) -> None:
    kind = one.exclusion.kind.value if one.exclusion else "bins"
    found = SubElement(point, "coverpointBin", name=one.name, key=str(number), type=kind)
    code = {"from": str(number), "to": str(number)}
    _contents(SubElement(found, "range", code), count)
    _attributes(found, one, goal)


def _attributes(found: Element, one: Bin, goal: int) -> None:
    """Add why a bin does not count, or that it needs fewer hits than others."""
    if one.exclusion is not None:
        _attribute(found, "reason", "str", one.exclusion.reason)
        _attribute(found, "proof", "str", one.exclusion.test)
        for key, text in (("category", one.exclusion.category), ("owner", one.exclusion.owner)):
            if text:
                _attribute(found, key, "str", text)
    elif one.goal != goal:
        _attribute(found, "at_least", "int", str(one.goal))


def _cross(item: CoverItem[Any], name: str, counts: Sequence[int], goal: int) -> Element:
    cross = Element("cross", name=name)
    SubElement(cross, "options", at_least=str(goal))
    for point in item.points:
        SubElement(cross, "crossExpr").text = point.name
    places = np.stack(np.unravel_index(np.arange(item.size), item.shape), axis=1).tolist()
    for number, (one, count, indices) in enumerate(zip(item.bins, counts, places, strict=True)):
        if one.exclusion is not None:
            continue
        found = SubElement(cross, "crossBin", name=one.name, key=str(number), type="bins")
        for index in indices:
            SubElement(found, "index").text = str(index)
        _contents(found, count)
        _attributes(found, one, goal)
    return cross


def _parts(item: CoverItem[Any], hits: Hits) -> Iterator[Element]:
    """Give each point of a cross; a bin all of whose crossings are excluded is so itself."""
    illegal = item.illegal.reshape(item.shape)
    excluded = np.array([b.exclusion is not None for b in item.bins], np.bool_).reshape(item.shape)
    sums = hits.reshape(item.shape)
    for axis, point in enumerate(item.points):
        others = tuple(n for n in range(len(item.points)) if n != axis)
        part = _coverpoint(point.name, 0, 1)
        kinds = _kinds(excluded.all(others), illegal.all(others))
        for number, (name, kind, count) in enumerate(
            zip(point.bins, kinds, sums.sum(others).tolist(), strict=True)
        ):
            found = SubElement(part, "coverpointBin", name=name, key=str(number), type=kind)
            _contents(SubElement(found, "range", {"from": str(number), "to": str(number)}), count)
        yield part


def _kinds(excluded: npt.ArrayLike, illegal: npt.ArrayLike) -> list[str]:
    texts = np.where(illegal, Kind.ILLEGAL.value, np.where(excluded, Kind.IGNORE.value, "bins"))
    return texts.tolist()
