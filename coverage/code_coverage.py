"""Code coverage: sets counters against the elaborated design and the waivers.

Nothing is merged over instances or models: each instance in each model must hit each of its bins. A
bit of one instance never stands for the same bit of another, narrower or wider one. Only generate
blocks are merged: each must be elaborated in some model.

Kinds of bins:

    line        a procedural block that runs
    branch      each way of an if, else if, else, or conditional operator
    expression  each way in which the terms of a condition decide it
    toggle      each bit of each signal, port and register: rising, and falling
    fsm         each state of a state machine, and each arc that its logic can take
    antecedent  the left side of each assertion: one that never fires it asserts nothing
    generate    each generate block: elaborated

Every bit of every signal of the elaborated design must have its two toggle counters: one that
Verilator left out is a problem, not a bin less. A line with logical operators but without expression
counters (Verilator gives up beyond 32 ways) is a bin that is not hit.
"""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

from triaxis.coverage.code_counters import FALL, RISE, Counters, Point
from triaxis.coverage.elaboration import Instance
from triaxis.coverage.stages import share
from triaxis.coverage.waiver_upkeep import WaivedPlace, other_rtl, stale_patterns
from triaxis.coverage.waivers import KINDS, BoundError, Waiver, module_code
from triaxis.golden.errors import InputError

# Of cover properties.
_PROPERTIES = ("fsm", "antecedent")

_LABEL = re.compile(r"\bbegin\s*:\s*(\w+)")

# What stands for the ways of a condition that Verilator does not count.
_NOT_COUNTED = "condition without counters"

_Applying = list[tuple[Waiver, dict[str, int]]]


@dataclass(frozen=True)
class ModelCoverage:
    """What was measured on one model: its counters, and its elaborated design, outer instances first."""

    name: str
    counters: Counters
    instances: Mapping[str, Instance]


@dataclass(frozen=True)
class GenerateBlock:
    """A generate block in the source, by its label."""

    module: str
    file: str
    line: int
    label: str


def generate_blocks(sources: Iterable[Path]) -> list[GenerateBlock]:
    """Return the labelled generate blocks of sources that hold one module each, named as the file is."""
    found: list[GenerateBlock] = []
    for source in sources:
        for number, line in enumerate(source.read_text().splitlines(), 1):
            code = line.partition("//")[0]
            labels = (match[1] for match in _LABEL.finditer(code))
            found += [GenerateBlock(source.stem, source.name, number, label) for label in labels]
    return found


@dataclass
class Total:
    """How many bins there are, were hit, and were not hit but waived."""

    hit: int = 0
    waived: int = 0
    total: int = 0

    @property
    def percent(self) -> float | None:
        """Return the share of bins that were hit or are waived, rounded down; None where there are none."""
        return share(self.hit + self.waived, self.total)

    def add(self, other: "Total") -> None:
        """Add the bins of another total."""
        self.hit += other.hit
        self.waived += other.waived
        self.total += other.total


@dataclass(frozen=True)
class Bin:
    """One bin, for people."""

    model: str
    kind: str
    file: str
    line: int
    what: str
    instance: str

    def __str__(self) -> str:
        """Return one line."""
        return f"{self.file}:{self.line}: {self.kind} {self.what}, {self.instance}, {self.model}"


