"""The families of the stress test: each has one knob, turned from easy to impossible."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from triaxis.bench.stress.constructions import (
    degenerate,
    far_away,
    gaps,
    near_misses,
    nearly_coplanar,
    of_unlike_size,
    slivers,
)
from triaxis.verif.core.stimulus.stimulus import Ints, Rng


@dataclass(frozen=True)
class Knob:
    """A setting of the knob: how it reads, and what makes pairs at it."""

    label: str
    construction: Callable[..., Ints]
    values: tuple[Any, ...]

    def make(self, rng: Rng, count: int) -> Ints:
        """Return pairs (N, 2, 3, 3) of whole numbers below 2^53."""
        return self.construction(rng, count, *self.values)


@dataclass(frozen=True)
class Family:
    """Settings from easy to impossible. ``knob``: what is turned, for an axis; ``about``: what is asked."""

    name: str
    knob: str
    about: str
    settings: tuple[Knob, ...]


def _powers(make: Callable[[Rng, int, float], Ints], exponents: Iterable[int]) -> tuple[Knob, ...]:
    """Return settings 2^k."""
    return tuple(Knob(f"2^{k}" if k else "1", make, (2.0**k,)) for k in exponents)


def _falling(make: Callable[[Rng, int, float], Ints], *exponents: int, zero: bool = True) -> tuple[Knob, ...]:
    """Return settings 2^-k, and 0 at the end where ``zero``."""
    end = (Knob("0", make, (0.0,)),) if zero else ()
    return (*_powers(make, (-k for k in exponents)), *end)


FAMILIES = (
    Family(
        "tilt",
        "tilt of the planes (radians)",
        "nearly coplanar triangles; 24-bit coordinates",
        _falling(nearly_coplanar, 4, 12, 16, 18, 20, 22, 24, 32, 40, 44, 48, 50, 52, 54, 60, 66),
    ),
    Family(
        "gap",
        "gap or depth / size",
        "features that nearly touch; 24-bit coordinates",
        _falling(gaps, 8, 12, 13, 14, 16, 18, 20, 22, 24, 32, 40, 44, 48, 50, 52, 54, 60, 66),
    ),
    Family(
        "sliver",
        "width / length of the sliver",
        "edges pass at half its width; 53-bit coordinates",
        _falling(slivers, 0, 8, 12, 16, 18, 20, 22, 24, 28, 36, 44, 46, 48),
    ),
    Family(
        "distance",
        "distance from the origin / range",
        "gaps of 2^-18 of the range; 53-bit coordinates",
        _powers(far_away, (0, 2, 4, 6, 8, 10, 12, 16, 20, 24, 28, 32, 34, 36)),
    ),
    Family(
        "ratio",
        "ratio of the triangles' sizes",
        "small ones pierce large; 53-bit coordinates",
        _falling(of_unlike_size, 0, 8, 12, 16, 18, 20, 22, 24, 26, 28, 36, 42, 46, 48, zero=False),
    ),
    Family(
        "near-miss",
        "bits of the coordinates",
        "a lattice step apart, touching, a lattice step deep",
        tuple(Knob(str(w), near_misses, (w,)) for w in (8, 10, 12, 14, 16, 18, 20, 22, 24, 28, 32)),
    ),
    Family(
        "degenerate",
        "A, B: triangle (T), segment (S) or point (P)",
        "touching, or apart by a step of a small grid",
        tuple(
            Knob(f"{a} {b}", degenerate, ("PST".index(a), "PST".index(b)))
            for a, b in ("TT", "TS", "TP", "SS", "SP", "PP")
        ),
    ),
)
