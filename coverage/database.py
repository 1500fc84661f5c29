"""Counts of several models side by side: those of one configuration never mix with another's."""

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from triaxis.coverage.counts import Counts, read_counts, write_counts
from triaxis.coverage.cover_model import CoverModel
from triaxis.golden.errors import InputError


class CoverageDatabase:
    """Counts by the name of their model. Merging is addition, model by model."""

    def __init__(self, models: Iterable[CoverModel[Any]]) -> None:
        """Start with zero counts of each model: what was never run shows as missing."""
        self._models = {model.name: model for model in models}
        self._counts = {name: Counts.empty(model) for name, model in self._models.items()}

    def __iter__(self) -> Iterator[tuple[CoverModel[Any], Counts]]:
        """Go through models and their counts, in the order given."""
        return ((model, self._counts[name]) for name, model in self._models.items())

    def add(self, counts: Counts) -> None:
        """Add counts to those of their model; raise InputError where that is not in the database."""
        if counts.model not in self._counts:
            raise InputError(f"counts of coverage model {counts.model}: no such model in this database")
        self._counts[counts.model].add(counts)

    def merge(self, other: "CoverageDatabase") -> None:
        """Add all counts of another database."""
        for _, counts in other:
            self.add(counts)

    def add_file(self, path: Path) -> None:
        """Add the counts in a file; raise InputError, adding nothing, where they do not belong here."""
        for counts in read_counts(path, self._models.values()):
            self.add(counts)

    def save(self, path: Path) -> None:
        """Write all counts into one file, whole or not at all."""
        write_counts(path, [counts for _, counts in self])
