import json
from dataclasses import replace

import numpy as np
import pytest

from triaxis.bench.mesh_cycles import Bound, Case, Row, bench_mesh, cases, write_rows
from triaxis.host.engines import SceneRun

NOTHING_NEAR = np.empty((0, 2), np.int64)


def row(bound, cycles, right=True):
    run = SceneRun(tested=100, cycles=cycles)
    return Row("scene", 10, 10, bound, run, right)


@pytest.mark.parametrize(
    ("bound", "cycles", "passed"),
    [
        (Bound(most_cycles=50), 50, True),
        (Bound(most_cycles=50), 51, False),
        (Bound(least_pairs_a_cycle=10), 10, True),
        (Bound(least_pairs_a_cycle=10), 11, False),
    ],
)
def test_bounds_are_judged(bound, cycles, passed):
    assert row(bound, cycles).passed == passed
    assert not row(bound, cycles, right=False).passed


@pytest.mark.simulator
def test_made_scenes_reach_their_bounds():
    chosen = cases(None)
    rows = bench_mesh(chosen, lambda _: None)
    assert [r.name for r in rows if not r.passed] == []
    worst = rows[0]
    assert worst.run.tested == worst.pairs == 40_000 and worst.run.near_count == 0
    assert rows[1].run.near_count == 40_000


@pytest.mark.simulator
def test_wrong_answer_is_seen(monkeypatch):
    """An engine that loses a near pair."""
    import triaxis.bench.mesh_cycles as module

    class Losing(module.MeshEngineScene):
        def run(self, *arguments, **options):
            found = super().run(*arguments, **options)
            return replace(found, near=found.near[1:])

    touching = np.zeros((3, 3, 3), np.int64)
    monkeypatch.setattr(module, "MeshEngineScene", Losing)
    (found,) = bench_mesh([Case("", touching, touching, 0, Bound(most_cycles=1000))], lambda _: None)
    assert not found.right and not found.passed


def test_result_tells_what_failed(tmp_path, monkeypatch):
    monkeypatch.setattr("triaxis.bench.mesh_cycles.RESULT", tmp_path / "mesh.json")
    content = json.loads(write_rows([row(Bound(most_cycles=50), 51)], False, 1.0).read_text())
    assert not content["passed"] and content["problems"] == ["scene: MISSED, 51 cycles, <= 50 cycles"]
