"""What all benchmarks are run with: the timer, steps that survive an interruption, peers, reports."""

from dataclasses import replace

import numpy as np
import pytest

from triaxis.bench import mesh_cycles
from triaxis.bench.harness import StoredSteps
from triaxis.bench.mesh_cycles import Case, Row, Zoned, bench_mesh, cases
from triaxis.bench.peers import TRIANGLE_PEERS
from triaxis.bench.peers.peer import present
from triaxis.host.engines import SceneRun


def test_an_interrupted_measurement_goes_on(tmp_path):
    made = []

    def steps(key="key"):
        return StoredSteps(tmp_path / "steps", key, lambda _: None)

    def step(name):
        made.append(name)
        if len(made) == 2:
            raise KeyboardInterrupt
        return {"value": name}

    steps().once("a", lambda: step("a"))
    with pytest.raises(KeyboardInterrupt):
        steps().once("b", lambda: step("b"))
    second = steps()
    assert second.once("a", lambda: step("a")) == {"value": "a"} and second.taken_up == 1
    second.once("b", lambda: step("b"))
    # Of another state of things, or damaged: made again.
    steps("other").once("a", lambda: step("a"))
    (tmp_path / "steps" / "b.json").write_text("{")
    steps().once("b", lambda: step("b"))
    assert made == ["a", "b", "b", "a", "b"]


def test_absent_packages_say_so(monkeypatch):
    def broken(_):
        raise OSError("libGL.so.1: cannot open shared object file")

    monkeypatch.setattr("triaxis.bench.peers.peer.import_module", broken)
    there, told = present(TRIANGLE_PEERS)
    assert {peer.distribution for peer, _ in there} <= {"libcgal-dev"}
    reasons = {each.name: each.why_absent for each in told}
    assert len(reasons) == len(TRIANGLE_PEERS) and "libGL" in (reasons["Open3D"] or "")


TOUCHING = np.zeros((3, 3, 3), np.int64)


@pytest.mark.parametrize(("cycles", "passed"), [(50, True), (51, False)])
def test_bounds_are_judged(cycles, passed):
    row = Row(Case("scene", TOUCHING, TOUCHING, 0, 50), SceneRun(tested=9, cycles=cycles), True, None)
    assert bool(mesh_cycles.findings([row], False).problems) is not passed
    assert mesh_cycles.findings([replace(row, right=False)], False).problems == [
        f"scene: WRONG, {cycles} cycles, <= 50"
    ]


@pytest.mark.parametrize(
    ("together", "right", "said"), [(756, True, None), (757, True, "MISSED"), (500, False, "WRONG")]
)
def test_a_run_with_zones_costs_little_more_than_the_widest_alone(together, right, said):
    case = Case("scene", TOUCHING, TOUCHING, 0, 50)
    row = Row(case, SceneRun(tested=9, cycles=50), True, Zoned(together, (300, 400, 500), right))
    more = together - 500
    due = f"scene: {said}, 50 cycles, <= 50; with zones {more} more than the widest alone, <= 256"
    assert mesh_cycles.findings([row], False).problems == ([due] if said else [])


@pytest.mark.simulator
@pytest.mark.regress
def test_made_scenes_reach_their_bounds():
    rows = bench_mesh(cases(None), lambda _: None)
    assert mesh_cycles.findings(rows, False).problems == []
    assert rows[0].run.tested == rows[0].pairs == 40_000 and rows[0].run.near_count == 0
    assert rows[1].run.near_count == 40_000
