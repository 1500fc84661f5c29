"""A checked run as a row of the coverage model."""

import numpy as np

from triaxis.coverage.mesh_sample import UNKNOWN, AbortSeen, Before, MeshBuild, MeshRow
from triaxis.golden.pairs import coordinate_range
from triaxis.golden.scene import SceneAnswer, boxes_of, boxes_of_groups
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.mesh_engine import Status
from triaxis.verif.mesh.expectation import moved
from triaxis.verif.mesh.items import Integers, ObservedRun, Summary

# Larger scenes are not searched for gaps: small ones have them all.
_LARGEST = 1 << 14
# From the acceptance of a run to the start of its scan, where nothing has to settle.
_START = 2


# Configurations that are driven pin by pin as well, where traffic can be seen.
PIN_DRIVEN = ("w16_m16_d64_g8_l8", "w12_m0_d32_g4_l2_c8")


def mesh_build(configuration: MeshConfiguration) -> MeshBuild:
    """Return the build of a configuration, as the coverage model takes it."""
    c = configuration
    return MeshBuild(
        f"mesh_{c.name}",
        c.width,
        c.margin_bits,
        c.depth,
        c.group,
        c.lanes,
        c.cycle_bits,
        c.name in PIN_DRIVEN,
        c.certified,
    )


def row_of(
    configuration: MeshConfiguration, run: ObservedRun, summary: Summary, answer: SceneAnswer | None,
    before: Before = Before.NO_FAULT, scrubbed: int = UNKNOWN,
) -> MeshRow:  # fmt: skip
    """Return the row of a run; ``answer`` is None where nothing was to be run."""
    request = run.request
    fits, beyond = _ends(configuration, run) if not any(run.overfull) else (0, 0)
    rows_skipped = rows = first_at = 0
    gaps = (0, 0, 0)
    if answer is not None:
        rows, rows_skipped = len(answer.rows_apart), int(answer.rows_apart.sum())
        # A run that ends early may have come to none of these boxes.
        gaps = _gaps(configuration, run, answer) if summary.status == Status.COMPLETE else gaps
        first_at = summary.tested - 1 if summary.status == Status.FIRST else UNKNOWN
    return MeshRow(
        mode=request.mode,
        status=summary.status,
        count_a=len(run.a),
        count_b=len(run.b),
        overfull=run.overfull[0] | run.overfull[1] << 1,
        margin=request.margin,
        slow=request.zones[0],
        warn=request.zones[1],
        move_x=request.translation[0],
        move_y=request.translation[1],
        move_z=request.translation[2],
        near=summary.near,
        zones=summary.zones,
        asked_again=run.asked_again,
        group_pairs_skipped=summary.group_pairs_skipped,
        group_pairs_opened=summary.group_pairs_opened,
        rows=rows,
        rows_skipped=rows_skipped,
        pairs_skipped=summary.pairs_skipped,
        tested=summary.tested,
        fits=fits if answer is not None else 0,
        beyond=beyond if summary.status == Status.OVERFLOW else 0,
        row_gaps=gaps[0],
        group_gaps=gaps[1],
        pair_gaps=gaps[2],
        aborts=_aborts(run, summary),
        reloaded=run.reloaded[0] | run.reloaded[1] << 1,
        first_at=first_at,
        saturated=int(summary.cycles == configuration.max_cycles),
        loaded_with_run=int(run.loaded_with_run),
        near_wait=max((part.wait for part in run.near), default=UNKNOWN),
        done_wait=summary.wait,
        tried=request.tries[0],
        which=request.tries[1],
        before=before,
        scrubbed=scrubbed,
    )


def _ends(configuration: MeshConfiguration, run: ObservedRun) -> tuple[int, int]:
    """Return the ends of the range that A moved reaches exactly, and the one that it passes by a step."""
    if not len(run.a):
        return 0, 0
    low, high = coordinate_range(configuration.width)
    points = moved(run.a, run.request.translation).reshape(-1, 3)
    past = np.stack([low - points.min(0), points.max(0) - high], 1).ravel()
    fits = sum(1 << n for n in np.flatnonzero(past == 0).tolist())
    passed = np.flatnonzero(past > 0).tolist()
    beyond = 1 << passed[0] if len(passed) == 1 and past[passed[0]] == 1 else 0
    return fits, beyond


def _gaps(configuration: MeshConfiguration, run: ObservedRun, answer: SceneAnswer) -> tuple[int, int, int]:
    """Return the gaps of rows, of groups in rows that are scanned, of pairs in groups that are opened."""
    if not answer.near.size or answer.near.size > _LARGEST:
        return 0, 0, 0
    margin, group = run.request.margins[-1], configuration.group
    boxes_a, boxes_b = boxes_of(moved(run.a, run.request.translation)), boxes_of(run.b)
    groups_a, groups_b = boxes_of_groups(boxes_a, group), boxes_of_groups(boxes_b, group)
    whole_b = boxes_of_groups(boxes_b, len(boxes_b))
    scanned = np.broadcast_to(~answer.rows_apart[:, None], answer.groups_apart.shape)
    return (
        _gap_mask(groups_a, whole_b, margin, np.ones((len(groups_a), 1), np.bool_)),
        _gap_mask(groups_a, groups_b, margin, scanned),
        _gap_mask(boxes_a, boxes_b, margin, ~answer.in_groups_apart),
    )


def _gap_mask(a: Integers, b: Integers, margin: int, counted: np.ndarray) -> int:
    """Return bit 4k+2s+e where, of boxes that count, the gap on axis k and side s is the margin plus e, and
    no other gap is more than the margin.
    """
    below = a[:, None, 0] - b[None, :, 1]
    above = b[None, :, 0] - a[:, None, 1]
    excess = np.stack([below, above], -1).reshape(len(a), len(b), 6) - margin
    alone = counted[..., None] & ((excess > 0).sum(-1, keepdims=True) <= (excess > 0))
    found = 0
    for step in range(2):
        hit = ((excess == step) & alone).any((0, 1))
        found |= sum(1 << (2 * n + step) for n in np.flatnonzero(hit).tolist())
    return found


def _aborts(run: ObservedRun, summary: Summary) -> int:
    found = AbortSeen.IDLE if run.accepted.idle_abort else AbortSeen(0)
    before = False
    for at in run.aborts:
        if at > summary.last_abort:
            found |= AbortSeen.REPORTING
        elif before:
            found |= AbortSeen.DRAINING
        else:
            found |= AbortSeen.STARTING if at <= _START else AbortSeen.SCANNING
        before = True
    return int(found)
