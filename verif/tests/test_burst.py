"""The burst agent: the same sequences as on the pins, faults and hangs caught, memory bounded."""

import re
import shutil

import pytest

from triaxis.verif.configuration import parse_configuration
from triaxis.verif.paths import DUT
from triaxis.verif.settings import BURST
from triaxis.verif.simulation import run, run_settings
from triaxis.verif.testnames import REPLAY, TESTS

# One build serves all of them.
CONFIG = "w8_m8"


def burst(test, seed, pairs, folder, config=CONFIG, **options):
    configuration = parse_configuration(config)
    return run_settings(test, configuration, seed, pairs, folder=folder, agent=BURST, **options)


@pytest.mark.parametrize("test", [name for name in TESTS if name not in (REPLAY, "SeedVectorsTest")])
def test_passes_in_bursts(tmp_path, seed, test):
    result = run(burst(test, seed, 3000, tmp_path, judged_one_in=100))
    assert result.passed, result.explain()
    assert result.counts is not None
    assert result.counts["checked"] > 0
    assert result.counts["judged_by_golden_model"] > 0
    if test == "ResetsTest":
        assert result.counts["resets"] > 10
        assert result.counts["discarded_by_reset"] > 0


@pytest.mark.parametrize(
    ("test", "message"),
    [
        ("DroppedResultTest", "was due"),
        ("DuplicatedResultTest", "was due"),
        ("CorruptClaimTest", "exact answer"),
        ("CorruptPairTest", "exact answer"),
    ],
)
def test_a_scoreboard_that_is_lied_to_fails(tmp_path, seed, test, message):
    result = run(burst(test, seed, 3000, tmp_path), shrink=False)
    assert not result.passed
    assert message in result.explain()
    assert result.counts is not None
    assert result.counts["failed"] > 0


def broken(tmp_path, file, old, new):
    copy = tmp_path / "dut"
    shutil.copytree(DUT, copy)
    text = (copy / file).read_text()
    assert text.count(old) == 1, "the RTL has changed: adapt the fault"
    (copy / file).write_text(text.replace(old, new))
    return copy


def test_a_hung_core_ends_its_burst(tmp_path, seed):
    """A tag that is never accepted: the burst's budget of clocks ends it, not a time limit."""
    full = "&& (in_flight_q != count_t'(Depth))"
    dut = broken(tmp_path, "triaxis_core.sv", full, f"{full} && (tag != 16'd1700)")
    # With stalls: otherwise an assertion on the throughput ends the run first.
    result = run(burst("StallsTest", seed, 3600, tmp_path / "run"), dut, shrink=False)
    assert not result.passed
    assert re.search(r"\d+ of 100 pairs accepted in \d+ clocks", result.explain()), result.explain()
    assert "the core hangs" in result.explain()


def test_lost_and_wrong_results_are_caught_and_replayed(tmp_path, seed):
    push = ".push_i (valid_q[Latency-1])"
    dut = broken(tmp_path, "triaxis_core.sv", push, f"{push[:-1]} && result.tag[9:0] != 10'd977)")
    # With stalls: otherwise an assertion on the latency ends the run first.
    result = run(burst("StallsTest", seed, 3600, tmp_path / "run"), dut, shrink=False)
    assert not result.passed
    assert "was due" in result.explain()
    command = f"triaxis sim StallsTest --seed {seed} --config {CONFIG} --pairs 3600 --agent burst"
    assert command in result.explain()


def test_memory_does_not_grow_with_the_run(tmp_path, seed):
    peaks = []
    for number, pairs in enumerate((1_000_000, 4_000_000)):
        result = run(burst("VolumeTest", seed, pairs, tmp_path / str(number), judged_one_in=1 << 16))
        assert result.passed, result.explain()
        assert result.counts is not None
        peaks.append(result.counts["peak_memory_mib"])
    print("peak memory in MiB of 1 and 4 million pairs:", peaks)
    assert peaks[1] < 1.1 * peaks[0]
