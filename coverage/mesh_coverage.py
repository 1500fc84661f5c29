"""What the mesh engine must have been seen doing: one coverage model for each build of it.

A transaction is a run. What a build cannot reach is no part of its model, or excluded with the reason.
"""

from collections.abc import Callable, Sequence
from functools import cache

from triaxis.coverage import mesh_points as points
from triaxis.coverage.counts import Counts
from triaxis.coverage.cover_model import CoverItem, CoverModel, Exclusion, Kind
from triaxis.coverage.mesh_points import Point
from triaxis.coverage.mesh_sample import MeshBuild, MeshRow, MeshView
from triaxis.sim.validity import Sources

Item = CoverItem[MeshView]

# See core_coverage.py.
_SOURCES = Sources(("triaxis.coverage.mesh_coverage", "triaxis.verif.mesh.checking"))

_FIRST, _BAD = 0, 3


class MeshCoverage:
    """Collects the coverage of one build of the engine."""

    def __init__(self, build: MeshBuild) -> None:
        """Start with zero counts."""
        self._build = build
        self.model = mesh_model(build)
        self.counts = Counts.empty(self.model)

    def sample(self, rows: Sequence[MeshRow]) -> None:
        """Count runs."""
        if rows:
            self.counts.sample(self.model, MeshView(self._build, rows))


@cache
def mesh_model(build: MeshBuild) -> CoverModel[MeshView]:
    """Return the coverage model of a build."""
    items = [
        Item("mesh_outcome", "mode x status", (points.MODE, points.STATUS), _outcomes()),
        *_sizes(build),
        *_skips(build),
        *_values(build),
        *_gaps(build),
        Item(
            "mesh_near",
            "mode x how many pairs are near, complete or first",
            (points.MODE, points.NEAR),
            _near(),
        ),
        Item("mesh_first", "where the first near pair stood among those tested", (points.FIRST_AT,)),
        Item("mesh_reload", "meshes loaded since the run before, of complete runs", (points.RELOADED,)),
        Item("mesh_abort", "when an abort was asked for", (points.aborts(build),)),
        *_trials(build),
    ]
    if build.cycle_bits < 16:
        items.append(
            Item("mesh_cycles", "whether the clocks went beyond what is counted", (points.SATURATED,))
        )
    if build.pins:
        items += [
            Item("mesh_near_wait", "clocks that a near pair waited, at most", (points.wait("near"),)),
            Item("mesh_done_wait", "clocks that a summary waited", (points.wait("done"),)),
            Item("mesh_load_run", "the last triangle accepted together with the run", (points.TOGETHER,)),
        ]
    return CoverModel(build.name, tuple(items), _SOURCES)


def _illegal(reason: str, when: Callable[..., bool], kind: Kind = Kind.ILLEGAL) -> Exclusion:
    return Exclusion(kind, reason, "MeshRandomTest", when, "mesh engine", "mesh engine")


def _none(reason: str, when: Callable[..., bool]) -> Exclusion:
    return _illegal(reason, when, Kind.IGNORE)


def _outcomes() -> tuple[Exclusion, ...]:
    first, bad = points.STATUSES.index("first"), points.STATUSES.index("bad mode")
    aborted, fault = points.STATUSES.index("aborted"), points.STATUSES.index("fault")
    return (
        _illegal("only mode first stops at a near pair", lambda m, s: s == first and m != _FIRST),
        _illegal("no other mode is refused as one", lambda m, s: s == bad and m != _BAD),
        _illegal(
            "mode none is refused before all else, but for an abort and a fault",
            lambda m, s: m == _BAD and s not in (bad, aborted, fault),
        ),
    )


def _sizes(build: MeshBuild) -> list[Item]:
    group, depth = build.group, build.depth
    # Classes of sizes that the build has not, or that another one takes.
    lacks = {
        2: group <= 2,
        3: group in (1, depth),
        4: group + 1 >= depth,
        5: not set(range(depth)) - {0, 1, group - 1, group, group + 1},
    }
    absent = {size for size, lacking in lacks.items() if lacking}
    none = _none("the build has no such size of its own", lambda a, b: a in absent or b in absent)
    items = [
        Item(
            "mesh_sizes",
            "size of A x B, of runs in a mode that there is",
            (points.size(build, "a"), points.size(build, "b")),
            (none,),
        )
    ]
    if build.group > 1:
        for m in "ab":
            last = points.last("group", m, build.group)
            items.append(Item(f"mesh_last_group_{m}", f"the last group of {m.upper()}", (last,)))
    if build.lanes > 1:
        last = points.last("word", "b", build.lanes)
        items.append(Item("mesh_last_word", "the last word of lanes of B", (last,)))
    return items


def _skips(build: MeshBuild) -> list[Item]:
    single = build.groups == 1
    excluded = [
        _none(
            "a single group of B is the whole of B: what its box leaves, the group's leaves",
            lambda code: single and code in (1, 2, 4, 6, 8),
        ),
        _none(
            "a group of one triangle has the box of the triangle",
            lambda code: build.group == 1 and code in (3, 4, 7, 8),
        ),
    ]
    return [
        Item(
            "mesh_skips",
            "what boxes decide in complete runs",
            (Point("skipped", points.WHO, points.who_skips, partial=True),),
            tuple(excluded),
        )
    ]


