"""The checklists of the stages: what coverage/checklist.toml asks, answered by figures, results and files."""

import re
import tomllib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any

from triaxis.coverage.stages import STAGES, STAGES_FILE, Values, read_figures
from triaxis.golden.errors import InputError
from triaxis.golden.input_file import read_input
from triaxis.sim.paths import ROOT
from triaxis.verif.signoff.parts import Part

CHECKLIST = STAGES_FILE.with_name("checklist.toml")
_LISTS = ("D1", "D2", "D3", *STAGES)
# Where a pattern of the design, and one of its verification, may not be found.
_SEARCHED = {
    "D": ("dut/**/*.sv", "dut/**/*.svh"),
    "V": tuple(
        f"{top}/**/*.{end}" for top in ("verif", "sim", "golden", "coverage") for end in ("py", "cpp", "sv")
    ),
}


class Answer(StrEnum):
    """What can be said of an item."""

    MET = "met"
    OPEN = "open"
    ABSENT = "not measured"
    YOURS = "yours"
    NONE = "not applicable"


@dataclass(frozen=True)
class Item:
    """An item: its list, its names, what it asks, and how it is answered: kind and value."""

    list: str
    item: str
    asks: str
    kind: str
    value: Any


@dataclass(frozen=True)
class Answered:
    """An item with its answer and what that rests on."""

    item: Item
    answer: Answer
    by: str

    @property
    def content(self) -> dict[str, str]:
        """Return it as it stands in the file."""
        item = self.item
        return {
            "list": item.list, "item": item.item, "asks": item.asks,
            "answer": self.answer.value, "by": self.by,
        }  # fmt: skip


def read_checklist(path: Path = CHECKLIST) -> list[Item]:
    """Return all items; raise InputError where the file is wrong."""
    try:
        content = tomllib.loads(read_input(path).decode())
    except ValueError as error:
        raise InputError(f"{path}: cannot be read: {error}") from error
    if tuple(content) != _LISTS:
        raise InputError(f"{path}: must hold the lists {', '.join(_LISTS)}, in this order")
    return [_item(name, entry, path) for name, entries in content.items() for entry in entries]


def _item(name: str, entry: Any, path: Path) -> Item:
    kinds = set(entry) - {"item", "asks"} if isinstance(entry, dict) else set[str]()
    if len(kinds) != 1 or len(entry) != 3 or not kinds < set(_ANSWERS):
        raise InputError(f"{path}: {name}: {entry}: must hold item, asks, and one of {', '.join(_ANSWERS)}")
    (kind,) = kinds
    # Of no figure and of no file all would be well.
    if kind in ("figure", "file") and not (isinstance(entry[kind], list) and entry[kind]):
        raise InputError(f"{path}: {name} {entry['item']}: {kind} must be a list that names at least one")
    return Item(name, entry["item"], entry["asks"], kind, entry[kind])


def answered(
    items: list[Item], figures: Values, parts: Mapping[str, Part], root: Path = ROOT
) -> list[Answered]:
    """Return the items with their answers; ``parts``: of the sign-off, and the results that stand beside it.

    Raises InputError where an item names a figure or a part that does not exist, or a figure of which its
    stage asks nothing.
    """
    found: list[Answered] = []
    for item in items:
        try:
            answer, by = _ANSWERS[item.kind](item, figures, parts, root)
        except KeyError as error:
            raise InputError(f"{CHECKLIST}: {item.list} {item.item}: no such {item.kind}: {error}") from error
        found.append(Answered(item, answer, by))
    return found


_Answer = tuple[Answer, str]


def _figure(item: Item, figures: Values, parts: Mapping[str, Part], root: Path) -> _Answer:
    known, stage = {figure.name: figure for figure in read_figures()}, f"V{item.list[1]}"
    asked = [known[name] for name in item.value]
    if unasked := [figure.name for figure in asked if stage not in figure.bounds]:
        raise InputError(f"{CHECKLIST}: {item.list} {item.item}: {stage} asks nothing of {unasked[0]}")
    met = all(figure.is_met(figures[figure.name], stage) for figure in asked)
    said = "; ".join(f"{figure.meaning}: {figure.text(figures[figure.name])}" for figure in asked)
    return Answer.MET if met else Answer.OPEN, said


def _part(item: Item, figures: Values, parts: Mapping[str, Part], root: Path) -> _Answer:
    part, name = parts[item.value], str(item.value).replace("_", " ")
    if part.evidence is None:
        return Answer.ABSENT, f"{name}: {part.absent}"
    return Answer.MET if part.evidence["passed"] else Answer.OPEN, f"{name}: {part.evidence['summary']}"


def _file(item: Item, figures: Values, parts: Mapping[str, Part], root: Path) -> _Answer:
    missing = [place for place in item.value if not _is_there(root, *place.split("#"))]
    return (Answer.OPEN, f"missing: {', '.join(missing)}") if missing else (Answer.MET, ", ".join(item.value))


def _is_there(root: Path, name: str, heading: str | None = None) -> bool:
    path = root / name
    if not path.is_file():
        return False
    pattern = re.compile(rf"^#+ {re.escape(heading or '')}$", re.MULTILINE)
    return heading is None or pattern.search(path.read_text(encoding="utf-8")) is not None


def _without(item: Item, figures: Values, parts: Mapping[str, Part], root: Path) -> _Answer:
    pattern = re.compile(item.value)
    paths = [path for glob in _SEARCHED[item.list[0]] for path in sorted(root.glob(glob))]
    found = [path for path in paths if pattern.search(path.read_text(encoding="utf-8"))]
    if found:
        return Answer.OPEN, ", ".join(str(path.relative_to(root)) for path in found)
    return Answer.MET if paths else Answer.OPEN, f"in none of {len(paths)} files"


_ANSWERS: dict[str, Callable[[Item, Values, Mapping[str, Part], Path], _Answer]] = {
    "figure": _figure,
    "part": _part,
    "file": _file,
    "without": _without,
    "yours": lambda item, *_: (Answer.YOURS, item.value),
    "none": lambda item, *_: (Answer.NONE, item.value),
}


def open_items(items: list[Answered]) -> Iterator[str]:
    """Yield the items that a file or a pattern leaves open; figures and parts are problems by themselves."""
    for one in items:
        if one.answer is Answer.OPEN and one.item.kind in ("file", "without"):
            yield f"checklist: {one.item.list} {one.item.item}: {one.by}"
