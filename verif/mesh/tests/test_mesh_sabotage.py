"""The scoreboard of the engine sees every lie, and a test that checks nothing fails."""

import pytest

from triaxis.verif.mesh import sabotage_tests
from triaxis.verif.testbench.settings import BURST
from triaxis.verif.testbench.simulation import run, run_settings

CONFIG = "mesh_w16_m16_d64_g8_l8"

SAID = {
    "MeshNearLostTest": "near pairs sent",
    "MeshNearTwiceTest": "near pairs: number",
    "MeshNearOrderTest": "near pairs: number",
    "MeshUntestedTest": "skipped without a proof",
    "MeshOtherMeshTest": "is due",
    "MeshLoadLostTest": "were given",
    "MeshSummaryLostTest": "a run was accepted during a run",
    "MeshSummaryTwiceTest": "a summary without a run",
    "MeshStatusTest": "status",
    "MeshAccountTest": "is due",
    "MeshNothingTest": "0 runs checked",
    "MeshOnlyEmptyTest": "no pair was checked",
}


def test_every_lie_is_tried():
    names = {name for name in vars(sabotage_tests) if name.startswith("Mesh") and name.endswith("Test")}
    assert names - {"MeshVolumeTest"} == set(SAID)


@pytest.mark.parametrize("name", SAID)
def test_a_lie_fails_the_test(tmp_path, seed, name):
    result = run(run_settings(name, CONFIG, seed, 20_000, folder=tmp_path / "run", agent=BURST))
    assert not result.passed
    log = result.log.read_text()
    assert SAID[name] in log, log[-3000:]


def test_each_counter_is_compared(tmp_path, seed):
    settings = run_settings("MeshAccountTest", CONFIG, seed, 20_000, folder=tmp_path / "run", agent=BURST)
    log = run(settings).log.read_text()
    for name in ("group_pairs_skipped", "group_pairs_opened", "pairs_skipped", "tested", "near"):
        assert f"{name} " in log


def test_the_truth_passes(tmp_path, seed):
    result = run(run_settings("MeshVolumeTest", CONFIG, seed, 20_000, folder=tmp_path / "run", agent=BURST))
    assert result.passed and result.counts
    assert result.counts["checked"] == result.counts["skipped_with_proof"] + result.counts["tested"]
    assert result.counts["judged_by_golden_model"] > 100
