"""A declarative coverage model: coverpoints with named bins, their crosses, goals and exclusions.

A coverpoint maps a sample, arrays of N transactions, to one small unsigned code for each: the number of
its bin. Existing Python coverage libraries sample one transaction at a time, tens of microseconds each;
codes are arrays here, made once a sample and counted in native code.
"""

import ctypes
import hashlib
import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import Enum
from functools import cache, cached_property
from itertools import product
from math import prod
from pathlib import Path
from typing import Any, Generic, TypeVar

import numpy as np
import numpy.typing as npt

from triaxis.golden.native import native_function
from triaxis.sim.validity import Sources

Sample = TypeVar("Sample")
Codes = npt.NDArray[np.uint8]
Mask = npt.NDArray[np.uint32]

# Bits of a mask point, and codes of another, at most.
MASK_BITS = 32
_MOST_CODES = 256


@dataclass(frozen=True, eq=False)
class Coverpoint(Generic[Sample]):
    """Named bins, and a function from a sample of N transactions to N codes, 0..len(bins) - 1.

    With ``partial`` a code may also be len(bins): the transaction falls into none of the bins. A point
    that is covered on its own, in no cross, may give any number of codes.
    """

    name: str
    bins: tuple[str, ...]
    codes: Callable[[Sample], Codes]
    partial: bool = False

    @property
    def radix(self) -> int:
        """Return how many codes there are."""
        return len(self.bins) + self.partial


@dataclass(frozen=True, eq=False)
class MaskPoint(Generic[Sample]):
    """Bins of which a transaction hits any number: a function from a sample to N masks, bit n for bin n."""

    name: str
    bins: tuple[str, ...]
    masks: Callable[[Sample], Mask]


class Kind(Enum):
    """What a hit of an excluded bin means: nothing, or an error."""

    IGNORE = "ignore"
    ILLEGAL = "illegal"


@dataclass(frozen=True)
class Exclusion:
    """Bins that do not count: those for whose codes, one argument for each point, ``when`` is true.

    ``reason`` says why, for what cannot happen the proof in a few words; ``test`` names the test that
    supports it. ``category`` names the kind of the argument, ``owner`` who answers for it.
    """

    kind: Kind
    reason: str
    test: str
    when: Callable[..., bool]
    category: str = ""
    owner: str = ""


@dataclass(frozen=True)
class Bin:
    """One bin: what to call it, how many hits it needs, and why it does not count, if so."""

    name: str
    goal: int
    exclusion: Exclusion | None


@dataclass(frozen=True)
class CoverItem(Generic[Sample]):
    """What is covered: a coverpoint, or the cross of several.

    A mask point comes first, and there is at most one. Of several exclusions of a bin the first holds.
    ``at_least``: hits that a bin needs, a number or a function of its codes.
    """

    name: str
    meaning: str
    points: tuple[Coverpoint[Sample] | MaskPoint[Sample], ...]
    exclusions: tuple[Exclusion, ...] = ()
    at_least: int | Callable[..., int] = 1

    def __post_init__(self) -> None:
        """Refuse what could not be sampled."""
        if not self.points or any(isinstance(point, MaskPoint) for point in self.points[1:]):
            raise ValueError(f"{self.name}: needs points, and a mask point only as the first")
        if any(isinstance(p, MaskPoint) and len(p.bins) > MASK_BITS for p in self.points):
            raise ValueError(f"{self.name}: a mask has {MASK_BITS} bits")
        if not self.size:
            raise ValueError(f"{self.name}: a point without bins would always be covered")
        if any(isinstance(p, Coverpoint) and p.radix > _MOST_CODES for p in self.points):
            raise ValueError(f"{self.name}: a point has at most {_MOST_CODES} codes")

    @property
    def shape(self) -> tuple[int, ...]:
        """Return the number of bins of each point."""
        return tuple(len(point.bins) for point in self.points)

    @property
    def size(self) -> int:
        """Return the number of all bins, excluded or not."""
        return prod(self.shape)

    @cached_property
    def bins(self) -> tuple[Bin, ...]:
        """Return all bins, the last point's varying fastest."""
        return tuple(self._bins())

    @cached_property
    def goals(self) -> npt.NDArray[np.int64]:
        """Return the hits that each bin needs: (size,); 0 where it is excluded."""
        return np.array([0 if b.exclusion else b.goal for b in self.bins], np.int64)

    @cached_property
    def illegal(self) -> npt.NDArray[np.bool_]:
        """Return which bins must not be hit: (size,)."""
        kinds = [b.exclusion.kind if b.exclusion else None for b in self.bins]
        return np.array([kind is Kind.ILLEGAL for kind in kinds], np.bool_)

    def _bins(self) -> Iterator[Bin]:
        for codes in product(*map(range, self.shape)):
            name = " / ".join(point.bins[code] for point, code in zip(self.points, codes, strict=True))
            goal = self.at_least(*codes) if callable(self.at_least) else self.at_least
            if goal < 1:
                raise ValueError(f"{self.name}: {name}: a bin that needs no hit would always be covered")
            yield Bin(name, goal, next((e for e in self.exclusions if e.when(*codes)), None))


