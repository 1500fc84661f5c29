"""The engine's coverage model: each bin is hit by its run and by no other, and what cannot be is excluded."""

from dataclasses import replace

import numpy as np
import pytest

from triaxis.coverage.mesh_coverage import MeshCoverage
from triaxis.coverage.mesh_sample import AbortSeen, MeshBuild, MeshRow, Reloaded
from triaxis.coverage.report import report

BUILD = MeshBuild("mesh_test", 16, 16, 64, 8, 4, 8)
# A complete run of all pairs: two groups against one, some skipped.
ROW = MeshRow(
    mode=1, status=1, count_a=16, count_b=5, near=3, zones=3, group_pairs_skipped=1, group_pairs_opened=1,
    rows=2, rows_skipped=1, pairs_skipped=10, tested=30,
)  # fmt: skip


def hit(row, item, build=BUILD):
    """Return the bins of an item that a run hits."""
    coverage = MeshCoverage(build)
    coverage.sample([row])
    found = next(one for one in coverage.model.items if one.name == item)
    return [found.bins[n].name for n in np.flatnonzero(coverage.counts.hits[item])]


@pytest.mark.parametrize(
    ("changes", "item", "bins"),
    [
        ({}, "mesh_outcome", ["all / complete"]),
        ({}, "mesh_sizes", ["several groups / several groups"]),
        ({"count_a": 0, "count_b": 64}, "mesh_sizes", ["empty / depth"]),
        ({"mode": 3, "status": 6}, "mesh_sizes", []),
        ({"count_a": 64, "overfull": 1, "count_b": 9}, "mesh_sizes", ["overfull / group + 1"]),
        ({}, "mesh_last_group_a", ["full"]),
        ({"count_b": 0}, "mesh_last_group_a", []),
        ({}, "mesh_last_word", ["partial"]),
        ({}, "mesh_skips", ["some by both, some tested"]),
        ({"rows_skipped": 2, "group_pairs_opened": 0}, "mesh_skips", ["all by rows"]),
        ({"group_pairs_opened": 0}, "mesh_skips", ["all by rows and groups"]),
        ({"group_pairs_skipped": 0, "tested": 0}, "mesh_skips", ["all by boxes of triangles"]),
        ({"group_pairs_skipped": 0, "pairs_skipped": 0}, "mesh_skips", ["nothing"]),
        ({"status": 3}, "mesh_skips", []),
        ({"margin": 65535}, "mesh_margin", ["largest / ran"]),
        ({"move_y": -65536}, "mesh_move_y", ["-65536, the lowest"]),
        ({"fits": 0b100001}, "mesh_fits", ["x low", "z high"]),
        ({"beyond": 0b10}, "mesh_beyond", ["x high"]),
        ({"row_gaps": 1 << 7}, "mesh_row_gaps", ["y, B above, the margin + 1"]),
        ({"group_gaps": 1 << 8}, "mesh_group_gaps", ["z, B below, the margin"]),
        ({"pair_gaps": 1 << 3}, "mesh_pair_gaps", ["x, B above, the margin + 1"]),
        ({}, "mesh_near", ["all / some"]),
        ({"near": 1, "mode": 0, "status": 2}, "mesh_near", ["first / one"]),
        ({"margin": 3, "slow": 3, "warn": 2}, "mesh_zones", ["as wide / narrower"]),
        ({"margin": 3, "warn": 4}, "mesh_zones", ["narrower / wider"]),
        ({"near": 0, "zones": 0}, "mesh_found", ["none / nowhere"]),
        ({"warn": 1}, "mesh_found", ["warn / within the margin"]),
        ({"near": 0, "zones": 2, "slow": 1, "warn": 2}, "mesh_found", ["both / in warn"]),
        ({"near": 0, "slow": 1, "warn": 1}, "mesh_found", ["slow / in slow"]),
        ({"slow": 1, "status": 3}, "mesh_found", []),
        ({"slow": 1, "asked_again": 15}, "mesh_again", ["some"]),
        ({"asked_again": 15}, "mesh_again", []),
        ({"margin": 2, "slow": 1, "warn": 2}, "mesh_again", []),
        ({"margin": 2, "slow": 1, "warn": 3}, "mesh_again", ["none"]),
        ({"tried": 2}, "mesh_trial", ["parity / otherwise"]),
        ({"tried": 2, "tested": 0}, "mesh_trial", []),
        ({"tried": 4, "status": 3}, "mesh_trial", ["memory / otherwise"]),
        ({"tried": 4, "status": 4}, "mesh_trial", []),
        ({"tried": 4, "count_a": 0}, "mesh_trial", []),
        ({"tried": 4, "count_a": 0, "status": 7}, "mesh_trial", ["memory / in a fault"]),
        ({"status": 2, "mode": 0, "first_at": 0}, "mesh_first", ["the first"]),
        ({"reloaded": int(Reloaded.ONLY_B)}, "mesh_reload", ["only B"]),
        ({"aborts": int(AbortSeen.DRAINING | AbortSeen.IDLE)}, "mesh_abort", ["draining", "idle"]),
        ({"saturated": 1}, "mesh_cycles", ["at the largest number"]),
        ({"done_wait": 8}, "mesh_done_wait", ["8 and more"]),
        ({"loaded_with_run": 1}, "mesh_load_run", ["together"]),
    ],
)
def test_a_run_hits_its_bins_and_no_other(changes, item, bins):
    assert hit(replace(ROW, **changes), item) == bins


def test_an_outcome_that_cannot_be_is_illegal():
    coverage = MeshCoverage(BUILD)
    coverage.sample([replace(ROW, status=2), replace(ROW, mode=3)])
    found = [one.bin for item in report(coverage.model, coverage.counts).items for one in item.illegal_hits]
    assert found == ["all / first", "none / complete", "none / some"]
