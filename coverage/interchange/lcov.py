"""An lcov tracefile of line and branch coverage, for genhtml and whatever else reads one.

It is a coarser view than `triaxis.coverage.code_coverage`, which decides: there each instance in each
model must hit each bin, here counts are added over instances and models, because lcov knows files and
lines only.

- A way of a branch counts as often as it was taken. A statement of two ways is one block; an arm of an
  ``else if`` chain that is followed by another ``if`` is a block of one way.
- A line counts as often as the bin that was hit most of those whose statements stand on it; the line of
  a branch counts all its ways.
- Waivers change nothing: what no instance of any model hits shows as not hit, waived or not.
- Expressions and toggles, and blocks that no model elaborates, are not in it.

Files are named from the checkout on, so run genhtml there. Counters are read here with columns and the lines
of a block, beside `triaxis.coverage.code_counters`, which is about what must be hit: it keeps no line ranges,
and reads toggles too, which are nineteen in twenty of the bins.
"""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

from triaxis.coverage.code_counters import read_lines
from triaxis.golden.errors import InputError
from triaxis.golden.outputs import write_whole

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


_TEST = "triaxis"


def write_lcov(path: Path, counters: Iterable[Path], root: Path) -> Path:
    """Write the tracefile of some models' counters (coverage.dat files), whole or not at all.

    ``root`` is the folder from which files are named. Raise InputError where counters are damaged, or
    the tracefile cannot be written.
    """
    text = "".join(f"{line}\n" for line in _tracefile(_merged(counters, root)))
    return write_whole(path, text)


def _merged(counters: Iterable[Path], root: Path) -> dict[Place, int]:
    """Return the counts of each bin, added over instances and models."""
    counts: dict[Place, int] = {}
    for file in counters:
        for point in read_code_points(file, root):
            counts[point.place] = counts.get(point.place, 0) + point.count
    return counts


def _tracefile(counts: Mapping[Place, int]) -> Iterator[str]:
    places = sorted(counts, key=lambda p: p.file)
    for file, here in groupby(places, key=lambda p: p.file):
        yield f"TN:{_TEST}"
        yield f"SF:{file}"
        yield from _record(list(here), counts)
        yield "end_of_record"


def _record(places: Sequence[Place], counts: Mapping[Place, int]) -> Iterator[str]:
    """Give the branches and lines of one file, each with their totals."""
    lines: dict[int, int] = {}
    for place in places:
        for line in place.lines:
            lines[line] = max(lines.get(line, 0), counts[place])
    taken: list[int] = []
    blocks: dict[int, int] = {}
    for statement in branch_statements(places):
        line = statement[0].line
        block = blocks[line] = blocks.get(line, -1) + 1
        ways = [counts[place] for place in statement]
        yield from (f"BRDA:{line},{block},{way},{count}" for way, count in enumerate(ways))
        lines[line] = max(lines.get(line, 0), sum(ways))
        taken += ways
    yield f"BRF:{len(taken)}"
    yield f"BRH:{sum(map(bool, taken))}"
    yield from (f"DA:{line},{lines[line]}" for line in sorted(lines))
    yield f"LF:{len(lines)}"
    yield f"LH:{sum(map(bool, lines.values()))}"
