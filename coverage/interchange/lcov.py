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

Files are named from the checkout on, so run genhtml there.
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from itertools import groupby
from pathlib import Path

from triaxis.coverage.code_counters import Point, read_counters
from triaxis.golden.errors import InputError
from triaxis.golden.outputs import write_whole

_BRANCH = "branch"
# The first way of a statement, by its second, which Verilator places one column further on.
_FIRST_WAYS = {"else": "if", "cond_else": "cond_then"}


def read_code(path: Path, root: Path) -> dict[Point, int]:
    """Return the line and branch bins that a run counted, with files named from ``root`` on.

    Raise InputError where the file is damaged or cut short, or counts files outside of ``root``.
    """
    counts: dict[Point, int] = {}
    for point, count in read_counters(path, toggles=False).points.items():
        if point.kind not in ("line", _BRANCH):
            continue
        if not Path(point.path).is_relative_to(root):
            raise InputError(
                f"{path}: counts {point.path}, which is not below {root}: run `triaxis coverage code` here"
            )
        counts[point._replace(path=Path(point.path).relative_to(root).as_posix())] = count
    if not counts:
        raise InputError(f"{path}: no line or branch counters: run `triaxis coverage code`")
    return counts


def _numbers(ranges: str) -> tuple[int, ...]:
    """Return the lines in a text such as ``28-32,35``."""
    found: list[int] = []
    for text in filter(None, ranges.split(",")):
        first, _, last = text.partition("-")
        found += range(int(first), int(last or first) + 1)
    return tuple(found)


def branch_statements(points: Iterable[Point]) -> list[list[Point]]:
    """Return the ways of each statement that branches, statements and ways in the order of the source.

    Verilator counts ``else if`` chains arm by arm: an arm that is followed by another ``if`` is a
    statement of one way, the last two arms are one of two. So is each arm of a case by itself.
    """
    ways = sorted((p for p in points if p.kind == _BRANCH), key=lambda p: (p.path, p.line, p.column))
    statements: list[list[Point]] = []
    for _, same_line in groupby(ways, key=lambda p: (p.path, p.line)):
        open_ways: dict[tuple[int, str], list[Point]] = {}
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


def _merged(counters: Iterable[Path], root: Path) -> Counter[Point]:
    """Return the counts of each bin, added over instances and models."""
    counts: Counter[Point] = Counter()
    for file in counters:
        for point, count in read_code(file, root).items():
            counts[point._replace(instance="", module="")] += count
    return counts


def _tracefile(counts: Mapping[Point, int]) -> Iterator[str]:
    for file, here in groupby(sorted(counts, key=lambda p: p.path), key=lambda p: p.path):
        yield f"TN:{_TEST}"
        yield f"SF:{file}"
        yield from _record(list(here), counts)
        yield "end_of_record"


def _record(points: list[Point], counts: Mapping[Point, int]) -> Iterator[str]:
    """Give the branches and lines of one file, each with their totals."""
    lines: dict[int, int] = {}
    for point in points:
        for line in _numbers(point.lines):
            lines[line] = max(lines.get(line, 0), counts[point])
    taken: list[int] = []
    blocks: dict[int, int] = {}
    for statement in branch_statements(points):
        line = statement[0].line
        block = blocks[line] = blocks.get(line, -1) + 1
        ways = [counts[way] for way in statement]
        yield from (f"BRDA:{line},{block},{way},{count}" for way, count in enumerate(ways))
        lines[line] = max(lines.get(line, 0), sum(ways))
        taken += ways
    yield f"BRF:{len(taken)}"
    yield f"BRH:{sum(map(bool, taken))}"
    yield from (f"DA:{line},{lines[line]}" for line in sorted(lines))
    yield f"LF:{len(lines)}"
    yield f"LH:{sum(map(bool, lines.values()))}"