_NO_SOURCES = Sources(())


@dataclass(frozen=True)
class CoverModel(Generic[Sample]):
    """Items under one name. ``sources``: the code that samples, for the hash."""

    name: str
    items: tuple[CoverItem[Sample], ...]
    sources: Sources = _NO_SOURCES

    def __post_init__(self) -> None:
        """Refuse two items of one name."""
        names = [item.name for item in self.items]
        if len(set(names)) < len(names):
            raise ValueError(f"{self.name}: items share a name")

    @cached_property
    def hash(self) -> str:
        """Return a hash of the whole definition and of the sampling code.

        Counts of one model are never taken for another's, nor those of an older sampling for a newer's.
        """
        definition = [self.name, [_definition(item) for item in self.items]]
        digest = hashlib.sha256(json.dumps(definition).encode())
        digest.update(_hash_of(self.sources).encode())
        return digest.hexdigest()


@cache
def _hash_of(sources: Sources) -> str:
    """Return the hash of code: read once in a process, whose models are of the code that it runs."""
    return sources.hash()


def _definition(item: CoverItem[Any]) -> list[Any]:
    return [
        item.name,
        item.meaning,
        [point.name for point in item.points],
        [
            [
                b.name,
                b.goal,
                [b.exclusion.kind.value, b.exclusion.reason, b.exclusion.test] if b.exclusion else None,
            ]
            for b in item.bins
        ],
    ]


Hits = npt.NDArray[np.int64]


@cache
def _native(function: str, arguments: str) -> Callable[..., None]:
    return native_function("bins", function, arguments, Path(__file__).parent)


class Sampler(Generic[Sample]):
    """Counts the items of a model for one sample, keeping the codes that several items need."""

    def __init__(self, sample: Sample) -> None:
        """Start with no codes computed."""
        self._sample = sample
        self._known: dict[Coverpoint[Sample], Codes] = {}

    def hits(self, item: CoverItem[Sample]) -> Hits:
        """Return how often each bin of the item is hit: (item.size,)."""
        first, *others = item.points
        classes = tuple(point for point in others if isinstance(point, Coverpoint))
        if isinstance(first, MaskPoint):
            return self._mask_hits(first, classes)
        classes = (first, *classes)
        radices, codes = _radices(classes), self._codes(classes)
        table = np.zeros(radices, np.int64)
        _native("triaxis_count", "ppiiip")(
            _addresses(codes), radices.ctypes.data, len(codes), len(codes[0]), table.size, table.ctypes.data
        )
        return table[_bins(classes)].reshape(-1)

    def _mask_hits(self, point: MaskPoint[Sample], classes: tuple[Coverpoint[Sample], ...]) -> Hits:
        masks = np.ascontiguousarray(point.masks(self._sample), np.uint32)
        if len(masks) and int(np.bitwise_or.reduce(masks)) >> len(point.bins):
            raise ValueError(f"{point.name}: a mask has bits beyond its {len(point.bins)} bins")
        radices, codes = _radices(classes), self._codes(classes)
        if codes and len(codes[0]) != len(masks):
            raise ValueError(f"{point.name}: masks and codes of different samples")
        table = np.zeros((*radices, MASK_BITS), np.int64)
        _native("triaxis_count_masks", "pppiip")(
            masks.ctypes.data,
            _addresses(codes),
            radices.ctypes.data,
            len(codes),
            len(masks),
            table.ctypes.data,
        )
        return np.moveaxis(table[(*_bins(classes), slice(len(point.bins)))], -1, 0).reshape(-1)

    def _codes(self, points: tuple[Coverpoint[Sample], ...]) -> list[Codes]:
        """Return the codes of points: one too large would count for another bin of a cross."""
        for point in points:
            if point in self._known:
                continue
            codes = point.codes(self._sample)
            # A code that is none would be counted outside of the table.
            if codes.dtype.kind not in "ub":
                raise ValueError(f"{point.name}: codes of type {codes.dtype}: must be unsigned")
            if len(codes) and codes.max() >= point.radix:
                raise ValueError(f"{point.name}: code {codes.max()} where there are {point.radix}")
            self._known[point] = np.ascontiguousarray(codes, np.uint8)
        found = [self._known[point] for point in points]
        if len({len(codes) for codes in found}) > 1:
            raise ValueError(f"{', '.join(point.name for point in points)}: codes of different samples")
        return found


def _radices(points: tuple[Coverpoint[Any], ...]) -> npt.NDArray[np.int64]:
    return np.array([point.radix for point in points], np.int64)


def _addresses(arrays: list[Codes]) -> ctypes.Array[ctypes.c_void_p]:
    return (ctypes.c_void_p * max(len(arrays), 1))(*(array.ctypes.data for array in arrays))


def _bins(points: tuple[Coverpoint[Any], ...]) -> tuple[slice, ...]:
    """Return what of a table is bins: the last code of a partial point stands for none of them."""
    return tuple(slice(len(point.bins)) for point in points)
