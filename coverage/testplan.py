"""The testplan: what is promised, what must be verified of it, and by what; read from testplan.hjson.

The file has the form of OpenTitan's testplans, so dvsim maps the results of a regression to it. Before the
testpoints stand the requirements, each with an ``id`` and a ``text``. A testpoint holds

    name        unique
    desc        three parts, each begun by its name: **Goal**:, **Stimulus**:, **Check**:
    stage       V1, V2 or V3, see stages.toml
    requirements  ids of those that it serves
    tests       names of UVM tests; ["N/A"], as dvsim wants it, where no simulation belongs to it
    proofs      names of formal proofs
    faults      names of faults of the catalogue
    checks      names of other runs that check: see verif/signoff/testplan.py
    bins        patterns of coverage bins, "<cover item>.<bin>"; "<cover item>" stands for all its bins
    assertions  "<module>.<label>"
    mutants     patterns of mutants, "<module>/<operator>/.."

and lists that are empty may be left out, ``tests`` excepted. In a pattern ``*`` stands for anything; the name
of the cover item, or of the module, is always written out.
"""

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import hjson

from triaxis.golden.errors import InputError
from triaxis.golden.input_file import read_input

TESTPLAN = Path(__file__).with_name("testplan.hjson")
# What dvsim takes for "not mapped to simulations".
NOT_SIMULATED = "N/A"

PARTS = ("goal", "stimulus", "check")
# What runs, and so can fail by itself.
RUNS = ("tests", "proofs", "faults", "checks")
# Everything that a testpoint owns.
KINDS = (*RUNS, "bins", "assertions", "mutants")
_TEXTS = ("name", "desc", "stage")
_LISTS = ("requirements", *KINDS)
_PART = re.compile(rf"^\*\*({'|'.join(part.capitalize() for part in PARTS)})\*\*:", re.MULTILINE)


@dataclass(frozen=True)
class Requirement:
    """What the product promises."""

    id: str
    text: str


@dataclass(frozen=True)
class Testpoint:
    """What is to be verified, and what does it; see the module's docstring.

    A part of the description that is missing is empty, and so is a missing stage: `lint` refuses both.
    ``simulated``: false where ``tests`` says that no simulation belongs to it.
    """

    name: str
    stage: str
    goal: str
    stimulus: str
    check: str
    requirements: tuple[str, ...] = ()
    tests: tuple[str, ...] = ()
    proofs: tuple[str, ...] = ()
    faults: tuple[str, ...] = ()
    checks: tuple[str, ...] = ()
    bins: tuple[str, ...] = ()
    assertions: tuple[str, ...] = ()
    mutants: tuple[str, ...] = ()
    simulated: bool = True

    def entries(self, kind: str) -> tuple[str, ...]:
        """Return what it names of one of `KINDS`."""
        return getattr(self, kind)


@dataclass(frozen=True)
class Testplan:
    """All requirements and testpoints, in the order of the file."""

    path: Path
    name: str
    testpoints: tuple[Testpoint, ...]
    requirements: tuple[Requirement, ...] = ()

    def serving(self, requirement: Requirement) -> list[Testpoint]:
        """Return the testpoints that serve a requirement."""
        return [point for point in self.testpoints if requirement.id in point.requirements]


def read_testplan(path: Path = TESTPLAN) -> Testplan:
    """Read a testplan; raise InputError where its form is wrong. Whether it is complete, `lint` says."""
    data = read_input(path)
    try:
        content = hjson.loads(data.decode(), object_pairs_hook=_object)
    # Of both kinds: what is no Hjson, what is no text, and a key that comes twice.
    except ValueError as error:
        raise InputError(f"{path}: not a testplan: {error}") from error
    if not isinstance(content, dict) or set(content) != {"name", "requirements", "testpoints"}:
        raise InputError(f"{path}: must hold `name`, `requirements` and `testpoints`, and nothing else")
    name, entries = content["name"], content["testpoints"]
    if not isinstance(name, str) or not isinstance(entries, list) or not entries:
        raise InputError(f"{path}: `name` must be a text and `testpoints` a list of at least one")
    testpoints = tuple(_testpoint(path, n, entry) for n, entry in enumerate(entries, 1))
    return Testplan(path, name, testpoints, _requirements(path, content["requirements"]))


def _requirements(path: Path, entries: Any) -> tuple[Requirement, ...]:
    found: list[Requirement] = []
    for entry in entries if isinstance(entries, list) else [entries]:
        fields = entry if isinstance(entry, dict) else {}
        texts = [value.strip() for value in fields.values() if isinstance(value, str) and value.strip()]
        if set(fields) != {"id", "text"} or len(texts) != len(fields):
            raise InputError(f"{path}: requirement {fields.get('id', '')}: must hold an `id` and a `text`")
        found.append(Requirement(fields["id"].strip(), " ".join(fields["text"].split())))
    return tuple(found)


def _object(pairs: Sequence[tuple[str, Any]]) -> dict[str, Any]:
    """Return an object of the file; raise ValueError where a key comes twice, of which one would get lost."""
    twice = [key for key, count in Counter(key for key, _ in pairs).items() if count > 1]
    if twice:
        owner = dict(pairs).get("name", "the testplan")
        raise ValueError(f"{owner}: key {twice[0]} given twice")
    return dict(pairs)


def _testpoint(path: Path, number: int, entry: Any) -> Testpoint:
    if not isinstance(entry, dict):
        raise InputError(f"{path}: testpoint {number}: must be an object")
    name = entry.get("name")
    if not isinstance(name, str) or not name.strip():
        raise InputError(f"{path}: testpoint {number}: needs a name")
    where = f"{path}: testpoint {name}"
    fields = {key: _field(where, key, value) for key, value in entry.items()}
    if "tests" not in fields:
        raise InputError(f'{where}: needs `tests`, ["{NOT_SIMULATED}"] where no simulation belongs to it')
    simulated = fields["tests"] != (NOT_SIMULATED,)
    if not simulated:
        fields["tests"] = ()
    parts = _parts(where, fields.pop("desc", ""))
    return Testpoint(**{"stage": "", **parts, **fields, "simulated": simulated})


def _field(where: str, key: str, value: Any) -> Any:
    if key in _TEXTS:
        if not isinstance(value, str):
            raise InputError(f"{where}: {key}: must be a text")
        return value.strip()
    if key not in _LISTS:
        raise InputError(f"{where}: {key}: no such key; one of: {', '.join((*_TEXTS, *_LISTS))}")
    if not isinstance(value, list) or not all(isinstance(text, str) and text for text in value):
        raise InputError(f"{where}: {key}: must be a list of texts")
    return tuple(value)


def _parts(where: str, text: str) -> dict[str, str]:
    """Return the parts of a description, one line each, those that are missing empty."""
    before, *found = _PART.split(text)
    names = [name.lower() for name in found[::2]]
    if before.strip() or len(set(names)) < len(names):
        raise InputError(
            f"{where}: desc: must be **Goal**:, **Stimulus**: and **Check**:, each at the start of a line, "
            "once, and nothing before"
        )
    texts = (" ".join(part.split()) for part in found[1::2])
    return dict.fromkeys(PARTS, "") | dict(zip(names, texts, strict=True))
