"""The linter of the testplan: what a testpoint lacks, and what exists and no testpoint owns."""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cached_property

from triaxis.coverage.stages import STAGES
from triaxis.coverage.testplan import KINDS, NOT_SIMULATED, PARTS, RUNS, Testplan, Testpoint
from triaxis.coverage.waivers import fit

# Kinds whose entries are patterns, and what ends the part that must be written out.
_PATTERNS = {"bins": ".", "mutants": "/"}


@dataclass(frozen=True)
class Inventory:
    """Everything that exists and must be owned by a testpoint.

    ``bins``: by coverage model, "<cover item>.<bin>", those with goals. ``illegal``: those that must not be
    hit.
    """

    tests: frozenset[str]
    proofs: frozenset[str]
    faults: frozenset[str]
    checks: frozenset[str]
    assertions: frozenset[str]
    mutants: frozenset[str]
    bins: Mapping[str, frozenset[str]]
    illegal: Mapping[str, frozenset[str]]

    def names(self, kind: str) -> frozenset[str]:
        """Return the names of one of `KINDS`; bins of all models together, the illegal ones too."""
        if kind == "bins":
            return frozenset().union(*self.bins.values(), *self.illegal.values())
        return getattr(self, kind)

    def heads(self, kind: str) -> frozenset[str]:
        """Return what an entry must write out: cover items, modules, names of the other kinds."""
        return frozenset(self._groups[kind])

    def matching(self, kind: str, entry: str) -> frozenset[str]:
        """Return the names that an entry of a testpoint stands for."""
        end = _PATTERNS.get(kind)
        if end is None:
            return self._groups[kind].get(entry, frozenset())
        head, _, rest = entry.partition(end)
        group = self._groups[kind].get(head, frozenset())
        return group if rest in ("", "*") else frozenset(n for n in group if fit((entry,), n) is not None)

    def owned(self, testpoint: Testpoint, kind: str) -> frozenset[str]:
        """Return what of a kind a testpoint owns."""
        return frozenset().union(*(self.matching(kind, entry) for entry in testpoint.entries(kind)))

    @cached_property
    def _groups(self) -> dict[str, dict[str, frozenset[str]]]:
        """Return, by kind, the names by what must be written out."""
        return {kind: _grouped(self.names(kind), _PATTERNS.get(kind)) for kind in KINDS}


def _grouped(names: Iterable[str], end: str | None) -> dict[str, frozenset[str]]:
    """Return names by what comes before ``end``; each by itself where there is none."""
    groups: dict[str, set[str]] = {}
    for name in names:
        groups.setdefault(name.partition(end)[0] if end else name, set()).add(name)
    return {head: frozenset(group) for head, group in groups.items()}


def lint(plan: Testplan, inventory: Inventory) -> list[str]:
    """Return what is wrong with a testplan, a line each: where, what, and what to do; empty: nothing."""
    found = [f"{plan.path}: {line}" for line in _twice(plan)]
    for testpoint in plan.testpoints:
        where = f"{plan.path}: testpoint {testpoint.name}"
        found += [f"{where}: {line}" for line in (*_lacks(testpoint), *_unknown(testpoint, inventory))]
    found += [f"{plan.path}: {line}" for line in _promised(plan)]
    return found + [f"{plan.path}: {line}" for kind in KINDS for line in _unowned(plan, inventory, kind)]


def _twice(plan: Testplan) -> Iterator[str]:
    for name, count in Counter(testpoint.name for testpoint in plan.testpoints).items():
        if count > 1:
            yield f"testpoint {name}: there are {count} of this name; give each its own"


def _promised(plan: Testplan) -> Iterator[str]:
    ids = Counter(requirement.id for requirement in plan.requirements)
    yield from (
        f"requirement {name}: there are {count} of this id" for name, count in ids.items() if count > 1
    )
    for requirement in plan.requirements:
        if not plan.serving(requirement):
            yield f"requirement {requirement.id}: no testpoint serves it; name it in one that does"
    for testpoint in plan.testpoints:
        if not testpoint.requirements:
            yield f"testpoint {testpoint.name}: serves no requirement; name one, or add what is promised"
        for name in testpoint.requirements:
            if name not in ids:
                yield f"testpoint {testpoint.name}: requirement {name}: unknown"


def _lacks(testpoint: Testpoint) -> Iterator[str]:
    for part in PARTS:
        if not getattr(testpoint, part):
            yield f"no {part}: add **{part.capitalize()}**: to its desc"
    if testpoint.stage not in STAGES:
        yield f"stage {testpoint.stage or 'missing'}: must be one of {', '.join(STAGES)}"
    if testpoint.simulated and not testpoint.tests:
        yield f'no tests: name them, or ["{NOT_SIMULATED}"] where no simulation belongs to it'
    if not any(testpoint.entries(kind) for kind in RUNS):
        yield f"nothing runs: name at least one of {', '.join(RUNS)}"
    if not testpoint.mutants:
        yield "no mutants: name those of the RTL that it verifies; a kill by any test counts"


def _unknown(testpoint: Testpoint, inventory: Inventory) -> Iterator[str]:
    for kind in KINDS:
        entries = testpoint.entries(kind)
        yield from (f"{kind}: {entry} is named twice" for entry, n in Counter(entries).items() if n > 1)
        for entry in dict.fromkeys(entries):
            if not inventory.matching(kind, entry):
                yield f"{kind[:-1]} {entry}: {_why(kind, entry, inventory)}"


def _why(kind: str, entry: str, inventory: Inventory) -> str:
    end = _PATTERNS.get(kind)
    head = entry.partition(end)[0] if end else entry
    if end and "*" in head:
        return f"a pattern must write out what comes before `{end}`"
    known = inventory.heads(kind)
    if end and head in known:
        return f"matches nothing in {head}; correct it, or drop it"
    close = get_close_matches(head, known, n=1)
    return f"unknown; {f'perhaps {close[0]}' if close else f'there is no such {kind[:-1]}'}"


def _unowned(plan: Testplan, inventory: Inventory, kind: str) -> Iterator[str]:
    """Name what nobody owns, bins and mutants by cover item and module."""
    owned = frozenset().union(*(inventory.owned(testpoint, kind) for testpoint in plan.testpoints))
    left = sorted(inventory.names(kind) - owned)
    singular, end = kind[:-1], _PATTERNS.get(kind)
    if end is None:
        yield from (
            f"{singular} {name}: no testpoint owns it; add it to the one that it verifies" for name in left
        )
        return
    for head, names in _grouped(left, end).items():
        first, *more = sorted(names)
        others = f" and {len(more)} more of {head}" if more else ""
        yield f"{singular} {first}{others}: no testpoint owns them; add a pattern to the one that they verify"
