from dataclasses import replace

import numpy as np
import pytest

from triaxis.bench.mesh_cycles import Bound, Case, Row, bench_mesh, cases, findings
from triaxis.host.engines import SceneRun

TOUCHING = np.zeros((3, 3, 3), np.int64)


@pytest.mark.parametrize(
    ("bound", "cycles", "passed"),
    [
        (Bound(most_cycles=50), 50, True),
        (Bound(most_cycles=50), 51, False),
        (Bound(least_pairs_a_cycle=3), 3, True),
        (Bound(least_pairs_a_cycle=3), 4, False),
    ],
)
def test_bounds_are_judged(bound, cycles, passed):
    run = SceneRun(tested=9, cycles=cycles)
    row = Row(Case("scene", TOUCHING, TOUCHING, 0, bound), run, True)
    assert bool(findings([row], False).problems) is not passed
    assert findings([replace(row, right=False)], False).problems == [
        f"scene: WRONG, {cycles} cycles, {bound}"
    ]


@pytest.mark.simulator
def test_made_scenes_reach_their_bounds():
    rows = bench_mesh(cases(None), lambda _: None)
    assert findings(rows, False).problems == []
    assert rows[0].run.tested == rows[0].pairs == 40_000 and rows[0].run.near_count == 0
    assert rows[1].run.near_count == 40_000
