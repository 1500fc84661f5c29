"""The engine's tests on the simulator: they pass, on the pins and on the bare engine, and count alike."""

import argparse

import pytest

from triaxis.coverage.counts import load
from triaxis.golden.errors import InputError
from triaxis.host.cli import sim
from triaxis.verif.mesh.uvm_tests import BOARD, ONE_LANE, SQUARE, WIDEST, WORDS
from triaxis.verif.regress.coverage_models import model_named, model_of
from triaxis.verif.signoff.plan import plan
from triaxis.verif.testbench.settings import BURST, PIN
from triaxis.verif.testbench.simulation import run, run_settings
from triaxis.verif.testbench.test_table import check_test_fits, check_test_name, mesh_tests


def passed(folder, test, seed, pairs, agent, config=SQUARE):
    result = run(run_settings(test, config, seed, pairs, folder=folder, agent=agent))
    assert result.passed and result.counts, result.explain()
    assert result.counts["checked"] == result.counts["skipped_with_proof"] + result.counts["tested"]
    return result


@pytest.mark.parametrize("test", ["MeshRandomTest", "MeshAbortTest", "MeshResetsTest"])
def test_pins(tmp_path, seed, test):
    result = passed(tmp_path / "run", test, seed, 300, PIN)
    assert result.counts and result.counts["runs"] > 10
    assert (result.counts["resets"] > 2) == (test == "MeshResetsTest")


@pytest.mark.parametrize("test", ["MeshGapsTest", "MeshAbortTest"])
def test_bare_engine(tmp_path, seed, test):
    result = passed(tmp_path / "run", test, seed, 300, BURST)
    hits = load(result.coverage, model_of(SQUARE)).hits
    item = {"MeshGapsTest": "mesh_group_gaps", "MeshAbortTest": "mesh_abort"}[test]
    # The bare engine is not aborted twice, nor where there is no run.
    assert (hits[item] > 0).sum() == {"MeshGapsTest": 12, "MeshAbortTest": 3}[test]


def test_both_agents_send_and_find_the_same(tmp_path, seed):
    pins, bare = (passed(tmp_path / a, "MeshGapsTest", seed, 100, a).counts or {} for a in (PIN, BURST))
    same = ("runs", "complete_runs", "triangles", "checked", "skipped_with_proof", "tested", "near")
    assert {name: pins[name] for name in same} == {name: bare[name] for name in same}


def test_the_sign_off_has_every_test_and_both_agents():
    runs = [run for run in plan(1) if run.of_mesh_engine]
    assert {run.test for run in runs} == set(mesh_tests())
    assert {run.agent for run in runs} == {PIN, BURST}
    assert {run.config for run in runs} == {SQUARE, WORDS, WIDEST, ONE_LANE, BOARD}
    assert len({run.folder for run in runs}) == len(runs)
    assert all(run.of_mesh_engine and run.width == run.mesh_configuration.width for run in runs)


def test_models_by_their_names():
    assert model_named("core_w16_m0") is model_of("w16_m0")
    assert model_named(SQUARE) is model_of(SQUARE)


def test_tests_and_configurations_must_fit():
    check_test_name("MeshRandomTest")
    check_test_fits("MeshRandomTest", SQUARE)
    check_test_fits("MeshTest", "w16_m0")
    for test, config in (("MeshRandomTest", "w16_m0"), ("MeshTest", SQUARE)):
        with pytest.raises(InputError, match="needs another --config"):
            check_test_fits(test, config)


def test_command(capsys):
    parser = argparse.ArgumentParser()
    sim.add_arguments(parser)
    asked = ["MeshGapsTest", "--config", SQUARE, "--agent", "burst", "--pairs", "10"]
    assert sim.run(parser.parse_args(asked)) == 0
    assert "skipped with a proof" in capsys.readouterr().out
    for more in (["--soak"], ["--fault", "F1-box"]):
        with pytest.raises(InputError, match="go with tests of the core"):
            sim.run(parser.parse_args([*asked, *more]))
    with pytest.raises(InputError, match="must read"):
        sim.run(parser.parse_args(["MeshGapsTest", "--config", "mesh_w16"]))
