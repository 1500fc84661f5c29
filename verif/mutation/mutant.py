"""A mutant: one small change of the RTL, with a name that survives edits elsewhere.

And those of the macro TRIAXIS_STAGE itself, the one register of all modules.
"""

import hashlib
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

RUNTIME, ELABORATION = "runtime", "elaboration"

_DIGITS = 8

_MACRO_FILE = "core/triaxis_stage.svh"
_MACRO = "triaxis_stage"

# What in the macro's text gives way to what. The operators' names are those of statements.py.
_MACRO_CHANGES = (
    ("generate_condition", "if (Comb)", "if (!(Comb))"),
    ("deletion", "assign q = d;", ""),
    ("deletion", "always_ff @(posedge clk_i) q <= d;", ""),
    ("edge", "posedge clk_i", "negedge clk_i"),
)


@dataclass(frozen=True)
class Edit:
    """The text of a file between two offsets gives way to another one."""

    start: int
    end: int
    text: str


@dataclass(frozen=True)
class Mutant:
    """One change of one file of dut/.

    ``kind``: RUNTIME mutants share a build and are selected by a number; an ELABORATION mutant changes what
    is fixed when the design elaborates, and needs a build of its own. ``original`` and ``changed`` are the
    statement before and after. ``edit`` makes the change in the file itself. ``host`` is the offset of the
    module item that holds it, ``needs`` that of the item which must elaborate for the mutant to be there.
    """

    id: str
    module: str
    operator: str
    kind: str
    file: str
    line: int
    original: str
    changed: str
    edit: Edit
    host: int
    needs: int

    @property
    def place(self) -> str:
        """Return file and line."""
        return f"dut/{self.file}:{self.line}"

    @property
    def block(self) -> str:
        """Return the folder of dut/: core, mesh or board."""
        return self.file.partition("/")[0]

    @property
    def short(self) -> str:
        """Return what is left of its name where that is listed; no two mutants have the same."""
        return self.id.rpartition("/")[2]


def normalised(text: str) -> str:
    """Return the text with every run of white space as one space."""
    return " ".join(text.split())


def named(mutants: Iterable[Mutant]) -> list[Mutant]:
    """Return the mutants with their names: module, operator, and a hash of what is changed to what.

    Of mutants that read the same, the later ones count on.
    """
    seen: Counter[tuple[str, ...]] = Counter()
    result: list[Mutant] = []
    for mutant in mutants:
        key = (mutant.module, mutant.operator, mutant.original, mutant.changed)
        text = "\0".join([*key, str(seen[key])])
        seen[key] += 1
        digest = hashlib.sha256(text.encode()).hexdigest()[:_DIGITS]
        result.append(replace(mutant, id=f"{mutant.module}/{mutant.operator}/{digest}"))
    return result


def applied(text: str, edits: Sequence[Edit]) -> str:
    """Return the text with edits that do not overlap."""
    for edit in sorted(edits, key=lambda edit: -edit.start):
        text = text[: edit.start] + edit.text + text[edit.end :]
    return text


def macro_mutants(dut: Path) -> list[Mutant]:
    """Return the mutants of the macro, named. Each is there wherever the macro is used."""
    text = (dut / _MACRO_FILE).read_text()
    found: list[Mutant] = []
    for operator, old, new in _MACRO_CHANGES:
        start = text.find(old)
        if start < 0:
            continue
        line = text.count("\n", 0, start) + 1
        edit = Edit(start, start + len(old), new)
        found.append(
            Mutant(
                "",
                _MACRO,
                operator,
                ELABORATION,
                _MACRO_FILE,
                line,
                normalised(old),
                new or ";",
                edit,
                start,
                -1,
            )
        )
    return named(found)
