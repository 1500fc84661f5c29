"""Verilator's code coverage counters of one model, read from the file that a run writes.

The file is coverage.dat: a line ``C '<key>' <count>`` for each bin, the key being names and values
between \\x01 and \\x02. Our models count each instance by itself, and end the file with a line of
their own, so that one cut short is noticed.
"""

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

from triaxis.golden.errors import InputError
from triaxis.golden.input_file import read_input
from triaxis.golden.outputs import write_whole

FIRST_LINE = "# SystemC::Coverage-3"
LAST_LINE = "# end"
RISE, FALL = ":0->1", ":1->0"

_BIN = re.compile(
    r"C '\x01f\x02([^\x01]+)\x01l\x02(\d+)\x01n\x02(\d+)\x01t\x02(\w+)"
    r"\x01page\x02\w+/([^\x01]+)\x01o\x02([^\x01]+)(?:\x01S\x02((?:\d+(?:-\d+)?,?)+))?"
    r"\x01h\x02([^\x01']+)' (\d+)"
)
_TOGGLE = "\x01t\x02toggle\x01"
_KINDS = {"line": "line", "branch": "branch", "expr": "expression"}
# Cover properties: of state machines in modules so called, else of the left sides of assertions.
_PROPERTY, STATES = "user", "_states"
_IN_LOOP = re.compile(r"__BRA__(\d+)__KET__")
# Verilator counts the ways of an else-if chain as lines.
_WAYS = ("if", "elsif", "else", "case", "default")


@dataclass(slots=True)
class Toggle:
    """How often one bit of a signal rose and fell, and where the signal is declared.

    None where there is no such counter.
    """

    file: str
    line: int
    rises: int | None = None
    falls: int | None = None


class Point(NamedTuple):
    """One bin that is no toggle.

    ``instance``: of a cover property, with the blocks around it. ``lines``: those that run when it is hit, as
    in 28-32,35; often empty.
    """

    kind: str
    path: str
    line: int
    column: int
    what: str
    instance: str
    module: str = ""
    lines: str = ""

    @property
    def file(self) -> str:
        """Return the name of the file alone."""
        return self.path[self.path.rfind("/") + 1 :]


@dataclass
class Counters:
    """The counters of one model: toggles by instance and bit, and all other bins by themselves."""

    toggles: dict[tuple[str, str], Toggle] = field(default_factory=dict)
    points: Counter[Point] = field(default_factory=Counter)

    def count_toggle(self, instance: str, bit: str, file: str, line: int, edge: str, count: int) -> None:
        """Add to the counter of one edge of one bit."""
        toggle = self.toggles.get((instance, bit))
        if toggle is None:
            toggle = self.toggles[instance, bit] = Toggle(file, line)
        if edge == RISE:
            toggle.rises = (toggle.rises or 0) + count
        else:
            toggle.falls = (toggle.falls or 0) + count


def read_lines(path: Path) -> list[str]:
    """Return the lines of the bins in a coverage file; raise InputError where it is none, or cut short."""
    try:
        lines = read_input(path).decode().splitlines()
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: damaged: not text") from error
    if not lines or lines[0] != FIRST_LINE:
        raise InputError(f"{path}: not a coverage file: line 1 must read {FIRST_LINE}")
    if lines[-1] != LAST_LINE or len(lines) == 2:
        raise InputError(f"{path}: cut short after line {len(lines)}: run again")
    return lines[1:-1]


def add_files(paths: Sequence[Path], total: Path) -> None:
    """Write the sum of what runs of one model counted; raise InputError where they are not of one model."""
    files = [[line.rpartition(" ") for line in read_lines(path)] for path in paths]
    if any([key for key, _, _ in file] != [key for key, _, _ in files[0]] for file in files[1:]):
        raise InputError(f"{total.name}: counters of two builds, or damaged: run again")
    sums = np.sum([[int(count) for _, _, count in file] for file in files], 0).tolist()
    lines = [f"{key} {count}" for (key, _, _), count in zip(files[0], sums, strict=True)]
    write_whole(total, "\n".join([FIRST_LINE, *lines, LAST_LINE]) + "\n")


def read_counters(path: Path, toggles: bool = True) -> Counters:
    """Read the counters that a run wrote; raise InputError where the file is damaged or cut short.

    Without ``toggles``, nineteen in twenty of the bins are passed over.
    """
    counters = Counters()
    for number, line in enumerate(read_lines(path), 2):
        if not toggles and _TOGGLE in line:
            continue
        match = _BIN.fullmatch(line)
        if match is None or not _count(counters, match):
            raise InputError(f"{path}: line {number}: damaged, or written by another Verilator")
    return counters


def _count(counters: Counters, match: re.Match[str]) -> bool:
    """Add one line; return whether it is a bin of a known type."""
    path, line, column, kind, module, what, lines, instance, count = match.groups()
    if kind == "toggle":
        bit, edge = what[:-5], what[-5:]
        counters.count_toggle(instance, bit, path[path.rfind("/") + 1 :], int(line), edge, int(count))
        return edge in (RISE, FALL)
    if kind == _PROPERTY:
        kind = "fsm" if module.endswith(STATES) else "antecedent"
        instance = _IN_LOOP.sub(r"[\1]", instance.removesuffix(f".{what}")).replace("__DOT__", ".")
        instance, what = instance.removesuffix(f".{what}"), what.removesuffix("Antecedent")
    elif kind in _KINDS:
        kind = "branch" if what in _WAYS else _KINDS[kind]
    else:
        return False
    point = Point(kind, path, int(line), int(column), what, instance, module, lines or "")
    counters.points[point] += int(count)
    return True
