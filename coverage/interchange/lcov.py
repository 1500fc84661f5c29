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

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import groupby
from pathlib import Path

from triaxis.coverage.interchange.code_points import Place, branch_statements, read_code_points
from triaxis.golden.outputs import write_whole

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
