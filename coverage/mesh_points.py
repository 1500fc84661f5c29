"""The points of the mesh engine's coverage model: what a finished run is sorted by."""

import numpy as np

from triaxis.coverage.cover_model import Coverpoint, MaskPoint
from triaxis.coverage.mesh_sample import Before, Codes, Column, MeshBuild, MeshView

Point = Coverpoint[MeshView]

MODES = ("first", "all", "count", "none")
STATUSES = ("complete", "first", "aborted", "overflow", "overfull", "bad mode", "fault")
_BAD_MODE, _FAULT = 6, 7
TRIALS = ("nothing", "claim", "parity", "number", "memory", "walk", "intake", "board")
MEMORIES = ("groups of A", "groups of B", "boxes of A", "boxes of B", "triangles of A", "triangles of B")
WHICHES = 32
# Of trials of memories, from number 8 on: those of the scrub.
SCRUBBED = (
    *(f"{memory}, scrubbed" for memory in MEMORIES),
    *(f"signature, each eighth bit from {bit} on" for bit in range(8)),
    *(f"{bounds}, axis {axis}" for bounds in ("within its box", "within its group's box") for axis in "xyz"),
)
_SCRUBBED_FROM = (*range(8, 14), *range(16, 30))
SIZES = ("empty", "1", "group - 1", "group", "group + 1", "several groups", "depth", "overfull")
AXES = "xyz"
ENDS = ("low", "high")
SIDES = ("B below", "B above")
WHO = (
    "all by rows",
    "all by groups, no row",
    "all by rows and groups",
    "all by boxes of triangles",
    "all by boxes of all kinds",
    "nothing",
    "some by groups, some tested",
    "some by triangles, some tested",
    "some by both, some tested",
)


def _classes(column: Column, *starts: int) -> Codes:
    """Return how many of the ascending starts are not above each number."""
    return np.searchsorted(np.array(starts), column, "right").astype(np.uint8)


def _choice(*conditions: np.ndarray) -> Codes:
    """Return the number of the first condition that holds; one more than there are: none."""
    table = np.stack([*conditions, np.ones_like(conditions[0], np.bool_)])
    return table.argmax(0).astype(np.uint8)


MODE = Point("mode", MODES, lambda v: v.mode.astype(np.uint8))
STATUS = Point("status", STATUSES, lambda v: (v.status - 1).astype(np.uint8))
RAN = Point(
    "ran",
    ("refused", "ran"),
    lambda v: np.where(v.status == _FAULT, 2, v.status <= 3).astype(np.uint8),
    partial=True,
)


def size(build: MeshBuild, mesh: str) -> Point:
    """Return the point of the sizes of mesh "a" or "b", of runs whose mode is one."""
    bit = 1 << "ab".index(mesh)

    def codes(view: MeshView) -> Codes:
        count = getattr(view, f"count_{mesh}")
        group = build.group
        sizes = _choice(
            (count == 0),
            (count == 1),
            (count == group - 1),
            (count == group) & (count < build.depth),
            (count == group + 1) & (count < build.depth),
            (count < build.depth),
            (view.overfull & bit) == 0,
        )
        return np.where(view.status == _BAD_MODE, len(SIZES), sizes).astype(np.uint8)

    return Point(f"size of {mesh.upper()}", SIZES, codes, partial=True)


def last(name: str, mesh: str, size: int) -> Point:
    """Return whether the last group or word, of ``size`` triangles, was full, of runs that scanned."""

    def codes(view: MeshView) -> Codes:
        count = getattr(view, f"count_{mesh}")
        ran = (view.status <= 2) & (view.count_a * view.count_b > 0)
        return _choice(ran & (count % size == 0), ran)

    return Point(f"last {name} of {mesh.upper()}", ("full", "partial"), codes, partial=True)


def who_skips(view: MeshView) -> Codes:
    """Return which boxes decided how much, of complete runs with pairs: numbers of `WHO`."""
    ran = (view.status == 1) & (view.count_a * view.count_b > 0)
    opened, groups, boxes = view.group_pairs_opened, view.group_pairs_skipped, view.pairs_skipped
    return _choice(
        ran & (opened == 0) & (view.rows_skipped == view.rows),
        ran & (opened == 0) & (view.rows_skipped == 0),
        ran & (opened == 0),
        ran & (view.tested == 0) & (groups == 0),
        ran & (view.tested == 0),
        ran & (groups == 0) & (boxes == 0),
        ran & (boxes == 0),
        ran & (groups == 0),
        ran,
    )


def margin(build: MeshBuild) -> Point:
    """Return the point of margins."""
    largest = build.largest_margin
    bins = ("0", "1") if largest == 1 else ("0", "1", "between", "largest")
    starts = (1,) if largest == 1 else (1, 2, largest)
    return Point("margin", bins, lambda v: _classes(v.margin, *starts))


def move(axis: str, reach: int) -> Point:
    """Return the point of translations along an axis; ``reach``: the ends of the port."""
    bins = (f"-{reach}, the lowest", "below 0", "0", "above 0", f"{reach - 1}, the highest")
    return Point(
        f"translation {axis}",
        bins,
        lambda v: _classes(getattr(v, f"move_{axis}"), -reach + 1, 0, 1, reach - 1),
    )


def mask(name: str, bins: tuple[str, ...]) -> MaskPoint[MeshView]:
    """Return the point of a column whose bits are bins."""
    return MaskPoint(name, bins, lambda v: getattr(v, name).astype(np.uint32))


