"""The coverpoints of the core's model: names of bins, and which array of the view holds their codes."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from triaxis.coverage.core_sample import Codes, CoreView, axes_of, classes
from triaxis.coverage.cover_model import Coverpoint, MaskPoint
from triaxis.golden.axes import NUM_AXES, axis_name
from triaxis.golden.facts import Mask
from triaxis.sim.configuration import Configuration

Point = Coverpoint[CoreView]

# Runs of unstalled pairs: one deeper than the result queue, and one much longer than the pipeline.
_RUNS = (2, 8, 33, 1025)
_WAITS = ("none", "1", "2 to 7", "8 or more")
_VERTEX_SETS = ("1", "2", "1+2", "3", "1+3", "2+3", "1+2+3")
_FEATURES = ("vertex", "edge", "face")
# Vertices sorted by (x, y, z), as golden.facts numbers orders.
_ORDERS = ("123", "132", "213", "231", "312", "321")
_RANKS = ("point", "segment", "triangle")


def _both(
    name: str, bins: tuple[str, ...], codes: Callable[[CoreView, str], Codes], partial: bool = False
) -> tuple[Point, Point]:
    """Return a point of A and one of B; ``codes``: of a view, and of "a" or "b"."""

    def of(triangle: str) -> Point:
        named = tuple(f"{triangle} {one}" for one in bins)
        return Point(f"{name} {triangle}", named, lambda v: codes(v, triangle.lower()), partial)

    return of("A"), of("B")


def _orders(rank: int) -> tuple[Point, Point]:
    """Return the points of the orders of vertices where the rank is as wanted."""

    def codes(view: CoreView, triangle: str) -> Codes:
        other = (getattr(view.facts, f"rank_{triangle}") != rank).view(np.uint8) * np.uint8(6)
        return np.maximum(getattr(view.facts, f"order_{triangle}"), other)

    return _both(f"{_RANKS[rank]} order", _ORDERS, codes, partial=True)


RANK_A, RANK_B = _both("rank", _RANKS, lambda v, t: getattr(v.facts, f"rank_{t}"))
COPLANAR = Point("coplanar", ("not coplanar", "coplanar"), lambda v: v.facts.coplanar)
VERDICT = Point("verdict", ("clear", "near"), lambda v: v.near)
DECISION = Point("decision", ("clear by box", "clear by other axis", "near"), lambda v: v.decision)
PREVIOUS = Point(
    "decision before", ("after box", "after other axis", "after near"), lambda v: v.previous, partial=True
)
SIDE = Point("side", ("B above A", "B below A"), lambda v: v.side)
MARGIN_SIGN = Point("margin sign", ("m = 0", "m > 0"), lambda v: v.margin_positive)
SIZE = Point("size", ("below 8", "below 2^(W/2)", "large", "both limits"), lambda v: v.size)
EXTENT = Point("extent", ("narrow", "wide"), lambda v: v.wide)
RELATION = Point(
    "relation",
    ("clear", "touching", "A in B", "B in A", "identical", "coplanar overlap", "penetrating"),
    lambda v: v.relation,
)
CONTACT_A, CONTACT_B = _both(
    "contact", _VERTEX_SETS, lambda v, t: v.support(getattr(v.facts, f"support_{t}")), partial=True
)
FEATURE_A, FEATURE_B = _both(
    "feature", _FEATURES, lambda v, t: v.features(getattr(v.facts, f"support_{t}")), partial=True
)
TRIANGLE_ORDER_A, TRIANGLE_ORDER_B = _orders(2)
SEGMENT_ORDER_A, SEGMENT_ORDER_B = _orders(1)
ANSWER = Point(
    "answer",
    (
        "clear, wrongly",
        "near, wrongly",
        "clear, by the lowest axis",
        "near",
        "clear, by another axis or with spare bits",
        "near, with spare bits or an axis",
    ),
    lambda v: v.answer,
    partial=True,
)
FLAGS = Point(
    "flags",
    tuple(
        ", ".join(n for bit, n in enumerate(("coplanar", "A degenerate", "B degenerate")) if code >> bit & 1)
        or "no flag"
        for code in range(8)
    ),
    lambda v: v.answered_flags,
)
WAITS_IN = Point("waits in", tuple(f"in {w}" for w in _WAITS), lambda v: classes(v.sample.waits_in, 1, 2, 8))
WAITS_OUT = Point(
    "waits out", tuple(f"out {w}" for w in _WAITS), lambda v: classes(v.sample.waits_out, 1, 2, 8)
)
RUNS = Point(
    "runs", ("1", "2 to 7", "8 to 32", "33 to 1024", "more than 1024"), lambda v: classes(v.runs, *_RUNS)
)
BLIND = Point("blind", ("by its axes", "near, though a missing axis separates"), lambda v: v.blind)
# The kind of each claim, 0 near, 1 + axis otherwise.
_KIND_OF_CLAIM = np.repeat(np.arange(6, dtype=np.uint8), [1, 3, 2, 9, 18, 1])
# Builds with margins have all axes: every claim has a kind.
KIND = Point(
    "kind",
    ("near", "box", "normal", "edge x edge", "edge x box"),
    lambda v: _KIND_OF_CLAIM.take(v.claim),
    partial=True,
)
# What a pair of a certified core tries: a claim, of any of the 32 axes, and how far from true it is; a parity
# bit; a bit of its number.
TRIED_CLAIM = Point(
    "claim on trial",
    tuple(f"{n:02d} {axis_name(n)}" for n in range(NUM_AXES)),
    lambda v: v.tried_claim,
    partial=True,
)
TRIED_DISTANCE = Point(
    "distance on it",
    ("less than the margin", "the margin", "the smallest step more", "more"),
    lambda v: v.tried_distance,
)
TRIED_PARITY = Point(
    "parity on trial",
    (
        *(f"{triangle}{v} {k}" for triangle in "AB" for v in (1, 2, 3) for k in "xyz"),
        "the rest of the pair",
        "result",
    ),
    lambda v: v.tried_parity,
    partial=True,
)
TRIED_NUMBER = Point(
    "number on trial", tuple(f"bit {n}" for n in range(7)), lambda v: v.tried_number, partial=True
)


@dataclass(frozen=True)
class AxisPoints:
    """The points whose bins are the axes of a build; a pair may fall into none of them."""

    claim: Point
    sole: Point
    sole_step: Point
    level_above: MaskPoint[CoreView]
    level_below: MaskPoint[CoreView]
    near_step_above: MaskPoint[CoreView]
    near_step_below: MaskPoint[CoreView]
    flat: MaskPoint[CoreView]


def axis_points(build: Configuration) -> AxisPoints:
    """Return the points whose bins are the axes of a build."""
    axes = tuple(f"{n:02d} {axis_name(n)}" for n in range(axes_of(build)))

    def mask(name: str, masks: Callable[[CoreView], Mask]) -> MaskPoint[CoreView]:
        return MaskPoint(name, axes, masks)

    return AxisPoints(
        Point("claim", ("near", *axes), lambda v: v.claim, partial=True),
        Point("sole axis", axes, lambda v: v.sole, partial=True),
        Point("sole axis by one step", axes, lambda v: v.sole_step, partial=True),
        mask("level, B above", lambda v: v.near_only(v.facts.level & v.facts.upper)),
        mask("level, B below", lambda v: v.near_only(v.facts.level & v.facts.lower)),
        mask("one step short, B above", lambda v: v.near_only(v.facts.near_step & v.facts.upper)),
        mask("one step short, B below", lambda v: v.near_only(v.facts.near_step & v.facts.lower)),
        mask("flat", lambda v: v.flat_at_zero),
    )


def margin_point(build: Configuration) -> Point:
    """Return the point of margins, from 0 to a quarter of the range and more, as far as a build has them."""
    # From a quarter on every axis can still be the one that separates, whatever W and M.
    large = 1 << max(build.margin_bits - 2, 0)
    starts = [1]
    starts += [2] if build.margin_bits > 1 else []
    starts += [8] if build.margin_bits > 3 else []
    starts += [large] if large > 8 else []
    bins = ("m = 0", "m = 1", *(f"m from {start}" for start in starts[1:]))
    return Point("margin", bins, lambda v: classes(v.sample.margins, *starts))


def margin_end(build: Configuration) -> Point:
    """Return the point of margins at the end of the range."""
    largest = build.max_margin
    bins = ("smaller margin", f"m = {largest}, the largest")
    return Point("largest margin", bins, lambda v: classes(v.sample.margins, largest))
