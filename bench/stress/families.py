"""The families of the stress test: each has one knob, turned from easy to impossible."""

from collections.abc import Callable
from dataclasses import dataclass

from triaxis.bench.stress.constructions import (
    WIDTH,
    contacts_at,
    degenerate,
    far_away,
    near_misses,
    nearly_coplanar,
    of_unlike_size,
    slivers,
)
from triaxis.verif.core.stimulus.stimulus import Ints, Rng


@dataclass(frozen=True)
class Knob:
    """A setting of the knob: how it reads, and pairs (N, 2, 3, 3) of whole numbers below 2^53 at it."""

    label: str
    make: Callable[[Rng, int], Ints]


@dataclass(frozen=True)
class Family:
    """Settings from easy to impossible. ``knob``: what is turned, for an axis; ``about``: what is asked."""

    name: str
    knob: str
    about: str
    settings: tuple[Knob, ...]


def _power(exponent: int) -> str:
    return f"2^{exponent}" if exponent else "1"


def _falling(
    make: Callable[[Rng, int, float], Ints], exponents: tuple[int, ...], zero: bool
) -> tuple[Knob, ...]:
    """Return settings 2^-k, and 0 at the end where ``zero``."""

    def knob(label: str, value: float) -> Knob:
        return Knob(label, lambda rng, count: make(rng, count, value))

    settings = tuple(knob(_power(-k), 2.0**-k) for k in exponents)
    return (*settings, knob("0", 0.0)) if zero else settings


def _gaps(rng: Rng, count: int, gap: float) -> Ints:
    return contacts_at(rng, count, WIDTH, gap * 2.0 ** (WIDTH - 2))


def _width(width: int) -> Knob:
    return Knob(str(width), lambda rng, count: near_misses(rng, count, width))


def _ranks(label: str, rank_a: int, rank_b: int) -> Knob:
    return Knob(label, lambda rng, count: degenerate(rng, count, rank_a, rank_b))


FAMILIES = (
    Family(
        "tilt",
        "tilt of the planes (radians)",
        "nearly coplanar triangles; 24-bit coordinates",
        _falling(nearly_coplanar, (4, 12, 16, 18, 20, 22, 24, 32, 40, 44, 48, 50, 52, 54, 60, 66), True),
    ),
    Family(
        "gap",
        "gap or depth / size",
        "features that nearly touch; 24-bit coordinates",
        _falling(_gaps, (8, 12, 13, 14, 16, 18, 20, 22, 24, 32, 40, 44, 48, 50, 52, 54, 60, 66), True),
    ),
    Family(
        "sliver",
        "width / length of the sliver",
        "edges pass at half its width; 53-bit coordinates",
        _falling(slivers, (0, 8, 12, 16, 18, 20, 22, 24, 28, 36, 44, 46, 48), True),
    ),
    Family(
        "distance",
        "distance from the origin / range",
        "gaps of 2^-18 of the range; 53-bit coordinates",
        tuple(
            Knob(_power(k), lambda rng, count, k=k: far_away(rng, count, 2.0**k))
            for k in (0, 2, 4, 6, 8, 10, 12, 16, 20, 24, 28, 32, 34, 36)
        ),
    ),
    Family(
        "ratio",
        "ratio of the triangles' sizes",
        "small ones pierce large; 53-bit coordinates",
        _falling(of_unlike_size, (0, 8, 12, 16, 18, 20, 22, 24, 26, 28, 36, 42, 46, 48), False),
    ),
    Family(
        "near-miss",
        "bits of the coordinates",
        "a lattice step apart, touching, a lattice step deep",
        tuple(_width(width) for width in (8, 10, 12, 14, 16, 18, 20, 22, 24, 28, 32)),
    ),
    Family(
        "degenerate",
        "A, B: triangle (T), segment (S) or point (P)",
        "touching, or apart by a step of a small grid",
        (
            _ranks("T T", 2, 2),
            _ranks("T S", 2, 1),
            _ranks("T P", 2, 0),
            _ranks("S S", 1, 1),
            _ranks("S P", 1, 0),
            _ranks("P P", 0, 0),
        ),
    ),
)