@dataclass
class Assessment:
    """Totals by file and kind, what is not covered, and what is wrong.

    ``waived`` counts the bins of each waiver by its number, ``places`` says where they are; ``elaborated``
    holds the generate blocks that exist in some model, by module and label; ``asserted`` the assertions that
    do, by the module in which each is, its own and its label; ``void`` the numbers of the waivers that hold
    no more.
    """

    files: dict[tuple[str, str], Total] = field(default_factory=dict)
    uncovered: list[Bin] = field(default_factory=list)
    problems: list[str] = field(default_factory=list)
    waived: dict[int, int] = field(default_factory=dict)
    places: dict[int, set[WaivedPlace]] = field(default_factory=dict)
    elaborated: set[tuple[str, str]] = field(default_factory=set)
    asserted: set[tuple[str, str, str]] = field(default_factory=set)
    void: set[int] = field(default_factory=set)

    @property
    def totals(self) -> dict[str, Total]:
        """Return the totals by kind."""
        totals = {kind: Total() for kind in KINDS}
        for (_, kind), total in self.files.items():
            totals[kind].add(total)
        return totals

    @property
    def passed(self) -> bool:
        """Return whether there are bins of all kinds, all are covered, and nothing is wrong."""
        return not self.uncovered and not self.problems and all(t.total for t in self.totals.values())

    def add(self, other: "Assessment") -> None:
        """Add what was found on other models."""
        for key, total in other.files.items():
            self.files.setdefault(key, Total()).add(total)
        self.uncovered += other.uncovered
        self.problems += other.problems
        for number, count in other.waived.items():
            self.waived[number] = self.waived.get(number, 0) + count
        for number, places in other.places.items():
            self.places.setdefault(number, set()).update(places)
        self.elaborated |= other.elaborated
        self.asserted |= other.asserted
        self.void |= other.void

    def refute(self, waiver: Waiver, reason: str) -> None:
        """Take note that a waiver holds no more."""
        self.void.add(waiver.number)
        self.problems.append(f"{waiver.name}: {reason}")

    def cover(self, waiver: Waiver, place: WaivedPlace) -> None:
        """Take note of where a waiver covers bins."""
        self.places.setdefault(waiver.number, set()).add(place)

    def count_hit(self, file: str, kind: str, count: int) -> None:
        """Count bins that were hit and that no waiver is about."""
        self.files.setdefault((file, kind), Total()).add(Total(count, 0, count))

    def count(self, bin_: Bin, hit: bool, waiver: Waiver | None) -> None:
        """Count one bin, hit or not, and its waiver."""
        waived = waiver is not None and not hit
        self.files.setdefault((bin_.file, bin_.kind), Total()).add(Total(int(hit), int(waived), 1))
        if waiver is not None:
            self.waived[waiver.number] = self.waived.get(waiver.number, 0) + 1
            if hit:
                self.refute(waiver, f"is hit: {bin_}")
        elif not hit:
            self.uncovered.append(bin_)


@cache
def _source(path: str) -> list[str]:
    """Return the lines of a source, without spaces around them; none where it is not there any more."""
    file = Path(path)
    return [line.strip() for line in file.read_text(encoding="utf-8").splitlines()] if file.is_file() else []


def _for_module(waivers: list[Waiver], kind: str, module: str) -> list[Waiver]:
    return [w for w in waivers if w.kind == kind and (module in w.modules or "*" in w.modules)]


def _variables(instances: Mapping[str, Instance]) -> dict[str, dict[str, int]]:
    """Return for each path what expressions know there: the parameters around it and its own."""
    top = next(iter(instances.values()))
    width, margin_bits = top.parameters["W"], top.parameters.get("M", 0)
    numbers = {"W": width, "M": margin_bits, "L": 2**width - 1, "margin": 2**margin_bits - 1}
    found: dict[str, dict[str, int]] = {}
    for path, instance in instances.items():
        outer = path.rpartition(".")[0]
        while outer and outer not in found:
            outer = outer.rpartition(".")[0]
        found[path] = {**found.get(outer, numbers), **instance.parameters}
    return found


