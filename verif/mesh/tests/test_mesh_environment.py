"""The engine's environment: its tests pass with either agent, and count alike; lies are seen."""

import argparse

import pytest

from triaxis.coverage.counts import load
from triaxis.golden.errors import InputError
from triaxis.verif.commands import sim
from triaxis.verif.mesh.kept_clocks import FoundClocks, kept
from triaxis.verif.mesh.uvm_tests import SQUARE
from triaxis.verif.regress.coverage_models import model_of
from triaxis.verif.testbench.settings import BURST, PIN
from triaxis.verif.testbench.simulation import run, run_settings
from triaxis.verif.testbench.table import table

pytestmark = [pytest.mark.simulator, pytest.mark.long]

# The tests whose monitors lie, or that check nothing, and what is said of each.
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
COUNTERS = ("group_pairs_skipped", "group_pairs_opened", "pairs_skipped", "tested", "near")


def simulated(folder, test, seed, pairs, agent):
    return run(run_settings(test, SQUARE, seed, pairs, folder=folder, agent=agent))


def passed(folder, test, seed, pairs, agent):
    result = simulated(folder, test, seed, pairs, agent)
    assert result.passed and result.counts, result.explain()
    assert result.counts["checked"] == result.counts["skipped_with_proof"] + result.counts["tested"]
    return result


# By test: the coverage of which every bin is hit.
TESTS = {
    "MeshRandomTest": (),
    "MeshAbortTest": ("mesh_abort",),
    "MeshStallsTest": ("mesh_near_wait", "mesh_done_wait", "mesh_load_run"),
    "MeshResetsTest": (),
}
SAME = ("runs", "complete_runs", "triangles", "checked", "skipped_with_proof", "tested", "near")


@pytest.mark.parametrize("test", [*TESTS, "MeshGapsTest"])
def test_agents(tmp_path, seed, test):
    pins, burst = (passed(tmp_path / a, test, seed, 150, a) for a in (PIN, BURST))
    for result in (pins, burst):
        assert result.counts and result.counts["runs"] > 10
        assert (result.counts["resets"] > 2) == (test == "MeshResetsTest")
        hits = load(result.coverage, model_of(SQUARE)).hits
        for item in TESTS.get(test, ()):
            assert (hits[item] > 0).all(), item
    # Without what hangs on clocks, both send and find the same.
    if test == "MeshGapsTest":
        assert pins.counts and burst.counts
        assert {name: pins.counts[name] for name in SAME} == {name: burst.counts[name] for name in SAME}
        assert (load(burst.coverage, model_of(SQUARE)).hits["mesh_group_gaps"] > 0).sum() == 12


def test_clocks_are_those_that_are_kept(tmp_path, seed, monkeypatch):
    # Every configuration in which the test runs has kept ones.
    assert {name for runs in table()["MeshClocksTest"].runs for name in runs.configs} <= kept().keys()
    passed(tmp_path / "clocks", "MeshClocksTest", seed, 1, BURST)
    monkeypatch.setattr("triaxis.verif.mesh.kept_clocks.kept", lambda: {"a": {"one": [9, 50], "two": [1]}})
    clocks = FoundClocks("a", tmp_path)
    clocks.add("one", [9, 50])
    with pytest.raises(AssertionError, match="scenes that there are not: two"):
        clocks.check()
    clocks.add("two", [2])
    with pytest.raises(AssertionError, match=r"two: \[2\] clocks .*, \[1\] are kept"):
        clocks.check()


@pytest.mark.parametrize("name", SAID)
def test_a_lie_fails_the_test(tmp_path, seed, name):
    result = simulated(tmp_path / "run", name, seed, 20_000, BURST)
    assert not result.passed
    log = result.log.read_text()
    assert SAID[name] in log, log[-3000:]
    if name == "MeshAccountTest":
        assert all(f"{counter} " in log for counter in COUNTERS)


def test_command(capsys):
    parser = argparse.ArgumentParser()
    sim.add_arguments(parser)
    asked = ["MeshGapsTest", "--config", SQUARE, "--agent", "burst", "--pairs", "10"]
    assert sim.run(parser.parse_args(asked)) == 0
    assert "skipped with a proof" in capsys.readouterr().out
    for more, message in (
        (["--soak"], "go with tests of the core"),
        (["--fault", "F7"], "is in the wrapper"),
        (["--config", "w16_m0"], "needs another --config"),
    ):
        with pytest.raises(InputError, match=message):
            sim.run(parser.parse_args([*asked, *more]))