def _values(build: MeshBuild) -> list[Item]:
    items: list[Item] = []
    if build.margin_bits:
        items.append(Item("mesh_margin", "margin x whether it ran", (points.margin(build), points.RAN)))
        items += _zones(build)
    reach = 1 << build.width
    for k in points.AXES:
        items.append(Item(f"mesh_move_{k}", f"translation along {k}", (points.move(k, reach),)))
    ends = tuple(f"{points.AXES[n // 2]} {points.ENDS[n % 2]}" for n in range(6))
    for name, meaning in (
        ("fits", "the end of the range that A moved reaches exactly, of runs that were not refused"),
        ("beyond", "the end of the range that A moved passes by one step, the only one that it passes"),
    ):
        items.append(Item(f"mesh_{name}", meaning, (points.mask(name, ends),)))
    return items


def _zones(build: MeshBuild) -> list[Item]:
    few = _none(
        "three margins that differ need two bits", lambda s, w: build.margin_bits < 2 and s != 1 and w == 2
    )
    nothing, narrowest = points.FOUND.index("nowhere"), points.FOUND.index("within the margin")
    in_warn, in_slow = points.FOUND.index("in warn"), points.FOUND.index("in slow")
    none, slow, warn, both = range(len(points.WIDER))
    found = (
        _illegal(
            "what is in no zone but the margin is within that",
            lambda wider, f: wider == none and f not in (nothing, narrowest),
        ),
        _illegal("warn is no wider than slow", lambda wider, f: wider == slow and f == in_warn),
        _illegal("slow is no wider than the margin", lambda wider, f: wider == warn and f == in_slow),
        _none(
            "three margins that differ need two bits",
            lambda wider, f: build.margin_bits < 2 and wider == both,
        ),
    )
    return [
        Item("mesh_zones", "slow to the margin x warn to slow", (points.SLOW, points.WARN), (few,)),
        Item(
            "mesh_found",
            "zones wider than the one within them x where complete runs found something",
            (points.WIDER_ZONES, points.FOUND_IN),
            found,
        ),
        Item("mesh_again", "how often a run with zones asks about a pair once more", (points.AGAIN,)),
    ]


def _gaps(build: MeshBuild) -> list[Item]:
    steps = ("the margin", "the margin + 1")
    bins = tuple(f"{points.AXES[n // 4]}, {points.SIDES[n // 2 % 2]}, {steps[n % 2]}" for n in range(12))

    def beyond(reason: str, is_so: bool) -> tuple[Exclusion, ...]:
        return (_none(reason, lambda code: is_so and code % 2 == 1),)

    return [
        Item(f"mesh_{name}", f"gap between {meaning}, in complete runs", (points.mask(name, bins),), excluded)
        for name, meaning, excluded in (
            ("row_gaps", "a group of A and the whole of B", ()),
            (
                "group_gaps",
                "groups, of rows that are scanned",
                beyond("a single group of B is the whole of B", build.groups == 1),
            ),
            (
                "pair_gaps",
                "triangles, of groups that are opened",
                beyond("a group of one triangle has the box of the triangle", build.group == 1),
            ),
        )
    ]


def _trials(build: MeshBuild) -> list[Item]:
    tries = points.TRIALS
    always = {tries.index(name) for name in ("walk", "intake")}
    attempts = {tries.index(name) for name in ("claim", "parity", "number")}
    never = {tries.index(name) for name in ("nothing", "board")} | (set() if build.certified else attempts)
    exclusions = (
        _illegal("without a trial there is no fault", lambda t, f: t in never and f == 1),
        _illegal("two walks, and two intakes, are compared all the time", lambda t, f: t in always and not f),
    )
    every = tuple(map(str, range(points.WHICHES)))
    return [
        Item("mesh_trial", "what a run tries x how it ends", (points.TRIAL, points.FAULT), exclusions),
        *(
            Item(
                f"mesh_tried_{kind}",
                f"trials of the {meaning} that were a fault",
                (points.which(kind, bins),),
            )
            for kind, meaning, bins in (
                ("memory", "memories", points.MEMORIES),
                ("walk", "comparison of walks, each 32nd bit from one on", every),
                ("intake", "comparison of intakes, each 32nd bit from one on", every),
            )
        ),
        Item("mesh_scrubbed", "trials of the scrub that were found after their run", (points.SCRUB,)),
        Item("mesh_fault_before", "what became of a fault until the next run", (points.BEFORE,)),
    ]


def _near() -> tuple[Exclusion, ...]:
    return (
        _illegal("mode none runs nothing", lambda mode, near: mode == _BAD),
        _illegal("mode first ends at one", lambda mode, near: mode == _FIRST and near in (2, 3)),
    )
