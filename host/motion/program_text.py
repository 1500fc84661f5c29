"""The text of a G-code program, as both readers take it: its lines, or what controls may read otherwise.

What stands here of LinuxCNC was tried with its interpreter, rs274 of 2.9.
"""

import re
from pathlib import Path

from triaxis.golden.input_file import Place, read_input

COMMENT = re.compile(r"\([^)]*\)|;.*")
# Bytes of a line that LinuxCNC reads; what follows is a line of its own, and no comment any more.
LONGEST_LINE = 253
_LINE_END = re.compile(rb"\r*\n")
_CARRIAGE_RETURN = (
    "the line has a carriage return in it, a blank to some controls, and its end to others: correct it"
)
_STRANGE = re.compile(r"[^\t -~]")
_RUNS = re.compile(r"[(;]py(?:,|run|reload)")


def lines_of(path: Path) -> list[str]:
    """Return the lines of a program; raise InputError where a control may take one for another."""
    found = list[str]()
    data = read_input(path).removeprefix(b"\xef\xbb\xbf")
    for count, line in enumerate(_LINE_END.split(data.rstrip(b"\r")), 1):
        found.append(line.decode("utf-8", errors="replace"))
        _check(Place(path, count), found[-1], len(line))
    return found


def runs_python(text: str) -> bool:
    """Return whether a comment of a program may be one that LinuxCNC runs, as Python."""
    return _RUNS.search("".join(text.split()).lower()) is not None


def _check(place: Place, line: str, length: int) -> None:
    if "\r" in line:
        raise place.error(line.split("\r")[0][-20:].strip(), _CARRIAGE_RETURN)
    if length > LONGEST_LINE or "\0" in line:
        why = f"a line ends at a zero, or after {LONGEST_LINE} characters, for some controls: break it"
        raise place.error(line[:20], why)
    at = 0
    for comment in COMMENT.finditer(line):
        # Unless it is a character of a name like any other.
        if line.rfind("<", at, comment.start()) > line.rfind(">", at, comment.start()):
            raise place.error(line[at:].strip(), "a comment within a name: remove it")
        at = comment.end()
    if runs_python(line):
        raise place.error(line.strip(), "a comment that LinuxCNC runs, as Python: remove it")
    if strange := _STRANGE.search(COMMENT.sub("", line)):
        why = f"{strange[0]!a} outside of comments, which controls read in other ways: use plain characters"
        raise place.error(line.strip(), why)
