"""What the core must have been seen doing: one coverage model for each build of it.

What a build cannot reach is no part of its model, so goals are met build by build.
"""

from dataclasses import replace
from functools import cache

from triaxis.coverage import core_exclusions as exclusions
from triaxis.coverage import core_points as points
from triaxis.coverage.core_points import AxisPoints, Point, axis_points, margin_end, margin_point
from triaxis.coverage.core_sample import CoreSample, CoreView
from triaxis.coverage.counts import Counts
from triaxis.coverage.cover_model import CoverItem, CoverModel
from triaxis.sim.configuration import Configuration
from triaxis.sim.validity import Sources

Item = CoverItem[CoreView]

# Code that decides what a count means, with all that it imports: counts of another version of it are refused.
# The environment's, which makes samples, by its name: it stands above, and is not imported.
_SOURCES = Sources(("triaxis.coverage.core_coverage", "triaxis.verif.core.checking"))
# One hit of an axis as the claim may be luck: it is the answer that users rely on.
_CLAIMS = 10
# Of near pairs an error on any axis shows, so these need not be alone.
_LEVEL = "axes exactly at the margin, of near pairs"
_NEAR_STEP = "axes short of separating by the smallest step, of near pairs"


def core_model(configuration: Configuration) -> CoverModel[CoreView]:
    """Return the coverage model of a configuration: the same for every size of tags."""
    return _model(replace(configuration, tag_bits=Configuration().tag_bits))


class CoreCoverage:
    """Collects the coverage of one configuration of the core."""

    def __init__(self, configuration: Configuration) -> None:
        """Start with zero counts."""
        self._build = configuration
        self.model = core_model(configuration)
        self.counts = Counts.empty(self.model)

    def sample(self, sample: CoreSample) -> None:
        """Count N checked pairs. 16384 and more are fastest: a call takes about a millisecond at least."""
        self.counts.sample(self.model, CoreView(self._build, sample))


@cache
def _model(build: Configuration) -> CoverModel[CoreView]:
    axes = axis_points(build)
    margin = (points.MARGIN_SIGN,) if build.margin_bits else ()
    items = (
        *_answers(build, axes),
        *_axes(build, axes, margin),
        *_geometry(build, margin),
        *_orders(),
        *_protocol(),
        *(_attempts(margin) if build.certified else ()),
    )
    return CoverModel(f"core_{build.name}", items, _SOURCES)


def _answers(build: Configuration, axes: AxisPoints) -> list[Item]:
    items = [
        Item(
            "answer",
            "what the core answered, against the golden model",
            (points.ANSWER,),
            exclusions.ANSWER_PROOFS,
        ),
        Item("claim", "the verdict, with the axis that the core claims", (axes.claim,), at_least=_CLAIMS),
        Item(
            "flags", "who decided x flags answered", (points.DECISION, points.FLAGS), exclusions.flags(build)
        ),
    ]
    if not build.edge_box:
        items.append(
            Item(
                "blind",
                "axes that the core lacks x coplanar",
                (points.BLIND, points.COPLANAR),
                exclusions.BLIND_PROOFS,
            )
        )
    return items


def _axes(build: Configuration, axes: AxisPoints, margin: tuple[Point, ...]) -> list[Item]:
    items = [
        Item(
            "sole_axis",
            "the only axis that separates x side x ranks",
            (axes.sole, points.SIDE, points.RANK_A, points.RANK_B, *margin),
            exclusions.sole_axis(build),
        ),
        Item(
            "sole_axis_size", "the only axis that separates x size of the numbers", (axes.sole, points.SIZE)
        ),
        Item(
            "clear_step",
            "the only axis that separates, by the smallest step x side x extent",
            (axes.sole_step, points.SIDE, points.EXTENT, *margin),
        ),
        *(
            Item(f"{name}_{side}", f"{meaning}, B {side} A x extent", (point, points.EXTENT, *margin))
            for name, side, meaning, point in (
                ("level", "above", _LEVEL, axes.level_above),
                ("level", "below", _LEVEL, axes.level_below),
                ("near_step", "above", _NEAR_STEP, axes.near_step_above),
                ("near_step", "below", _NEAR_STEP, axes.near_step_below),
            )
        ),
        Item("flat", "axes on which all vertices of a near pair fall together, margin 0", (axes.flat,)),
    ]
    if build.margin_bits:
        sizes = margin_point(build)
        items += [
            Item("margin_kind", "margin x kind of the claim", (sizes, points.KIND)),
            Item("margin_axis", "the only axis that separates x margin", (axes.sole, sizes)),
            Item(
                "largest_margin",
                "whether the margin is the largest x who decided",
                (margin_end(build), points.DECISION),
                exclusions.largest_margin(build),
            ),
        ]
    return items


def _geometry(build: Configuration, margin: tuple[Point, ...]) -> list[Item]:
    ranks = (points.RANK_A, points.RANK_B, *margin)
    return [
        Item("relation", "how A and B lie x ranks", (points.RELATION, *ranks), exclusions.RELATION_PROOFS),
        Item(
            "contact",
            "vertices of A x of B that span what touches, of two triangles",
            (points.CONTACT_A, points.CONTACT_B, *margin),
            exclusions.CONTACT_PROOFS,
        ),
        Item(
            "contact_features",
            "feature of A x of B that touches x coplanar, of two triangles",
            (points.FEATURE_A, points.FEATURE_B, points.COPLANAR, *margin),
            exclusions.CONTACT_FEATURES_PROOFS,
        ),
        Item(
            "decision",
            "who decided x coplanar x ranks",
            (points.DECISION, points.COPLANAR, *ranks),
            exclusions.decision(build),
        ),
        Item("size", "size of the numbers x who decided", (points.SIZE, points.DECISION)),
    ]


def _orders() -> list[Item]:
    return [
        Item(
            "triangle_orders",
            "which order of the vertices sorts A x B x verdict, of two triangles",
            (points.TRIANGLE_ORDER_A, points.TRIANGLE_ORDER_B, points.VERDICT),
        ),
        *(
            Item(
                f"segment_order_{name.lower()}",
                f"which order of the vertices sorts {name} x verdict, {name} a segment",
                (point, points.VERDICT),
            )
            for name, point in (("A", points.SEGMENT_ORDER_A), ("B", points.SEGMENT_ORDER_B))
        ),
    ]


def _protocol() -> list[Item]:
    return [
        Item(
            "succession",
            "who decided the pair before x this pair: operand gating switches between them",
            (points.PREVIOUS, points.DECISION),
        ),
        Item(
            "waits",
            "clocks that a pair was offered before it was taken x its result",
            (points.WAITS_IN, points.WAITS_OUT),
        ),
        Item("runs", "pairs in a row, clock by clock, that waited on neither side", (points.RUNS,)),
    ]


def _attempts(margin: tuple[Point, ...]) -> list[Item]:
    return [
        Item(
            "tried_claim",
            "axes claimed on trial x how far they separate",
            (points.TRIED_CLAIM, points.TRIED_DISTANCE, *margin),
        ),
        Item(
            "tried_parity",
            "parity bits inverted on trial x who decided",
            (points.TRIED_PARITY, points.DECISION),
        ),
        Item(
            "tried_number",
            "bits of the pair's number inverted on trial x who decided",
            (points.TRIED_NUMBER, points.DECISION),
        ),
    ]
