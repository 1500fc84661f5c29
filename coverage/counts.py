"""Counts of models' bins: sampled, merged and kept in files, one configuration apart from another."""

import hashlib
import json
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from triaxis.coverage.cover_model import CoverModel, Hits, Sample, Sampler
from triaxis.golden.errors import InputError
from triaxis.golden.input_file import read_input
from triaxis.golden.outputs import write_whole

_FORMAT = "triaxis coverage 1"


@dataclass
class Counts:
    """How often each bin of a model was hit. Merging is addition, so neither order nor grouping matter."""

    model: str
    model_hash: str
    hits: dict[str, Hits]

    @staticmethod
    def empty(model: CoverModel[Any]) -> "Counts":
        """Return zero counts."""
        return Counts(
            model.name, model.hash, {item.name: np.zeros(item.size, np.int64) for item in model.items}
        )

    def sample(self, model: CoverModel[Sample], sample: Sample) -> None:
        """Count a sample of that model."""
        sampler = Sampler(sample)
        for item in model.items:
            self.hits[item.name] += sampler.hits(item)

    def add(self, other: "Counts") -> None:
        """Add counts of the same model; raise InputError where they are of another."""
        if (other.model, other.model_hash) != (self.model, self.model_hash):
            raise InputError(
                f"counts of coverage model {other.model}: cannot be merged with those of another "
                f"definition, {self.model}; run again"
            )
        for name, hits in other.hits.items():
            self.hits[name] += hits

    def save(self, path: Path) -> None:
        """Write the counts as JSON, whole or not at all; raise InputError where that cannot be done."""
        write_counts(path, [self])


def load(path: Path, model: CoverModel[Any]) -> Counts:
    """Read counts of one model; raise InputError where the file is not whole, or of another model."""
    found = read_counts(path, [model])
    if len(found) != 1:
        raise InputError(f"{path}: counts of {len(found)} models where those of {model.name} were due")
    return found[0]


def write_counts(path: Path, counts: Iterable[Counts]) -> None:
    """Write counts of several models into one file, whole or not at all."""
    models = [
        {
            "model": c.model,
            "hash": c.model_hash,
            "hits": {name: hits.tolist() for name, hits in c.hits.items()},
        }
        for c in counts
    ]
    content = {"format": _FORMAT, "digest": _digest(models), "models": models}
    write_whole(path, json.dumps(content) + "\n")


def read_counts(path: Path, models: Iterable[CoverModel[Any]]) -> list[Counts]:
    """Read what `write_counts` wrote; raise InputError where it is damaged, or of none of the models."""
    known = {model.name: model for model in models}
    data = read_input(path)
    try:
        content = json.loads(data)
        whole = content["format"] == _FORMAT and content["digest"] == _digest(content["models"])
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise InputError(f"{path}: not a coverage file; delete it and run again") from error
    if not whole:
        raise InputError(f"{path}: damaged, or of another format; delete it and run again")
    return [_checked(path, one, known) for one in content["models"]]


def _checked(path: Path, content: dict[str, Any], known: dict[str, CoverModel[Any]]) -> Counts:
    """Return the counts, or raise InputError where they are not of a known model's present definition."""
    model = known.get(content["model"])
    if model is None:
        raise InputError(
            f"{path}: counts of coverage model {content['model']}, which is not among those asked for"
        )
    if content["hash"] != model.hash:
        raise InputError(
            f"{path}: counts of another definition of coverage model {model.name}; delete it and run again"
        )
    try:
        hits = {name: np.array(numbers, np.int64) for name, numbers in content["hits"].items()}
    except (ValueError, TypeError, AttributeError, OverflowError) as error:
        raise InputError(
            f"{path}: counts of {model.name} that are no numbers; delete it and run again"
        ) from error
    shapes = {item.name: (item.size,) for item in model.items}
    if {name: h.shape for name, h in hits.items()} != shapes or any((h < 0).any() for h in hits.values()):
        raise InputError(f"{path}: counts that do not fit the bins of {model.name}; delete it and run again")
    return Counts(model.name, model.hash, hits)


def _digest(models: object) -> str:
    return hashlib.sha256(json.dumps(models).encode()).hexdigest()


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

    def add_file(self, path: Path) -> None:
        """Add the counts in a file; raise InputError, adding nothing, where they do not belong here."""
        for counts in read_counts(path, self._models.values()):
            self.add(counts)

    def save(self, path: Path) -> None:
        """Write all counts into one file, whole or not at all."""
        write_counts(path, [counts for _, counts in self])
