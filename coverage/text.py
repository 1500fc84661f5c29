"""Coverage as lines of text."""

from collections.abc import Iterable

from triaxis.coverage.covergroup import PointReport

_NAMED = 3


def coverage_lines(reports: Iterable[PointReport]) -> list[str]:
    """Return one line for each coverpoint: bins hit, and the first that are missing."""
    lines: list[str] = []
    for point in reports:
        line = f"{point.name:<12} {point.hit:>3} of {point.total}"
        if point.missing:
            named = ", ".join(point.missing[:_NAMED])
            more = len(point.missing) - _NAMED
            line += f"   missing: {named}" + (f" and {more} more" if more > 0 else "")
        lines.append(line)
    return lines