def _how_near(view: MeshView) -> Codes:
    ran = (view.status <= 2) & (view.count_a * view.count_b > 0)
    pairs = view.count_a * view.count_b
    return _choice(ran & (view.near == 0), ran & (view.near == 1), ran & (view.near == pairs), ran)


NEAR = Point("near", ("none", "one", "all", "some"), _how_near, partial=True)
# Zones that are wider than the one within them; where something was found, of complete runs with pairs.
WIDER = ("none", "slow", "warn", "both")
FOUND = ("within the margin", "in slow", "in warn", "nowhere")


def _slow(view: MeshView) -> Column:
    return np.maximum(view.slow, view.margin)


def _compared(one: Column, other: Column) -> Codes:
    return (1 + np.sign(one - other)).astype(np.uint8)


_COMPARED = ("narrower", "as wide", "wider")
SLOW = Point("slow", _COMPARED, lambda v: _compared(v.slow, v.margin))
WARN = Point("warn", _COMPARED, lambda v: _compared(v.warn, _slow(v)))
WIDER_ZONES = Point(
    "wider", WIDER, lambda v: ((v.slow > v.margin) + 2 * (v.warn > _slow(v))).astype(np.uint8)
)


def _found(view: MeshView) -> Codes:
    ran = (view.status == 1) & (view.count_a * view.count_b > 0)
    in_slow = (view.slow > view.margin) & (view.zones % 2 == 1)
    in_warn = (view.warn > _slow(view)) & (view.zones >= 2)
    return _choice(ran & (view.near > 0), ran & in_slow, ran & in_warn, ran)


FOUND_IN = Point("found", FOUND, _found, partial=True)
AGAIN = Point(
    "again",
    ("none", "one", "some", "16 and more"),
    lambda v: np.where(
        (v.slow > v.margin) | (v.warn > _slow(v)), _classes(v.asked_again, 1, 2, 16), 4
    ).astype(np.uint8),
    partial=True,
)
FIRST_AT = Point(
    "first",
    ("the first", "the second", "later"),
    lambda v: np.where((v.status == 2) & (v.first_at >= 0), np.minimum(v.first_at, 2), 3).astype(np.uint8),
    partial=True,
)
RELOADED = Point(
    "reloaded",
    ("none", "only A", "only B", "both"),
    lambda v: np.where(v.status == 1, v.reloaded, 4).astype(np.uint8),
    partial=True,
)
SATURATED = Point("cycles", ("counted", "at the largest number"), lambda v: v.saturated.astype(np.uint8))
TOGETHER = Point("load and run", ("apart", "together"), lambda v: v.loaded_with_run.astype(np.uint8))


def _tries(view: MeshView) -> Codes:
    """Return what runs try that began without a fault and came to it.

    Attempts need a pair, memories a scan.
    """
    attempts, memory = (view.tried >= 1) & (view.tried <= 3), view.tried == TRIALS.index("memory")
    idle = attempts & (view.tested == 0) | memory & ((view.count_a * view.count_b == 0) | (view.status > 3))
    none = (view.before == Before.STAYS) | idle & (view.status != _FAULT)
    return np.where(none, len(TRIALS), view.tried).astype(np.uint8)


TRIAL = Point("tries", TRIALS, _tries, partial=True)
FAULT = Point("ends", ("otherwise", "in a fault"), lambda v: (v.status == _FAULT).astype(np.uint8))
BEFORE = Point(
    "fault before",
    ("stays", "acknowledged", "ended by a reset"),
    lambda v: np.where(v.before == Before.NO_FAULT, 3, v.before - 1).astype(np.uint8),
    partial=True,
)


def _scrubbed(view: MeshView) -> Codes:
    codes = np.full(256, len(SCRUBBED), np.uint8)
    codes[list(_SCRUBBED_FROM)] = range(len(SCRUBBED))
    counts = (view.status == _FAULT) & (view.before == Before.STAYS) & (view.scrubbed >= 0)
    return codes[np.where(counts, view.scrubbed, 255)]


SCRUB = Point("which scrub", SCRUBBED, _scrubbed, partial=True)


def which(kind: str, bins: tuple[str, ...]) -> Point:
    """Return which of a kind of trial were a fault."""
    number = TRIALS.index(kind)

    def codes(view: MeshView) -> Codes:
        counts = (view.tried == number) & (view.status == _FAULT) & (view.before != Before.STAYS)
        return np.where(counts & (view.which < len(bins)), view.which, len(bins)).astype(np.uint8)

    return Point(f"which {kind}", bins, codes, partial=True)


def aborts(build: MeshBuild) -> MaskPoint[MeshView]:
    """Return when aborts came."""
    # Only on the pins is there a second abort, or one without a run.
    seen = ("settling", "scanning", "draining", "reporting", "idle")
    if build.pins:
        return MaskPoint("abort", seen, lambda v: v.aborts.astype(np.uint32))
    bins = tuple(seen[n] for n in (0, 1, 3))
    return MaskPoint("abort", bins, lambda v: (v.aborts & 3 | (v.aborts & 8) >> 1).astype(np.uint32))


def wait(stream: str) -> Point:
    """Return how long what the stream "near" or "done" offers waited."""

    def codes(view: MeshView) -> Codes:
        waits = getattr(view, f"{stream}_wait")
        return np.where(waits < 0, 3, _classes(waits, 1, 8)).astype(np.uint8)

    return Point(f"{stream} waits", ("none", "some", "8 and more"), codes, partial=True)
