"""Switching activity as simulators write it (SAIF, backward, IEEE 1801 annex): toggles of every signal.

Only what an account of toggles needs is read: instances, and of each bit its toggle count.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from triaxis.golden.errors import InputError

_ITEM = re.compile(
    r"""\s* (?:
        \( INSTANCE \s+ (?:"[^"]*"\s+)? (?P<instance>[^\s()]+)
      | \( (?P<open> SAIFILE | NET | PORT ) (?=[\s(])
      | \( DURATION \s+ (?P<duration>\d+) \s* \)
      | \( (?P<net>[^\s()]+) \s* (?P<counts> (?: \( (?: T[0-9XZBGC] | I[GK] ) \s+ \d+ \) \s* )+ ) \)
      | \( [A-Z_]+ (?: \s+ (?: "[^"]*" | [^\s()"]+ ) )* \s* \)
      | (?P<close> \) )
      | (?P<comment> //[^\n]* )
    )""",
    re.VERBOSE,
)
_TOGGLES = re.compile(r"\(TC\s+(\d+)\)")
_INDEX = re.compile(r"(?:\[\d+\])+$")


@dataclass(frozen=True)
class Activity:
    """What toggled: for each instance, as a path with slashes, the toggles of each signal's bits together."""

    instances: dict[str, dict[str, int]]

    def inside(self, path: str, signal: str) -> int:
        """Return the toggles of a signal in an instance and in all instances and blocks below it."""
        below = path + "/"
        return sum(
            nets.get(signal, 0)
            for place, nets in self.instances.items()
            if place == path or place.startswith(below)
        )


def read_saif(path: Path) -> Activity:
    """Read a file; raise InputError where it is no SAIF file, damaged, or cut off."""
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: not readable as SAIF: {error}") from error
    has_duration = False
    instances: dict[str, dict[str, int]] = {}
    # Open parentheses: the name of an instance, "" for anything else.
    open_: list[str] = []
    place = ""
    for item, line in _items(text, path):
        kind = item.lastgroup
        if kind in ("instance", "open"):
            open_.append(item["instance"] if kind == "instance" else "")
            place = "/".join(filter(None, open_))
            instances.setdefault(place, {})
        elif kind == "counts":
            toggles = _TOGGLES.search(item["counts"])
            if toggles is None:
                raise InputError(f"{path}:{line}: {item['net']} has no toggle count (TC)")
            name = _INDEX.sub("", item["net"].replace("\\", ""))
            instances[place][name] = instances[place].get(name, 0) + int(toggles[1])
        elif kind == "duration":
            has_duration = True
        elif kind == "close":
            if not open_:
                raise InputError(f"{path}:{line}: one closing parenthesis too many")
            open_.pop()
            place = "/".join(filter(None, open_))
    if open_ or not has_duration:
        raise InputError(f"{path}: not a whole SAIF file: it ends early, or has no DURATION")
    instances.pop("", None)
    return Activity(instances)


def _items(text: str, path: Path) -> Iterator[tuple[re.Match[str], int]]:
    """Yield the items of a file in order, with their lines; all of the text belongs to one."""
    position, line, end = 0, 1, len(text.rstrip())
    while position < end:
        item = _ITEM.match(text, position)
        if item is None:
            line += text.count("\n", position) - text[position:].lstrip().count("\n")
            raise InputError(f"{path}:{line}: not SAIF: {text[position : position + 40].strip()!r}")
        line += item[0].count("\n")
        position = item.end()
        yield item, line