class _ModelAssessor:
    def __init__(self, model: ModelCoverage, waivers: list[Waiver]) -> None:
        self.assessment = Assessment()
        self._model = model
        self._waivers = waivers
        self._variables = _variables(model.instances)
        self._left = dict(model.counters.toggles)

    def run(self) -> Assessment:
        points: dict[str, dict[Point, int]] = {}
        for point, count in self._model.counters.points.items():
            points.setdefault(point.instance, {})[point] = count
        for instance in self._model.instances.values():
            self._toggles(instance)
            self._points(instance, points.pop(instance.path, {}))
            self.assessment.elaborated |= {(instance.module, label) for label in instance.blocks}
        for path, found in list(points.items()):
            if all(point.kind in _PROPERTIES for point in found):
                self._properties(path, points.pop(path))
        unknown = [f"{path}: {bit}" for path, bit in self._left] + list(points)
        self._problems(f"{what} is counted but not in the design" for what in unknown)
        return self.assessment

    def _problems(self, problems: Iterable[str]) -> None:
        self.assessment.problems += [f"{self._model.name}: {problem}" for problem in problems]

    def _applying(self, kind: str, instance: Instance) -> _Applying:
        """Return the waivers for an instance, each with what its expressions know there."""
        known = self._variables[instance.path]
        found: _Applying = []
        for waiver in _for_module(self._waivers, kind, instance.module):
            numbers = waiver.applies(self._model.name, instance.path)
            if numbers is not None:
                found.append((waiver, {**known, **numbers}))
        return found

    def _place(self, instance: Instance, what: str, at: str = "") -> WaivedPlace:
        return WaivedPlace(self._model.name, instance.module, instance.path, what, at)

    def _toggles(self, instance: Instance) -> None:
        waivers = self._applying("toggle", instance)
        for signal in instance.signals:
            waived = _constant_bits(waivers, signal.name, signal.bits)
            for waiver in waived.values():
                self.assessment.cover(waiver, self._place(instance, signal.name))
            names = [f"{signal.name}[{bit}]" for bit in signal.bits] or [signal.name]
            for bit, name in zip(signal.bits or range(1), names, strict=True):
                self._bit(instance.path, name, waived.get(bit))

    def _bit(self, path: str, name: str, waiver: Waiver | None) -> None:
        toggle = self._left.pop((path, name), None)
        if toggle is None or toggle.rises is None or toggle.falls is None:
            self._problems([f"{path}: {name} has no toggle counters"])
        elif waiver is None and toggle.rises and toggle.falls:
            self.assessment.count_hit(toggle.file, "toggle", 2)
        else:
            for edge, count in ((RISE, toggle.rises), (FALL, toggle.falls)):
                place = Bin(self._model.name, "toggle", toggle.file, toggle.line, name + edge, path)
                self.assessment.count(place, count > 0, waiver)

    def _properties(self, path: str, points: dict[Point, int]) -> None:
        """Count cover properties: of modules that are bound to an instance, with no other counters."""
        outer = (path.rsplit(".", depth)[0] for depth in range(path.count(".")))
        self._variables[path] = next(self._variables[one] for one in outer if one in self._variables)
        # Verilator adds the parameters of an instance to the name of its module.
        module = next(iter(points)).module.partition("__")[0]
        self.assessment.elaborated |= {(module, point.what) for point in points}
        self._points(Instance(path, module), points)

    def _points(self, instance: Instance, points: dict[Point, int]) -> None:
        # Counting begins in reset, after power-up.
        points = {p: n for p, n in points.items() if p.kind != "line" or p.line not in instance.initial}
        counted = {point.line for point in points if point.kind == "expression"}
        file = f"{instance.module}.sv"
        for line in sorted(instance.conditions - counted):
            points[Point("expression", file, line, 0, _NOT_COUNTED, instance.path)] = 0
        waivers = {kind: self._applying(kind, instance) for kind in {point.kind for point in points}}
        for p, count in points.items():
            line = _source(p.path)[p.line - 1] if p.line <= len(_source(p.path)) else ""
            waiver = next((w for w, known in waivers[p.kind] if w.waives(p.what, known, line)), None)
            if waiver is not None:
                self.assessment.cover(waiver, self._place(instance, p.what, line))
            place = Bin(self._model.name, p.kind, p.file, p.line, p.what, instance.path)
            self.assessment.count(place, count > 0, waiver)


def _constant_bits(waivers: _Applying, signal: str, bits: range) -> dict[int, Waiver]:
    """Return the waiver of each bit that one waives: the first in the file."""
    found: dict[int, Waiver] = {}
    for waiver, variables in waivers:
        try:
            for bit in waiver.constant_bits(signal, bits, variables):
                found.setdefault(bit, waiver)
        except BoundError as error:
            raise InputError(f"{waiver.name}: {error}") from error
    return found


def assess_model(model: ModelCoverage, waivers: list[Waiver]) -> Assessment:
    """Return how the bins of one model are covered."""
    return _ModelAssessor(model, waivers).run()


def conclude(assessment: Assessment, blocks: list[GenerateBlock], waivers: list[Waiver]) -> Assessment:
    """Return the assessment of all models with what only all together show.

    Generate blocks that no model elaborates; waivers of RTL that has changed, that cover no bin, or with a
    pattern that fits none.
    """
    whole = Assessment()
    whole.add(assessment)
    for block in blocks:
        fitting = (w for w in _for_module(waivers, "generate", block.module) if w.waives(block.label, {}))
        first = next(fitting, None)
        place = Bin("any model", "generate", block.file, block.line, block.label, block.module)
        whole.count(place, (block.module, block.label) in whole.elaborated, first)
        if first is not None:
            whole.cover(first, WaivedPlace(place.model, block.module, block.module, block.label))
    code = module_code()
    for waiver in waivers:
        if said := other_rtl(waiver, code):
            whole.refute(waiver, said)
        if not whole.waived.get(waiver.number):
            whole.refute(waiver, "covers no bin that an earlier one does not cover")
        for reason in stale_patterns(waiver, whole.places.get(waiver.number, ())):
            whole.refute(waiver, reason)
    return whole
