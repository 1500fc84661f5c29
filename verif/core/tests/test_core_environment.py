"""The core's environment: its tests pass in bursts, some on the pins; lies, faults and hangs are caught."""

import re
import shutil

import pytest

from triaxis.coverage.core_coverage import core_model
from triaxis.coverage.counts import load
from triaxis.golden.errors import InputError
from triaxis.sim.paths import DUT
from triaxis.verif.testbench import simulation
from triaxis.verif.testbench.settings import BURST, PIN
from triaxis.verif.testbench.simulation import build_for, run, run_settings
from triaxis.verif.testbench.test_table import REPLAY, core_tests

pytestmark = pytest.mark.simulator

# One build for each agent serves all of them.
CONFIG = "w8_m8"
ON_PINS = ("RandomTest", "StallsTest", "ResetsTest")


def burst(test, seed, pairs, folder, **options):
    return run_settings(test, CONFIG, seed, pairs, folder=folder, agent=BURST, **options)


def test_a_folder_that_cannot_be_written_is_one_clear_line(tmp_path):
    (tmp_path / "runs").touch()
    settings = burst("RandomTest", 1, 10, tmp_path / "runs" / "one")
    with pytest.raises(InputError, match="runs/one: cannot make this folder: Not a directory"):
        run(settings)


@pytest.mark.parametrize(
    ("test", "agent"),
    [
        *((name, BURST) for name in core_tests() if name not in (REPLAY, "SeedVectorsTest")),
        *((name, PIN) for name in ON_PINS),
    ],
)
def test_passes(tmp_path, seed, test, agent):
    pairs = 3000 if agent == BURST else 400
    result = run(run_settings(test, CONFIG, seed, pairs, folder=tmp_path, agent=agent, judged_one_in=50))
    assert result.passed and result.counts, result.explain()
    assert result.counts["checked"] > 0
    assert result.counts["judged_by_golden_model"] > 0
    hits = load(result.coverage, core_model(*result.settings.configuration.covered)).hits
    assert hits["claim"].sum() == result.counts["checked"]
    if test == "ResetsTest":
        assert result.counts["resets"] > 2
        assert result.counts["discarded_by_reset"] > 0


@pytest.mark.parametrize(
    ("test", "message"),
    [
        ("DroppedResultTest", "was due"),
        ("DuplicatedResultTest", "was due"),
        ("ReorderedResultTest", "was due"),
        ("MissingPairTest", "seen accepted"),
        ("RaisingCheckerTest", "the checker is broken"),
        ("CorruptClaimTest", "exact answer"),
        ("CorruptPairTest", "exact answer"),
    ],
)
def test_a_scoreboard_that_is_lied_to_fails(tmp_path, seed, test, message):
    result = run(burst(test, seed, 3000, tmp_path))
    assert not result.passed
    assert message in result.log.read_text()


@pytest.mark.regress
def test_a_soak_checks_everything(tmp_path, seed):
    result = run(burst("VolumeTest", seed, 300_000, tmp_path, judged_one_in=1 << 16, soak=True))
    assert result.passed, result.explain()
    assert result.counts and result.counts["checked"] == result.counts["sent"] >= 300_000


def test_a_simulator_that_ends_badly_has_not_passed(tmp_path, seed, monkeypatch):
    """Whatever its results file says."""
    settings = burst("RandomTest", seed, 1000, tmp_path / "run")
    assert run(settings).passed
    honest, model = build_for(settings)
    crashing = tmp_path / "crashing"
    crashing.mkdir()
    script = crashing / "triaxis_bare_tb"
    script.write_text(f"#!/bin/sh\n{honest}/triaxis_bare_tb\nexit 3\n")
    script.chmod(0o755)
    monkeypatch.setattr(simulation, "build_for", lambda *_: (crashing, model))
    assert not run(settings).passed


def test_a_failing_assertion_fails_the_burst(tmp_path, seed):
    gate = "assign open = valid && (!Gating || separated == '0);"
    dut = broken(tmp_path, "core/triaxis_boxes.sv", gate, "assign open = valid;")
    result = run(burst("FarTest", seed, 3000, tmp_path / "run"), dut)
    assert not result.passed
    assert "moved for a pair that its boxes decide" in result.explain()


def broken(tmp_path, file, old, new):
    copy = tmp_path / "dut"
    shutil.copytree(DUT, copy)
    text = (copy / file).read_text()
    assert text.count(old) == 1, "the RTL has changed: adapt the fault"
    (copy / file).write_text(text.replace(old, new))
    return copy


def test_a_hung_core_ends_its_burst(tmp_path, seed):
    """A pair that is never accepted, by its tag: the burst's budget of clocks ends it, not a time limit."""
    full = "&& (in_flight_q != count_t'(Depth))"
    dut = broken(tmp_path, "core/triaxis_core.sv", full, f"{full} && (tag != 16'd42300)")
    # With stalls: otherwise an assertion on the throughput ends the run first.
    result = run(burst("StallsTest", seed, 3600, tmp_path / "run"), dut)
    assert not result.passed
    assert re.search(r"\d+ of 100 pairs accepted in \d+ clocks", result.explain()), result.explain()
    assert "the core hangs" in result.explain()


def test_lost_and_wrong_results_are_caught_and_replayed(tmp_path, seed):
    push = ".push_i (valid_q[Latency-1])"
    dut = broken(tmp_path, "core/triaxis_core.sv", push, f"{push[:-1]} && result.tag[9:0] != 10'd977)")
    # With stalls: otherwise an assertion on the latency ends the run first.
    result = run(burst("StallsTest", seed, 3600, tmp_path / "run"), dut)
    assert not result.passed
    assert "was due" in result.explain()
    command = f"triaxis sim StallsTest --seed {seed} --config {CONFIG} --pairs 3600 --agent burst"
    assert command in result.explain()


@pytest.mark.regress
def test_memory_does_not_grow_with_the_run(tmp_path, seed):
    peaks = []
    for number, pairs in enumerate((1_000_000, 4_000_000)):
        result = run(burst("VolumeTest", seed, pairs, tmp_path / str(number), judged_one_in=1 << 16))
        assert result.passed, result.explain()
        assert result.counts is not None
        peaks.append(result.counts["peak_memory_mib"])
    print("peak memory in MiB of 1 and 4 million pairs:", peaks)
    # What grew with the run would grow by this much for each million pairs.
    assert (peaks[1] - peaks[0]) / 3 < 3
