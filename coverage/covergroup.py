"""A small declarative coverage model: coverpoints with named bins, sampled on whole arrays.

Existing Python coverage libraries sample one transaction at a time, tens of microseconds each; here
a coverpoint maps arrays to bin numbers, and NumPy counts them.
"""

import hashlib
import json
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

import numpy as np
import numpy.typing as npt

from triaxis.golden.errors import InputError

Sample = TypeVar("Sample")
BinNumbers = npt.NDArray[np.int64]

# What a coverpoint answers for a sample that falls into none of its bins.
NO_BIN = -1


@dataclass(frozen=True)
class Coverpoint(Generic[Sample]):
    """Named bins, and a function from a sample of N transactions to N bin numbers or NO_BIN."""

    name: str
    meaning: str
    bins: tuple[str, ...]
    number: Callable[[Sample], BinNumbers]


@dataclass(frozen=True)
class CoverModel(Generic[Sample]):
    """Coverpoints under one name."""

    name: str
    coverpoints: tuple[Coverpoint[Sample], ...]

    @property
    def hash(self) -> str:
        """Return a hash of all names: counts of one model are never taken for another's."""
        shape = [self.name, [[p.name, p.meaning, p.bins] for p in self.coverpoints]]
        return hashlib.sha256(json.dumps(shape).encode()).hexdigest()


def cross(
    name: str, meaning: str, first: Coverpoint[Sample], second: Coverpoint[Sample]
) -> Coverpoint[Sample]:
    """Return the coverpoint of all combinations of two others' bins."""

    def number(sample: Sample) -> BinNumbers:
        i, j = first.number(sample), second.number(sample)
        both = (i != NO_BIN) & (j != NO_BIN)
        return np.where(both, i * len(second.bins) + j, NO_BIN)

    bins = tuple(f"{a} / {b}" for a in first.bins for b in second.bins)
    return Coverpoint(name, meaning, bins, number)


@dataclass
class Counts:
    """How often each bin of a model was hit. Merging is addition, so order does not matter."""

    model_hash: str
    hits: dict[str, npt.NDArray[np.int64]]

    @staticmethod
    def empty(model: CoverModel[Any]) -> "Counts":
        """Return zero counts."""
        return Counts(model.hash, {p.name: np.zeros(len(p.bins), np.int64) for p in model.coverpoints})

    def sample(self, model: CoverModel[Sample], sample: Sample) -> None:
        """Count a sample."""
        for point in model.coverpoints:
            numbers = point.number(sample)
            self.hits[point.name] += np.bincount(numbers[numbers != NO_BIN], minlength=len(point.bins))

    def save(self, path: Path) -> None:
        """Write the counts as JSON, whole or not at all."""
        content = {
            "model": self.model_hash,
            "hits": {name: hits.tolist() for name, hits in self.hits.items()},
        }
        partial = path.with_suffix(".partial")
        partial.write_text(json.dumps(content) + "\n")
        partial.replace(path)


def load(path: Path, model: CoverModel[Any]) -> Counts:
    """Read counts; raise InputError where the file is not whole, or of another model."""
    try:
        content = json.loads(path.read_text())
        counts = Counts(content["model"], {k: np.array(v, np.int64) for k, v in content["hits"].items()})
    except OSError as error:
        raise InputError(f"{path}: cannot read: {error.strerror}") from error
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise InputError(f"{path}: not a coverage file; delete it and run again") from error
    if counts.model_hash != model.hash:
        raise InputError(f"{path}: counts of another coverage model; delete it and run again")
    shape = {point.name: (len(point.bins),) for point in model.coverpoints}
    if {name: hits.shape for name, hits in counts.hits.items()} != shape:
        raise InputError(f"{path}: damaged coverage file; delete it and run again")
    return counts


def merge(model: CoverModel[Any], counts: Iterable[Counts]) -> Counts:
    """Return the sum of counts of one model."""
    total = Counts.empty(model)
    for one in counts:
        if one.model_hash != model.hash:
            raise InputError("counts of another coverage model cannot be merged")
        for name, hits in one.hits.items():
            total.hits[name] += hits
    return total


@dataclass(frozen=True)
class PointReport:
    """How far one coverpoint is covered."""

    name: str
    hit: int
    total: int
    missing: tuple[str, ...]


def report(model: CoverModel[Any], counts: Counts) -> list[PointReport]:
    """Return one report for each coverpoint."""
    reports: list[PointReport] = []
    for point in model.coverpoints:
        hits = counts.hits[point.name]
        missing = tuple(name for name, count in zip(point.bins, hits.tolist(), strict=True) if not count)
        reports.append(PointReport(point.name, len(point.bins) - len(missing), len(point.bins), missing))
    return reports
