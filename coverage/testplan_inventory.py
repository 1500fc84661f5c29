"""What exists and must be owned by a testpoint, and which of it a testpoint owns."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property

from triaxis.coverage.testplan import KINDS, Testpoint
from triaxis.coverage.waivers import fit

# Kinds whose entries are patterns, and what ends the part that must be written out.
PATTERNS = {"bins": ".", "mutants": "/"}


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
        end = PATTERNS.get(kind)
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
        return {kind: grouped(self.names(kind), PATTERNS.get(kind)) for kind in KINDS}


def grouped(names: Iterable[str], end: str | None) -> dict[str, frozenset[str]]:
    """Return names by what comes before ``end``; each by itself where there is none."""
    groups: dict[str, set[str]] = {}
    for name in names:
        groups.setdefault(name.partition(end)[0] if end else name, set()).add(name)
    return {head: frozenset(group) for head, group in groups.items()}
