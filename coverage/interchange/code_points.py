"""Line and branch counters of one model with all that other tools ask for: columns, and the lines of a block.

Beside `triaxis.coverage.code_counters`, which is about what must be hit: it keeps no line ranges, and
reads toggles too, which are nineteen in twenty of the bins.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

from triaxis.coverage.code_counters import read_lines
from triaxis.golden.errors import InputError

_POINT = re.compile(
    r"C '\x01f\x02(?P<file>[^\x01]+)\x01l\x02(?P<line>\d+)\x01n\x02(?P<column>\d+)"
    r"\x01t\x02(?:line|branch)\x01page\x02v_\w+/(?P<module>[^\x01]+)\x01o\x02(?P<what>[^\x01]+)"
    r"(?:\x01S\x02(?P<lines>\d+(?:-\d+)?(?:,\d+(?:-\d+)?)*))?"
    r"\x01h\x02(?P<instance>[^\x01']+)' (?P<count>\d+)"
)
_OTHER_KINDS = ("\x01t\x02toggle\x01", "\x01t\x02expr\x01")
_BLOCK = "block"
# The first way of a statement, by its second, which Verilator places one column further on.
_FIRST_WAYS = {"else": "if", "cond_else": "cond_then"}


@dataclass(frozen=True, slots=True)
class Place:
    """Where a bin stands in the source. ``lines`` run when it is hit: none where a way is empty."""

    file: str
    line: int
    column: int
    what: str
    lines: tuple[int, ...]

    @property
    def is_branch(self) -> bool:
        """Return whether it is one way of a branch, not a block."""
        return self.what != _BLOCK


@dataclass(frozen=True, slots=True)
class CodePoint:
    """One line or branch bin of one instance, and how often it was hit."""

    place: Place
    module: str
    instance: str
    count: int


def read_code_points(path: Path, root: Path) -> list[CodePoint]:
    """Read the line and branch bins that a run wrote, with files named from ``root`` on.

    Raise InputError where the file is damaged or cut short, or counts files outside of ``root``.
    """
    found: list[CodePoint] = []
    for number, text in enumerate(read_lines(path), 2):
        if any(kind in text for kind in _OTHER_KINDS):
            continue
        match = _POINT.fullmatch(text)
        if match is None:
            raise InputError(f"{path}: line {number}: damaged, or written by another Verilator")
        found.append(_point(match, path, root))
    if not found:
        raise InputError(f"{path}: no line or branch counters: run `triaxis coverage code`")
    return found


def _point(match: re.Match[str], path: Path, root: Path) -> CodePoint:
    file = Path(match["file"])
    if not file.is_relative_to(root):
        raise InputError(
            f"{path}: counts {file}, which is not below {root}: run `triaxis coverage code` here"
        )
    place = Place(
        file.relative_to(root).as_posix(),
        int(match["line"]),
        int(match["column"]),
        match["what"],
        _numbers(match["lines"] or ""),
    )
    return CodePoint(place, match["module"], match["instance"], int(match["count"]))


def _numbers(ranges: str) -> tuple[int, ...]:
    """Return the lines in a text such as ``28-32,35``."""
    found: list[int] = []
    for text in filter(None, ranges.split(",")):
        first, _, last = text.partition("-")
        found += range(int(first), int(last or first) + 1)
    return tuple(found)


def branch_statements(places: Sequence[Place]) -> list[list[Place]]:
    """Return the ways of each statement that branches, statements and ways in the order of the source.

    Verilator counts ``else if`` chains arm by arm: an arm that is followed by another ``if`` is a
    statement of one way, the last two arms are one of two. So is each arm of a case by itself.
    """
    ways = sorted((p for p in places if p.is_branch), key=lambda p: (p.file, p.line, p.column))
    statements: list[list[Place]] = []
    for _, same_line in groupby(ways, key=lambda p: (p.file, p.line)):
        open_ways: dict[tuple[int, str], list[Place]] = {}
        for way in same_line:
            first = open_ways.get((way.column - 1, _FIRST_WAYS.get(way.what, "")))
            if first is None:
                statements.append(open_ways.setdefault((way.column, way.what), [way]))
            else:
                first.append(way)
    return statements
