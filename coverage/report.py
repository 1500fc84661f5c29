"""What is covered, what is missing, what does not count and why."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from triaxis.coverage.counts import Counts
from triaxis.coverage.cover_model import CoverItem, CoverModel, Exclusion, Hits
from triaxis.coverage.stages import share


@dataclass(frozen=True)
class ExcludedBins:
    """How many bins an exclusion takes out, and how often they were hit all the same."""

    exclusion: Exclusion
    bins: int
    hits: int


@dataclass(frozen=True)
class IllegalHit:
    """An illegal bin that was hit: the core, the golden model or the proof is wrong."""

    bin: str
    hits: int
    reason: str


@dataclass(frozen=True)
class ItemReport:
    """How far one coverpoint or cross is covered. ``missing``: bins below their goals."""

    name: str
    meaning: str
    hit: int
    total: int
    missing: tuple[str, ...]
    excluded: tuple[ExcludedBins, ...]
    illegal_hits: tuple[IllegalHit, ...]

    @property
    def complete(self) -> bool:
        """Return whether every goal is met and nothing illegal was hit."""
        return self.hit == self.total and not self.illegal_hits


@dataclass(frozen=True)
class ModelReport:
    """How far one model, that of one configuration, is covered."""

    model: str
    items: tuple[ItemReport, ...]

    @property
    def hit(self) -> int:
        """Return how many bins met their goals."""
        return sum(item.hit for item in self.items)

    @property
    def total(self) -> int:
        """Return how many bins have goals."""
        return sum(item.total for item in self.items)

    @property
    def complete(self) -> bool:
        """Return whether every goal is met and nothing illegal was hit."""
        return all(item.complete for item in self.items)

    @property
    def illegal(self) -> list[str]:
        """Return what was hit and must not be, a line each."""
        return [
            f"coverage {self.model}, {item.name}: illegal bin {i.bin} hit {i.hits} times: {i.reason}"
            for item in self.items
            for i in item.illegal_hits
        ]

    @property
    def problems(self) -> list[str]:
        """Return what is not covered, or hit and must not be, a line each."""
        missing = [
            f"coverage {self.model}, {item.name}: {item.hit} of {item.total} bins hit, missing first: "
            f"{item.missing[0]}"
            for item in self.items
            if item.missing
        ]
        return missing + self.illegal


def percent(reports: Iterable[ModelReport]) -> float:
    """Return the share of bins that met their goals, 0..100, rounded down to two decimals: 100 means all."""
    every = list(reports)
    return share(sum(r.hit for r in every), sum(r.total for r in every)) or 0.0


def report(model: CoverModel[Any], counts: Counts) -> ModelReport:
    """Return how far a model is covered."""
    return ModelReport(model.name, tuple(_item_report(item, counts.hits[item.name]) for item in model.items))


def _item_report(item: CoverItem[Any], hits: Hits) -> ItemReport:
    missing = tuple(item.bins[n].name for n in (hits < item.goals).nonzero()[0])
    illegal = tuple(
        IllegalHit(item.bins[n].name, int(hits[n]), exclusion.reason)
        for n in ((hits > 0) & item.illegal).nonzero()[0]
        if (exclusion := item.bins[n].exclusion)
    )
    bins, hit = Counter[Exclusion](), Counter[Exclusion]()
    for one, count in zip(item.bins, hits.tolist(), strict=True):
        if one.exclusion:
            bins[one.exclusion] += 1
            hit[one.exclusion] += count
    excluded = tuple(ExcludedBins(e, bins[e], hit[e]) for e in item.exclusions if bins[e])
    total = item.size - sum(bins.values())
    return ItemReport(item.name, item.meaning, total - len(missing), total, missing, excluded, illegal)
