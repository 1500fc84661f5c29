"""The core's environment: its tests pass in bursts, some on the pins; lies and bad ends are caught.

Faults of the core have tests of their own, in verif/faults/tests/test_faults.py.
"""

import os
import re
import signal
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from triaxis.coverage.core_coverage import core_model
from triaxis.coverage.counts import load
from triaxis.sim.configuration import Configuration
from triaxis.sim.core_engine import CorePlayer, streamed
from triaxis.sim.models import core_build
from triaxis.sim.verilate import library
from triaxis.verif.core.tests.broken_rtl import broken_rtl
from triaxis.verif.testbench import simulation
from triaxis.verif.testbench.settings import BURST, PIN, REPLAY, Block, limit_file
from triaxis.verif.testbench.simulation import build_for, run, run_settings
from triaxis.verif.testbench.table import names_of

pytestmark = pytest.mark.simulator

# One build for each agent serves all of them; that for the pins is the one of verif/faults.
CONFIG, PINS = "w8_m8", "w16_m0"
OTHERS = (REPLAY, "SeedVectorsTest", "CertificatesTest")
ON_PINS = ("RandomTest", "StallsTest", "ResetsTest")


def burst(test, seed, pairs, folder, **options):
    return run_settings(test, CONFIG, seed, pairs, folder=folder, agent=BURST, **options)


def test_a_run_that_its_limit_ends_says_so(tmp_path, seed):
    """And not that something is wrong with the core."""
    where = limit_file(tmp_path)

    def children():
        lists = Path("/proc/self/task").glob("*/children")
        return [number for path in lists for number in path.read_text().split()]

    def opened(number):
        with suppress(OSError):
            return [link.resolve() for link in Path(f"/proc/{number}/fd").iterdir()]
        return []

    def strike():
        while not (holding := [number for number in map(int, children()) if where in opened(number)]):
            time.sleep(0.05)
        process = holding[0]
        os.kill(process, signal.SIGXCPU)
        while not where.stat().st_size:
            time.sleep(0.05)
        os.kill(process, signal.SIGKILL)

    with ThreadPoolExecutor(1) as beside:
        struck = beside.submit(strike)
        result = run(burst("VolumeTest", seed, 5_000_000, tmp_path))
        struck.result()
    assert not result.passed
    assert "s of the processor, the limit of such a run: the machine is too slow" in result.errors[0]


@pytest.mark.parametrize(
    ("test", "agent"),
    [
        *((name, BURST) for name in names_of(Block.CORE) if name not in OTHERS),
        # With a build of its own.
        pytest.param("CertificatesTest", BURST, marks=pytest.mark.long),
        *((name, PIN) for name in ON_PINS),
    ],
)
def test_passes(tmp_path, seed, test, agent):
    config, pairs = (CONFIG, 3000) if agent == BURST else (PINS, 400)
    certified = test == "CertificatesTest"
    config += "_certified" * certified
    result = run(run_settings(test, config, seed, pairs, folder=tmp_path, agent=agent, judged_one_in=50))
    assert result.passed and result.counts, result.explain()
    assert result.counts["judged_by_golden_model"] > 0
    hits = load(result.coverage, core_model(result.settings.configuration)).hits
    claims = hits["claim"].sum()
    assert 0 < claims < result.counts["checked"] if certified else claims == result.counts["checked"] > 0
    assert not certified or hits["tried_claim"].sum() > 0
    if test == "ResetsTest":
        assert result.counts["resets"] > 2
        assert result.counts["discarded_by_reset"] > 0


def test_the_log_says_what_ran_each_item_and_how_many_of_each_severity(tmp_path):
    quiet = run(burst("RandomTest", 1, 60, tmp_path / "a", verbosity="none")).log.read_text()
    assert "RandomTest, seed 1" in quiet and "UVM_ERROR   :    0" in quiet
    lies = run(burst("CorruptClaimTest", 7, 3000, tmp_path / "b", verbosity="high"))
    assert not lies.passed and lies.counts
    log = lies.log.read_text()
    assert f"CorruptClaimTest, seed 7, {CONFIG}, agent burst, build " in log and "[ITEM] burst 0" in log
    # One that is wrong in several ways is one; the log has each way.
    assert lies.counts["failed"] <= lies.counts["checked"]
    told = len(re.findall(r"\[SCOREBOARD\] result \d+ at clock \d+: ", log))
    assert told > 0 and f"UVM_ERROR   : {told:4d}" in log


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


def test_a_simulator_that_ends_badly_has_not_passed(tmp_path, seed, monkeypatch):
    """Whatever its results file says."""
    settings = burst("RandomTest", seed, 1000, tmp_path / "run")
    honest, model = build_for(settings)
    crashing = tmp_path / "crashing"
    crashing.mkdir()
    script = crashing / "triaxis_bare_tb"
    monkeypatch.setattr(simulation, "build_for", lambda *_: (crashing, model))
    for status in (0, 3):
        script.write_text(f"#!/bin/sh\n{honest}/triaxis_bare_tb\nexit {status}\n")
        script.chmod(0o755)
        assert run(settings).passed == (status == 0)


def test_a_register_without_a_reset_is_noticed_as_it_begins_with_anything(tmp_path, seed):
    dut = broken_rtl(tmp_path, ("core/triaxis_fifo.sv", "      write_q <= '0;\n", ""))
    # Two, because one may begin with what the reset should have given it.
    runs = [
        run(run_settings("RandomTest", "w8_m0", seed + n, 100, folder=tmp_path / str(n), agent=BURST), dut)
        for n in range(2)
    ]
    assert not all(one.passed for one in runs)
    # Where all begin with 0 nothing shows.
    core = Configuration(8)
    player = CorePlayer(library(core_build(core, dut)))
    pairs = np.zeros((100, 2, 3, 3), np.int32)
    assert (streamed(player, core, pairs, np.zeros(100, np.uint32))[0] & 1).all()


@pytest.mark.regress
@pytest.mark.parametrize("soak", [False, True])
def test_a_long_run_checks_everything_and_memory_does_not_grow_with_it(tmp_path, seed, soak):
    peaks = []
    for number, pairs in enumerate((1_000_000, 4_000_000)):
        settings = burst("VolumeTest", seed, pairs, tmp_path / str(number), judged_one_in=1 << 16, soak=soak)
        result = run(settings)
        assert result.passed and result.counts, result.explain()
        assert result.counts["checked"] == result.counts["sent"] >= pairs
        peaks.append(result.counts["peak_memory_mib"])
    # What grew with the run would grow by this much for each million pairs.
    assert (peaks[1] - peaks[0]) / 3 < 3
